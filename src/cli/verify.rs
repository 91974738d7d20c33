//! `nonius verify JOB --tables DIR [--after FILE|JOB]`

mod page;
mod second;

use crate::cli::inputs;
use crate::cli::outcome::{Outcome, Print};
use crate::cli::tables::read_directory;
use crate::judge::conformity::Verdict;
use crate::kit::second_look::second_look;
use crate::text::problem::Problems;
use clap::Args;
use page::Page;
use second::Second;
use std::path::PathBuf;

// Options of `verify`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Directory with the control's files
    #[arg(long, value_name = "DIR")]
    tables: PathBuf,
    /// A measurement with these tables active, against the forecast: an error table (CSV) or a job (TOML)
    #[arg(long, value_name = "FILE|JOB")]
    after: Option<PathBuf>,
    #[command(flatten)]
    print: Print,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let directory = options.tables.as_path();
    let inputs = inputs::read(&options.job)?;
    let after = options.after.as_deref();
    let second = after.map(|path| Second::read(&inputs, path, directory));
    let second = second.transpose()?;
    let verification = read_directory(&inputs, directory)?.verify(&inputs)?;
    let second = second.as_ref().map(|second| {
        second.ensure_active(&inputs, &verification)?;
        let corrected = || second::corrected(&inputs, &options.job);
        let look = second_look(&inputs, &verification, &second.measurement, corrected)?;
        Ok::<_, Problems>((second, look))
    });
    let page = Page {
        inputs: &inputs,
        directory,
        verification: &verification,
        second: second.transpose()?,
    };
    let outcome = options
        .print
        .outcome(|| page.screen(), || page.document())?;
    Ok(outcome.answering(page.verdict() == Verdict::Pass))
}
