//! One case of the whole program: a directory with the files of a bundle, and the arguments in its file `command`.
//!
//! The program is a process of its own, made from this one (`engine program REPORT ARGUMENTS`), so that status,
//! streams and files are those that a user gets. It leaves its peak of memory, its steps and its counters in a report.

use crate::bundle::Bundle;
use crate::case::{Ran, memory_limit};
use crate::coverage::{self, Edge};
use crate::tree::{Entry, tree};
use crate::{memory, oracles, watch};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// The program itself: `arguments` are the report and those of `nonius`.
pub fn program(arguments: &[String]) -> ExitCode {
    let Some((report, arguments)) = arguments.split_first() else {
        return ExitCode::from(2);
    };
    watch::begin("", &[]);
    watch::start(Path::new(report));
    let start = memory::start();
    let all = std::iter::once("nonius").chain(arguments.iter().map(String::as_str));
    let status = nonius::cli::run(all.map(Into::into));
    let mut bytes = (memory::peak(start) as u64).to_le_bytes().to_vec();
    bytes.extend(coverage::steps().to_le_bytes());
    bytes.extend(coverage::counters());
    // Without a report the case counts as ended by a signal, which is what it would be.
    let _ = fs::write(report, bytes);
    status
}

/// The files and folders (`NAME/`, without bytes) of a directory by name, also in its folders.
type Files = BTreeMap<String, Vec<u8>>;

/// What a run of the program left.
struct Run {
    status: Option<i32>,
    told: String,
    before: Files,
    after: Files,
    counters: Vec<u8>,
    steps: u64,
    peak: usize,
}

/// Runs a bundle's command, and judges it; after `generate` also `verify` and `history`.
pub fn run(place: &Path, input: &[u8]) -> Ran {
    let bundle = Bundle::read(input);
    let command =
        bundle.file("command").map_or("generate job.toml -o kit".into(), String::from_utf8_lossy);
    let words: Vec<&str> = command.split_whitespace().collect();
    // Longer command lines are not for the program to refuse: the system does.
    if command.len() > 60_000 || !words.iter().all(|word| stays_inside(word)) {
        return Ran::default();
    }
    let directory = place.join("case");
    lay_out(&bundle, &directory);
    let first = start(place, &directory, &words);
    let mut trace = coverage::trace(&first.counters);
    let mut wrong = judge(&first, &words, input).err();
    let is_asked = words.iter().any(|word| ["-h", "--help"].contains(word));
    if wrong.is_none()
        && words.first() == Some(&"generate")
        && matches!(first.status, Some(0 | 1))
        && !is_asked
    {
        wrong = follow_up(place, &directory, &words, (&first, input), &mut trace).err();
    }
    if wrong.is_none() && matches!(first.status, Some(0 | 1)) {
        wrong = made_again(place, &directory, &words, &first).err();
    }
    let mut answer = format!("{:?} {}", first.status, first.told);
    for (name, bytes) in &first.after {
        answer += &format!("\n=== {name}\n{}", String::from_utf8_lossy(bytes));
    }
    Ran { wrong, trace, answer, steps: first.steps }
}

/// What a command is told to write.
fn outputs<'a>(words: &[&'a str]) -> Vec<&'a str> {
    let options = ["-o", "--output", "--plot"];
    let named = words.windows(2).filter(|pair| options.contains(&pair[0])).map(|pair| pair[1]);
    let joined = words.iter().filter_map(|word| word.split_once('='));
    let joined = joined.filter(|(option, _)| options.contains(option)).map(|(_, name)| name);
    let in_one = words.iter().filter_map(|word| word.strip_prefix("-o"));
    named.chain(joined).chain(in_one.filter(|name| !name.is_empty())).collect()
}

/// A word that names nothing outside the directory of the case.
fn stays_inside(word: &str) -> bool {
    let bytes = word.as_bytes();
    let slash = |at: usize| {
        bytes[at] == b'/'
            && (at == 0 || !bytes[at - 1].is_ascii_alphanumeric() || word.starts_with('-'))
    };
    !word.contains("..") && !word.contains('\0') && !(0..bytes.len()).any(slash)
}

