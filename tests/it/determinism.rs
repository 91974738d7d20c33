//! Files and standard output depend on inputs and command only: not on language, time zone, cores, folder, environment.

use crate::support::{self, Entry, Tree, Visit, difference, skipped, succeeds};
use nonius::visit::files::Memory;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::LazyLock;

/// Fixtures, and commands that write kits, tables, pages, documents; `{}` = path of the fixture with a separator.
const COMMANDS: &[(&str, &str)] = &[
    ("start/errors", "generate {}job.toml -o {}kit --format json"),
    ("nine_errors_900", "generate {}siemens-840d-sl.toml -o {}kit"),
    ("nine_errors_900", "generate {}fanuc-30i.toml -o {}kit"),
    ("machine_h", "assess {}job.toml --window 6000,2000,1000 --histogram 50 --format json"),
    ("diagonals/case_b_setup", "generate {}job.toml -o {}kit"),
    ("diagonals/case_b_setup", "separate {}job.toml -o {}e.csv --trials 100 --format json"),
    ("diagonals/case_b_setup", "separate {}job.toml --trials 200"),
    ("start/errors", "simulate {}job.toml --errors -o {}after.csv"),
    ("formats", "import {}isg_component_errors_selfmade.csv -o {}e.csv --sign as-error"),
    ("standards", "standards {}x_axis.csv"),
];

type Made = (Option<i32>, String, Tree);

/// Runs a command in `from`; the folder of the visit is called `called`.
fn make(program: &mut Command, visit: &Visit, from: &Path, called: &str, words: &str) -> Made {
    let words = words.replace("{}", called);
    let program = program.args(words.split_whitespace()).current_dir(from).stdin(Stdio::null());
    let output = program.output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), said, visit.files())
}

fn nonius() -> Command {
    Command::new(support::nonius())
}

static MADE: LazyLock<Vec<Made>> =
    LazyLock::new(|| COMMANDS.iter().map(|command| made_by(nonius(), *command)).collect());

fn commands() -> impl Iterator<Item = (&'static (&'static str, &'static str), &'static Made)> {
    COMMANDS.iter().zip(&*MADE)
}

fn made_by(mut program: Command, (fixture, words): (&str, &str)) -> Made {
    let visit = Visit::of(fixture);
    make(&mut program, &visit, visit.folder(), "", words)
}

fn expect_same(what: &str, words: &str, expected: &Made, found: &Made) {
    assert_ne!(expected.0, Some(2), "{words}: {}", expected.1);
    assert_eq!(found.0, expected.0, "{what}: {words}");
    assert_eq!(found.1, expected.1, "{what}: {words}");
    let names = difference(&expected.2, &found.2);
    assert!(names.is_empty(), "{what}: {words}: {names} differ");
}

/// What another program gets of files in its memory.
#[test]
fn a_disk_and_memory_give_the_same() {
    fn files(tree: &Tree) -> impl Iterator<Item = (&str, &[u8])> {
        tree.iter().filter_map(|(name, entry)| match entry {
            Entry::File(bytes) => Some((name.as_str(), bytes.as_slice())),
            _ => None,
        })
    }
    for ((fixture, words), (status, said, tree)) in commands() {
        let memory = Memory::of(files(&Visit::of(fixture).files()));
        let answer = nonius::cli::answer(&memory, words.replace("{}", "").split(' '));
        assert_eq!(Some(i32::from(answer.status)), *status, "{words}: {}", answer.err);
        assert_eq!(String::from_utf8(answer.out).unwrap(), *said, "{words}");
        let all = memory.all();
        let found: Vec<_> = all.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])).collect();
        assert!(found == files(tree).collect::<Vec<_>>(), "{words}: other files");
    }
}

#[test]
fn language_time_zone_and_environment_change_no_byte() {
    let settings: &[&[(&str, &str)]] = &[
        &[("LC_ALL", "C"), ("LANG", "C")],
        &[("LC_ALL", "de_DE.UTF-8"), ("LANG", "de_DE.UTF-8")],
        &[("LC_ALL", "tr_TR.UTF-8"), ("LC_NUMERIC", "tr_TR.UTF-8")],
        &[("TZ", "Pacific/Kiritimati"), ("SOURCE_DATE_EPOCH", "0")],
        &[("COLUMNS", "20"), ("TERM", "dumb"), ("NO_COLOR", "1")],
        &[("CLICOLOR_FORCE", "1"), ("RUST_BACKTRACE", "full")],
        &[], // cleared
    ];
    for (command, expected) in commands() {
        for setting in settings {
            let mut program = nonius();
            if setting.is_empty() {
                program.env_clear();
            }
            program.envs(setting.iter().copied());
            expect_same(&format!("{setting:?}"), command.1, expected, &made_by(program, *command));
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn one_core_or_all_change_no_byte() {
    if !succeeds(Command::new("taskset").args(["-c", "0", "true"])) {
        return skipped("taskset is not here");
    }
    for (command, expected) in commands() {
        let mut program = Command::new("taskset");
        program.args(["-c", "0", &support::nonius()]);
        expect_same("one core", command.1, expected, &made_by(program, *command));
    }
}

/// The manifest names inputs as the job does, so where one stands does not matter either.
#[test]
fn working_directory_and_kind_of_path_change_no_byte_of_a_file() {
    for ((fixture, words), expected) in commands() {
        for kind in ["NAME/", "FOLDER/", "./NAME/../NAME/"] {
            let visit = Visit::of(fixture);
            let (folder, above) = (visit.folder(), visit.folder().parent().expect("a folder"));
            let name = folder.file_name().expect("a name").to_string_lossy();
            let called =
                kind.replace("NAME", &name).replace("FOLDER", &folder.display().to_string());
            let from = if kind == "FOLDER/" { folder } else { above };
            let (status, said, files) = make(&mut nonius(), &visit, from, &called, words);
            // Pages name files as they were called, on Windows with `\\`.
            let said = said.replace(&called, "").replace(&called.replace('/', "\\"), "");
            expect_same(kind, words, expected, &(status, said, files));
        }
    }
}
