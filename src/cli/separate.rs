//! `nonius separate JOB [-o errors.csv]`

mod advice;
mod agreement;
mod closure;
mod diagonals;
mod document;
mod reversal;
mod straight;
mod text;
mod words;

use crate::cli::outcome::Outcome;
use crate::cli::{Answer, Format, inputs, write};
use crate::inputs::error_table;
use crate::machine::separation::Separation;
use crate::machine::separation::metric::Plane;
use crate::machine::separation::monte_carlo::{Plan, Simulated, simulate};
use crate::machine::separation::noise::run_counts;
use crate::machine::separation::uncertainty::Budget;
use crate::quantity::axis::ErrorTerm;
use crate::quantity::diagonal::PathKind;
use crate::text::problem::{Problem, Problems};
use clap::Args;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

// Options of `separate`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML) with readings of the body diagonals; `-` = standard input
    job: PathBuf,
    /// The error table (CSV) of the nine errors; `-` = standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing error table
    #[arg(long)]
    force: bool,
    /// Trials of the Monte Carlo simulation of ranges and straightness; 0 = none
    #[arg(long, default_value_t = 2000, value_parser = trials)]
    trials: usize,
    /// Seed of the simulation
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

const MOST_TRIALS: usize = 10_000_000;
/// A simulation that is not done by then shows how far it is.
const PATIENCE: Duration = Duration::from_secs(1);

fn trials(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(1) | Err(_) => Err(format!(
            "expected 0 or a whole number from 2 to {MOST_TRIALS}"
        )),
        Ok(many) if many > MOST_TRIALS => Err(format!("at most {MOST_TRIALS}")),
        Ok(trials) => Ok(trials),
    }
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let to_stdout = options.output.as_deref() == Some(Path::new("-"));
    if to_stdout && options.format == Format::Json {
        return Err(Problem::new(
            "the error table and the document cannot both go to standard output",
        )
        .help("name a file with `-o`, or leave `--format json` out")
        .into());
    }
    if let Some(output) = options.output.as_deref().filter(|_| !to_stdout) {
        write::ensure_new(output, options.force)?;
    }
    let campaign = inputs::read_campaign(&options.job)?;
    if campaign.measurement.kind == PathKind::Straight {
        return straight_runs(options, &campaign);
    }
    let separation = campaign.separate()?;
    let simulated = simulated(options, &campaign, &separation)?;
    let csv = || error_table::write(&campaign.draft(&separation)).into_bytes();
    let outcome = match options.format {
        Format::Json => Outcome::json(&document::separation(&separation, simulated.as_ref())?)?,
        Format::Text => {
            let summary = text::summary(&separation, simulated.as_ref())?;
            match to_stdout {
                true => Outcome::bytes(csv()).saying(summary),
                false => Outcome::text(&summary),
            }
        }
    };
    // No, where an error is not determined or something speaks against the result.
    let outcome = outcome.answering(Answer::yes(separation.stands()));
    Ok(match options.output.as_deref().filter(|_| !to_stdout) {
        None => outcome,
        Some(output) => outcome
            .writing(write::write_file(output, &csv(), options.force)?)
            .saying(format!("wrote {}", output.display())),
    })
}

fn straight_runs(options: &Options, campaign: &inputs::CampaignFiles) -> Result<Outcome, Problems> {
    if options.output.is_some() {
        return Err(Problem::new(
            "straight runs hold no nine errors: four totals are three squareness errors and one combination of the scales",
        )
        .help("leave `-o` out, or measure in single-axis steps (`kind = \"step\"`)")
        .into());
    }
    let result = campaign.straight()?;
    let outcome = match options.format {
        Format::Text => Outcome::text(&straight::page(&result)?),
        Format::Json => Outcome::json(&straight::document(&result)?)?,
    };
    Ok(outcome.answering(Answer::yes(result.doubts.is_empty())))
}

fn simulated(
    options: &Options,
    files: &inputs::CampaignFiles,
    separation: &Separation,
) -> Result<Option<Simulated>, Problems> {
    if options.trials == 0 {
        return Ok(None);
    }
    let campaign = files.campaign()?;
    let runs = run_counts(&separation.runs);
    let budget = Budget {
        volume: &separation.volume,
        noise: separation.noise,
        runs: &runs,
        turned: separation.turn.is_some(),
        stated: campaign.stated,
        material: separation.material,
    };
    let plan = Plan {
        trials: options.trials,
        seed: options.seed,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
    };
    let progress = Progress::new(options.trials);
    let hear = |done: usize| progress.add(done);
    let simulated = simulate(&campaign, &budget, &separation.means, plan, &hear);
    progress.close();
    Ok(simulated.map(|simulated| known_only(simulated, separation)))
}

/// Without the figures whose uncertainty is not known: a simulation knows no more of them.
fn known_only(mut simulated: Simulated, separation: &Separation) -> Simulated {
    let range_known = |term: ErrorTerm| {
        let found = separation.errors.mean[term].as_ref();
        found.is_some_and(|found| found.u_um.is_some())
    };
    let squareness_known = |plane: &Plane| separation.u_squareness_um_per_m.of(*plane).is_some();
    simulated
        .figures
        .retain(|figure| match figure.name.split_once(' ') {
            Some(("range", term)) => ErrorTerm::from_name(term).is_none_or(range_known),
            Some(("squareness", key)) => {
                let plane = Plane::ALL.into_iter().find(|plane| plane.key() == key);
                plane.as_ref().is_none_or(squareness_known)
            }
            _ => true,
        });
    simulated
}

/// A bar on standard error, if that is a terminal and the simulation takes long.
struct Progress {
    done: AtomicUsize,
    all: usize,
    begun: Instant,
    shown: bool,
}

impl Progress {
    fn new(all: usize) -> Progress {
        Progress {
            done: AtomicUsize::new(0),
            all,
            begun: Instant::now(),
            shown: std::io::stderr().is_terminal(),
        }
    }

    fn add(&self, trials: usize) {
        let before = self.done.fetch_add(trials, Ordering::Relaxed);
        let percent = |done: usize| 100 * done / self.all.max(1);
        let (before, now) = (percent(before), percent(before + trials));
        if self.shown && now > before && self.begun.elapsed() > PATIENCE {
            let bar = "#".repeat(now / 4);
            // A bar that cannot be drawn is no failure.
            let _ = write!(std::io::stderr(), "\rsimulating [{bar:<25}] {now} %");
        }
    }

    fn close(&self) {
        if self.shown && self.begun.elapsed() > PATIENCE {
            let _ = write!(std::io::stderr(), "\r{:40}\r", "");
        }
    }
}
