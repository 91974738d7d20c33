//! The generic table of contract §4.1: deviation, correction and increment side by side.

use crate::quantity::axis::{Direction, ErrorTerm};

/// One row: one point of one term (and direction).
#[derive(Clone, Debug, PartialEq)]
pub struct GenericRow {
    /// Which error.
    pub term: ErrorTerm,
    /// Name of the moving axis.
    pub base_axis: String,
    /// Name of the corrected axis.
    pub output_axis: String,
    /// Direction of the moving axis the row is for; `None` = both.
    pub direction: Option<Direction>,
    /// Index of the point, from 0.
    pub index: u32,
    /// Machine coordinate, mm.
    pub position_mm: f64,
    /// Deviation relative to the reference, µm.
    pub deviation_um: f64,
    /// Correction, µm.
    pub correction_um: f64,
    /// Change of the correction from the point before, µm; `None` at the first.
    pub increment_um: Option<f64>,
}

/// All rows, in file order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GenericTable {
    /// The rows.
    pub rows: Vec<GenericRow>,
}
