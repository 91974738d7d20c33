//! What a read-out holds around the tables, against what the job asks of the control there.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::ControlUnit;
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterValue};
use crate::control::table::siemens::SiemensTables;
use crate::judge::active::{ActiveControl, Held, Origin, cec_limits, cec_outputs};
use crate::judge::findings::InControl;
use crate::quantity::axis::Axis;
use crate::text::finding::Finding;
use crate::write::compensation::Compiled;
use crate::write::plan::Plan;

/// Compares them; what is not read out of a control has no surroundings. What no file holds is taken
/// as the job asks, and said.
pub fn surroundings(plan: &Plan, wanted: &Compiled, active: &ActiveControl) -> Vec<Finding> {
    let Origin::ReadOut(held) = &active.origin else {
        return Vec::new();
    };
    let state = &wanted.state;
    let (mut found, what) = match (&wanted.tables, &held.tables) {
        (Tables::Siemens(tables), _) => (of_siemens(state, tables, held), absent(tables, held)),
        (Tables::Fanuc(tables), Tables::Fanuc(memory)) => (
            of_fanuc(plan, state, tables, memory),
            absent_parameters(&state.axes, tables, memory),
        ),
        _ => (Vec::new(), Vec::new()),
    };
    found.extend((!what.is_empty()).then_some(InControl::AsAsked { what }));
    found.into_iter().map(Finding::from).collect()
}

/// Unit of the control, limit and unit of CEC, reference points.
fn of_siemens(state: &ControlState, wanted: &SiemensTables, held: &Held) -> Vec<InControl> {
    let mut found = cec_limits(held, wanted, state.unit);
    found.extend(state.axes.iter().filter_map(|axis| {
        let own = wanted.lec.iter().find(|table| table.axis == axis.name);
        reference(axis, own.map_or(0, |table| table.encoder), state.unit, held)
    }));
    found
}

/// MD34100, the position at the zero mark of an incremental measuring system. With an absolute or
/// a distance-coded one (MD34200 other than 1) it says nothing (both from memory). The index of
/// MD34100 is a reference cam, that of MD34200 the measuring system.
fn reference(axis: &AxisState, encoder: u32, unit: ControlUnit, held: &Held) -> Option<InControl> {
    const SAME_MM: f64 = 1e-3;
    const ZERO_MARK: f64 = 1.0;
    let of = |name: &str, index: u32| held.number(name, &[index.to_string(), axis.name.clone()]);
    let position = of("MA_REFP_SET_POS", 0)?;
    let mode = of("MA_ENC_REFP_MODE", encoder);
    let counts = mode.is_none_or(|mode| (mode - ZERO_MARK).abs() <= 0.0);
    let own_mm = axis.reference.mm();
    let is_other = (position * unit.in_mm() - own_mm).abs() > SAME_MM;
    (counts && is_other).then(|| InControl::ReferencePoint {
        axis: axis.name.clone(),
        position,
        unit: unit.word(),
        own_mm,
    })
}

/// Preconditions on machine data that no file holds.
fn absent(tables: &SiemensTables, held: &Held) -> Vec<String> {
    let mut absent = Vec::new();
    if held.datum("MN_SCALING_SYSTEM_IS_METRIC", &[]).is_none() {
        absent.push("MD10240".to_string());
    }
    for output in cec_outputs(tables) {
        let data = [
            ("MA_CEC_MAX_SUM", "MD32720"),
            ("MA_CEC_SCALING_SYSTEM_METRIC", "MD32711"),
        ];
        let lacks = |name: &str| held.datum(name, std::slice::from_ref(&output)).is_none();
        let lacking = data.into_iter().filter(|(name, _)| lacks(name));
        absent.extend(lacking.map(|(_, number)| format!("{number} of {output}")));
    }
    absent
}

/// How a Fanuc control plays its points, and its second backlash parameter.
fn of_fanuc(
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
    let bits = |memory: &FanucMemory| match memory.parameter(3605, number) {
        Some(ParameterValue::Bits(bits)) => Some(bits),
        _ => None,
    };
    let of_state = u8::from(axis.bidirectional) | (u8::from(axis.interpolated) << 1);
    let asked = bits(wanted).unwrap_or(of_state) & 0b11;
    let Some(found) = bits(held) else {
        return vec![InControl::NoSwitches {
            axis: axis.name.clone(),
            directions: asked & 1,
            interpolated: asked >> 1,
        }];
    };
    let meanings = [
        "a table for each direction",
        "lines between the points, not steps",
    ];
    let other = meanings.into_iter().enumerate().map(|(bit, meaning)| {
        let (is, asked) = ((found >> bit) & 1, (asked >> bit) & 1);
        let axis = axis.name.clone();
        (is != asked).then_some(InControl::OtherSwitch {
            bit,
            axis,
            is,
            asked,
            meaning,
        })
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
    let of = |parameter| match held.parameter(parameter, number) {
        Some(ParameterValue::Integer(counts)) => Some(counts.to_string()),
        Some(ParameterValue::Real(counts)) => Some(counts.to_string()),
        _ => None,
    };
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
fn absent_parameters(axes: &[AxisState], wanted: &FanucMemory, held: &FanucMemory) -> Vec<String> {
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
