//! `nonius context JOB`

use crate::cli::outcome::Outcome;
use crate::cli::{Format, inputs};
use crate::kit::template_context;
use crate::text::problem::Problems;
use clap::Args;
use std::path::PathBuf;

// Options of `context`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Both print the same JSON document
    #[arg(long, value_enum, default_value_t = Format::Json)]
    format: Format,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let document = template_context(&inputs::read(&options.job)?)?;
    match options.format {
        Format::Text | Format::Json => Outcome::json(&document),
    }
}
