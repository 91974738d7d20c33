//! What differs between two builds of the program: `cargo run --example same_output -- OLD NEW`.
//!
//! Both run the same commands, each in a folder of its own: every job of the fixtures from `plan` to the
//! report of a second measurement, every refusal, every control, the files of other makers. Exit statuses,
//! what is printed and all files written are compared; differences are counted by kind, with their first line.
//! `--list` names each. Exit status: 0 equal, 1 different, 2 not compared.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program of the tests")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

#[path = "../support/parallel.rs"]
#[allow(clippy::expect_used, reason = "shared with the tests")]
mod parallel;
#[path = "../support/refusals.rs"]
#[allow(dead_code, clippy::expect_used, clippy::panic, reason = "shared with the tests")]
mod refusals;
#[path = "../support/tree.rs"]
#[allow(dead_code, clippy::expect_used, clippy::panic, reason = "shared with the tests")]
mod tree;

use tree::{Entry, Tree};

/// What is asked of each job of the fixtures, one after the other; `{}` = its name without ending.
const OF_A_JOB: [&str; 24] = [
    "plan {}.toml",
    "plan {}.toml --format json",
    "program {}.toml -o {}-programs",
    "separate {}.toml -o {}-separated.csv --trials 100",
    "separate {}.toml --trials 100 --format json",
    "separate {}.toml --trials 100 --explain",
    "generate {}.toml -o {}-kit",
    "generate {}.toml -o {}-json-kit --format json",
    "generate {}.toml -o {}-explained --explain",
    "verify {}.toml --tables {}-kit",
    "verify {}.toml --tables {}-kit --format json",
    "assess {}.toml --grid 7,7,7",
    "assess {}.toml --grid 7,7,7 --format json",
    "assess {}.toml --grid 7,7,7 --tables {}-kit --format json",
    "context {}.toml",
    "report {}.toml --tables {}-kit -o {}-report.html",
    "history {}-kit",
    "simulate {}.toml --errors --tables {}-kit --noise-um 0.2 --seed 7 -o {}-errors.csv",
    "simulate {}.toml --tables {}-kit --noise-um 0.2 --seed 7 -o {}-readings.csv",
    "simulate {}.toml --tables {}-kit --format json -o {}-simulated.csv",
    "verify {}.toml --tables {}-kit --after {}-errors.csv",
    "verify {}.toml --tables {}-kit --after {}-errors.csv --format json",
    "verify {}.toml --tables {}-kit --after {}-errors.csv --explain",
    "report {}.toml --tables {}-kit --after {}-errors.csv --language de -o {}-after.html",
];

/// What is asked of each control.
const OF_A_CONTROL: [&str; 5] = [
    "controllers show {}",
    "controllers show {} --format json",
    "new --controller {} --travel 800,500,-400:0 -o errors",
    "new --controller {} --travel 800,500,-400:0 --readings --both-directions -o readings",
    "plan readings/job.toml",
];

/// Where the programs agree in all but a digit so far behind the first.
const LAST_DIGITS: f64 = 1e-8;

/// Commands for a folder of inputs.
struct Scene {
    name: String,
    inputs: Tree,
    commands: Vec<String>,
}

/// What a scene gave: by kind and name.
type Given = BTreeMap<(String, String), Vec<u8>>;

fn main() -> ExitCode {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_list = arguments.iter().any(|a| a == "--list");
    arguments.retain(|a| a != "--list");
    let [old, new] = &arguments[..] else {
        eprintln!("usage: cargo run --example same_output -- OLD NEW [--list]");
        return ExitCode::from(2);
    };
    let (Ok(old), Ok(new)) = (Path::new(old).canonicalize(), Path::new(new).canonicalize()) else {
        eprintln!("expected two programs");
        return ExitCode::from(2);
    };
    let scenes = scenes(&new);
    let found = parallel::in_parallel(&scenes, |scene| compare(scene, &old, &new));
    let outputs: usize = found.iter().map(|(count, _)| count).sum();
    let differing: Vec<Difference> = found.into_iter().flat_map(|(_, found)| found).collect();
    print!("{}", page(&differing, is_list));
    let (count, differ) = (scenes.len(), differing.len());
    println!("{outputs} outputs of {count} jobs, refusals and controls compared: {differ} differ");
    ExitCode::from(u8::from(differ > 0))
}

