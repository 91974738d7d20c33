//! `nonius separate JOB [-o errors.csv]`

mod document;
mod straight;
mod text;
mod words;

use crate::cli::diagonals::by_standard;
use crate::cli::outcome::{Outcome, Output, Plot, held};
use crate::inputs::error_table;
use crate::machine::separation::monte_carlo::{Trials, simulate};
use crate::page::{Locale, separated};
use crate::quantity::PathKind;
use crate::text::{Problem, Problems};
use crate::visit::campaign::{CampaignFiles, read_campaign};
use crate::visit::files::Files;
use clap::Args;
use std::path::PathBuf;

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
    let plan = Trials { trials: options.trials, seed: options.seed };
    let simulated = || simulate(&separation, plan, files.progress(plan.trials));
    let simulated = (plan.trials > 0).then(simulated).flatten();
    let csv = || held(error_table::write(&campaign.draft(&separation)));
    let csv = output.is_asked_for().then(csv);
    let figures = by_standard(&separation.volume, PathKind::Step, &separation.zeroed_runs, true)?;
    let found = (&separation, &figures, simulated.as_ref());
    let outcome =
        output.deliver(csv, || text::screen(found), || document::separation(found), "")?;
    // No, where an error is not determined or something contradicts the result.
    let outcome = outcome.answering(separation.stands());
    let picture = |locale: Locale<'_>| {
        let words = locale.words("nine_errors_separated");
        let heading = format!("{}: {words}", campaign.job.machine.name);
        separated(locale, &heading, &separation)
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
    let figures = by_standard(&result.volume, PathKind::Straight, &result.zeroed_runs, true)?;
    let screen = || straight::screen(&result, &figures);
    let outcome = options.output.print.outcome(screen, || straight::document(&result, &figures))?;
    Ok(outcome.answering(result.doubts.is_empty()))
}
