//! The job: everything needed to make a kit again (contract §2.3).
//!
//! A job that exists is valid in itself; whether it fits the measured errors and the control is
//! checked later, with [`Job::problem_at`] pointing back at the key.

mod active;
pub mod ahead;
mod diagonals;
mod path;
mod program;
mod read;
mod read_active;
mod read_beams;
mod read_compensation;
mod read_diagonals;
mod read_measurement;
mod read_path;
mod read_program;

pub use self::active::{ActiveSettings, ActiveTables, NotMeasured};
pub use self::diagonals::{
    AxisMaterial, Beam, DiagonalMeasurement, Frame, Levers, Linear, LinearSlope, Material,
    Reflector, SetUp, StatedUncertainty,
};

pub use self::path::PathRequest;
pub use self::program::{ProgramRequest, RunType, TargetGrid, WayBack};

use crate::control::controller::LengthUnit;
use crate::quantity::axis::{Direction, ErrorTerm, PerAxis};
use crate::quantity::chain::Chain;
use crate::quantity::curve::Interpolation;
use crate::quantity::fit::Fit;
use crate::quantity::units::Millimetres;
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
    pub fn problem_at(&self, path: &str, message: impl Into<String>) -> Problem {
        self.source.problem_at(path, message)
    }
}

/// What is asked of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UseOf {
    /// Tables for a control.
    Tables,
    /// Figures of the machine as it was measured: `[compensation]` may be absent, and of two
    /// directions the mean counts.
    Figures,
}

impl UseOf {
    /// Figures, with tables beside them or without.
    pub const fn with(tables: bool) -> UseOf {
        if tables {
            UseOf::Tables
        } else {
            UseOf::Figures
        }
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

/// The machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its name, as in reports.
    pub name: String,
    /// Serial number.
    pub serial: Option<String>,
    /// Kinematic chain in the notation of contract §1, e.g. `wXYZt`.
    pub chain: Option<Chain>,
    /// Its axes; absent where the job does not describe one.
    pub axes: PerAxis<Option<MachineAxis>>,
}

/// One axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineAxis {
    /// Smallest machine coordinate.
    pub low: Millimetres,
    /// Largest machine coordinate.
    pub high: Millimetres,
    /// Reference (home) point: every table is zero here.
    pub reference: Millimetres,
    /// Direction of the reference return, if the job states it.
    pub reference_direction: Option<Direction>,
    /// Largest feed, mm/min.
    pub max_feed: Option<f64>,
}

impl MachineAxis {
    /// The stated direction of the reference return, or +.
    pub fn homing(&self) -> Direction {
        self.reference_direction.unwrap_or(Direction::Plus)
    }
}

/// Where the nine errors come from.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "there is one of them in a job")]
pub enum MeasuredData {
    /// Error tables, which are merged into one: their paths, relative to the job.
    Errors(Vec<String>),
    /// Readings of the body diagonals, which are separated first.
    Diagonals(DiagonalMeasurement),
}

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The error table, or the readings.
    pub data: MeasuredData,
    /// Path of a table of angular errors, relative to the job.
    pub angles: Option<String>,
    /// What the lever arms of the angular errors are counted from.
    pub levers: Levers,
    /// Date of the measurement, as it is printed.
    pub date: Option<String>,
    /// Compensation that was active.
    pub active: ActiveTables,
    /// What the job says to it.
    pub active_settings: ActiveSettings,
    /// Squareness to add, µm/m, by the term it is added to (EXY, EXZ, EYZ).
    pub squareness: Vec<(ErrorTerm, f64)>,
    /// `[measurement.protocol]`, as it is printed.
    pub protocol: Vec<(String, String)>,
    /// `[measurement.uncertainty]`.
    pub uncertainty: StatedUncertainty,
    /// What every output has to say of the measurement, one sentence each: what is stated and not
    /// used, and what a separation rests on.
    pub notes: Vec<String>,
}

impl Measurement {
    /// Keys of `[measurement.uncertainty]` that are stated and count in no figure.
    pub fn unused_keys(&self) -> Vec<&'static str> {
        match self.data {
            MeasuredData::Errors(_) => self.uncertainty.keys_of_readings(),
            MeasuredData::Diagonals(_) => Vec::new(),
        }
    }
}

/// Which terms to compensate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WantedTerms {
    /// All that are measured and that the control can take.
    All,
    /// These.
    Listed(Vec<ErrorTerm>),
}

/// What to do with the difference of the two directions of travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BacklashPolicy {
    /// One table with the mean of both directions.
    Mean,
    /// One table for each direction.
    TwoTables,
    /// One table with the curve of the + direction.
    ForwardOnly,
    /// One table with the curve of the reference direction; −B goes to the backlash parameter.
    CurveAndParameter,
}