fn scenes(program: &Path) -> Vec<Scene> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let mut scenes = of_jobs(&fixtures);
    for case in refusals::all(&fixtures) {
        let files = case.files.iter();
        let inputs =
            files.map(|(name, bytes)| (name.clone(), Entry::File(bytes.clone()))).collect();
        scenes.push(Scene { name: case.name, inputs, commands: vec![case.command] });
    }
    let ids = printed(program, Path::new("."), "controllers list --format json");
    let ids = serde_json::from_slice::<serde_json::Value>(&ids.1).unwrap_or_default();
    for id in ids["controllers"].as_array().into_iter().flatten() {
        let id = id["id"].as_str().unwrap_or_default();
        let commands = OF_A_CONTROL.map(|command| command.replace("{}", id)).to_vec();
        scenes.push(Scene { name: format!("control {id}"), inputs: Tree::new(), commands });
    }
    scenes.extend(of_other_files(&fixtures));
    scenes
}

/// One scene a job: its folder, and every command.
fn of_jobs(fixtures: &Path) -> Vec<Scene> {
    let jobs = tree::tree(fixtures).into_keys().filter(|name| name.ends_with(".toml"));
    let jobs = jobs.map(|name| fixtures.join(name));
    let scene = |job: PathBuf| {
        let name = job.strip_prefix(fixtures).ok()?.with_extension("");
        let name = name.to_string_lossy().into_owned();
        let stem = job.file_stem()?.to_string_lossy().into_owned();
        let commands = OF_A_JOB.map(|command| command.replace("{}", &stem)).to_vec();
        Some(Scene { name, inputs: tree::tree(job.parent()?), commands })
    };
    jobs.filter_map(scene).collect()
}

/// Measurements of other makers, runs of one axis, and what has no input.
fn of_other_files(fixtures: &Path) -> Vec<Scene> {
    let scene = |folder: &str, commands: &[&str]| {
        let inputs =
            if folder.is_empty() { Tree::new() } else { tree::tree(&fixtures.join(folder)) };
        let asked = |command: &&str| match command.contains("{}") {
            true => inputs.keys().map(|name| command.replace("{}", name)).collect(),
            false => vec![command.to_string()],
        };
        let commands = commands.iter().flat_map(asked).collect();
        Scene { name: format!("{folder}/"), inputs, commands }
    };
    vec![
        scene("formats", &["import {} -o {}.csv", "import {} --sign as-error -o {}.signed.csv"]),
        scene("standards", &["standards {}", "standards {} --format json"]),
        scene("", &["controllers list", "man", "completions bash", "--help", "generate --help"]),
    ]
}

/// What differs of one output.
struct Difference {
    kind: String,
    name: String,
    old: String,
    new: String,
}

/// The number of outputs of a scene, and those that differ.
fn compare(scene: &Scene, old: &Path, new: &Path) -> (usize, Vec<Difference>) {
    let (old, new) = (given(scene, old), given(scene, new));
    let mut keys: Vec<_> = old.keys().chain(new.keys()).collect();
    keys.sort();
    keys.dedup();
    let differing = keys.iter().filter(|key| old.get(**key) != new.get(**key));
    let found = differing.map(|(kind, name)| {
        let key = (kind.clone(), name.clone());
        let (old, new) = (old.get(&key), new.get(&key));
        let text = |side: Option<&Vec<u8>>| side.map(|b| String::from_utf8_lossy(b).into_owned());
        let (old, new) = (text(old), text(new));
        let digits = matches!((&old, &new), (Some(a), Some(b)) if only_digits_differ(a, b));
        let kind = format!("{kind}{}", if digits { ", last digits" } else { "" });
        let (old, new) = first_difference(old.as_deref(), new.as_deref());
        Difference { kind, name: format!("{}: {name}", scene.name), old, new }
    });
    (keys.len(), found.collect())
}