fn lay_out(bundle: &Bundle, directory: &Path) {
    let _ = fs::remove_dir_all(directory);
    let _ = fs::create_dir_all(directory);
    for (name, bytes) in bundle.0.iter().filter(|(name, _)| name != "command") {
        let path = directory.join(name);
        let _ = path.parent().map(fs::create_dir_all);
        let _ = fs::write(path, bytes); // a name that the system does not take is left out
    }
}

fn start(place: &Path, directory: &Path, words: &[&str]) -> Run {
    let report = place.join("report");
    let _ = fs::remove_file(&report);
    let before = files(directory);
    let own = std::env::current_exe().unwrap_or_else(|_| PathBuf::from("engine"));
    let mut command = Command::new(own);
    command.arg("program").arg(&report).args(words).current_dir(directory).stdin(Stdio::null());
    let (status, told) = match command.output() {
        Ok(output) => (output.status.code(), [output.stderr, output.stdout].concat()),
        Err(error) => (None, error.to_string().into_bytes()),
    };
    let report = fs::read(&report).unwrap_or_default();
    let (peak, rest) = report.split_at(report.len().min(8));
    let (steps, counters) = rest.split_at(rest.len().min(8));
    let number = |bytes: &[u8]| bytes.try_into().map_or(0, u64::from_le_bytes);
    Run {
        status,
        told: String::from_utf8(told).unwrap_or_else(|_| "\u{0} (no UTF-8)".to_string()),
        before,
        after: files(directory),
        counters: counters.to_vec(),
        steps: number(steps),
        peak: number(peak) as usize,
    }
}

/// What lies in a directory; the name of a folder ends in `/`.
fn files(directory: &Path) -> Files {
    let named = |(name, entry)| match entry {
        Entry::Directory => (name + "/", Vec::new()),
        Entry::File(bytes) => (name, bytes),
        Entry::Other(what) => (name, what.into_bytes()),
    };
    tree(directory).into_iter().map(named).collect()
}

/// What a run that answers may leave: what was there, and its outputs. Of an output that was there before, with
/// `--force` a file is exchanged, and a folder lies at its name with `.previous`, with everything that was in it.
fn judge_files(run: &Run, words: &[&str]) -> Result<(), String> {
    let outputs = outputs(words);
    let has_force = words.contains(&"--force");
    if let Some(name) = run.after.keys().find(|name| name.contains(".partial-")) {
        return Err(format!("left behind: {name}"));
    }
    let is_kept = |name: &str, bytes: &Vec<u8>| {
        let moved = |output: &&str| {
            let output = output.trim_end_matches('/');
            let rest = name.strip_prefix(output).filter(|rest| rest.starts_with('/'))?;
            let kept = |(other, found): (&String, &Vec<u8>)| {
                other.starts_with(&format!("{output}.previous"))
                    && other.ends_with(rest)
                    && found == bytes
            };
            Some(run.after.iter().any(kept))
        };
        has_force && (outputs.contains(&name) || outputs.iter().find_map(moved).unwrap_or(false))
    };
    let mut changed = run.before.iter().filter(|(name, bytes)| run.after.get(*name) != Some(bytes));
    if let Some((name, _)) = changed.find(|(name, bytes)| !is_kept(name, bytes)) {
        return Err(format!("an input was changed: {name}"));
    }
    let is_output = |name: &&String| {
        let of = |output: &&str| {
            let output = output.trim_start_matches("./").trim_end_matches('/');
            name.starts_with(output) || output.starts_with(name.as_str())
        };
        run.before.contains_key(*name) || outputs.iter().any(of)
    };
    match run.after.keys().find(|name| !is_output(name)) {
        Some(name) => Err(format!("something else was written: {name}")),
        None => Ok(()),
    }
}

