//! `nonius verify JOB --tables DIR [--after FILE|JOB]`

mod page;
mod second;

use crate::cli::outcome::{Outcome, PlotOnly, Print};

use crate::judge::conformity::Verdict;
use crate::kit::second_look::second_look;
use crate::kit::{Inputs, Verification};
use crate::text::problem::Problems;
use crate::visit::files::Files;
use crate::visit::inputs;
use crate::visit::tables::read_directory;
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
    plot: PlotOnly,
    #[command(flatten)]
    print: Print,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let inputs = inputs::read(files, &options.job)?;
    let judged =
        Judged::read(files, &inputs, &options.job, &options.tables, options.after.as_deref())?;
    let page = judged.page(&inputs)?;
    let outcome = options.print.outcome(|| page.screen(), || page.document())?;
    let outcome = outcome.answering(page.verdict() == Verdict::Pass);
    options.plot.beside(outcome, |locale| page.picture(locale))
}

/// Tables, and a measurement with them active.
pub(super) struct Judged<'a> {
    files: &'a dyn Files,
    job: &'a Path,
    directory: &'a Path,
    verification: Verification,
    second: Option<Second>,
}

impl<'a> Judged<'a> {
    /// The files of a directory, and of a second measurement.
    pub(super) fn read(
        files: &'a dyn Files,
        inputs: &Inputs,
        job: &'a Path,
        directory: &'a Path,
        after: Option<&Path>,
    ) -> Result<Judged<'a>, Problems> {
        let second = after.map(|path| Second::read(files, inputs, path, directory));
        let second = second.transpose()?;
        let verification = read_directory(files, inputs, directory)?.verify(inputs)?;
        Ok(Judged { files, job, directory, verification, second })
    }

    /// Tables that were made and lie nowhere yet.
    pub(super) fn made(
        files: &'a dyn Files,
        job: &'a Path,
        verification: Verification,
    ) -> Judged<'a> {
        let directory = Path::new("");
        Judged { files, job, directory, verification, second: None }
    }

    /// `date` and protocol of the second measurement, as its job states them.
    pub(super) fn protocol_after(&self) -> Vec<(String, String)> {
        self.second.as_ref().map(|second| second.protocol.clone()).unwrap_or_default()
    }

    /// What is told of them.
    pub(super) fn page<'b>(&'b self, inputs: &'b Inputs) -> Result<Page<'b>, Problems> {
        let second = self.second.as_ref().map(|second| {
            second.ensure_active(inputs, &self.verification)?;
            let corrected = || second::corrected(self.files, inputs, self.job);
            let look = second_look(inputs, &self.verification, &second.measurement, corrected)?;
            Ok::<_, Problems>((second, look))
        });
        let mut page = Page {
            inputs,
            directory: self.directory,
            verification: &self.verification,
            second: second.transpose()?,
            decides: None,
        };
        page.decides = page.what_decides();
        Ok(page)
    }
}
