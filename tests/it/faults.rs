//! A run that is killed, ended or refused by the system at any of its system calls, and a disk that is
//! full at any size: what lies at the output is the old thing, the new one or nothing, each whole; no
//! input is changed and nothing of a user's is lost.
//!
//! Of the system calls a sample is taken; `NONIUS_FAULTS=all cargo test --test faults` takes all. They
//! need Linux with `strace`, full disks need root; where that is missing, the tests say so.

use crate::support::tree::{
    Entry, Tree, below, copies, copy_of, difference, lay, skipped, told, tree,
};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use tempfile::TempDir;

/// A command that writes, with what lies around it.
struct Scene {
    name: &'static str,
    fixture: &'static str,
    /// What lies there besides the fixture.
    arrange: fn(&Path),
    command: &'static str,
    /// Where it writes.
    output: &'static str,
}

/// In an old kit or at the place of a file: gone, it would be lost.
const USERS_OWN: &[u8] = b"what a person wrote\n";

fn put(path: &Path, text: impl AsRef<[u8]>) {
    fs::write(path, text).expect("a file can be written");
}

fn append(path: &Path, text: &str) {
    let old = fs::read_to_string(path).expect("a file");
    put(path, old + text);
}

fn run(at: &Path, command: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(command.split_whitespace())
        .current_dir(at)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

fn nothing(_: &Path) {}

/// An old kit with a user's file in it, made from another table.
fn old_kit(at: &Path) {
    let table = fs::read_to_string(at.join("errors.csv")).expect("a table");
    put(&at.join("errors.csv"), table.replace("1.43", "1.53"));
    run(at, "generate job.toml -o kit");
    put(&at.join("errors.csv"), table);
    put(&at.join("kit/archive.arc"), USERS_OWN);
}

/// An old kit, and an older one as it was made.
fn older_kit(at: &Path) {
    old_kit(at);
    fs::remove_file(at.join("kit/archive.arc")).expect("it is there");
    fs::rename(at.join("kit"), at.join("kit.previous")).expect("a kit can be moved");
    old_kit(at);
}

fn old_file(at: &Path) {
    put(&at.join("put.csv"), USERS_OWN);
}

fn with_program(at: &Path) {
    let program = "\n[program]\nwhat = \"single-axis\"\nbidirectional = false\nsteps = 5
start_mm = { x = 10.0, y = 10.0, z = -190.0 }\nsize_mm = { x = 300.0, y = 200.0, z = 100.0 }\n";
    append(&at.join("job.toml"), program);
}

/// An old folder of a measuring run with readings.
fn old_run(at: &Path) {
    with_program(at);
    run(at, "program job.toml -o kit");
    put(&at.join("kit/readings.csv"), USERS_OWN);
}

/// 0.6 MB of samples.
fn with_part_program(at: &Path) {
    let offset = "\n[[path.offset]]\nsystem = \"G54\"\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 0.0\n";
    append(&at.join("job.toml"), offset);
    let there_and_back = "X400.\nX0.\n".repeat(8);
    put(&at.join("part.nc"), format!("G21 G90 G1 F1000\n{there_and_back}M30\n"));
}

fn old_path(at: &Path) {
    with_part_program(at);
    old_file(at);
}

const SCENES: &[Scene] = &[
    Scene {
        name: "a first kit",
        fixture: "start/errors",
        arrange: nothing,
        command: "generate job.toml -o new/deep/kit",
        output: "new/deep/kit",
    },
    Scene {
        name: "a kit over one with a user's file",
        fixture: "start/errors",
        arrange: old_kit,
        command: "generate job.toml -o kit --force",
        output: "kit",
    },
    Scene {
        name: "a kit over two old ones",
        fixture: "start/errors",
        arrange: older_kit,
        command: "generate job.toml -o kit --force --format json",
        output: "kit",
    },
    Scene {
        name: "a measuring run",
        fixture: "start/errors",
        arrange: with_program,
        command: "program job.toml -o kit",
        output: "kit",
    },
    Scene {
        name: "a measuring run over one with readings",
        fixture: "start/errors",
        arrange: old_run,
        command: "program job.toml -o kit --force",
        output: "kit",
    },
    Scene {
        name: "simulated readings",
        fixture: "start/errors",
        arrange: nothing,
        command: "simulate job.toml --errors -o put.csv",
        output: "put.csv",
    },
    Scene {
        name: "simulated readings over a file",
        fixture: "start/errors",
        arrange: old_file,
        command: "simulate job.toml --errors -o put.csv --force",
        output: "put.csv",
    },
    Scene {
        name: "separated errors",
        fixture: "diagonals/case_b_setup",
        arrange: nothing,
        command: "separate job.toml -o put.csv",
        output: "put.csv",
    },
    Scene {
        name: "separated errors over a file",
        fixture: "diagonals/case_b_setup",
        arrange: old_file,
        command: "separate job.toml -o put.csv --force",
        output: "put.csv",
    },
    Scene {
        name: "an imported table over a file",
        fixture: "formats",
        arrange: old_file,
        command: "import isg_component_errors_selfmade.csv -o put.csv --sign as-error --force",
        output: "put.csv",
    },
    Scene {
        name: "samples of a path",
        fixture: "start/errors",
        arrange: with_part_program,
        command: "path job.toml part.nc -o put.csv",
        output: "put.csv",
    },
    Scene {
        name: "samples of a path over a file",
        fixture: "start/errors",
        arrange: old_path,
        command: "path job.toml part.nc -o put.csv --force",
        output: "put.csv",
    },
];

/// A scene with what it is before, and after a run that nothing disturbs.
struct Played {
    scene: &'static Scene,
    before: Tree,
    after: Tree,
    said: Output,
}

impl Played {
    fn new(scene: &'static Scene) -> Played {
        let place = copy_of(scene.fixture);
        (scene.arrange)(place.path());
        let before = tree(place.path());
        let said = run(place.path(), scene.command);
        assert_ne!(said.status.code(), Some(2), "{}: {said:?}", scene.name);
        let after = tree(place.path());
        assert!(after.contains_key(scene.output), "{}", scene.name);
        Played { scene, before, after, said }
    }

    /// A fresh place, as it is before.
    fn place(&self) -> TempDir {
        let place = tempfile::tempdir().expect("a temporary directory can be made");
        lay(&self.before, place.path());
        place
    }

    /// What lies at the output is old, new, or was and is nothing, and all else is as it was.
    fn whole(&self, found: &Tree) -> Result<(), String> {
        let output = self.scene.output;
        let now = at(found, output);
        if now != at(&self.before, output) && now != at(&self.after, output) {
            return Err("the output is neither old nor new".to_string());
        }
        for (name, entry) in &self.before {
            if !name.starts_with(output) && found.get(name) != Some(entry) {
                return Err(format!("{name} was changed"));
            }
        }
        for name in found.keys() {
            let is_expected = name.starts_with(output) || output.starts_with(name.as_str());
            if !is_expected && !self.before.contains_key(name) {
                return Err(format!("{name} was left"));
            }
        }
        self.kept(found)
    }

    /// No half kit lies at DIR.previous, and the old one with a user's file lies somewhere.
    fn kept(&self, found: &Tree) -> Result<(), String> {
        let output = self.scene.output;
        let old = at(&self.before, output);
        let previous = format!("{output}.previous");
        let known = [old.clone(), at(&self.before, &previous), at(&self.after, output)];
        let is_kept = |name: &&String| name.starts_with(&previous) && !name.contains(".partial-");
        for name in directories(found).filter(is_kept) {
            if !known.contains(&at(found, name)) {
                return Err(format!("{name} is no whole kit"));
            }
        }
        let is_directory = matches!(self.before.get(output), Some(Entry::Directory));
        if is_directory && !directories(found).any(|name| at(found, name) == old) {
            return Err("the old kit is gone".to_string());
        }
        Ok(())
    }

    /// The new thing is in its place.
    fn written(&self, found: &Tree) -> Result<(), String> {
        match at(found, self.scene.output) == at(&self.after, self.scene.output) {
            true => Ok(()),
            false => Err("the output is not the new one".to_string()),
        }
    }

    /// So it is, and nothing unfinished is there.
    fn complete(&self, found: &Tree) -> Result<(), String> {
        self.written(found)?;
        match partials(found).first() {
            Some(left) => Err(format!("{left} was left")),
            None => Ok(()),
        }
    }

    /// A run that nothing disturbs writes the new thing and removes what a killed one left, by name.
    fn next_run(&self, place: &Path, left: &Tree) -> Result<(), String> {
        let command = self.scene.command.replace(" --force", "");
        let next = run(place, &format!("{command} --force"));
        let talk = String::from_utf8_lossy(&next.stderr);
        if next.status != self.said.status {
            return Err(format!("the next run: {talk}"));
        }
        let found = tree(place);
        self.complete(&found).map_err(|why| format!("after the next run {why}"))?;
        if copies(&self.before, USERS_OWN) > copies(&found, USERS_OWN) && !self.is_file() {
            return Err("the next run lost a user's file".to_string());
        }
        let is_named = |name: &&String| talk.contains(name.as_str());
        match partials(left).iter().find(|name| !is_named(name)) {
            Some(name) => Err(format!("{name} is removed without a word: {talk}")),
            None => Ok(()),
        }
    }

    /// With `--force` on a file the old one is replaced.
    fn is_file(&self) -> bool {
        matches!(self.after.get(self.scene.output), Some(Entry::File(_)))
    }
}

/// A file or everything in a directory; `None` where nothing is.
fn at(tree: &Tree, name: &str) -> Option<Tree> {
    let entry = tree.get(name)?;
    below(tree, name).or_else(|| Some(Tree::from([(String::new(), entry.clone())])))
}

fn directories(tree: &Tree) -> impl Iterator<Item = &String> {
    let is_directory = |(_, entry): &(&String, &Entry)| **entry == Entry::Directory;
    tree.iter().filter(is_directory).map(|(name, _)| name)
}

/// The outermost names of what is unfinished.
fn partials(tree: &Tree) -> Vec<&String> {
    let is_outermost = |name: &&String| {
        let unfinished = name.split('/').position(|part| part.contains(".partial-"));
        unfinished.is_some_and(|depth| depth + 1 == name.split('/').count())
    };
    tree.keys().filter(is_outermost).collect()
}

/// A system call of a run: its name, and which one of that name it is.
#[derive(Clone)]
struct Call {
    name: String,
    number: usize,
    /// The system may refuse it.
    is_refusable: bool,
}

/// Calls that concern memory, time, threads and signals: the system refuses them nowhere, so they are
/// places to be killed at only. So is the end of listing a directory, whose failure (seen nowhere) makes
/// Rust's library panic.
const NO_FILE: &[&str] = &[
    "arch_prctl",
    "brk",
    "clock_gettime",
    "clone",
    "clone3",
    "exit",
    "exit_group",
    "futex",
    "getrandom",
    "gettid",
    "getpid",
    "madvise",
    "mmap",
    "mprotect",
    "mremap",
    "munmap",
    "prctl",
    "prlimit64",
    "restart_syscall",
    "rseq",
    "rt_sigaction",
    "rt_sigprocmask",
    "rt_sigreturn",
    "sched_getaffinity",
    "sched_yield",
    "set_robust_list",
    "set_tid_address",
    "sigaltstack",
    "tgkill",
];

const ERRORS: &[&str] = &["ENOSPC", "EIO", "EACCES", "EINTR", "EINVAL"];

/// Whether all faults are asked for.
fn is_whole() -> bool {
    std::env::var("NONIUS_FAULTS").is_ok_and(|asked| asked == "all")
}

fn has_strace() -> bool {
    let traced = Command::new("strace")
        .args(["-f", "-o", "/dev/null", "true"])
        .stderr(Stdio::null())
        .status();
    traced.is_ok_and(|status| status.success())
}

/// The system calls of a scene, from the first that names its output on.
fn calls(played: &Played) -> Vec<Call> {
    let place = played.place();
    let log = tempfile::NamedTempFile::new().expect("a place for the log");
    traced(place.path(), log.path(), &["-y"], played.scene.command);
    let text = fs::read_to_string(log.path()).expect("a log");
    let first = text.split_whitespace().next().expect("a process");
    let output = played.scene.output.trim_start_matches("new/deep/");
    let mut seen = BTreeMap::new();
    let mut calls = Vec::new();
    let (mut touched, mut listed) = (false, "");
    for line in text.lines() {
        let (process, rest) = line.split_once(char::is_whitespace).expect("a process");
        let Some((name, words)) = rest.trim_start().split_once('(') else {
            continue;
        };
        // A number and what it stands for.
        let handle = words.split([',', ')']).next().unwrap_or_default();
        if process != first || !name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') {
            continue;
        }
        let number = seen.entry(name.to_string()).or_insert(0);
        *number += 1;
        touched |= name != "execve" && rest.contains(output);
        if touched {
            calls.push(Call {
                name: name.to_string(),
                number: *number,
                is_refusable: !NO_FILE.contains(&name) && (name != "close" || handle != listed),
            });
        }
        if name == "getdents64" {
            listed = handle;
        }
    }
    assert!(calls.len() > 20, "{}: {text}", played.scene.name);
    calls
}

