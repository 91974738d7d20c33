//! Where a run writes, and with whom at the same time: killed runs, twenty at once, a closed standard
//! output, places that are read-only, links, or inputs.
//!
//! What is refused because it is an input or no regular file is tested in `tests/it/lost.rs`, a standard output
//! that is full or not read in `tests/it/outcome.rs`, a failure of single system calls and a full disk in
//! `tests/it/faults.rs`.

use crate::support::tree;
use crate::support::tree::{Entry, Tree, below, copies, copy_of, difference, tree};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

fn program(at: &Path, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
    command
        .args(words.split_whitespace())
        .current_dir(at)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn run(at: &Path, words: &str) -> Output {
    program(at, words).output().expect("the program starts")
}

fn talk(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every whole kit below a directory passes `verify`, which checks the manifest; nothing else is there.
fn only_whole_kits(at: &Path) {
    let found = tree(at);
    let is_kit = |name: &&String| name.starts_with("kit") && !name.contains('/');
    for name in found.keys().filter(is_kit) {
        let partial = name.contains(".partial-");
        let whole = partial || {
            let verified = run(at, &format!("verify job.toml --tables {name}"));
            verified.status.success()
        };
        assert!(whole, "{name} is not whole");
    }
}

#[test]
fn killed_at_any_moment_nothing_looks_finished_that_is_not() {
    let place = copy_of("start/errors");
    let at = place.path();
    for round in 0..60_u64 {
        let mut child =
            program(at, "generate job.toml -o kit --force").spawn().expect("the program starts");
        std::thread::sleep(Duration::from_micros(round * 150));
        // It may have finished already; then there is nothing to kill.
        let _ = child.kill();
        child.wait().expect("the program ends");
        only_whole_kits(at);
    }
}

/// Twenty runs, started together.
fn twenty(at: &Path, words: &str) -> Vec<Output> {
    let start = |_| program(at, words).spawn().expect("the program starts");
    let children: Vec<Child> = (0..20).map(start).collect();
    let end = |child: Child| child.wait_with_output().expect("the program ends");
    children.into_iter().map(end).collect()
}

/// How many of them wrote; the others were refused, and each says what it did.
fn wrote(outputs: &[Output]) -> usize {
    let mut wrote = 0;
    for output in outputs {
        let said = talk(output);
        match output.status.code() {
            Some(0 | 1) if said.contains("wrote ") => wrote += 1,
            Some(2) if said.starts_with("problem: ") && !said.contains("wrote ") => {}
            other => panic!("{other:?}: {said}"),
        }
    }
    wrote
}

fn nothing_unfinished(found: &Tree) {
    let unfinished = found.keys().find(|name| name.contains(".partial-"));
    assert_eq!(unfinished, None);
}

#[test]
fn of_twenty_at_once_one_writes_and_the_others_are_refused() {
    let place = copy_of("start/errors");
    let at = place.path();
    for (words, output) in [
        ("generate job.toml -o kit", "kit"),
        ("generate job.toml -o new/deep/kit", "new"),
        ("simulate job.toml --errors -o put.csv", "put.csv"),
    ] {
        let before = tree(at);
        let outputs = twenty(at, words);
        assert_eq!(wrote(&outputs), 1, "{words}");
        let found = tree(at);
        nothing_unfinished(&found);
        let name = difference(&before, &found);
        let is_ours = |name: &str| name == output || name.starts_with(&format!("{output}/"));
        assert!(name.split(", ").all(is_ours), "{words}: {name}");
        only_whole_kits(at);
    }
}

#[test]
fn twenty_at_once_with_force_lose_nothing() {
    let place = copy_of("start/errors");
    let at = place.path();
    run(at, "generate job.toml -o kit");
    let own = b"what a person wrote\n";
    fs::write(at.join("kit/archive.arc"), own).expect("a file can be written");
    let outputs = twenty(at, "generate job.toml -o kit --force");
    assert!(wrote(&outputs) > 0);
    let found = tree(at);
    nothing_unfinished(&found);
    assert_eq!(copies(&found, own), 1);
    assert!(below(&found, "kit").is_some());
    only_whole_kits(at);
    let outputs = twenty(at, "simulate job.toml --errors -o put.csv --force");
    assert!(wrote(&outputs) > 0);
    nothing_unfinished(&tree(at));
}

/// What a command writes in a fresh place, and what it says.
fn undisturbed(words: &str) -> (Output, Tree) {
    let place = copy_of("start/errors");
    let output = run(place.path(), words);
    (output, tree(place.path()))
}

const WRITING: &[&str] = &[
    "generate job.toml -o kit",
    "generate job.toml -o new/kit --format json",
    "simulate job.toml --errors -o put.csv",
];

#[cfg(unix)]
#[test]
fn with_a_closed_standard_output_the_same_is_written() {
    for words in WRITING {
        let (expected, files) = undisturbed(words);
        let line = format!("exec '{}' {words} >&-", env!("CARGO_BIN_EXE_nonius"));
        let place = copy_of("start/errors");
        let closed = Command::new("sh")
            .args(["-c", &line])
            .current_dir(place.path())
            .output()
            .expect("a shell");
        assert_eq!(closed.status, expected.status, "{words}: {}", talk(&closed));
        assert_eq!(talk(&closed), talk(&expected));
        assert!(tree(place.path()) == files, "{words}");
    }
}

#[cfg(unix)]
#[test]
fn a_place_that_is_read_only_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let place = copy_of("start/errors");
    let at = place.path();
    let closed = at.join("closed");
    fs::create_dir(&closed).expect("a directory");
    run(at, "generate job.toml -o closed/kit");
    run(at, "simulate job.toml --errors -o closed/put.csv");
    let mode = |mode| fs::Permissions::from_mode(mode);
    fs::set_permissions(&closed, mode(0o555)).expect("its owner may");
    // The administrator may write there all the same, unless all that is below is mounted read-only.
    let mount = |options: &[&str]| {
        let mut command = Command::new("mount");
        command.args(options).arg(&closed).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    let path = closed.to_string_lossy().into_owned();
    let is_mounted = mount(&["--bind", &path]);
    let is_closed = fs::create_dir(closed.join("try")).is_err() || {
        fs::remove_dir(closed.join("try")).expect("just made");
        is_mounted && mount(&["-o", "remount,bind,ro"])
    };
    let before = tree(at);
    let outputs = [
        "generate job.toml -o closed/new",
        "generate job.toml -o closed/new/kit",
        "generate job.toml -o closed/kit --force",
        "simulate job.toml --errors -o closed/put.csv --force",
        "simulate job.toml --errors -o closed/new.csv",
    ]
    .map(|words| (words, run(at, words)));
    let after = tree(at);
    if is_mounted {
        let unmounted = Command::new("umount").arg(&closed).status();
        assert!(unmounted.is_ok_and(|status| status.success()));
    }
    fs::set_permissions(&closed, mode(0o755)).expect("its owner may");
    if !is_closed {
        return tree::skipped("nothing is closed to this user, and nothing can be mounted");
    }
    for (words, output) in outputs {
        assert_eq!(output.status.code(), Some(2), "{words}: {}", talk(&output));
        let said = talk(&output);
        assert!(said.contains("nothing was written"), "{words}: {said}");
    }
    assert_eq!(difference(&before, &after), "");
}

#[cfg(unix)]
#[test]
fn a_kit_is_written_through_a_link_to_its_folder() {
    let place = copy_of("start/errors");
    let at = place.path();
    fs::create_dir(at.join("stick")).expect("a directory");
    std::os::unix::fs::symlink("stick", at.join("link")).expect("a link");
    assert_eq!(run(at, "generate job.toml -o link/kit").status.code(), Some(0));
    assert_eq!(run(at, "generate job.toml -o link/kit --force").status.code(), Some(0));
    let found = tree(at);
    assert!(below(&found, "stick/kit.previous").is_some());
    assert!(below(&found, "stick/kit") == below(&found, "stick/kit.previous"));
}

/// Its target would stay where it is, and the link would become something else.
#[cfg(unix)]
#[test]
fn a_link_is_not_replaced_by_a_kit() {
    let place = copy_of("start/errors");
    let at = place.path();
    run(at, "generate job.toml -o kit");
    fs::create_dir(at.join("empty")).expect("a directory");
    for target in ["kit", "empty"] {
        let link = format!("link-{target}");
        std::os::unix::fs::symlink(target, at.join(&link)).expect("a link");
        for output in [link.clone(), format!("{link}/")] {
            refused(at, &format!("generate job.toml -o {output} --force"));
        }
    }
}

fn refused(at: &Path, words: &str) {
    let before = tree(at);
    let output = run(at, words);
    assert_eq!(output.status.code(), Some(2), "{words}: {}", talk(&output));
    assert_eq!(difference(&before, &tree(at)), "", "{words}");
}

#[test]
fn no_output_lies_in_or_around_what_a_job_reads() {
    let place = copy_of("start/errors");
    let at = place.path();
    run(at, "generate job.toml -o old");
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    let update = job.replace("\"none\"", "\"old\"");
    fs::write(at.join("update.toml"), update).expect("a file can be written");
    fs::create_dir(at.join("old.previous")).expect("a directory");
    for words in [
        "generate update.toml -o old --force",
        "generate update.toml -o old/new",
        "generate update.toml -o old/new/kit --force",
        "generate job.toml -o job.toml/kit",
        "generate job.toml -o job.toml --force",
        "generate job.toml -o . --force",
        "generate job.toml -o .. --force",
        "simulate job.toml --tables old --errors -o old/put.csv",
        "simulate job.toml --errors -o errors.csv/put.csv",
    ] {
        refused(at, words);
    }
    assert!(matches!(tree(at)["job.toml"], Entry::File(_)));
}
