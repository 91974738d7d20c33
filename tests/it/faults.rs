//! A run that is killed, ended or refused by the system at any of its system calls, and a disk that is
//! full at any size: what lies at the output is the old thing, the new one or nothing, each whole; no
//! input is changed and nothing of a user's is lost.
//!
//! Of the system calls of every command a sample is taken; `NONIUS_SIMULATIONS=all cargo test --test it faults`
//! takes all. They need Linux with `strace`, full disks need root; where that is missing, the tests say so.

use super::lost::PROGRAM;
use crate::support::*;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use tempfile::{NamedTempFile, TempDir};

/// In an old kit or at the place of a file: gone, it would be lost.
const USERS_OWN: &[u8] = b"what a person wrote\n";

fn old_kit(visit: &Visit) {
    let table = visit.read("errors.csv");
    visit.edit("errors.csv", "x,400,8,", "x,400,9,");
    visit.run("generate job.toml -o kit");
    visit.put("errors.csv", table).put("kit/archive.arc", USERS_OWN);
}

fn older_kit(visit: &Visit) {
    old_kit(visit);
    fs::remove_file(visit.at("kit/archive.arc")).unwrap();
    fs::rename(visit.at("kit"), visit.at("kit.previous")).unwrap();
    old_kit(visit);
}

fn old_file(visit: &Visit) {
    visit.put("put.csv", USERS_OWN);
}

fn old_run(visit: &Visit) {
    visit.append("job.toml", PROGRAM).run("program job.toml -o kit");
    visit.put("kit/readings.csv", USERS_OWN);
}

/// 0.6 MB of samples.
fn with_part_program(visit: &Visit) {
    visit.append("job.toml", G54);
    let there_and_back = "X400.\nX0.\n".repeat(8);
    visit.put("part.nc", format!("G21 G90 G1 F1000\n{there_and_back}M30\n"));
}

fn old_path(visit: &Visit) {
    with_part_program(visit);
    old_file(visit);
}

fn lists_and_form(visit: &Visit) {
    visit.yes("new --controller generic --travel 400,300,200 --readings -o run");
    let form = visit.read("run/readings.csv");
    for name in DIAGONALS {
        let count = form.lines().filter(|line| line.starts_with(name)).count();
        visit.put(&format!("{name}.txt"), (0..count).map(|k| format!("{k}\n")).collect::<String>());
    }
}

const ERRORS: &str = "start/errors";
const READINGS: &str = "diagonals/case_b_setup";
const FORM: &str = "import --form run/readings.csv --ppp PPP.txt --npp NPP.txt --pnp PNP.txt --ppn PPN.txt \
    --columns #1=displacement_mm --captures cumulative -o put.csv";
const IMPORT: &str = "import isg_component_errors_selfmade.csv -o put.csv --sign as-error --force";

/// A fixture, what lies there besides, and a command that writes.
type Scene = (&'static str, fn(&Visit), &'static str);

const SCENES: [Scene; 17] = [
    (ERRORS, |_| (), "generate job.toml -o new/deep/kit"),
    (ERRORS, old_kit, "generate job.toml -o kit --force"),
    (ERRORS, older_kit, "generate job.toml -o kit --force --format json"),
    (ERRORS, |visit| _ = visit.append("job.toml", PROGRAM), "program job.toml -o kit"),
    (ERRORS, old_run, "program job.toml -o kit --force"),
    (ERRORS, |_| (), "simulate job.toml --errors -o put.csv"),
    (ERRORS, old_file, "simulate job.toml --errors -o put.csv --force"),
    (READINGS, |_| (), "separate job.toml -o put.csv"),
    (READINGS, old_file, "separate job.toml -o put.csv --force"),
    ("formats", old_file, IMPORT),
    (ERRORS, with_part_program, "path job.toml part.nc -o put.csv"),
    (ERRORS, old_path, "path job.toml part.nc -o put.csv --force"),
    (ERRORS, |_| (), "new --controller fanuc-30i --travel 400,300,200 -o new/deep/visit"),
    (ERRORS, |_| (), "report job.toml -o put.html"),
    (ERRORS, |visit| _ = visit.put("put.html", USERS_OWN), "report job.toml -o put.html --force"),
    (ERRORS, |_| (), "assess job.toml --plot put.svg"),
    (ERRORS, lists_and_form, FORM),
];

struct Played {
    command: &'static str,
    output: &'static str,
    before: Tree,
    after: Tree,
    said: Ran,
    calls: Vec<Call>,
}

static PLAYED: LazyLock<[Played; 17]> = LazyLock::new(|| SCENES.map(Played::new));

