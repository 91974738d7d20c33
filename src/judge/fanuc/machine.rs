//! What a Fanuc read-out says of the machine, against the job: unit, names, references, detection units and
//! travel of its axes. What is compared of the tables themselves stands in [`super::read_out`].

use crate::control::controller::{ControlUnit, FanucFacts};
use crate::control::table::fanuc::FanucMemory;
use crate::inputs::job::{Job, MachineAxis};
use crate::judge::findings::InControl;
use crate::quantity::{Axis, PerAxis, power_of_ten, rounded};

/// 1001#0 INM: whether the machine counts in inches.
pub(super) fn unit(memory: &FanucMemory) -> Option<ControlUnit> {
    let is_inch = memory.bits(1001, None)? & 1 == 1;
    Some(if is_inch { ControlUnit::Inch } else { ControlUnit::Millimetre })
}

/// What contradicts the job, axis by axis.
pub(super) fn found(
    job: &Job,
    names: &PerAxis<Vec<String>>,
    memory: &FanucMemory,
    facts: &FanucFacts,
) -> Vec<InControl> {
    let own = job.compensation.control_unit;
    let is_same_unit = unit(memory).is_none_or(|unit| unit == own);
    let mut found = Vec::new();
    for (axis, names) in names.iter() {
        for (index, name) in names.iter().enumerate() {
            let on = OnControl { memory, name, unit: own, facts };
            found.extend(on.other_name(axis, index == 0));
            if !is_same_unit {
                continue;
            }
            if let Some(machine) = &job.machine.axes[axis] {
                found.extend(on.reference(machine.reference.mm()));
                found.extend(on.travel(machine));
            }
            let settings = job.compensation.axes[axis].as_ref();
            let stated = settings.and_then(|s| s.detection_unit_um);
            found.extend(stated.and_then(|um| on.detection_unit(um)));
        }
    }
    found
}

/// A controlled axis of the read-out.
struct OnControl<'a> {
    memory: &'a FanucMemory,
    name: &'a str,
    unit: ControlUnit,
    facts: &'a FanucFacts,
}

impl OnControl<'_> {
    /// Its number.
    fn number(&self) -> Option<u32> {
        self.name.parse().ok()
    }

    /// The last digit of a length, in the unit of the control.
    fn digit(&self) -> f64 {
        1.0 / power_of_ten(match self.unit {
            ControlUnit::Millimetre => self.facts.interval_decimals_mm.value,
            ControlUnit::Inch => self.facts.interval_decimals_inch.value,
        })
    }

    /// A length in the unit of the control; a whole number counts its last digits, as 3624 does on the same
    /// control.
    fn length(&self, parameter: u32) -> Option<f64> {
        let digits = self.memory.whole(parameter, self.number());
        let digits = digits.map(|digits| digits as f64 * self.digit());
        digits.or_else(|| self.memory.amount(parameter, self.number()))
    }

    /// 1020, the code of a letter. A slave of a gantry may have any but that of another linear axis.
    fn other_name(&self, own: Axis, is_first: bool) -> Option<InControl> {
        let code = self.memory.count(1020, self.number())?;
        let letter = char::from_u32(code)?;
        let others = if is_first { "XYZABC" } else { "XYZ" };
        let is_other = others.contains(letter) && letter != own.letter();
        let axis = self.name.to_string();
        is_other.then_some(InControl::OtherName { axis, code, letter, own })
    }

    /// 1240, within half a digit of the control.
    fn reference(&self, own_mm: f64) -> Option<InControl> {
        let position = self.length(1240)?;
        let off_mm = (position * self.unit.in_mm() - own_mm).abs();
        (off_mm > 0.5 * self.digit() * self.unit.in_mm() * 1.001).then(|| InControl::Reference {
            axis: self.name.to_string(),
            position,
            unit: self.unit.word(),
            own_mm,
        })
    }

    /// 1820 and 1013: the least command increment divided by CMR (both from memory).
    fn detection_unit(&self, own_um: f64) -> Option<InControl> {
        let cmr = self.memory.count(1820, self.number())?;
        let system = self.memory.bits(1013, self.number())?;
        let (system, of_is_b) = match system & 0b1111 {
            0 => ("IS-B", 1.0),
            1 => ("IS-A", 10.0),
            2 => ("IS-C", 0.1),
            4 => ("IS-D", 0.01),
            8 => ("IS-E", 0.001),
            _ => return None,
        };
        let per_unit = match cmr {
            1..=96 => f64::from(cmr) / 2.0,
            101..=127 => 1.0 / f64::from(cmr - 100),
            _ => return None,
        };
        let increment_um = match self.unit {
            ControlUnit::Millimetre => of_is_b,
            ControlUnit::Inch => 2.54 * of_is_b,
        };
        let um = rounded(increment_um / per_unit, 6);
        let axis = self.name.to_string();
        let is_other = (um - own_um).abs() > 0.01 * um;
        is_other.then_some(InControl::DetectionUnit { axis, cmr, system, um, own_um })
    }

    /// 1321 and 1320, the stored stroke limits; where − is not below +, there are none (from memory). They may
    /// stand a little beside the travel that was stated; a tenth of it that no limit lets through is another
    /// machine, or other coordinates.
    fn travel(&self, own: &MachineAxis) -> Option<InControl> {
        const SAME_MM: f64 = 1.0;
        let limit = |parameter| Some(self.length(parameter)? * self.unit.in_mm());
        let (low, high) = (limit(1321)?, limit(1320)?);
        let (from, to) = (own.low.mm(), own.high.mm());
        let beyond = (low - from).max(0.0) + (to - high).max(0.0);
        let differs = (low - from).abs().max((high - to).abs()) > SAME_MM;
        let axis = self.name.to_string();
        if low >= high || !differs {
            return None;
        }
        let (held_mm, own_mm) = ([low, high], [from, to]);
        Some(match beyond > 0.1 * (to - from) {
            true => InControl::TravelBeyond { axis, held_mm, own_mm },
            false => InControl::OtherTravel { axis, held_mm, own_mm },
        })
    }
}
