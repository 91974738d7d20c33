//! `nonius verify JOB --tables DIR [--after FILE|JOB]`

mod page;
mod second;

use crate::cli::outcome::{Outcome, Shows};

use crate::judge::conformity::Verdict;
use crate::kit::{Inputs, SecondLook, Verification, second_look};
use crate::page::Locale;
use crate::text::Problems;
use crate::visit::files::Files;
use crate::visit::inputs;
use crate::visit::inputs::read_directory;
use clap::Args;
pub(super) use page::Page;
use second::Second;
use std::path::{Path, PathBuf};

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
    shows: Shows,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let inputs = inputs::read(files, &options.job)?;
    let page = Page::read(files, &inputs, &options.job, &options.tables, options.after.as_deref())?;
    let picture = |locale: Locale<'_>| page.picture(locale);
    let outcome = options.shows.outcome(|| page.screen(), || page.document(), picture)?;
    Ok(outcome.answering(page.verdict() == Verdict::Pass))
}

impl<'a> Page<'a> {
    /// The files of a directory, and of a measurement with them active.
    pub(super) fn read(
        files: &dyn Files,
        inputs: &'a Inputs,
        job: &Path,
        directory: &Path,
        after: Option<&Path>,
    ) -> Result<Page<'a>, Problems> {
        let second = after.map(|path| Second::read(files, inputs, path, directory));
        let second = second.transpose()?;
        let verification = read_directory(files, inputs, directory)?.verify(inputs)?;
        let second = second.map(|second| {
            second.ensure_active(inputs, &verification.loaded)?;
            let corrected = || second::corrected(files, inputs, job);
            let look = second_look(&verification, &second.measurement, corrected)?;
            Ok::<_, Problems>((second, look))
        });
        let second = second.transpose()?;
        Ok(Page::of(verification, second))
    }

    /// Tables, and a measurement with them active where there is one.
    pub(super) fn of(
        verification: Verification<'a>,
        second: Option<(Second, SecondLook)>,
    ) -> Page<'a> {
        let inputs = verification.loaded.asked.inputs;
        let mut page = Page { inputs, verification, second, decides: None };
        page.decides = page.what_decides();
        page
    }
}