impl Played {
    fn new((fixture, arrange, command): Scene) -> Played {
        let (_, output) = command.split_once("-o ").or(command.split_once("--plot ")).unwrap();
        let output = output.split(' ').next().unwrap();
        let visit = Visit::of(fixture);
        arrange(&visit);
        let before = visit.files();
        let (said, log) = traced(&visit, &["-y"], command);
        let after = visit.files();
        assert!(after.contains_key(output), "{command}");
        let calls = calls(&log, output);
        Played { command, output, before, after, said: said.answers(), calls }
    }

    /// What lies at the output is old, new, or was and is nothing, and all else is as it was.
    fn whole(&self, found: &Tree) -> Result<(), String> {
        let (output, now) = (self.output, at(found, self.output));
        let is_whole = now == at(&self.before, output) || now == at(&self.after, output);
        check(is_whole, "the output is neither old nor new")?;
        for (name, entry) in self.before.iter().filter(|(name, _)| !name.starts_with(output)) {
            check(found.get(name) == Some(entry), format!("{name} was changed"))?;
        }
        for name in found.keys() {
            let is_expected = name.starts_with(output) || output.starts_with(name.as_str());
            check(is_expected || self.before.contains_key(name), format!("{name} was left"))?;
        }
        self.kept(found)
    }

    /// No half kit lies at DIR.previous, and the old one with a user's file lies somewhere.
    fn kept(&self, found: &Tree) -> Result<(), String> {
        let output = self.output;
        let old = at(&self.before, output);
        let previous = format!("{output}.previous");
        let known = [old.clone(), at(&self.before, &previous), at(&self.after, output)];
        let is_kept = |name: &&String| name.starts_with(&previous) && !name.contains(".partial-");
        for name in directories(found).filter(is_kept) {
            check(known.contains(&at(found, name)), format!("{name} is no whole kit"))?;
        }
        let is_directory = self.before.get(output) == Some(&Entry::Directory);
        let is_there = directories(found).any(|name| at(found, name) == old);
        check(!is_directory || is_there, "the old kit is gone")
    }

    fn written(&self, found: &Tree) -> Result<(), String> {
        let is_new = at(found, self.output) == at(&self.after, self.output);
        check(is_new, "the output is not the new one")
    }

    fn complete(&self, found: &Tree) -> Result<(), String> {
        self.written(found).and_then(|()| tidy(found))
    }

    /// A run that nothing disturbs writes the new thing and removes what a killed one left, by name.
    fn next_run(&self, visit: &Visit, left: &Tree) -> Result<(), String> {
        let command = self.command.replace(" --force", "");
        let Ran { status, err, .. } = visit.run(&format!("{command} --force"));
        check(status == self.said.status, format!("the next run: {err}"))?;
        let found = visit.files();
        self.complete(&found).map_err(|why| format!("after the next run {why}"))?;
        // With `--force` on a file the old one is replaced.
        let is_file = matches!(self.after.get(self.output), Some(Entry::File(_)));
        let is_kept = copies(&self.before, USERS_OWN) <= copies(&found, USERS_OWN);
        check(is_kept || is_file, "the next run lost a user's file")?;
        let silent = partials(left).into_iter().find(|name| !err.contains(*name));
        check(silent.is_none(), format!("{silent:?} is removed without a word: {err}"))
    }
}

fn check(is_so: bool, why: impl Into<String>) -> Result<(), String> {
    is_so.then_some(()).ok_or_else(|| why.into())
}

/// A file or everything in a directory; `None` where nothing is.
fn at(tree: &Tree, name: &str) -> Option<Tree> {
    let entry = tree.get(name)?;
    below(tree, name).or_else(|| Some(Tree::from([(String::new(), entry.clone())])))
}

fn directories(tree: &Tree) -> impl Iterator<Item = &String> {
    tree.iter().filter(|(_, entry)| **entry == Entry::Directory).map(|(name, _)| name)
}

fn partials(tree: &Tree) -> Vec<&String> {
    let is_outermost =
        |name: &&String| name.split_once(".partial-").is_some_and(|(_, rest)| !rest.contains('/'));
    tree.keys().filter(is_outermost).collect()
}

fn tidy(found: &Tree) -> Result<(), String> {
    partials(found).first().map_or(Ok(()), |left| Err(format!("{left} was left")))
}

struct Call {
    name: String,
    number: usize,
    is_refusable: bool,
}

/// Calls that concern memory, time, threads and signals: the system refuses them nowhere, so they are
/// places to be killed at only. So is the end of listing a directory, whose failure (seen nowhere) makes
/// Rust's library panic.
const NO_FILE: &str = "arch_prctl brk clock_gettime clone clone3 exit exit_group futex getrandom gettid \
    getpid madvise mmap mprotect mremap munmap prctl prlimit64 restart_syscall rseq rt_sigaction \
    rt_sigprocmask rt_sigreturn sched_getaffinity sched_yield set_robust_list set_tid_address \
    sigaltstack tgkill";