impl BacklashPolicy {
    /// The word of the job.
    pub const fn word(self) -> &'static str {
        match self {
            BacklashPolicy::Mean => "mean",
            BacklashPolicy::TwoTables => "two-tables",
            BacklashPolicy::ForwardOnly => "forward-only",
            BacklashPolicy::CurveAndParameter => "curve-and-parameter",
        }
    }
}

/// How the points of a table are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridRequest {
    /// This distance of two points, mm.
    Spacing(f64),
    /// This number of points.
    Points(u32),
    /// As few points as keep this residual, µm.
    MaxResidual(f64),
}

/// Where the grid passes the measured range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsideMeasured {
    /// The end value is held, marked as not measured.
    Hold,
    /// Refused.
    Refuse,
}

/// `[compensation.axes.*]`.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSettings {
    /// How its points are chosen.
    pub grid: Option<GridRequest>,
    /// How the control names its physical axes (several for a gantry); empty = the profile's default.
    pub ids: Vec<String>,
    /// Siemens: measuring system, 1 or 2.
    pub measuring_system: Option<u32>,
    /// Detection unit, µm.
    pub detection_unit_um: Option<f64>,
    /// Fanuc: first pitch point number of the axis.
    pub first_point: Option<u32>,
    /// Fanuc: bit parameter 3605 as found.
    pub parameter_3605: Option<u8>,
    /// Fanuc: interpolated pitch compensation (3605#1) is on; `None` = not stated.
    pub interpolated: Option<bool>,
    /// First point of the table, mm.
    pub start_mm: Option<f64>,
    /// Last point of the table, mm.
    pub end_mm: Option<f64>,
    /// Where the grid passes the measured range.
    pub outside: OutsideMeasured,
}

impl AxisSettings {
    /// Whether Fanuc 3605#1 is taken to be on: as stated, else as found, else off.
    pub fn is_interpolated(&self) -> bool {
        let found = self.parameter_3605.is_some_and(|bits| bits & 0b10 != 0);
        self.interpolated.unwrap_or(found)
    }
}

/// `[compensation]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Compensation {
    /// Id of a built-in profile, or the path of a user's own.
    pub controller: String,
    /// Basic system of the control.
    pub control_unit: LengthUnit,
    /// Which terms.
    pub terms: WantedTerms,
    /// What to do with two directions; no default where the data have two.
    pub backlash: Option<BacklashPolicy>,
    /// Between measured points.
    pub curve: Interpolation,
    /// Table values.
    pub fit: Fit,
    /// Siemens: first CEC table that is free.
    pub first_table: Option<u32>,
    /// Fanuc: first straightness set that is free (from 1).
    pub first_set: Option<u32>,
    /// Fanuc: point numbers in use elsewhere.
    pub reserved_points: Vec<[u32; 2]>,
    /// Settings of each axis.
    pub axes: PerAxis<Option<AxisSettings>>,
}

impl Compensation {
    /// What a job without `[compensation]` stands for: no control, straight lines between the
    /// measured points.
    pub(crate) fn none() -> Compensation {
        Compensation {
            controller: "generic".to_string(),
            control_unit: LengthUnit::Millimetre,
            terms: WantedTerms::All,
            backlash: None,
            curve: Interpolation::Linear,
            fit: Fit::Sample,
            first_table: None,
            first_set: None,
            reserved_points: Vec::new(),
            axes: PerAxis::default(),
        }
    }
}

/// `[limits]`: refuse rather than emit nonsense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest correction, µm.
    pub max_correction_um: f64,
    /// Largest slope, µm/mm.
    pub max_slope_um_per_mm: f64,
    /// Largest bump of a sign proof, µm; never more than [`LARGEST_BUMP_UM`].
    pub max_bump_um: f64,
}

/// No sign proof moves an axis by more, µm.
pub const LARGEST_BUMP_UM: f64 = 20.0;
/// A smaller bump is not seen beyond doubt on a dial gauge of 1 µm, µm.
pub const LEAST_BUMP_UM: f64 = 5.0;

/// `[acceptance]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Acceptance {
    /// Bound of what is left of every term, µm.
    pub max_deviation_um: Option<f64>,
    /// Bound of max − min along every body diagonal, µm.
    pub max_diagonal_um: Option<f64>,
    /// Part of an axis that is judged, machine coordinates; `None` = the whole travel.
    pub range: PerAxis<Option<(Millimetres, Millimetres)>>,
}

impl Acceptance {
    /// Whether there is no limit to judge by.
    pub fn asks_nothing(&self) -> bool {
        self.max_deviation_um.is_none() && self.max_diagonal_um.is_none()
    }
}
