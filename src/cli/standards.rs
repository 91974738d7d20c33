//! `nonius standards FILE`

pub(super) mod diagonals;
mod document;
mod text;

use crate::cli::Format;
use crate::cli::inputs::{file_name, read_argument};
use crate::cli::outcome::Outcome;
use crate::control::controller::TableSign;
use crate::inputs::import::stated::{
    self, MaterialCorrected, Runs as Ways, axis_word, direction_word, millimetres,
};
use crate::inputs::import::{Measurement, encoding_word, measured_runs};
use crate::inputs::target_runs::{Runs, Stated, Values};
use crate::kit::sha256;
use crate::machine::standards::iso_230_2::{self, Travel};
use crate::machine::standards::{Condition, vdi_3441};
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::{LengthUnit, header_and_rows};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use clap::Args;
use std::path::PathBuf;

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
    #[arg(long)]
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
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let (name, bytes) = read_argument(&options.file)?;
    let input = Input::of(&name, &bytes);
    options.refuse_foreign(input)?;
    match input {
        Input::Job => diagonals::of_job(&options.file, options.format),
        Input::Readings => {
            diagonals::of_readings(Source::from_bytes(&name, &bytes)?, options.format)
        }
        Input::RunsTable => {
            let stated = Stated {
                unit: options.unit,
                values: options.values,
            };
            let runs = Runs::read(&Source::from_bytes(&name, &bytes)?, stated)?;
            options.axis(&name, &runs, Vec::new())
        }
        Input::Rtl => {
            let file = Measurement {
                path: &name,
                name: &file_name(&options.file),
                sha256: &sha256(&bytes),
                bytes: &bytes,
            };
            let measured = measured_runs(file, options.encoding, &options.stated())?;
            let runs = Runs::new(measured.targets_mm, measured.up_um, measured.down_um)?;
            options.axis(&name, &runs, measured.facts)
        }
    }
}

/// What a file is, by what stands in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Input {
    /// Runs of one axis in rows and columns.
    RunsTable,
    /// Runs of one axis as Renishaw writes them.
    Rtl,
    /// Readings of the body diagonals.
    Readings,
    /// A job that names readings.
    Job,
}

impl Input {
    fn of(name: &str, bytes: &[u8]) -> Input {
        let ends_with = |ending: &str| name.to_ascii_lowercase().ends_with(ending);
        let text = String::from_utf8_lossy(bytes);
        let is_content = |line: &&str| !line.is_empty() && !line.starts_with('#');
        let text = text.trim_start_matches('\u{feff}');
        let first = text.lines().map(str::trim).find(is_content).unwrap_or("");
        let key = first.split('=').next().unwrap_or("").trim();
        if ends_with(".rtl") || first == "HEADER::" {
            Input::Rtl
        } else if ends_with(".toml") || key == "schema" || first.starts_with('[') {
            Input::Job
        } else if is_readings(name, bytes) {
            Input::Readings
        } else {
            Input::RunsTable
        }
    }

    const fn word(self) -> &'static str {
        match self {
            Input::RunsTable => "a table of runs",
            Input::Rtl => "an `.rtl` file",
            Input::Readings => "readings of the body diagonals",
            Input::Job => "a job",
        }
    }

    const fn takes(self) -> &'static [&'static str] {
        match self {
            Input::RunsTable => &["--unit", "--values", "--travel-mm"],
            Input::Rtl => &[
                "--travel-mm",
                "--sign",
                "--targets-run",
                "--runs",
                "--axis",
                "--material-corrected",
                "--encoding",
            ],
            Input::Readings | Input::Job => &[],
        }
    }
}

fn is_readings(name: &str, bytes: &[u8]) -> bool {
    let source = Source::from_bytes(name, bytes).ok();
    let header = source.as_ref().and_then(header_and_rows);
    header.is_some_and(|(header, _)| {
        let cells = header.cells();
        ["diagonal", "node"]
            .iter()
            .all(|name| cells.iter().any(|cell| cell == name))
    })
}

impl Options {
    fn stated(&self) -> stated::Stated {
        stated::Stated {
            sign: self.sign,
            targets_run: self.targets_run,
            runs: self.runs,
            axis: self.axis,
            material_corrected: self.material_corrected,
            ..stated::Stated::default()
        }
    }

    /// An option without meaning for the file is a mistake of the user.
    fn refuse_foreign(&self, input: Input) -> Result<(), Problems> {
        let given = [
            ("--unit", self.unit.is_some()),
            ("--values", self.values.is_some()),
            ("--travel-mm", self.travel_mm.is_some()),
            ("--sign", self.sign.is_some()),
            ("--targets-run", self.targets_run.is_some()),
            ("--runs", self.runs.is_some()),
            ("--axis", self.axis.is_some()),
            ("--material-corrected", self.material_corrected.is_some()),
            ("--encoding", self.encoding.is_some()),
        ];
        let mut problems = Problems::none();
        for (option, _) in given
            .iter()
            .filter(|(option, is)| *is && !input.takes().contains(option))
        {
            problems.push(
                Problem::new(format!("`{option}` has no meaning for {}", input.word()))
                    .help("leave it out"),
            );
        }
        problems.or_ok(())
    }

    /// Figures of one axis; `facts` are what its file states.
    fn axis(&self, name: &str, runs: &Runs, facts: Vec<String>) -> Result<Outcome, Problems> {
        let results = Results::of(runs, self.travel_mm, facts)?;
        match self.format {
            Format::Json => Outcome::json(&document::document(runs, &results)),
            Format::Text => Ok(Outcome::text(&text::report(name, runs, &results))),
        }
    }
}

/// What the standards say about the runs of an axis.
struct Results {
    travel: Travel,
    iso: iso_230_2::Figures,
    conditions: Vec<Condition>,
    vdi: Option<vdi_3441::Figures>,
    notes: Vec<String>,
}

impl Results {
    fn of(runs: &Runs, travel_mm: Option<f64>, facts: Vec<String>) -> Result<Results, Problem> {
        let travel = Travel::of(runs, travel_mm)?;
        let mut notes = facts;
        notes.extend(iso_230_2::remarks(runs, travel));
        Ok(Results {
            travel,
            iso: iso_230_2::figures(runs),
            conditions: iso_230_2::conditions(runs, travel),
            vdi: vdi_3441::figures(runs),
            notes,
        })
    }
}
