//! The same bytes everywhere: files and standard output depend on the inputs and the command only, not
//! on language, time zone, cores, working directory or environment, and not on how the program was
//! compiled.
//!
//! `cargo build --release && NONIUS_OTHER=target/release/nonius cargo test --test determinism` compares
//! another build with this one, which checks every overflow, on all fixtures.

use crate::support::refusals;
use crate::support::tree::{Tree, copy_of, difference, lay, skipped, told, tree};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Fixtures and commands that between them write kits, tables, pages and documents; `{}` = the path of
/// the fixture, with a separator at its end.
const COMMANDS: &[(&str, &str)] = &[
    ("start/errors", "generate {}job.toml -o {}kit --format json"),
    ("nine_errors_900", "generate {}siemens-840d-sl.toml -o {}kit"),
    ("nine_errors_900", "generate {}fanuc-30i.toml -o {}kit"),
    ("nine_errors_900", "assess {}generic.toml --format json"),
    ("diagonals/case_b_setup", "generate {}job.toml -o {}kit"),
    ("diagonals/case_b_setup", "separate {}job.toml -o {}e.csv --trials 100 --format json"),
    ("diagonals/case_b_setup", "separate {}job.toml"),
    ("start/errors", "simulate {}job.toml --errors -o {}after.csv"),
    ("formats", "import {}isg_component_errors_selfmade.csv -o {}e.csv --sign as-error"),
    ("standards", "standards {}x_axis.csv"),
];

/// Exit status, standard output and the files afterwards.
type Made = (Option<i32>, String, Tree);

/// Runs a command in `from`; the fixture is called `called`.
fn make(program: &mut Command, fixture: &TempDir, from: &Path, called: &str, words: &str) -> Made {
    let words = words.replace("{}", called);
    let output = program
        .args(words.split_whitespace())
        .current_dir(from)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), said, tree(fixture.path()))
}

fn plain((fixture, words): (&str, &str)) -> Made {
    let place = copy_of(fixture);
    let mut program = Command::new(env!("CARGO_BIN_EXE_nonius"));
    make(&mut program, &place, place.path(), "", words)
}

fn expect_same(what: &str, words: &str, expected: &Made, found: &Made) {
    assert_ne!(expected.0, Some(2), "{words}: {}", expected.1);
    assert_eq!(found.0, expected.0, "{what}: {words}");
    assert_eq!(found.1, expected.1, "{what}: {words}");
    let names = difference(&expected.2, &found.2);
    assert!(names.is_empty(), "{what}: {words}: {names} differ");
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
    for command in COMMANDS {
        let expected = plain(*command);
        for setting in settings {
            let place = copy_of(command.0);
            let mut program = Command::new(env!("CARGO_BIN_EXE_nonius"));
            if setting.is_empty() {
                program.env_clear();
            }
            program.envs(setting.iter().copied());
            let found = make(&mut program, &place, place.path(), "", command.1);
            expect_same(&format!("{setting:?}"), command.1, &expected, &found);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn one_core_or_all_change_no_byte() {
    let can_choose = Command::new("taskset")
        .args(["-c", "0", "true"])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !can_choose {
        return skipped("taskset is not here");
    }
    for command in COMMANDS {
        let place = copy_of(command.0);
        let mut program = Command::new("taskset");
        program.args(["-c", "0", env!("CARGO_BIN_EXE_nonius")]);
        let found = make(&mut program, &place, place.path(), "", command.1);
        expect_same("one core", command.1, &plain(*command), &found);
    }
}

/// The manifest names inputs as the job does, so where one stands does not matter either.
#[test]
fn working_directory_and_kind_of_path_change_no_byte_of_a_file() {
    for command in COMMANDS {
        let expected = plain(*command);
        let place = copy_of(command.0);
        let name = place.path().file_name().expect("a name").to_string_lossy();
        let above = place.path().parent().expect("it lies in one").to_path_buf();
        let whole = format!("{}/", place.path().display());
        for (from, called) in [
            (above.clone(), format!("{name}/")),
            (place.path().to_path_buf(), whole),
            (above.clone(), format!("./{name}/../{name}/")),
        ] {
            let place = emptied(&place, &tree(copy_of(command.0).path()));
            let mut program = Command::new(env!("CARGO_BIN_EXE_nonius"));
            let found = make(&mut program, place, &from, &called, command.1);
            // Pages name files as they were called.
            let found = (found.0, found.1.replace(&called, ""), found.2);
            expect_same(&called, command.1, &expected, &found);
        }
    }
}

/// The same directory with other content.
fn emptied<'a>(place: &'a TempDir, content: &Tree) -> &'a TempDir {
    for entry in std::fs::read_dir(place.path()).expect("a directory") {
        let path = entry.expect("an entry").path();
        let removed = match path.is_dir() {
            true => std::fs::remove_dir_all(path),
            false => std::fs::remove_file(path),
        };
        removed.expect("it can be removed");
    }
    lay(content, place.path());
    place
}

/// Inputs and a command for them.
struct Asked {
    name: String,
    inputs: Tree,
    words: String,
}

/// Every folder of the fixtures with a job, and every refusal, with the commands that they may be meant for.
fn all_commands() -> Vec<Asked> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let pattern = format!("{}/**/*.toml", fixtures.display());
    let jobs = glob::glob(&pattern).expect("a pattern");
    let folder = |path: PathBuf| path.parent().expect("a folder").to_path_buf();
    let folders: BTreeSet<PathBuf> = jobs.map(|path| folder(path.expect("a file"))).collect();
    let of_folder = |folder: &PathBuf| for_jobs(&folder.display().to_string(), &tree(folder));
    let mut commands: Vec<Asked> = folders.iter().flat_map(of_folder).collect();
    for case in refusals::all(&fixtures) {
        let place = tempfile::tempdir().expect("a temporary directory can be made");
        case.lay_out(place.path());
        let (name, inputs, words) = (case.name, tree(place.path()), case.command);
        commands.extend(for_jobs(&name, &inputs));
        commands.push(Asked { name, inputs, words });
    }
    commands
}