fn calls(text: &str, output: &str) -> Vec<Call> {
    let first = text.split_whitespace().next().unwrap();
    let output = output.trim_start_matches("new/deep/");
    let (mut seen, mut calls) = (BTreeMap::new(), Vec::new());
    let (mut touched, mut listed) = (false, "");
    for line in text.lines() {
        let (process, rest) = line.split_once(char::is_whitespace).unwrap();
        let Some((name, words)) = rest.trim_start().split_once('(') else { continue };
        // A number and what it stands for.
        let handle = words.split([',', ')']).next().unwrap_or_default();
        if process != first || !name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') {
            continue;
        }
        let number = seen.entry(name).or_insert(0);
        *number += 1;
        touched |= name != "execve" && rest.contains(output);
        if touched {
            let concerns_files = !NO_FILE.split_whitespace().any(|other| other == name);
            let is_refusable = concerns_files && (name != "close" || handle != listed);
            calls.push(Call { name: name.to_string(), number: *number, is_refusable });
        }
        if name == "getdents64" {
            listed = handle;
        }
    }
    assert!(calls.len() > 20, "{output}: {text}");
    calls
}

fn traced(visit: &Visit, options: &[&str], command: &str) -> (Ran, String) {
    let log = NamedTempFile::new().unwrap();
    // Started in the background by a script, a program ignores Ctrl-C: `kill` has to end it all the same.
    let (ignored, options) = match options {
        [BACKGROUND, rest @ ..] => ("INT", rest),
        all => ("", all),
    };
    let output = Command::new("sh")
        .args(["-c", "[ -z \"$0\" ] || trap '' $0; exec strace \"$@\"", ignored])
        .args(["-f", "-e", "signal=none", "-o"])
        .arg(log.path())
        .args(options)
        .arg(nonius())
        .args(command.split_whitespace())
        .current_dir(visit.folder())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    (Ran::of(command, &output), fs::read_to_string(log.path()).unwrap())
}

/// The option of [`traced`] for a run that ignores Ctrl-C.
const BACKGROUND: &str = "background ";

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    Kill,
    /// Ended by Ctrl-C, the end of the session or `kill`.
    End,
    Refuse,
}

fn disturbed(played: &Played, call: &Call, fault: Fault, how: &str) -> Result<(), String> {
    let visit = Visit::new();
    lay(&played.before, visit.folder());
    let Call { name, number, .. } = call;
    let only = format!("trace={name}");
    let inject = format!("inject={name}:{}:when={number}", how.trim_start_matches(BACKGROUND));
    let background = how.starts_with(BACKGROUND).then_some(BACKGROUND);
    let options: Vec<&str> = background.into_iter().chain(["-e", &only, "-e", &inject]).collect();
    let (ran, log) = traced(&visit, &options, played.command);
    let found = visit.files();
    let next = |()| match fault {
        Fault::End => Ok(()),
        // The removal of what is not needed any more may have been refused; it is tried again.
        Fault::Refuse if partials(&found).is_empty() => Ok(()),
        _ => played.next_run(&visit, &found),
    };
    judge(played, fault, &ran, &found).and_then(next).map_err(|why| {
        let line = log.lines().find(|line| line.contains("INJECTED")).unwrap_or_default();
        let Ran { command, status, err, .. } = ran;
        format!("{command}: {how} at {name} {number}: {why}\n  status {status:?}, {line}\n  {err}")
    })
}

fn judge(played: &Played, fault: Fault, ran: &Ran, found: &Tree) -> Result<(), String> {
    played.whole(found)?;
    let done = ran.status == played.said.status;
    let is_end_of_a_list = ran.err.contains("unexpected error during closedir");
    let changed = || Err(format!("changed: {}", difference(&played.before, found)));
    match (fault, ran.status) {
        (Fault::Kill, None) => Ok(()),
        (Fault::End, Some(2) | None) => match tidy(found) {
            Ok(()) if *found != played.before && played.complete(found).is_err() => changed(),
            tidy => tidy,
        },
        (Fault::Refuse, Some(2)) if *found == played.before => Ok(()),
        (Fault::Refuse, Some(2)) => changed(),
        (Fault::Refuse, Some(_)) if done => played.written(found),
        (_, Some(_)) if done => played.complete(found),
        // The library panics where the end of a list of files is refused (docs/security.md §3): nothing is half.
        (Fault::Refuse, Some(101)) if is_end_of_a_list => played.kept(found),
        _ => Err("it ended in another way".to_string()),
    }
}

