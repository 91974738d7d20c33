//! What a command made goes out whole or not at all, whether the run failed, was ended or was killed.

#![cfg(unix)]
use crate::support::{G54, Visit, below, own_profile, program, replaced, succeeds};
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

fn start() -> Visit {
    let visit = Visit::with_job("nine_errors_900/siemens-840d-sl.toml");
    visit.copy("diagonals/case_b_setup/job.toml", "diagonals.toml");
    visit.copy("diagonals/case_b_setup/readings.csv", "readings.csv");
    visit
}

const WRITING: [(&str, &str); 6] = [
    ("generate job.toml -o new", "new"),
    ("generate job.toml -o above/deep/new", "above"),
    ("generate job.toml --format json -o new", "new"),
    ("simulate job.toml --errors -o new.csv", "new.csv"),
    ("simulate diagonals.toml --format json -o new.csv", "new.csv"),
    ("separate diagonals.toml --trials 0 -o new.csv", "new.csv"),
];

#[test]
fn where_standard_output_fails_nothing_is_written() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let visit = start();
    let before = visit.files();
    for (command, _) in WRITING {
        let ran = visit.shell(&format!("$N {command} > /dev/full")).ends(2);
        ran.says("standard output cannot be written").omits("wrote");
        assert!(visit.files() == before, "{command}");
    }
    visit.shell("$N generate job.toml -o kit");
    let kept = visit.files();
    visit.shell("$N generate job.toml -o kit --force > /dev/full").ends(2);
    assert!(visit.files() == kept);
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    for (command, made) in WRITING {
        let visit = start();
        let ran = visit.shell(&format!("{{ $N {command}; echo $? > status; }} | true"));
        // 1 = made, but the answer is no.
        let status = visit.read("status");
        assert!(["0", "1"].contains(&status.trim()), "{command}: {status}");
        assert!(ran.err.contains("wrote"), "{command}: {}", ran.err);
        assert!(visit.has(made), "{command}");
    }
}

#[test]
fn a_run_that_fails_leaves_no_directory_behind() {
    let visit = start();
    let before = visit.files();
    // A name of a file in the kit that is longer than a name may be.
    let path = "A".repeat(300);
    let from = Visit::new();
    let file = format!(
        "[[files]]\nrole = \"table\"\npath = \"{path}.CSV\"\ntemplate = \"generic.csv.tera\"\n"
    );
    from.put("own.toml", own_profile("generic", &file));
    let at = |visit: &Visit, name: &str| visit.at(name).display().to_string();
    let job = replaced(&visit.read("job.toml"), "siemens-840d-sl", &at(&from, "own.toml"));
    from.put("job.toml", replaced(&job, "errors.csv", &at(&visit, "errors.csv")));
    let line = format!("$N generate {} -o a/b/kit", at(&from, "job.toml"));
    visit.shell(&line).ends(2).says("cannot write");
    assert!(visit.files() == before);
}

#[test]
fn what_is_written_has_the_permissions_that_the_users_mask_leaves() {
    let visit = start();
    for mask in [0o022, 0o077, 0o002] {
        let kit = format!("kit-{mask:o}");
        let write =
            format!("$N generate job.toml -o {kit} && $N simulate job.toml --errors -o {kit}.csv");
        visit.shell(&format!("umask {mask:o}; {write}")).ends(0);
        for (name, mode) in [("", 0o777), ("/manifest.json", 0o666), (".csv", 0o666)] {
            assert_eq!(visit.mode(&format!("{kit}{name}")) & 0o777, mode & !mask, "{kit}{name}");
        }
    }
}

fn long_program(visit: &Visit, repeats: usize) {
    let block = "G1 X100 Y50 F500\nX0 Y0\n".repeat(repeats);
    visit.put("long.nc", format!("G21 G90\n{block}M30\n"));
    visit.put("path.toml", visit.read("job.toml") + G54);
}

