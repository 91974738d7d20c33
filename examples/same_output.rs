//! What differs between two builds of the program: `cargo run --example same_output -- OLD NEW`.
//!
//! Both run the same commands, each in a folder of its own: every job of the fixtures from `plan` to the
//! report of a second measurement, every refusal, every control, the files of other makers. Exit statuses,
//! what is printed and all files written are compared; differences are counted by kind, with their first line.
//! `--list` names each; a third word compares only what has it in its name. `--windows`: NEW is for Windows, so `\` and the
//! ending of its name are no difference; and since wine starts nothing once in thousands of starts, a scene that differs
//! runs once more, and is named. Exit status: 0 equal, 1 different,
//! anything else: not compared. All has been compared only where every command came to its end once.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::expect_used,
    reason = "a program of the tests, which stops at what it did not expect"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode, ExitStatus, Stdio};

#[path = "../tests/support/parallel.rs"]
mod parallel;
#[path = "../tests/support/refusals.rs"]
#[allow(dead_code, reason = "shared with the tests")]
mod refusals;
#[path = "../tests/support/tree.rs"]
#[allow(dead_code, reason = "shared with the tests")]
mod tree;

use tree::{Entry, Tree};

/// What is asked of each job of the fixtures, one after the other; `{}` = its name without ending.
const OF_A_JOB: [&str; 29] = [
    "plan {}.toml",
    "plan {}.toml --format json",
    "program {}-run.toml -o {}-programs",
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
    "path {}.toml part.nc --with-tables -o {}-path.csv --plot {}-path.svg",
    "path {}.toml part.nc --tables {}-kit --format json",
    "report {}.toml --tables {}-kit -o {}-report.html",
    "history {}-kit",
    "simulate {}.toml --errors --tables {}-kit --noise-um 0.2 --seed 7 -o {}-errors.csv",
    "simulate {}.toml --tables {}-kit --noise-um 0.2 --seed 7 -o {}-readings.csv",
    "simulate {}.toml --tables {}-kit --format json -o {}-simulated.csv",
    "verify {}.toml --tables {}-kit --after {}-errors.csv",
    "verify {}.toml --tables {}-kit --after {}-errors.csv --format json",
    "verify {}.toml --tables {}-kit --after {}-errors.csv --explain --plot {}-after.svg",
    "generate {}.toml -o {}-kit --force --plot {}-kit.svg",
    "generate {}.toml --compare",
    "history {}-kit --format json",
    "report {}.toml --tables {}-kit --after {}-errors.csv --language de -o {}-after.html",
];

/// What stands behind a job where it leads a run, and a part program in machine coordinates.
const RUN: &str = "\n[program]\nwhat = \"step-diagonal\"\nsteps = 4\n\
    start_mm = { x = 10.0, y = 10.0, z = -190.0 }\nsize_mm = { x = 300.0, y = 200.0, z = 150.0 }\n";
const PART: &str = "G90 G94 G53 G0 X10. Y10. Z-10.\nG53 G1 X50. F500\nG53 G1 Y40. Z-60.\nM30\n";

/// What is asked of each control.
const OF_A_CONTROL: [&str; 4] = [
    "controllers show {}",
    "controllers show {} --format json",
    "new --controller {} --travel 800,500,-400:0 -o errors",
    "new --controller {} --travel 800,500,-400:0 --readings --both-directions -o readings",
];

/// What needs no file.
const OF_NO_FILE: [&str; 5] =
    ["controllers list", "man", "completions bash", "--help", "generate --help"];

/// The form of whatever has to be refused.
const REFUSAL: &str = "a refusal";

/// Where the programs agree in all but a digit so far behind the first.
const LAST_DIGITS: f64 = 1e-8;

/// What is asked of files of other makers.
const OF_OTHER_FILES: [&str; 8] = [
    "import rtl_linear_bidirectional_selfmade.rtl --term EXX --first-target-at-mm -200 --targets-run + --sign as-error --material-corrected yes -o rtl.csv",
    "import ren_table_selfmade.ren --term EYX --first-target-at-mm 400 --targets-run - -o ren.csv",
    "import pos_linear_selfmade.pos --term EXX --first-target-at-mm 0 --targets-run + --sign as-error --material-corrected no -o pos.csv",
    "import etalon_exchange_selfmade.txt --sign as-error -o etalon.csv",
    "import isg_component_errors_selfmade.csv --sign as-correction -o isg.csv",
    "import columns.csv --columns AXn=position_mm,Delta=ex_mm --axis x --direction both --sign as-error -o mapped.csv",
    "standards x_axis.csv",
    "standards x_axis.csv --format json",
];

