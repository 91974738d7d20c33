//! `nonius standards FILE`

mod pages;

use crate::cli::outcome::{Outcome, Shows};
use crate::cli::refusals;
use crate::control::controller::TableSign;
use crate::inputs::import::stated::{
    self, MaterialCorrected, Runs as Ways, axis_word, direction_word, millimetres,
};
use crate::inputs::import::{encoding_word, measured_runs};
use crate::inputs::kind::FileKind;
use crate::inputs::target_runs::{RunFacts, Runs, Values};
use crate::quantity::{Axis, Direction};
use crate::text::{LengthUnit, Problems};
use crate::visit::files::Files;
use crate::visit::job_files::InputFile;
use clap::Args;
pub(super) use pages::of_separation;
use pages::{AxisPage, of_job, of_readings};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

// Options of `standards`. Which of them have a meaning depends on the file.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Runs of one axis (CSV or Renishaw .rtl), or a job or file of readings of the body diagonals;
    /// `-` = standard input
    file: PathBuf,
    /// Unit of the columns whose names have none: mm, in, um or uin
    #[arg(long)]
    unit: Option<LengthUnit>,
    /// What the columns of runs hold, where it is open: positions or deviations
    #[arg(long)]
    values: Option<Values>,
    /// Travel of the axis, mm [default: from the first to the last target]
    #[arg(long, value_name = "MM", value_parser = millimetres)]
    travel_mm: Option<f64>,
    /// .rtl: as-error = measured - target; as-correction = what has to be added
    #[arg(long, hide_possible_values = true)]
    sign: Option<TableSign>,
    /// .rtl: way of the axis from the first target to the last, in machine coordinates: + or -
    #[arg(long, value_name = "+|-", allow_hyphen_values = true, value_parser = direction_word)]
    targets_run: Option<Direction>,
    /// .rtl: unidirectional, or bidirectional (even runs go back)
    #[arg(long)]
    runs: Option<Ways>,
    /// .rtl: the axis that moved, where the file names none
    #[arg(long, value_parser = axis_word)]
    axis: Option<Axis>,
    /// .rtl: whether the instrument took the expansion of the material out: yes, no or not-stated
    #[arg(long)]
    material_corrected: Option<MaterialCorrected>,
    /// .rtl: encoding of its text, where it does not show itself, e.g. latin-1 or gbk
    #[arg(long, value_parser = encoding_word)]
    encoding: Option<&'static encoding_rs::Encoding>,
    #[command(flatten)]
    shows: Shows,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let file = InputFile::read(files, &options.file)?;
    let input = file.kind();
    options.refuse_foreign(input)?;
    let (runs, facts) = match input {
        FileKind::Job => return of_job(files, &options.file)?.outcome(files, &options.shows),
        FileKind::Readings => {
            return of_readings(file.source()?)?.outcome(files, &options.shows);
        }
        FileKind::Table => {
            let stated = RunFacts { unit: options.unit, values: options.values };
            (Runs::read(&file.source()?, stated)?, Vec::new())
        }
        FileKind::Rtl => measured_runs(file.measurement(), &options.stated())?,
    };
    let page = AxisPage::of(&file.name, &runs, options.travel_mm, facts)?;
    options.shows.outcome(files, || page.screen(), || &page, |locale| page.picture(locale))
}

/// Runs of one axis, which say by themselves what they hold.
pub(super) fn of_axis<'a>(file: &'a InputFile<'_>) -> Result<AxisPage<'a>, Problems> {
    let kind = file.kind();
    if kind != FileKind::Table {
        return Err(refusals::no_runs_of_axis(&file.name, kind.words()).into());
    }
    let stated = RunFacts { unit: None, values: None };
    let runs = Runs::read(&file.source()?, stated)?;
    let name = Path::new(&file.name).file_name().and_then(OsStr::to_str).unwrap_or(&file.name);
    Ok(AxisPage::of(name, &runs, None, Vec::new())?)
}

impl Options {
    fn stated(&self) -> stated::ImportFacts {
        stated::ImportFacts {
            encoding: self.encoding,
            sign: self.sign,
            targets_run: self.targets_run,
            runs: self.runs,
            axis: self.axis,
            material_corrected: self.material_corrected,
            ..stated::ImportFacts::default()
        }
    }

    /// An option without meaning for the file is a mistake of the user.
    fn refuse_foreign(&self, input: FileKind) -> Result<(), Problems> {
        use FileKind::{Rtl, Table};
        let given = [
            ("--unit", &[Table][..], self.unit.is_some()),
            ("--values", &[Table], self.values.is_some()),
            ("--travel-mm", &[Table, Rtl], self.travel_mm.is_some()),
            ("--sign", &[Rtl], self.sign.is_some()),
            ("--targets-run", &[Rtl], self.targets_run.is_some()),
            ("--runs", &[Rtl], self.runs.is_some()),
            ("--axis", &[Rtl], self.axis.is_some()),
            ("--material-corrected", &[Rtl], self.material_corrected.is_some()),
            ("--encoding", &[Rtl], self.encoding.is_some()),
        ];
        let mut problems = Problems::none();
        for (option, takes, is_given) in given {
            if is_given && !takes.contains(&input) {
                problems.push(refusals::no_meaning(option, input.words()));
            }
        }
        problems.or_ok(())
    }
}
