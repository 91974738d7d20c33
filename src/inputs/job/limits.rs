//! `[limits]` and `[acceptance]`: what is refused, and what is judged by.

use crate::quantity::axis::PerAxis;
use crate::quantity::units::Millimetres;

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
    pub(crate) fn asks_nothing(&self) -> bool {
        self.max_deviation_um.is_none() && self.max_diagonal_um.is_none()
    }
}