/// Commands for a folder of inputs, each with the form that it was made from.
struct Scene {
    name: String,
    inputs: Tree,
    commands: Vec<(&'static str, String)>,
}

/// What a scene gave, by kind and name, and the forms of the commands that came to their end.
#[derive(Default)]
struct Given {
    outputs: BTreeMap<(String, String), Vec<u8>>,
    ended: BTreeSet<&'static str>,
}

impl Given {
    fn add(&mut self, kind: String, name: &str, bytes: Vec<u8>) {
        self.outputs.insert((kind, name.to_string()), bytes);
    }
}

fn main() -> ExitCode {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let [is_list, is_windows] =
        ["--list", "--windows"].map(|word| arguments.iter().any(|own| own == word));
    arguments.retain(|own| !own.starts_with("--"));
    let (old, new, only) = match &arguments[..] {
        [old, new] => (old, new, ""),
        [old, new, only] => (old, new, only.as_str()),
        _ => {
            eprintln!(
                "usage: cargo run --example same_output -- OLD NEW [PART OF A NAME] [--list] [--windows]"
            );
            return ExitCode::from(2);
        }
    };
    let program = |path: &String| Path::new(path).canonicalize().expect("two programs");
    let (old, new) = (program(old), program(new));
    let mut scenes = scenes(&new);
    scenes.retain(|scene| scene.name.contains(only));
    if scenes.is_empty() {
        eprintln!("not compared: no job, refusal or control has `{only}` in its name");
        return ExitCode::from(2);
    }
    let found = parallel::in_parallel(&scenes, |scene| {
        let found = compare(scene, &old, &new, is_windows);
        if !is_windows || found.2.is_empty() {
            return found;
        }
        eprintln!("again: {}", scene.name);
        compare(scene, &old, &new, is_windows)
    });
    let outputs: usize = found.iter().map(|(count, ..)| count).sum();
    let ended: BTreeSet<&str> = found.iter().flat_map(|(_, ended, _)| ended).copied().collect();
    let forms: BTreeSet<&str> =
        scenes.iter().flat_map(|scene| &scene.commands).map(|(form, _)| *form).collect();
    let differing: Vec<Difference> = found.into_iter().flat_map(|(.., found)| found).collect();
    print!("{}", page(&differing, is_list));
    let (count, differ) = (scenes.len(), differing.len());
    println!("{outputs} outputs of {count} jobs, refusals and controls compared: {differ} differ");
    let never: Vec<_> = forms.difference(&ended).collect();
    if only.is_empty() && !never.is_empty() {
        eprintln!("not compared: never came to its end in {}: {never:?}", new.display());
        return ExitCode::from(2);
    }
    ExitCode::from(u8::from(differ > 0))
}

fn scenes(program: &Path) -> Vec<Scene> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let mut scenes = of_jobs(&fixtures);
    for case in refusals::all(&fixtures) {
        let commands = vec![(REFUSAL, case.command)];
        scenes.push(Scene { name: case.name, inputs: case.files, commands });
    }
    let ids = printed(program, Path::new("."), "controllers list --format json");
    let ids: serde_json::Value = serde_json::from_slice(&ids.1).expect("a list of controls");
    for id in ids["controllers"].as_array().expect("a list of controls") {
        let id = id["id"].as_str().expect("a name");
        let commands = OF_A_CONTROL.map(|form| (form, form.replace("{}", id))).to_vec();
        scenes.push(Scene { name: format!("control {id}"), inputs: Tree::new(), commands });
    }
    let folders = ["formats", "standards", "base"].map(|name| tree::tree(&fixtures.join(name)));
    let inputs = folders.into_iter().flatten().collect();
    let commands = OF_OTHER_FILES.iter().chain(&OF_NO_FILE);
    let commands = commands.map(|form| (*form, form.to_string())).collect();
    scenes.push(Scene { name: "files of other makers".into(), inputs, commands });
    scenes
}