fn traced(at: &Path, log: &Path, options: &[&str], command: &str) -> Output {
    Command::new("strace")
        .args(["-f", "-e", "signal=none", "-o"])
        .arg(log)
        .args(options)
        .arg(env!("CARGO_BIN_EXE_nonius"))
        .args(command.split_whitespace())
        .current_dir(at)
        .stdin(Stdio::null())
        .output()
        .expect("strace starts")
}

/// What happens at a system call.
#[derive(Clone, Copy, Debug)]
enum Fault {
    /// Killed: nothing can be tidied up.
    Kill,
    /// Ended by Ctrl-C, the end of the session or `kill`.
    End(&'static str),
    /// The system refuses the call.
    Refuse(&'static str),
}

impl Fault {
    fn words(self) -> String {
        match self {
            Fault::Kill => "signal=SIGKILL".to_string(),
            Fault::End(signal) => format!("signal={signal}"),
            Fault::Refuse(error) => format!("error={error}"),
        }
    }
}

fn disturbed(played: &Played, call: &Call, fault: Fault) -> Result<(), String> {
    let place = played.place();
    let log = tempfile::NamedTempFile::new().expect("a place for the log");
    let Call { name, number, .. } = call;
    let inject = format!("inject={name}:{}:when={number}", fault.words());
    let only = format!("trace={name}");
    let options = ["-e", only.as_str(), "-e", inject.as_str()];
    let output = traced(place.path(), log.path(), &options, played.scene.command);
    let found = tree(place.path());
    judge(played, fault, &output, &found)
        .and_then(|()| match fault {
            Fault::Kill => played.next_run(place.path(), &found),
            // The removal of what is not needed any more was refused; it is tried again.
            Fault::Refuse(_) if !partials(&found).is_empty() => {
                played.next_run(place.path(), &found)
            }
            _ => Ok(()),
        })
        .map_err(|why| {
            let log = fs::read_to_string(log.path()).expect("a log");
            let line = log.lines().find(|line| line.contains("INJECTED"));
            format!(
                "{}: {fault:?} at {name} {number}: {why}\n  status {:?}, {}\n  {}",
                played.scene.name,
                output.status.code(),
                line.unwrap_or_default(),
                String::from_utf8_lossy(&output.stderr).lines().next().unwrap_or_default(),
            )
        })
}

fn is_end_of_a_list(output: &Output) -> bool {
    let said = String::from_utf8_lossy(&output.stderr);
    said.contains("unexpected error during closedir")
}

fn judge(played: &Played, fault: Fault, output: &Output, found: &Tree) -> Result<(), String> {
    played.whole(found)?;
    let done = output.status == played.said.status;
    match (fault, output.status.code()) {
        (Fault::Kill, None) => Ok(()),
        (Fault::End(_), Some(2) | None) => match partials(found).first() {
            Some(left) => Err(format!("{left} was left")),
            None if *found == played.before || played.complete(found).is_ok() => Ok(()),
            None => Err(format!("changed: {}", difference(&played.before, found))),
        },
        (Fault::Refuse(_), Some(2)) if *found == played.before => Ok(()),
        (Fault::Refuse(_), Some(2)) => {
            Err(format!("status 2, but changed: {}", difference(&played.before, found)))
        }
        (Fault::Refuse(_), Some(_)) if done => played.written(found),
        (_, Some(_)) if done => played.complete(found),
        // The library panics where the end of a list of files is refused (docs/security.md §3): nothing is half.
        (Fault::Refuse(_), Some(101)) if is_end_of_a_list(output) => played.kept(found),
        _ => Err("it ended in another way".to_string()),
    }
}

/// Tries faults at the system calls of all scenes: every `step`th, or all.
fn try_faults(faults: impl Fn(&Call) -> Vec<Fault>, step: usize) {
    if !has_strace() {
        return skipped("strace is not here, or may not trace");
    }
    let played: Vec<Played> = SCENES.iter().map(Played::new).collect();
    let mut cases = Vec::new();
    for scene in &played {
        for call in calls(scene) {
            let faults = faults(&call);
            cases.extend(faults.into_iter().map(|fault| (scene, call.clone(), fault)));
        }
    }
    let all = cases.len();
    let step = if is_whole() { 1 } else { step };
    let cases: Vec<_> = cases.into_iter().step_by(step).collect();
    let failures = in_parallel(&cases, |(scene, call, fault)| disturbed(scene, call, *fault));
    told(&format!("{} of {all} cases", cases.len()));
    let shown: Vec<&str> = failures.iter().take(40).map(String::as_str).collect();
    assert!(
        failures.is_empty(),
        "{} of {} cases:\n{}",
        failures.len(),
        cases.len(),
        shown.join("\n")
    );
}

/// What went wrong, in the order of the cases.
fn in_parallel<T: Sync>(
    cases: &[T],
    test: impl Fn(&T) -> Result<(), String> + Sync,
) -> Vec<String> {
    let next = AtomicUsize::new(0);
    let failures = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                while let Some((index, case)) = {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    cases.get(index).map(|case| (index, case))
                } {
                    if let Err(why) = test(case) {
                        failures.lock().expect("no test panics").push((index, why));
                    }
                }
            });
        }
    });
    let mut failures = failures.into_inner().expect("no test panics");
    failures.sort();
    failures.into_iter().map(|(_, why)| why).collect()
}