/// What may be asked of the jobs among some inputs.
fn for_jobs(name: &str, inputs: &Tree) -> Vec<Asked> {
    let jobs = inputs.keys().filter(|file| file.ends_with(".toml") && !file.contains('/'));
    let asked = |job: &String| {
        [
            "generate JOB -o out.kit",
            "separate JOB -o out.csv --trials 100 --format json",
            "assess JOB --format json",
            "program JOB -o out.run",
            "simulate JOB --errors -o out.sim.csv --format json",
            "context JOB",
        ]
        .map(|words| Asked {
            name: name.to_string(),
            inputs: inputs.clone(),
            words: words.replace("JOB", job),
        })
    };
    jobs.flat_map(asked).collect()
}

fn made_by(program: &Path, asked: &Asked) -> (Made, String) {
    let place = tempfile::tempdir().expect("a temporary directory can be made");
    lay(&asked.inputs, place.path());
    let output = Command::new(program)
        .args(asked.words.split_whitespace())
        .current_dir(place.path())
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let made = (output.status.code(), text(&output.stdout), tree(place.path()));
    (made, text(&output.stderr))
}

#[test]
fn another_build_makes_the_same_bytes_of_all_fixtures() {
    let Some(other) = std::env::var_os("NONIUS_OTHER") else {
        return skipped("NONIUS_OTHER names no other build");
    };
    let other = Path::new(env!("CARGO_MANIFEST_DIR")).join(other);
    let own = Path::new(env!("CARGO_BIN_EXE_nonius"));
    let commands = all_commands();
    let mut differing = Vec::new();
    let mut written = 0;
    for asked in &commands {
        let (made, talk) = made_by(own, asked);
        let said = format!("{}: {}", asked.name, asked.words);
        assert!(made.0.is_some_and(|status| status < 3), "{said}\n{talk}");
        written += usize::from(made.0 != Some(2));
        if (made, talk) != made_by(&other, asked) {
            differing.push(said);
        }
    }
    assert!(differing.is_empty(), "{}", differing.join("\n"));
    let all = commands.len();
    told(&format!("{all} commands, {written} of them with a result: the same bytes"));
}