fn judge(run: &Run, words: &[&str], input: &[u8]) -> Result<(), String> {
    let told = || {
        let from = run.told.char_indices().rev().nth(299).map_or(0, |(at, _)| at);
        &run.told[from..]
    };
    match run.status {
        Some(0 | 1) => {}
        Some(2) if run.after == run.before => {}
        Some(2) => return Err("status 2, and the directory is another".to_string()),
        status => return Err(format!("status {status:?}: {}", told())),
    }
    if run.counters.is_empty() && coverage::edges() > 0 {
        return Err("the run left no report of its memory and steps".to_string());
    }
    judge_files(run, words)?;
    let made = run.after.iter().filter(|(_, bytes)| !run.before.values().any(|old| old == *bytes));
    let mut size = run.before.values().map(Vec::len).sum::<usize>() + run.told.len();
    oracles::judge(&run.told, input)?;
    for (name, bytes) in made {
        size += bytes.len();
        oracles::judge(&oracles::text(bytes), input).map_err(|wrong| format!("{name}: {wrong}"))?;
        let is_page = bytes.starts_with(b"<!DOCTYPE html>"); // of `report`, whatever its name
        if name.ends_with(".csv") && !is_page {
            oracles::judge_cells(&oracles::text(bytes))
                .map_err(|wrong| format!("{name}: {wrong}"))?;
        }
    }
    match run.peak > memory_limit(size) {
        true => Err(format!(
            "memory: {} MiB at its peak for {} KiB in and out",
            run.peak >> 20,
            size >> 10
        )),
        false => Ok(()),
    }
}

/// What `generate` made, `verify` judges alike and `history` takes.
fn follow_up(
    place: &Path,
    directory: &Path,
    words: &[&str],
    (made, input): (&Run, &[u8]),
    trace: &mut Vec<Edge>,
) -> Result<(), String> {
    let kit = words.windows(2).find(|pair| pair[0] == "-o").map(|pair| pair[1]);
    let (Some(kit), Some(job)) = (kit, words.get(1)) else {
        return Ok(());
    };
    let verified = start(place, directory, &["verify", job, "--tables", kit]);
    let history = start(place, directory, &["history", kit]);
    *trace = coverage::trace(&merged(&[&made.counters, &verified.counters, &history.counters]));
    if verified.status != made.status {
        return Err(format!(
            "generate ends with {:?}, verify with {:?}: {}",
            made.status, verified.status, verified.told
        ));
    }
    if !matches!(history.status, Some(0))
        && !made.before.keys().any(|name| name.contains("manifest"))
    {
        return Err(format!("history ends with {:?}: {}", history.status, history.told));
    }
    judge(&verified, &[], input).and_then(|()| judge(&history, &[], input))
}

/// What took the place of something is made in the same way once more: so it did not replace what it is made of. Only a
/// form is filled in where it lies.
fn made_again(place: &Path, directory: &Path, words: &[&str], made: &Run) -> Result<(), String> {
    let is_form =
        |output: &&str| words.windows(2).any(|pair| pair[0] == "--form" && pair[1] == *output);
    let outputs = outputs(words);
    let mut replaced = outputs.iter().map(|output| output.trim_end_matches('/'));
    let Some(output) = replaced.find(|output| {
        let folder = format!("{output}/");
        let was_there = made.before.contains_key(*output) || made.before.contains_key(&folder);
        was_there && !is_form(output)
    }) else {
        return Ok(());
    };
    let again = start(place, directory, words);
    if again.status != made.status {
        return Err(format!(
            "{output} was replaced; made again: {:?}: {}",
            again.status, again.told
        ));
    }
    let is_of = |name: &str| name == output || name.starts_with(&format!("{output}/"));
    match made
        .after
        .iter()
        .find(|(name, bytes)| is_of(name) && again.after.get(*name) != Some(bytes))
    {
        Some((name, _)) => Err(format!("{output} was replaced; made again, another {name}")),
        None => Ok(()),
    }
}

fn merged(all: &[&[u8]]) -> Vec<u8> {
    let mut sum = all[0].to_vec();
    for counters in &all[1..] {
        for (sum, count) in sum.iter_mut().zip(*counters) {
            *sum = sum.saturating_add(*count);
        }
    }
    sum
}
