//! Typed look at the parameters of a kit, and what it holds that is not emulated.
//!
//! A parameter that no file writes keeps its old content, so a missing one is never taken as 0.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{FanucFacts, NumberRange};
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::read::emulate::{CannotEmulate, Emulated, cannot};

/// Whose points a table has, and which.
pub(super) type Run = (String, NumberRange);

/// Everything the tables of a control are built from.
#[derive(Clone, Copy)]
pub(super) struct Loading<'a> {
    /// What the kit writes.
    pub(super) memory: &'a FanucMemory,
    /// What the control does with it.
    pub(super) facts: &'a FanucFacts,
    /// What the job states.
    pub(super) state: &'a ControlState,
}

/// `parameter 3620 of axis 1`, as messages name it.
pub(super) fn name(number: u32, axis: Option<u32>) -> String {
    ParameterKey { number, axis }.to_string()
}

impl<'a> Loading<'a> {
    /// The stated axis of a controlled-axis number.
    pub(super) fn axis(self, number: u32) -> Emulated<&'a AxisState> {
        match self.state.axis(&number.to_string()) {
            Some(axis) => Ok(axis),
            None => cannot(format!("the files name axis {number}, which the job does not state")),
        }
    }

    /// Detection unit of an axis, µm.
    pub(super) fn detection_unit_um(self, axis: &AxisState) -> Emulated<f64> {
        match axis.detection_unit_um {
            Some(um) if um.is_finite() && um > 0.0 => Ok(um),
            _ => cannot(format!(
                "axis {}: the detection unit is not stated, or not more than 0 µm",
                axis.name
            )),
        }
    }

    /// Whether the kit writes a parameter.
    pub(super) fn holds(self, number: u32, axis: Option<u32>) -> bool {
        self.memory.parameter(number, axis).is_some()
    }

    /// A whole number, which has to be there.
    pub(super) fn integer(self, number: u32, axis: Option<u32>) -> Emulated<i64> {
        match self.memory.parameter(number, axis) {
            Some(ParameterValue::Integer(value)) => Ok(value),
            Some(_) => cannot(format!("{} is not a whole number", name(number, axis))),
            None => cannot(format!(
                "{} is missing; a parameter left out keeps its old content",
                name(number, axis)
            )),
        }
    }

    /// A whole number that has to lie in `0..=limit`.
    pub(super) fn count(self, number: u32, axis: Option<u32>, limit: u32) -> Emulated<u32> {
        let value = self.integer(number, axis)?;
        u32::try_from(value).ok().filter(|count| *count <= limit).ok_or_else(|| {
            let name = name(number, axis);
            CannotEmulate(format!("{name} is {value}, expected 0 to {limit}"))
        })
    }

    /// A whole number that has to lie in `-limit..=limit`.
    pub(super) fn amount(self, number: u32, axis: Option<u32>, limit: u32) -> Emulated<f64> {
        let value = self.integer(number, axis)?;
        let amount = i32::try_from(value).ok();
        amount.filter(|amount| amount.unsigned_abs() <= limit).map(f64::from).ok_or_else(|| {
            let name = name(number, axis);
            CannotEmulate(format!("{name} is {value}, expected -{limit} to {limit}"))
        })
    }

    /// Eight bits, if the kit writes them.
    pub(super) fn bits(self, number: u32, axis: Option<u32>) -> Emulated<Option<u8>> {
        match self.memory.parameter(number, axis) {
            Some(ParameterValue::Bits(bits)) => Ok(Some(bits)),
            Some(_) => cannot(format!("{} does not hold eight bits", name(number, axis))),
            None => Ok(None),
        }
    }

    /// Values of `count` points from `first` on, detection units. A real control holds more than the
    /// `increment_max` that is written, so no other limit than that of the data word counts here.
    pub(super) fn increments(self, first: u32, count: u32) -> Emulated<Vec<i32>> {
        (first..first + count)
            .map(|point| match self.memory.points.get(&point) {
                Some(value) => Ok(*value),
                None => cannot(format!(
                    "point {point} is missing; a point left out keeps its old content"
                )),
            })
            .collect()
    }

    /// Refuses what the kit holds beyond pitch and straightness compensation.
    pub(super) fn refuse_others(self) -> Emulated<()> {
        for key in self.memory.parameters.keys() {
            let what = name(key.number, key.axis);
            if let Some((words, _)) = OTHERS.iter().find(|(_, ranges)| is_in(ranges, key.number)) {
                return cannot(format!("{what}: {words}"));
            }
            if AXIS_TYPE.contains(&key.number) && key.axis.is_none() {
                return cannot(format!("{what} names no axis, but each axis has its own"));
            }
            let has_none =
                is_in(&NO_AXIS, key.number) || self.facts.is_of_per_point_set(key.number);
            if key.axis.is_some() && has_none {
                return cannot(format!("{what}: no axis owns this parameter"));
            }
            if let Some((_, mask, words)) = OTHER_BITS.iter().find(|(bits, ..)| *bits == key.number)
                && self.bits(key.number, key.axis)?.is_some_and(|bits| bits & mask != 0)
            {
                return cannot(format!("{what}: {words}"));
            }
        }
        Ok(())
    }
}

/// Pitch parameters, one for each axis (docs/fanuc.md §2.1).
const AXIS_TYPE: [u32; 9] = [3605, 3620, 3621, 3622, 3623, 3624, 3625, 3626, 3627];

/// Straightness parameters, of the path (docs/fanuc.md §2.4).
const NO_AXIS: [(u32, u32); 1] = [(5711, 5788)];

fn is_in(ranges: &[(u32, u32)], number: u32) -> bool {
    ranges.iter().any(|(a, b)| (*a..=*b).contains(&number))
}

/// Why the emulation would be wrong if it ignored them, and first and last number (docs/fanuc.md §3.3).
const OTHERS: [(&str, &[(u32, u32)]); 6] = [
    ("the reference position is taken from the job, a kit must not change it", &[(1240, 1240)]),
    ("the backlash is taken from the job, a kit must not change it", &[(1851, 1852)]),
    ("separate point numbers of slave axes are not emulated", &[(3666, 3671), (3676, 3677)]),
    ("inclination compensation is not emulated", &[(5861, 5864), (5871, 5874)]),
    ("three-dimensional error compensation is not emulated", &[(10800, 10814)]),
    ("cyclic second pitch compensation is not emulated", &[(14985, 14988)]),
];

/// Parameter, bits that must be 0, and what they would mean (docs/fanuc.md §2.1).
const OTHER_BITS: [(u32, u8, &str); 3] = [
    (3602, 1, "pitch data as total values (bit 0) are not emulated"),
    (3605, 0b1100, "arbitrary-pitch and cyclic second compensation (bits 2, 3) are not emulated"),
    (8135, 1, "pitch compensation is not available on this control (bit 0)"),
];
