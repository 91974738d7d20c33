//! Fanuc memory: numbered parameters and numbered points (docs/fanuc.md §1, §3).
//!
//! Point numbers stand here without the offset of the file (+10000).

use std::collections::BTreeMap;
use std::fmt;

/// Name of a parameter: its number, and the controlled axis it belongs to (axis type).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParameterKey {
    /// Parameter number, e.g. 3620.
    pub number: u32,
    /// Controlled axis from 1; `None` for parameters that no axis owns.
    pub axis: Option<u32>,
}

impl fmt::Display for ParameterKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "parameter {}", self.number)?;
        match self.axis {
            Some(axis) => write!(f, " of axis {axis}"),
            None => Ok(()),
        }
    }
}

/// Content of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterValue {
    /// A whole number.
    Integer(i64),
    /// A number with a decimal point, in the control's unit.
    Real(f64),
    /// Eight bits; bit 7 stands leftmost in the file.
    Bits(u8),
}

/// For messages; what a file gets is decided where it is written.
impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterValue::Integer(whole) => write!(f, "{whole}"),
            ParameterValue::Real(real) => write!(f, "{real}"),
            ParameterValue::Bits(bits) => write!(f, "{bits:08b}"),
        }
    }
}

/// Parameters and points that a kit writes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FanucMemory {
    /// Parameters.
    pub parameters: BTreeMap<ParameterKey, ParameterValue>,
    /// Pitch and straightness data: point number → increment.
    pub points: BTreeMap<u32, i32>,
}

impl FanucMemory {
    /// The content of a parameter of an axis (or of none).
    pub fn parameter(&self, number: u32, axis: Option<u32>) -> Option<ParameterValue> {
        self.parameters.get(&ParameterKey { number, axis }).copied()
    }
}