/// One scene a job: its folder, and every command.
fn of_jobs(fixtures: &Path) -> Vec<Scene> {
    let jobs = tree::tree(fixtures).into_keys().filter(|name| name.ends_with(".toml"));
    let scene = |name: String| {
        let job = fixtures.join(&name);
        let stem = job.file_stem().expect("a name").to_string_lossy().into_owned();
        let commands = OF_A_JOB.map(|form| (form, form.replace("{}", &stem))).to_vec();
        let mut inputs = tree::tree(job.parent().expect("a folder"));
        let run = std::fs::read_to_string(&job).expect("a job") + RUN;
        inputs.insert(format!("{stem}-run.toml"), Entry::File(run.into()));
        inputs.insert("part.nc".into(), Entry::File(PART.into()));
        Scene { name, inputs, commands }
    };
    jobs.map(scene).collect()
}

/// What differs of one output.
struct Difference {
    kind: String,
    name: String,
    old: String,
    new: String,
}

/// The number of outputs of a scene, the forms of the commands that came to their end, and what differs.
fn compare(
    scene: &Scene,
    old: &Path,
    new: &Path,
    is_windows: bool,
) -> (usize, BTreeSet<&'static str>, Vec<Difference>) {
    let (Given { outputs: old, .. }, Given { outputs: new, ended }) =
        (given(scene, old), given(scene, new));
    let keys: BTreeSet<_> = old.keys().chain(new.keys()).collect();
    let text = |bytes: &Vec<u8>| {
        let text = String::from_utf8_lossy(bytes);
        match is_windows {
            true => text.replace('\\', "/").replace("nonius.exe", "nonius"),
            false => text.into_owned(),
        }
    };
    let is_same = |key: &(String, String)| match (old.get(key), new.get(key)) {
        (Some(a), Some(b)) => a == b || is_windows && text(a) == text(b),
        _ => false,
    };
    let found = keys.iter().filter(|key| !is_same(key)).map(|key| {
        let (kind, name) = key;
        let (old, new) = (old.get(*key).map(text), new.get(*key).map(text));
        let digits = matches!((&old, &new), (Some(a), Some(b)) if only_digits_differ(a, b));
        let kind = format!("{kind}{}", if digits { ", last digits" } else { "" });
        let (old, new) = first_difference(old.as_deref(), new.as_deref());
        Difference { kind, name: format!("{}: {name}", scene.name), old, new }
    });
    (keys.len(), ended, found.collect())
}

/// Runs a scene in a fresh folder.
fn given(scene: &Scene, program: &Path) -> Given {
    let place = tempfile::tempdir().expect("a folder");
    tree::lay(&scene.inputs, place.path());
    let (mut given, mut before) = (Given::default(), tree::tree(place.path()));
    for (form, command) in &scene.commands {
        let (status, out, err) = printed(program, place.path(), command);
        if matches!(status.code(), Some(0 | 1)) || *form == REFUSAL {
            given.ended.insert(form);
        }
        let verb = command.split_whitespace().next().unwrap_or_default();
        let screen = if command.contains("--format json") { "JSON" } else { "screen" };
        let status = status.to_string().into_bytes();
        for (channel, bytes) in [(screen, out), ("talk", err), ("status", status)] {
            given.add(format!("{verb} {channel}"), command, bytes);
        }
        let after = tree::tree(place.path());
        for (name, entry) in &after {
            if let Entry::File(bytes) = entry
                && before.get(name) != Some(entry)
            {
                given.add(format!("{verb} {}", kind_of(name)), name, bytes.clone());
            }
        }
        for name in before.keys().filter(|name| !after.contains_key(*name)) {
            given.add(format!("{verb} removed"), name, Vec::new());
        }
        before = after;
    }
    given
}

/// Exit status, standard output, standard error.
fn printed(program: &Path, folder: &Path, command: &str) -> (ExitStatus, Vec<u8>, Vec<u8>) {
    let words = command.split_whitespace();
    let mut program = Command::new(program);
    let ran = program.args(words).current_dir(folder).stdin(Stdio::null()).output();
    let ran = ran.expect("the program starts");
    (ran.status, ran.stdout, ran.stderr)
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
