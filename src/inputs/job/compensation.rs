//! `[compensation]`: what the control shall hold.

use crate::control::controller::LengthUnit;
use crate::quantity::axis::{ErrorTerm, PerAxis};
use crate::quantity::curve::Interpolation;
use crate::quantity::fit::Fit;

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
    pub(crate) fn is_interpolated(&self) -> bool {
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
