//! What a read-out holds around the points: how the control plays them, its second backlash parameter.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::table::fanuc::FanucMemory;
use crate::judge::findings::InControl;
use crate::quantity::Axis;
use crate::write::plan::Plan;

/// How a Fanuc control plays its points, and its second backlash parameter.
pub(super) fn found(
    plan: &Plan,
    state: &ControlState,
    wanted: &FanucMemory,
    held: &FanucMemory,
) -> Vec<InControl> {
    let mut found = Vec::new();
    for axis in &state.axes {
        if wanted.parameter(3623, axis.name.parse().ok()).is_some() {
            found.extend(switches(axis, wanted, held));
        }
        found.extend(rapid(plan, axis, held));
    }
    found
}

/// 3605 bits 0 and 1 of an axis with a pitch table.
fn switches(axis: &AxisState, wanted: &FanucMemory, held: &FanucMemory) -> Vec<InControl> {
    let number = axis.name.parse().ok();
    let of_state = u8::from(axis.bidirectional) | (u8::from(axis.interpolated) << 1);
    let asked = wanted.bits(3605, number).unwrap_or(of_state) & 0b11;
    let Some(found) = held.bits(3605, number) else {
        return vec![InControl::NoSwitches {
            axis: axis.name.clone(),
            directions: asked & 1,
            interpolated: asked >> 1,
        }];
    };
    let meanings = ["a table for each direction", "lines between the points, not steps"];
    let other = meanings.into_iter().enumerate().map(|(bit, meaning)| {
        let (is, asked) = ((found >> bit) & 1, (asked >> bit) & 1);
        let axis = axis.name.clone();
        (is != asked).then_some(InControl::OtherSwitch { bit, axis, is, asked, meaning })
    });
    other.flatten().collect()
}

/// 1852 beside 1851 where the job sets the backlash parameter. Which of the two acts in rapid
/// traverse depends on a bit (1800#4, from memory) that is not read.
fn rapid(plan: &Plan, axis: &AxisState, held: &FanucMemory) -> Option<InControl> {
    let sets = |own: &Axis| plan.names[*own].contains(&axis.name) && plan.sets_backlash(*own);
    if !Axis::ALL.iter().any(sets) {
        return None;
    }
    let number = axis.name.parse().ok();
    let of = |parameter| Some(held.amount(parameter, number)?.to_string());
    let (axis, cutting) = (axis.name.clone(), of(1851));
    match of(1852) {
        None => cutting.map(|_| InControl::NoRapid { axis }),
        Some(rapid) => (cutting.as_ref() != Some(&rapid)).then(|| InControl::RapidDiffers {
            axis,
            rapid,
            cutting: cutting.unwrap_or("in no file".to_string()),
        }),
    }
}

/// Preconditions on parameters that no file holds, for the axes with a pitch table.
pub(super) fn absent(axes: &[AxisState], wanted: &FanucMemory, held: &FanucMemory) -> Vec<String> {
    let mut absent = Vec::new();
    if held.parameters.keys().all(|key| key.number != 3602) {
        absent.push("3602".to_string());
    }
    for axis in axes {
        let number = axis.name.parse().ok();
        let own = wanted.parameter(3623, number).is_some();
        let lacks = |parameter: &u32| own && held.parameter(*parameter, number).is_none();
        let lacking = [1006, 1240].into_iter().filter(lacks);
        absent.extend(lacking.map(|parameter| format!("{parameter} of axis {}", axis.name)));
    }
    absent
}
