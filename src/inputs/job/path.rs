//! `[path]`: what the control knows before a part program starts, and how its path is followed.

use crate::inputs::nc::{G43WithoutH, WithoutPoint};
use crate::quantity::axis::PerAxis;
use crate::quantity::units::Millimetres;
use std::collections::BTreeMap;

/// `[path]`.
#[derive(Clone, Debug, PartialEq)]
pub struct PathRequest {
    /// Where the axes stand before the program; `None` = at the reference.
    pub start: Option<PerAxis<Millimetres>>,
    /// Second reference point (G30).
    pub second_reference: Option<PerAxis<Millimetres>>,
    /// Origins of coordinate systems (numbers of [`crate::inputs::nc::system_number`]).
    pub systems: BTreeMap<u32, PerAxis<Millimetres>>,
    /// Tool lengths by number of the offset, mm.
    pub tools: BTreeMap<u32, f64>,
    /// Length of the tool that was measured with, mm; `None` = not stated.
    pub measured_tool_mm: Option<f64>,
    /// Inches until G21.
    pub inch: bool,
    /// Coordinates without a decimal point.
    pub without_point: WithoutPoint,
    /// Which tool offset G43 without H takes.
    pub g43_without_h: G43WithoutH,
    /// How far the end of an arc may miss its circle, mm; `None` = as the program's unit needs.
    pub arc_mm: Option<f64>,
    /// Lines with `/` are left out.
    pub skip_deletable: bool,
    /// Rapid moves count too.
    pub rapid: bool,
    /// How far chords may leave an arc, mm.
    pub chord_mm: f64,
    /// Largest distance of two samples, mm.
    pub sample_mm: f64,
    /// Places outside the measured range are refused.
    pub refuse_outside: bool,
    /// Probed places whose mean error is the datum, machine coordinates.
    pub datum: Vec<PerAxis<Millimetres>>,
}

/// Chords leave an arc by no more than the last digit of a program.
const DEFAULT_CHORD_MM: f64 = 0.001;
/// Errors of a machine change over tens of millimetres.
const DEFAULT_SAMPLE_MM: f64 = 1.0;

impl Default for PathRequest {
    fn default() -> Self {
        PathRequest {
            start: None,
            second_reference: None,
            systems: BTreeMap::new(),
            tools: BTreeMap::new(),
            measured_tool_mm: None,
            inch: false,
            without_point: WithoutPoint::Unit,
            g43_without_h: G43WithoutH::Refuse,
            arc_mm: None,
            skip_deletable: false,
            rapid: false,
            chord_mm: DEFAULT_CHORD_MM,
            sample_mm: DEFAULT_SAMPLE_MM,
            refuse_outside: false,
            datum: Vec::new(),
        }
    }
}