/// Names of files that are being written, or were; their content may change meanwhile.
fn partials(visit: &Visit) -> Vec<String> {
    let mut names = visit.names();
    names.retain(|name| name.contains(".partial-"));
    names
}

/// Starts a run that writes for long, after a word to the shell, and waits until it writes.
fn started(visit: &Visit, first: &str) -> Child {
    let before = partials(visit);
    let mut shell =
        visit.by_shell(&format!("{first} exec $N path path.toml long.nc -o points.csv"));
    shell.stdout(Stdio::null()).stderr(File::create(visit.at("talk")).expect("a file"));
    let mut child = shell.spawn().expect("a shell");
    while partials(visit).iter().all(|name| before.contains(name)) {
        let ended = child.try_wait().expect("it can be asked");
        assert!(ended.is_none(), "the run ended too early: {ended:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

fn ended_by(mut child: Child, signal: &str) -> Option<i32> {
    assert!(succeeds(Command::new("kill").args([format!("-{signal}"), child.id().to_string()])));
    child.wait().expect("it ends").code()
}

#[test]
fn a_run_that_is_ended_cleans_up() {
    let visit = start();
    long_program(&visit, 200_000);
    // A shell starts with `&` what does not hear Ctrl-C; `kill` ends it as ever.
    for (before, name) in [("", "INT"), ("", "TERM"), ("", "HUP"), ("trap '' INT;", "TERM")] {
        assert_eq!(ended_by(started(&visit, before), name), Some(2), "{name}");
        assert_eq!(partials(&visit), Vec::<String>::new(), "{name}");
        assert!(!visit.has("points.csv"));
    }
}

#[test]
fn what_a_killed_run_left_is_named_and_removed_by_the_next_but_not_what_is_at_work() {
    let visit = start();
    long_program(&visit, 200_000);
    ended_by(started(&visit, ""), "KILL");
    let left = partials(&visit);
    assert_eq!(left.len(), 1);
    // A name that a person chose is nobody's left-over.
    visit.put("points.csv.partial-backup", "mine");
    let working = started(&visit, "");
    let mut of_the_working = partials(&visit);
    of_the_working.retain(|name| !left.contains(name) && !name.ends_with("backup"));
    let talk = visit.read("talk");
    let words = format!("removed {}, left by a run that was killed", left[0]);
    assert!(talk.contains(&words), "{talk}");
    visit.put("short.nc", "G21 G90\nG1 X1 F100\nM30\n");
    let ran = visit.run("path path.toml short.nc -o points.csv").ends(0);
    assert_eq!(of_the_working.len(), 1);
    assert!(visit.has(&of_the_working[0]), "{}", ran.err);
    ended_by(working, "TERM");
    assert_eq!(partials(&visit), ["points.csv.partial-backup"]);
}

/// `nohup`, and a shell's `&`.
#[cfg(target_os = "linux")]
#[test]
fn signals_that_the_run_was_started_to_ignore_stay_ignored_and_no_lock_is_waited_for() {
    let visit = start();
    long_program(&visit, 2_000);
    for name in ["HUP", "INT"] {
        assert_eq!(ended_by(started(&visit, &format!("trap '' {name};")), name), Some(0));
        std::fs::remove_file(visit.at("points.csv")).expect("written");
    }
    let folder = File::open(visit.folder()).expect("the folder");
    folder.lock().expect("its lock");
    visit.yes("generate job.toml -o kit");
}

#[test]
fn the_directory_is_never_absent_while_it_is_replaced() {
    let visit = start().with_kit();
    for _ in 0..10 {
        let mut command = program(visit.folder(), "generate job.toml -o kit --force");
        command.stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the program starts");
        while child.try_wait().expect("it can be asked").is_none() {
            if cfg!(target_os = "linux") {
                assert!(visit.has("kit/manifest.json"), "the kit is absent");
            }
        }
    }
    let files = visit.files();
    let names = |kit: &str| below(&files, kit).expect("a kit").into_keys().collect::<Vec<_>>();
    assert_eq!(names("kit"), names("kit.previous"));
}