#[test]
fn killed_at_any_system_call_nothing_is_half_and_the_next_run_tidies_up() {
    try_faults(|_| vec![Fault::Kill], 23);
}

#[test]
fn ended_at_any_system_call_nothing_unfinished_is_left() {
    let signals = vec![Fault::End("SIGTERM"), Fault::End("SIGINT")];
    try_faults(|_| signals.clone(), 53);
}

#[test]
fn refused_at_any_system_call_everything_is_written_or_nothing() {
    let faults = |call: &Call| match call.is_refusable {
        true => ERRORS.iter().map(|error| Fault::Refuse(error)).collect(),
        false => Vec::new(),
    };
    try_faults(faults, 53);
}

/// A small memory disk; unmounted at the end.
struct Stick {
    folder: TempDir,
}

impl Stick {
    /// `None` where none can be mounted.
    fn new(size: &str) -> Option<Stick> {
        let folder = tempfile::tempdir().expect("a temporary directory can be made");
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", size, "tmpfs"])
            .arg(folder.path())
            .stderr(Stdio::null())
            .status();
        let is_mounted = mounted.is_ok_and(|status| status.success());
        is_mounted.then(|| Stick { folder })
    }
}

impl Drop for Stick {
    fn drop(&mut self) {
        let unmounted = Command::new("umount").arg("-l").arg(self.folder.path()).status();
        assert!(unmounted.is_ok_and(|status| status.success()));
    }
}