/// Runs a scene in a fresh folder.
fn given(scene: &Scene, program: &Path) -> Given {
    let mut given = Given::new();
    let Ok(place) = tempfile::tempdir() else { return given };
    let mut before = scene.inputs.clone();
    for (name, entry) in &scene.inputs {
        if let Entry::File(bytes) = entry {
            let path = place.path().join(name);
            let made = path.parent().map(std::fs::create_dir_all);
            let written = std::fs::write(&path, bytes);
            if !matches!(made, Some(Ok(()))) || written.is_err() {
                given.insert(("not laid out".into(), name.clone()), Vec::new());
            }
        }
    }
    for command in &scene.commands {
        let (status, out, err) = printed(program, place.path(), command);
        let verb = command.split_whitespace().next().unwrap_or_default();
        let screen = if command.contains("--format json") { "JSON" } else { "screen" };
        for (channel, bytes) in [(screen, out), ("talk", err), ("status", status.into_bytes())] {
            given.insert((format!("{verb} {channel}"), command.clone()), bytes);
        }
        let after = tree::tree(place.path());
        for (name, entry) in &after {
            if let Entry::File(bytes) = entry
                && before.get(name) != Some(entry)
            {
                given.insert((format!("{verb} {}", kind_of(name)), name.clone()), bytes.clone());
            }
        }
        for name in before.keys().filter(|name| !after.contains_key(*name)) {
            given.insert((format!("{verb} removed"), name.clone()), Vec::new());
        }
        before = after;
    }
    given
}

/// Exit status, standard output, standard error.
fn printed(program: &Path, folder: &Path, command: &str) -> (String, Vec<u8>, Vec<u8>) {
    let words = command.split_whitespace();
    let mut program = Command::new(program);
    match program.args(words).current_dir(folder).stdin(Stdio::null()).output() {
        Ok(output) => (output.status.to_string(), output.stdout, output.stderr),
        Err(why) => (why.to_string(), Vec::new(), Vec::new()),
    }
}

/// What a written file is.
fn kind_of(name: &str) -> &'static str {
    let file = name.rsplit('/').next().unwrap_or(name);
    match file {
        "manifest.json" => "manifest",
        _ if file.starts_with("checklist.") => "checklist",
        _ if file.ends_with(".html") => "page",
        _ => "bytes",
    }
}

/// The first line in which two texts differ.
fn first_difference(old: Option<&str>, new: Option<&str>) -> (String, String) {
    let (Some(old), Some(new)) = (old, new) else {
        let is_there = |side: Option<&str>| side.map_or("absent", |_| "present").to_string();
        return (is_there(old), is_there(new));
    };
    let (mut old, mut new) = (old.lines(), new.lines());
    loop {
        match (old.next(), new.next()) {
            (None, None) => return ("other line ends".into(), "other line ends".into()),
            (a, b) if a == b => {}
            (a, b) => return around(a.unwrap_or("(end)"), b.unwrap_or("(end)")),
        }
    }
}

/// Two lines from a little before they part.
fn around(old: &str, new: &str) -> (String, String) {
    let same = old.chars().zip(new.chars()).take_while(|(a, b)| a == b).count();
    let part = |line: &str| line.chars().skip(same.saturating_sub(40)).take(110).collect();
    (part(old), part(new))
}

/// Whether two texts are the same but for digits of numbers behind the eighth.
fn only_digits_differ(old: &str, new: &str) -> bool {
    let (old, new) = (parts(old), parts(new));
    let is_same = |(a, b): (&&str, &&str)| {
        let are_near =
            |a: f64, b: f64| (a - b).abs() <= LAST_DIGITS * a.abs().max(b.abs()).max(1.0);
        a == b || matches!((a.parse(), b.parse()), (Ok(a), Ok(b)) if are_near(a, b))
    };
    old.len() == new.len() && old.iter().zip(&new).all(is_same)
}

/// A text cut where numbers begin and end.
fn parts(text: &str) -> Vec<&str> {
    let is_of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e');
    let mut parts = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let kind = is_of_number(first);
        let end = rest.find(|c| is_of_number(c) != kind).unwrap_or(rest.len());
        parts.push(&rest[..end]);
        rest = &rest[end..];
    }
    parts
}

/// The differences by kind: how many, and the first of each (or all of them).
fn page(differing: &[Difference], is_list: bool) -> String {
    let mut kinds: BTreeMap<&str, Vec<&Difference>> = BTreeMap::new();
    for one in differing {
        kinds.entry(&one.kind).or_default().push(one);
    }
    let mut page = String::new();
    for (kind, all) in kinds {
        let _ = writeln!(page, "{kind}: {}", all.len());
        for one in all.iter().take(if is_list { all.len() } else { 2 }) {
            let _ = writeln!(page, "  {}\n    - {}\n    + {}", one.name, one.old, one.new);
        }
    }
    page
}
