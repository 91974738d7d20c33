//! `nonius separate JOB [-o errors.csv]`

mod document;
mod straight;
mod text;
mod words;

use crate::cli::diagonals::StandardFigures;
use crate::cli::outcome::{Content, Outcome, Output, Plot};
use crate::inputs::error_table;
use crate::machine::separation::Separation;
use crate::machine::separation::monte_carlo::{Simulated, Trials, simulate};
use crate::page::{Locale, separated};
use crate::quantity::diagonal::PathKind;
use crate::text::problem::{Problem, Problems};
use crate::visit::campaign::{CampaignFiles, read_campaign};
use crate::visit::files::Files;
use clap::Args;
use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

// Options of `separate`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML) with readings of the body diagonals; `-` = standard input
    job: PathBuf,
    /// Trials of the Monte Carlo simulation of ranges and straightness; 0 = none
    #[arg(long, default_value_t = 2000, value_parser = trials)]
    trials: usize,
    /// Seed of the simulation
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    plot: Plot,
}

const MOST_TRIALS: usize = 200_000;
/// A simulation that is not done by then shows how far it is.
const PATIENCE: Duration = Duration::from_secs(1);

fn trials(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(1) | Err(_) => Err(format!("expected 0 or a whole number from 2 to {MOST_TRIALS}")),
        Ok(many) if many > MOST_TRIALS => Err(format!("at most {MOST_TRIALS}")),
        Ok(trials) => Ok(trials),
    }
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let output = &options.output;
    output.ensure_new(files, "the error table")?;
    let campaign = read_campaign(files, &options.job)?;
    if campaign.measurement.kind == PathKind::Straight {
        return straight_runs(options, &campaign);
    }
    let separation = campaign.separate()?;
    let simulated = (options.trials > 0).then(|| simulated(options, files, &separation)).flatten();
    let csv = || Content::Bytes(error_table::write(&campaign.draft(&separation)).into_bytes());
    let csv = output.is_asked_for().then(csv);
    let figures =
        StandardFigures::of(&separation.volume, PathKind::Step, &separation.zeroed_runs, true)?;
    let found = (&separation, &figures, simulated.as_ref());
    let outcome =
        output.deliver(csv, || text::screen(found), || document::separation(found), "")?;
    // No, where an error is not determined or something contradicts the result.
    let outcome = outcome.answering(separation.stands());
    let picture = |locale: Locale<'_>| {
        let words = locale.words("nine_errors_separated");
        let heading = format!("{}: {words}", campaign.job.machine.name);
        Ok(separated(locale, &heading, &separation))
    };
    options.plot.beside(outcome, output.force, picture)
}

fn straight_runs(options: &Options, campaign: &CampaignFiles) -> Result<Outcome, Problems> {
    if options.output.is_asked_for() {
        return Err(Problem::new(
            "straight runs hold no nine errors: four totals are three squareness errors and one combination of the scales",
        )
        .help("leave `-o` out, or measure in single-axis steps (`kind = \"step\"`)")
        .into());
    }
    let result = campaign.straight()?;
    let figures =
        StandardFigures::of(&result.volume, PathKind::Straight, &result.zeroed_runs, true)?;
    let screen = || straight::screen(&result, &figures);
    let outcome = options.output.print.outcome(screen, || straight::document(&result, &figures))?;
    Ok(outcome.answering(result.doubts.is_empty()))
}

fn simulated(options: &Options, files: &dyn Files, separation: &Separation) -> Option<Simulated> {
    let mut progress = Progress::new(options.trials, files.is_watched());
    let plan = Trials { trials: options.trials, seed: options.seed };
    let simulated = simulate(separation, plan, || progress.add());
    progress.close();
    simulated
}

/// A bar on standard error, if that is a terminal and the simulation takes long.
struct Progress {
    done: usize,
    all: usize,
    /// `None` where nobody looks on.
    begun: Option<Instant>,
}

impl Progress {
    fn new(all: usize, is_watched: bool) -> Progress {
        Progress { done: 0, all, begun: is_watched.then(Instant::now) }
    }

    fn is_shown(&self) -> bool {
        self.begun.is_some_and(|begun| begun.elapsed() > PATIENCE)
    }

    fn add(&mut self) {
        let percent = |done: usize| 100 * done / self.all.max(1);
        let (before, now) = (percent(self.done), percent(self.done + 1));
        self.done += 1;
        if now > before && self.is_shown() {
            let bar = "#".repeat(now / 4);
            // A bar that cannot be drawn is no failure.
            let _ = write!(std::io::stderr(), "\rsimulating [{bar:<25}] {now} %");
        }
    }

    fn close(&self) {
        if self.is_shown() {
            let _ = write!(std::io::stderr(), "\r{:40}\r", "");
        }
    }
}