/// Tries faults at the system calls of all scenes: every `step`th of each scene, or all.
fn try_faults(fault: Fault, ways: &[&str], step: usize) {
    if !succeeds(Command::new("strace").args(["-f", "-o", "/dev/null", "true"])) {
        return skipped("strace is not here, or may not trace");
    }
    let step = if is_whole() { 1 } else { step };
    let (mut cases, mut all) = (Vec::new(), 0);
    for (number, played) in PLAYED.iter().enumerate() {
        let is_tried = |call: &&Call| fault != Fault::Refuse || call.is_refusable;
        let each = |call| ways.iter().map(move |how| (played, call, *how));
        let of_scene: Vec<_> = played.calls.iter().filter(is_tried).flat_map(each).collect();
        all += of_scene.len();
        // Each scene begins at another place; one case of each is taken at least.
        let first = (number * step / SCENES.len()) % of_scene.len();
        cases.extend(of_scene.into_iter().skip(first).step_by(step));
    }
    let tried = in_parallel(&cases, |(played, call, how)| disturbed(played, call, fault, how));
    let failures: Vec<String> = tried.into_iter().filter_map(Result::err).collect();
    told(&format!("{} of {all} cases", cases.len()));
    let shown = failures.iter().take(40).map(String::as_str).collect::<Vec<_>>().join("\n");
    assert!(failures.is_empty(), "{} of {} cases:\n{shown}", failures.len(), cases.len());
}

#[test]
fn killed_at_any_system_call_nothing_is_half_and_the_next_run_tidies_up() {
    try_faults(Fault::Kill, &["signal=SIGKILL"], 97);
}

#[test]
fn ended_at_any_system_call_nothing_unfinished_is_left() {
    try_faults(Fault::End, &["signal=SIGTERM", "signal=SIGINT", "background signal=SIGTERM"], 311);
}

#[test]
fn refused_at_any_system_call_everything_is_written_or_nothing() {
    let errors = ["ENOSPC", "EIO", "EACCES", "EINTR", "EINVAL"].map(|e| format!("error={e}"));
    try_faults(Fault::Refuse, &errors.each_ref().map(String::as_str), 211);
}

struct Stick(TempDir);

impl Stick {
    /// `None` where none can be mounted.
    fn new(size: &str) -> Option<Stick> {
        let folder = tempfile::tempdir().unwrap();
        let tmpfs = ["-t", "tmpfs", "-o", size, "tmpfs"];
        succeeds(Command::new("mount").args(tmpfs).arg(folder.path())).then(|| Stick(folder))
    }
}

impl Drop for Stick {
    fn drop(&mut self) {
        assert!(succeeds(Command::new("umount").arg("-l").arg(self.0.path())));
    }
}

#[test]
fn on_a_disk_of_any_size_everything_is_written_or_nothing() {
    if Stick::new("size=4k").is_none() {
        return skipped("a small memory disk cannot be mounted here");
    }
    // On these the commands find too little room at every stage, or enough: pages of 4 KiB, and numbers of names.
    let step = if is_whole() { 1 } else { 7 };
    let pages = (1..=48).step_by(step).map(|n| format!("size={}k", 4 * n));
    let names = (2..=26).step_by(step).map(|n| format!("nr_inodes={n}"));
    let sizes: Vec<String> = pages.chain(names).collect();
    let visit = Visit::of("start/errors");
    visit.append("job.toml", PROGRAM);
    with_part_program(&visit);
    let mut refused = 0;
    for (words, output) in [
        ("generate job.toml --force", "new/kit"),
        ("program job.toml --force", "kit"),
        ("simulate job.toml --errors --force", "put.csv"),
        ("path job.toml part.nc --force", "put.csv"),
    ] {
        let onto = |stick: &Path| {
            (visit.run(&format!("{words} -o {}/{output}", stick.display())), tree(stick))
        };
        let (new, after) = onto(Stick::new("size=8m").unwrap().0.path());
        let new = new.answers();
        for size in &sizes {
            let stick = Stick::new(size).unwrap();
            let mut before = tree(stick.0.path());
            for _ in 0..2 {
                let (ran, found) = onto(stick.0.path());
                let is_refused = ran.status == Some(2);
                let is_new = at(&found, output) == at(&after, output) && tidy(&found).is_ok();
                let is_right = match is_refused {
                    true => found == before && ran.err.contains("no space left"),
                    false => ran.status == new.status && is_new,
                };
                let changed = difference(&before, &found);
                assert!(is_right, "{words}, {size}: {changed}: {}", ran.all());
                refused += usize::from(is_refused);
                before = found;
            }
        }
    }
    assert!(refused > 8, "{refused}");
}
