# Read by the scripts beside it: where things lie, and what is switched on in what is given to users.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root="$PWD"
package="$root/target/package"
tools="$root/target/tools"
mkdir -p "$package" "$tools"
export CARGO_INCREMENTAL=0
version="$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)"

# Spreadsheets, and the page for a browser where packaging/page/build has made it.
features=excel
[ ! -f "$package/nonius.html" ] || features+=,page

say() { printf '%s\n' "$*"; }
stop() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }
# Packages of Python, each in a folder of its own below $tools, because pip puts no second one into one `bin`.
python_package() { python3 -m pip install --quiet --disable-pip-version-check --root-user-action ignore --upgrade --target "$tools/$1" "$2"; }
made() { for file in "$@"; do printf '%8s KiB  %s\n' "$(($(stat -c %s "$file") / 1024))" "${file#"$root/"}"; done; }
