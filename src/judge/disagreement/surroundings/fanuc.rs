//! How a Fanuc control plays its points, and its second backlash parameter.

use super::Surroundings;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::table::fanuc::{FanucMemory, ParameterValue};
use crate::quantity::axis::Axis;
use crate::write::plan::Plan;

impl Surroundings {
    pub(super) fn of_fanuc(
        &mut self,
        plan: &Plan,
        state: &ControlState,
        wanted: &FanucMemory,
        held: &FanucMemory,
    ) {
        for axis in &state.axes {
            if wanted.parameter(3623, axis.name.parse().ok()).is_some() {
                self.switches(axis, wanted, held);
            }
            self.rapid(plan, axis, held);
        }
        self.absent(absent(&state.axes, wanted, held));
    }

    /// 3605 bits 0 and 1 of an axis with a pitch table.
    fn switches(&mut self, axis: &AxisState, wanted: &FanucMemory, held: &FanucMemory) {
        let number = axis.name.parse().ok();
        let bits = |memory: &FanucMemory| match memory.parameter(3605, number) {
            Some(ParameterValue::Bits(bits)) => Some(bits),
            _ => None,
        };
        let of_state = u8::from(axis.bidirectional) | (u8::from(axis.interpolated) << 1);
        let asked = bits(wanted).unwrap_or(of_state) & 0b11;
        let name = &axis.name;
        let Some(found) = bits(held) else {
            self.notes.push(format!(
                "no file holds 3605 of axis {name}: bit 0 (table for each direction) and bit 1 (interpolated) are taken as the job asks, {} and {}",
                asked & 1,
                asked >> 1
            ));
            return;
        };
        let meanings = [
            "a table for each direction",
            "lines between the points, not steps",
        ];
        for (bit, meaning) in meanings.iter().enumerate() {
            let (is, should) = ((found >> bit) & 1, (asked >> bit) & 1);
            if is != should {
                self.disagreements.push(format!(
                    "3605#{bit} of axis {name} is {is}, the job is for {should} (1 = {meaning})"
                ));
            }
        }
    }

    /// 1852 beside 1851 where the job sets the backlash parameter. Which of the two acts in rapid
    /// traverse depends on a bit (1800#4, from memory) that is not read.
    fn rapid(&mut self, plan: &Plan, axis: &AxisState, held: &FanucMemory) {
        let number = axis.name.parse().ok();
        let of = |parameter| match held.parameter(parameter, number) {
            Some(ParameterValue::Integer(counts)) => Some(counts.to_string()),
            Some(ParameterValue::Real(counts)) => Some(counts.to_string()),
            _ => None,
        };
        let sets = |own: &Axis| plan.names[*own].contains(&axis.name) && plan.sets_backlash(*own);
        if !Axis::ALL.iter().any(sets) {
            return;
        }
        let name = &axis.name;
        match (of(1851), of(1852)) {
            (cutting, Some(rapid)) if cutting.as_ref() != Some(&rapid) => {
                let cutting = cutting.unwrap_or("in no file".to_string());
                self.beside.push(format!(
                    "1852 of axis {name} is {rapid}, 1851 is {cutting}, and the job asks for the same in both: where the control takes 1852 in rapid traverse, the axis stands elsewhere than forecast after it"
                ));
            }
            (Some(_), None) => self.notes.push(format!(
                "no file holds 1852 of axis {name}: taken as its 1851"
            )),
            _ => {}
        }
    }
}

/// Preconditions on parameters that no file holds, for the axes with a pitch table.
fn absent(axes: &[AxisState], wanted: &FanucMemory, held: &FanucMemory) -> Vec<String> {
    let mut absent = Vec::new();
    if held.parameters.keys().all(|key| key.number != 3602) {
        absent.push("3602".to_string());
    }
    for axis in axes {
        let number = axis.name.parse().ok();
        let own = wanted.parameter(3623, number).is_some();
        for parameter in [1006, 1240].into_iter().filter(|_| own) {
            if held.parameter(parameter, number).is_none() {
                absent.push(format!("{parameter} of axis {}", axis.name));
            }
        }
    }
    absent
}