/// Sizes of disks on which the commands below find too little room at every stage, or enough: pages of
/// 4 KiB, and numbers of names.
fn sizes() -> Vec<String> {
    let step = if is_whole() { 1 } else { 7 };
    let pages = (1..=48).step_by(step).map(|n| format!("size={}k", 4 * n));
    let names = (2..=26).step_by(step).map(|n| format!("nr_inodes={n}"));
    pages.chain(names).collect()
}

#[test]
fn on_a_disk_of_any_size_everything_is_written_or_nothing() {
    if Stick::new("size=4k").is_none() {
        return skipped("a small memory disk cannot be mounted here");
    }
    let place = copy_of("start/errors");
    with_program(place.path());
    with_part_program(place.path());
    let mut refused = 0;
    for (words, output) in [
        ("generate job.toml --force", "new/kit"),
        ("program job.toml --force", "kit"),
        ("simulate job.toml --errors --force", "put.csv"),
        ("path job.toml part.nc --force", "put.csv"),
    ] {
        let plenty = Stick::new("size=8m").expect("it was possible before");
        let new = filled(place.path(), words, plenty.folder.path(), output);
        assert_ne!(new.0.status.code(), Some(2), "{words}: {:?}", new.0);
        for size in sizes() {
            let stick = Stick::new(&size).expect("it was possible before");
            refused += fill(place.path(), words, stick.folder.path(), output, &new)
                .unwrap_or_else(|why| panic!("{words}, {size}: {why}"));
        }
    }
    assert!(refused > 8, "{refused}");
}

/// Runs the command; what it said, and what lies on the stick.
fn filled(at: &Path, words: &str, stick: &Path, output: &str) -> (Output, Tree) {
    let said = run(at, &format!("{words} -o {}/{output}", stick.display()));
    (said, tree(stick))
}

/// Writes twice onto the stick; how often it was refused.
fn fill(
    place: &Path,
    words: &str,
    stick: &Path,
    output: &str,
    new: &(Output, Tree),
) -> Result<usize, String> {
    let mut refused = 0;
    let mut before = tree(stick);
    for _ in 0..2 {
        let (said, found) = filled(place, words, stick, output);
        let talk = String::from_utf8_lossy(&said.stderr);
        if said.status.code() != Some(2) {
            let is_whole = said.status == new.0.status && at(&found, output) == at(&new.1, output);
            if !is_whole || !partials(&found).is_empty() {
                return Err(format!("not whole: {talk}"));
            }
        } else if found != before || !talk.contains("no space left") {
            return Err(format!("{}: {talk}", difference(&before, &found)));
        } else {
            refused += 1;
        }
        before = found;
    }
    Ok(refused)
}
