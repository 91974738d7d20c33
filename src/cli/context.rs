//! `nonius context JOB`

use crate::cli::{Answer, Format, inputs, print_json};
use crate::kit::template_context;
use crate::problem::Problems;
use clap::Args;
use std::path::PathBuf;

/// Options of `context`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Both print the same JSON document
    #[arg(long, value_enum, default_value_t = Format::Json)]
    format: Format,
}

pub(super) fn run(options: &Options) -> Result<Answer, Problems> {
    let document = template_context(&inputs::read(&options.job)?)?;
    match options.format {
        Format::Text | Format::Json => print_json(&document),
    }
}
