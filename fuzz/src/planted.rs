//! Whether bugs that are known to be there are found: the patches of `planted/`, all in one copy of the repository, which
//! is built once. Each bug shows only where `NONIUS_PLANTED` names it. Fuzzer and fault tests run on each in turn.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// The variable that lets one bug show.
const PLANTED: &str = "NONIUS_PLANTED";
/// How long the fuzzer looks for each.
const SECONDS: &str = "60";

/// Prints which bug was found by which; true = each by one at least.
pub fn run() -> Result<bool, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let copy = root.join("target/planted");
    let bugs = copy_with_bugs(&root, &copy)?;
    let started = Instant::now();
    fuzzer(&copy, None, "0");
    let tests = cargo(&copy, None)
        .args(["test", "--quiet", "--locked", "--test", "it", "--no-run"])
        .status();
    if !tests.is_ok_and(|status| status.success()) {
        return Err("the copy with the bugs does not compile".to_string());
    }
    println!("built in {} s", started.elapsed().as_secs());
    println!("| planted bug | fuzzer | said | fault tests | s |\n| --- | --- | --- | --- | ---: |");
    let mut all = true;
    // Without a bug nothing is found; with each, by one of the two at least.
    for bug in std::iter::once(None).chain(bugs.iter().map(Some)) {
        let started = Instant::now();
        let bug = bug.map(String::as_str);
        let ((fuzzer, said), faults) = (fuzzer(&copy, bug, SECONDS), faults(&copy, bug));
        let seconds = started.elapsed().as_secs();
        println!("| {} | {fuzzer} | {said} | {faults} | {seconds} |", bug.unwrap_or("none"));
        all &= [fuzzer, faults].contains(&FOUND) == bug.is_some();
    }
    Ok(all)
}

const FOUND: &str = "found";

/// What `git` knows of the repository, as it lies there, with every patch; returns the names of the bugs.
fn copy_with_bugs(root: &Path, copy: &Path) -> Result<Vec<String>, String> {
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(root).output();
    let listed = listed.map_err(|error| format!("git: {error}"))?.stdout;
    let names = String::from_utf8_lossy(&listed).into_owned();
    for name in names.split('\0').filter(|name| !name.is_empty()) {
        let to = copy.join(name);
        let bytes = fs::read(root.join(name)).unwrap_or_default();
        // A file that is as it was keeps its time, so that it is not compiled again.
        if fs::read(&to).is_ok_and(|old| old == bytes) {
            continue;
        }
        let made =
            to.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&to, bytes));
        made.map_err(|error| format!("{name}: {error}"))?;
    }
    let mut patches: Vec<PathBuf> = fs::read_dir(root.join("fuzz/planted"))
        .map_err(|error| format!("fuzz/planted: {error}"))?
        .flatten()
        .map(|entry| entry.path())
        .collect();
    patches.sort();
    for patch in &patches {
        let applied = Command::new("patch")
            .args(["-p1", "--quiet", "--fuzz=0", "-i"])
            .arg(patch)
            .current_dir(copy)
            .status();
        if !applied.is_ok_and(|status| status.success()) {
            return Err(format!("{} does not fit the code any more", patch.display()));
        }
    }
    let name = |path: &PathBuf| path.file_stem().map(|name| name.to_string_lossy().into_owned());
    Ok(patches.iter().filter_map(name).collect())
}

/// The fuzzer of the copy with a bug, and what it said first.
fn fuzzer(copy: &Path, bug: Option<&str>, seconds: &str) -> (&'static str, String) {
    let _ = fs::remove_dir_all(copy.join("fuzz/found"));
    let words =
        ["run", "--quiet", "--locked", "--release", "--manifest-path", "fuzz/Cargo.toml", "--"];
    let mut command = cargo(copy, bug);
    command.args(words).args(["--seconds", seconds, "--jobs", "2"]).stderr(Stdio::null());
    let output = command.output();
    let said = output
        .map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
        .unwrap_or_default();
    let first = said.lines().find_map(|line| line.strip_prefix("found: "));
    match first {
        Some(first) => {
            (FOUND, first.rsplit(".case: ").next().unwrap_or(first).chars().take(80).collect())
        }
        None => ("–", String::new()),
    }
}

/// The fault tests of the copy with a bug.
fn faults(copy: &Path, bug: Option<&str>) -> &'static str {
    let mut command = cargo(copy, bug);
    command.args(["test", "--quiet", "--locked", "--test", "it", "--", "faults::"]);
    match command.stdout(Stdio::null()).stderr(Stdio::null()).status() {
        Ok(status) if status.success() => "–",
        _ => FOUND,
    }
}

fn cargo(copy: &Path, bug: Option<&str>) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(copy).env_remove(PLANTED);
    if let Some(bug) = bug {
        command.env(PLANTED, bug);
    }
    command
}
