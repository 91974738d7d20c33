//! The measurement afterwards.

use crate::inputs::error_table::is_simulated;
use crate::judge::findings::joined;
use crate::machine::model::{ErrorModel, MeasuredTerm};
use crate::machine::separation::readings::Walk;
use crate::quantity::{PerDiagonal, Volume};
use crate::text::Finding;

/// A measurement of the machine with its tables active.
#[derive(Clone, Debug, PartialEq)]
pub enum AfterMeasurement {
    /// Error curves, zero at the reference.
    Errors(Box<ErrorModel>),
    /// Straight runs along the body diagonals.
    Diagonals(StraightRuns),
}

/// Straight runs along the body diagonals: their means and figures.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightRuns {
    /// The box and its nodes.
    pub volume: Volume,
    /// Mean readings of each pass that was walked.
    pub walks: Vec<Walk>,
    /// Max − min along each diagonal, both passes, µm.
    pub range_um: PerDiagonal<f64>,
    /// Standard uncertainty (k = 1) of a mean reading, µm; `None` = neither stated nor repeated.
    pub u_um: Option<f64>,
    /// Degrees of freedom of the estimate behind it; `None` = it is stated.
    pub degrees_of_freedom: Option<f64>,
    /// Standard uncertainty of a length: laser, set-up, beam, µm/m.
    pub scale_um_per_m: f64,
    /// Of it what all diagonals share: the laser's scale, µm/m.
    pub laser_um_per_m: f64,
    /// The reverse passes count from the forward start.
    pub one_zero: bool,
    /// What the readings say of themselves and what their evaluation rests on.
    pub labels: Vec<Finding>,
}

impl AfterMeasurement {
    /// Whether the values say of themselves that they were simulated.
    pub(crate) fn is_simulated(&self) -> bool {
        match self {
            AfterMeasurement::Errors(model) => model.remarks.simulated().next().is_some(),
            AfterMeasurement::Diagonals(runs) => runs.labels.iter().any(is_simulated),
        }
    }

    /// Standard uncertainty (k = 1) of the laser's scale that no u of a value holds, µm/m.
    pub(crate) fn laser_um_per_m(&self) -> f64 {
        match self {
            AfterMeasurement::Errors(model) => model.laser_um_per_m,
            AfterMeasurement::Diagonals(runs) => runs.laser_um_per_m,
        }
    }

    /// What was measured at five places or more and is the same at all of them, to the last digit.
    pub(super) fn flat(&self) -> String {
        let is_flat = |measured: &MeasuredTerm| {
            measured.largest_um() <= 0.0 && measured.curves().any(|c| c.knots().len() >= 5)
        };
        match self {
            AfterMeasurement::Errors(model) => {
                let flat = model.measured().filter(|(_, measured)| is_flat(measured));
                joined(flat.map(|(term, _)| term))
            }
            AfterMeasurement::Diagonals(runs) => {
                let flat = runs.range_um.iter().filter(|(_, um)| **um <= 0.0);
                joined(flat.map(|(diagonal, _)| diagonal))
            }
        }
    }
}
