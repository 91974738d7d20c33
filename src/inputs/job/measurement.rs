//! `[measurement]`: what was measured.

use crate::inputs::job::active::{ActiveSettings, ActiveTables};
use crate::inputs::job::diagonals::{DiagonalMeasurement, Levers, StatedUncertainty};
use crate::quantity::axis::ErrorTerm;

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
    pub(crate) fn unused_keys(&self) -> Vec<&'static str> {
        match self.data {
            MeasuredData::Errors(_) => self.uncertainty.keys_of_readings(),
            MeasuredData::Diagonals(_) => Vec::new(),
        }
    }
}
