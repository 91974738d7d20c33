//! Fanuc memory: numbered parameters and numbered points (docs/fanuc.md §2.1, §3.2).
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

impl ParameterKey {
    /// `3620 of axis 1`, or `5711`.
    pub(crate) fn words(&self) -> String {
        let axis = self.axis.map_or(String::new(), |axis| format!(" of axis {axis}"));
        format!("{}{axis}", self.number)
    }
}

impl fmt::Display for ParameterKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "parameter {}", self.words())
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

impl ParameterValue {
    /// Whether it is 0, or no bit is set.
    pub(crate) fn is_zero(self) -> bool {
        match self {
            ParameterValue::Integer(whole) => whole == 0,
            ParameterValue::Real(real) => real.abs() <= 0.0,
            ParameterValue::Bits(bits) => bits == 0,
        }
    }
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
    /// Nothing.
    pub(crate) const NONE: FanucMemory =
        FanucMemory { parameters: BTreeMap::new(), points: BTreeMap::new() };

    /// The content of a parameter of an axis (or of none).
    pub fn parameter(&self, number: u32, axis: Option<u32>) -> Option<ParameterValue> {
        self.parameters.get(&ParameterKey { number, axis }).copied()
    }

    /// Sets a whole number.
    pub(crate) fn set(&mut self, number: u32, axis: Option<u32>, whole: impl Into<i64>) {
        let value = ParameterValue::Integer(whole.into());
        self.parameters.insert(ParameterKey { number, axis }, value);
    }

    /// A whole number.
    pub(crate) fn whole(&self, number: u32, axis: Option<u32>) -> Option<i64> {
        match self.parameter(number, axis)? {
            ParameterValue::Integer(whole) => Some(whole),
            _ => None,
        }
    }

    /// A whole number that is not negative.
    pub(crate) fn count(&self, number: u32, axis: Option<u32>) -> Option<u32> {
        self.whole(number, axis).and_then(|whole| u32::try_from(whole).ok())
    }

    /// A number with or without a decimal point.
    pub(crate) fn amount(&self, number: u32, axis: Option<u32>) -> Option<f64> {
        match self.parameter(number, axis)? {
            ParameterValue::Integer(whole) => Some(whole as f64),
            ParameterValue::Real(real) => Some(real),
            ParameterValue::Bits(_) => None,
        }
    }

    /// Eight bits.
    pub(crate) fn bits(&self, number: u32, axis: Option<u32>) -> Option<u8> {
        match self.parameter(number, axis)? {
            ParameterValue::Bits(bits) => Some(bits),
            _ => None,
        }
    }
}
