//! The job: everything needed to make a kit again (contract §2.3).
//!
//! A job that exists is valid in itself; whether it fits the measured errors and the control is
//! checked later, with [`Job::problem_at`] pointing back at the key.

mod active;
pub mod ahead;
mod compensation;
mod diagonals;
mod limits;
mod machine;
mod measurement;
mod path;
mod program;
mod read;
mod read_active;
mod read_beams;
mod read_compensation;
mod read_diagonals;
mod read_measurement;
mod read_path;
mod read_places;
mod read_program;
mod read_words;

pub use self::active::{ActiveSettings, ActiveTables, NotMeasured};
pub use self::compensation::{
    AxisSettings, BacklashPolicy, Compensation, GridRequest, OutsideMeasured, UseOf, WantedTerms,
};
pub use self::diagonals::{
    AxisMaterial, Beam, DiagonalMeasurement, Frame, Levers, Linear, LinearSlope, Material,
    Reflector, SetUp, StatedUncertainty,
};
pub use self::limits::{Acceptance, LARGEST_BUMP_UM, LEAST_BUMP_UM, Limits};
pub use self::machine::{Machine, MachineAxis};
pub use self::measurement::{MeasuredData, Measurement};
pub use self::path::PathRequest;
pub use self::program::{ProgramRequest, RunType, TargetGrid, WayBack};

use crate::text::document::{Source, read_page};
use crate::text::problem::{Problem, Problems};

/// A checked job.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The file.
    pub source: Source,
    /// `[machine]`.
    pub machine: Machine,
    /// `[measurement]`.
    pub measurement: Measurement,
    /// `[compensation]`.
    pub compensation: Compensation,
    /// `[limits]`.
    pub limits: Limits,
    /// `[acceptance]`.
    pub acceptance: Acceptance,
    /// `[program]`.
    pub program: Option<ProgramRequest>,
    /// `[path]`.
    pub path: PathRequest,
}

impl Job {
    /// Reads and checks a job; all problems of the page are given at once.
    pub fn read(source: Source) -> Result<Job, Problems> {
        Job::read_for(source, UseOf::Tables)
    }

    /// Reads and checks a job for what is asked of it: figures need no `[compensation]`.
    pub fn read_for(source: Source, use_of: UseOf) -> Result<Job, Problems> {
        refuse_table(&source)?;
        let (parts, source) = read_page(source, |root| read::job(root, use_of))?;
        let (machine, measurement, compensation, limits, acceptance, program, path) = parts;
        Ok(Job {
            source,
            machine,
            measurement,
            compensation,
            limits,
            acceptance,
            program,
            path,
        })
    }

    /// A problem at a key of the job, by its dotted path.
    pub(crate) fn problem_at(&self, path: &str, message: impl Into<String>) -> Problem {
        self.source.problem_at(path, message)
    }
}

/// A table in place of the job would be refused line by line.
fn refuse_table(source: &Source) -> Result<(), Problem> {
    let is_content = |line: &&str| !line.is_empty() && !line.starts_with('#');
    let mut lines = source.text.lines().map(str::trim).filter(is_content);
    let head = lines.next().unwrap_or_default().to_ascii_lowercase();
    if head.contains(['=', '[']) || !head.contains([',', ';', '\t']) {
        return Ok(());
    }
    let has = |name: &str| {
        head.split([',', ';', '\t'])
            .any(|cell| cell.trim().trim_matches('"') == name)
    };
    let what = if has("diagonal") {
        "a table of readings"
    } else if has("axis") {
        "an error table"
    } else {
        "a table"
    };
    let key = if has("diagonal") {
        "readings"
    } else {
        "errors"
    };
    Err(Problem::new(format!(
        "`{}` is {what}, expected the job (TOML) that names it",
        source.name
    ))
    .help(format!(
        "give the job with `{key} = …` in [measurement]; fixtures/start holds jobs to begin with"
    )))
}
