#!/bin/sh
# Whether two builds write the same tables: `tests/same_bytes.sh OLD NEW`, two programs.
#
# Both make the kit and the measuring programs of every job under fixtures/ (without refuses/). Exit
# statuses and all files for the control have to be equal byte for byte; checklists and manifests, which
# are words for people and scripts, are only counted where they differ. `ALL=1`: they have to be equal too,
# and so has what is printed. Exit status: 0 equal, 1 different, 2 nothing compared.
set -u
[ $# -eq 2 ] || { echo "usage: $0 OLD NEW" >&2; exit 2; }
old=$(realpath "$1") && new=$(realpath "$2") || exit 2
cd "$(dirname "$0")/.." || exit 2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
different=0 files=0 words=0 kits=0

made() { # PROGRAM COMMAND JOB SIDE: what it makes and says lies in $work/SIDE
    rm -rf "$work/kit" "$work/$4" && mkdir "$work/$4"
    "$1" "$2" "$3" -o "$work/kit" >"$work/$4/printed" 2>"$work/$4/said"
    echo $? >"$work/$4/status"
    [ ! -d "$work/kit" ] || mv "$work/kit" "$work/$4/kit"
}

for job in $(find fixtures -name '*.toml' -not -path '*/refuses/*' | LC_ALL=C sort); do
    for command in generate program; do
        made "$old" $command "$job" old
        made "$new" $command "$job" new
        [ ! -d "$work/old/kit" ] || kits=$((kits + 1))
        for file in $(cd "$work" && find old new -type f | sed 's,^[a-z]*/,,' | LC_ALL=C sort -u); do
            files=$((files + 1))
            cmp -s "$work/old/$file" "$work/new/$file" && continue
            case ${ALL:-0}/$file in
                0/*checklist* | 0/*manifest.json | 0/printed | 0/said) words=$((words + 1)) ;;
                *) different=$((different + 1)) && echo "$command $job: $file differs" ;;
            esac
        done
    done
done
echo "$kits kits, $files files and answers: $different differ, and $words that are words"
[ "$kits" -gt 0 ] || exit 2
[ "$different" -eq 0 ]
