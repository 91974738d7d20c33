//! Coverage-guided fuzzing of `nonius` on stable Rust: inputs are changed, those that take a new way through the
//! program are kept and changed further, and of every case the same things have to hold (src/case.rs, src/commands.rs).
//!
//! ```text
//!  fixtures, corpus/ ─→ queue ─→ mutate ─→ targets: readers, kits │ commands ─→ oracles, grammar ─→ found/
//!                         ↑                                           │
//!                         └────────────── coverage: new edges ────────┘
//! ```
//! `launcher` builds this with counters; `supervisor` starts one `worker` for each job and goes on when one is killed.
//! `rust-fuzz`'s tools need the nightly compiler or programs of their own; this needs neither.

mod bundle;
mod case;
mod commands;
mod coverage;
mod distil;
mod finding;
mod grammar;
mod growth;
mod kits;
mod memory;
mod mutate;
mod oracles;
mod queue;
#[path = "../../tests/support/random.rs"]
mod random;
mod readers;
#[path = "../../tests/support/refusals.rs"]
#[allow(dead_code, reason = "the tests use the rest")]
mod refusals;
mod supervisor;
mod targets;
#[path = "../../tests/support/tree.rs"]
#[allow(dead_code, reason = "the tests use the rest")]
mod tree;
mod watch;
mod worker;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;
use worker::Plan;

const USAGE: &str = "\
cargo run --release --manifest-path fuzz/Cargo.toml -- [--seconds N | --hours N] [--cases N] [--jobs N] [--seed N]
                                                       [--only TARGET] [--keep DIR]
                                                    -- replay FILE      run one case again
                                                    -- distil DIR [TARGET]   make corpus/ anew from what --keep kept
                                                    -- growth    whether work grows with the input
                                                    -- planted   whether the bugs of planted/ are found";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["program", ..] => commands::program(&arguments[1..]),
        ["worker", place, seed, time, cases, ref only @ ..] => {
            as_worker(place, [seed, time, cases], only.first().copied())
        }
        ["replay", path] => replay(Path::new(path)),
        ["growth"] => growth(),
        ["distil", run, ref only @ ..] => {
            distil::distil(Path::new(run), only.first().copied());
            ExitCode::SUCCESS
        }
        _ => match plan(&words) {
            Some((plan, jobs, kept)) => fuzz(&plan, jobs, kept),
            None => {
                eprintln!("{USAGE}");
                ExitCode::from(2)
            }
        },
    }
}

/// Plan, number of workers, and whether the directory stays.
fn plan(words: &[&str]) -> Option<(Plan, usize, bool)> {
    let mut plan = Plan {
        place: supervisor::place(),
        seed: 1,
        time: Duration::MAX,
        cases: u64::MAX,
        only: None,
    };
    let (mut jobs, mut kept) = (1, false);
    for pair in words.chunks(2) {
        let [option, value] = pair else { return None };
        match *option {
            "--seconds" => plan.time = Duration::from_secs_f64(value.parse().ok()?),
            "--hours" => plan.time = Duration::from_secs_f64(value.parse::<f64>().ok()? * 3600.0),
            "--cases" => plan.cases = value.parse().ok()?,
            "--jobs" => jobs = value.parse().ok()?,
            "--seed" => plan.seed = value.parse().ok()?,
            "--only" => plan.only = Some(value.to_string()),
            "--keep" => (plan.place, kept) = (PathBuf::from(value), true),
            _ => return None,
        }
    }
    plan.time = match plan.time == Duration::MAX {
        true if plan.cases == u64::MAX => Duration::from_secs(60),
        true => Duration::from_secs(10 * 365 * 24 * 3600),
        false => plan.time,
    };
    Some((plan, jobs, kept))
}

fn growth() -> ExitCode {
    let place = supervisor::place();
    let is_good = std::fs::create_dir_all(&place).is_ok() && growth::judge(&place);
    let _ = std::fs::remove_dir_all(&place);
    if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn fuzz(plan: &Plan, jobs: usize, kept: bool) -> ExitCode {
    println!("{} edges counted in nonius, seed {}", coverage::edges(), plan.seed);
    let (cases, findings) = supervisor::supervise(plan, jobs);
    supervisor::print_sum(plan.seed, cases, findings);
    if !kept {
        let _ = std::fs::remove_dir_all(&plan.place);
    }
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn as_worker(place: &str, numbers: [&str; 3], only: Option<&str>) -> ExitCode {
    let [seed, time, cases] = numbers.map(|number| number.parse::<u64>().unwrap_or(0));
    let time = Duration::from_millis(time);
    worker::work(&Plan {
        place: PathBuf::from(place),
        seed,
        time,
        cases,
        only: only.map(str::to_string),
    });
    ExitCode::SUCCESS
}

/// Runs a case of `found/` or `corpus/` again, and prints what came of it.
fn replay(path: &Path) -> ExitCode {
    let (Ok(input), place) = (std::fs::read(path), supervisor::place()) else {
        eprintln!("{} cannot be read", path.display());
        return ExitCode::from(2);
    };
    let path = path.to_string_lossy().into_owned();
    let is_of = |target: &&targets::Target| {
        path.contains(&format!("/{}-", target.name)) || path.contains(&format!("/{}/", target.name))
    };
    let targets = targets::all();
    let Some(target) = targets.iter().filter(is_of).max_by_key(|target| target.name.len()) else {
        eprintln!("the file's name tells no target");
        return ExitCode::from(2);
    };
    case::note_panics();
    let _ = std::fs::create_dir_all(&place);
    let ran = target.run(&place, &input);
    let _ = std::fs::remove_dir_all(&place);
    println!(
        "{}\n{}: {}",
        ran.answer,
        target.name,
        ran.wrong.as_deref().unwrap_or("nothing is wrong")
    );
    if ran.wrong.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
