//! The state of the control that goes with the files of a directory.
//!
//! A backlash parameter stands in no file for the control: a kit names it in its manifest. The job
//! that the kit is judged by may ask for another one.

use super::{Inputs, named_backlash};
use crate::control::control_state::{AxisState, ControlState};
use crate::judge::active::{ActiveControl, named_axis};
use crate::write::compensation::Compiled;
use crate::write::plan::Plan;
use serde_json::Value;

/// Two parameters closer than this are one, µm (a manifest holds picometres).
const SAME_UM: f64 = 1e-6;

/// The control outside the files, as they go with it.
#[derive(Clone, Debug)]
pub struct LoadedState {
    /// That of the job, with the backlash parameters that the manifest names.
    pub state: ControlState,
    /// Where the manifest names another one than the job, one sentence each.
    pub disagreements: Vec<String>,
    /// Parameters that are taken as the job asks because nothing tells them, one sentence each.
    pub notes: Vec<String>,
}

/// Puts the backlash parameters of a kit into the control of a job; `named` = `state` of its
/// manifest, `None` where there is none, so that only the job says what they are.
pub fn loaded_state(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    named: Option<&Value>,
) -> LoadedState {
    let mut loaded = LoadedState {
        state: compiled.state.clone(),
        disagreements: Vec::new(),
        notes: Vec::new(),
    };
    for axis in &mut loaded.state.axes {
        let entry = named.and_then(|state| named_axis(state, &axis.name));
        let wanted = named_backlash(inputs, plan, compiled, &axis.name);
        let Some(parameter) = entry.and_then(|entry| entry.get("backlash_um")) else {
            let name = &axis.name;
            // No kit, or one from before manifests held it.
            loaded.notes.extend(wanted.map(|um| {
                format!("no manifest names the backlash parameter of axis {name}: taken as the job asks, {}", micrometres(um))
            }));
            continue;
        };
        let words = take(axis, "the kit was made for", parameter.as_f64(), wanted);
        loaded.disagreements.extend(words);
    }
    loaded
}

/// The same with the backlash parameters that were read out of the control. One that the job does
/// not ask for acts as it did while measuring.
pub(super) fn read_out_state(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    control: &ActiveControl,
) -> LoadedState {
    let mut loaded = LoadedState {
        state: compiled.state.clone(),
        disagreements: Vec::new(),
        notes: Vec::new(),
    };
    let parameter = inputs.profile.dialect.backlash_parameter();
    for axis in &mut loaded.state.axes {
        let own = |(name, _): &&(String, Option<f64>)| *name == axis.name;
        let found = control.held_backlash.iter().find(own);
        let found = found.and_then(|(_, um)| *um);
        let wanted = named_backlash(inputs, plan, compiled, &axis.name);
        let name = &axis.name;
        let note = match (found, wanted) {
            (None, None) => None,
            (None, Some(um)) => Some(format!(
                "no file holds the {parameter} of axis {name}: taken as the job asks, {}",
                micrometres(um)
            )),
            (Some(um), None) => (um.abs() > 0.0).then(|| {
                format!(
                    "the {parameter} of axis {name} is {}; the job does not set it, so it counts as unchanged since the measurement",
                    micrometres(um)
                )
            }),
            (Some(_), Some(_)) => {
                let words = take(axis, "the control holds", found, wanted);
                loaded.disagreements.extend(words);
                None
            }
        };
        loaded.notes.extend(note);
    }
    loaded
}

/// To a nanometre, without the digits that a conversion from millimetres adds.
fn micrometres(um: f64) -> String {
    format!("{} µm", (um * 1e3).round() / 1e3 + 0.0)
}

/// A parameter that the tables do not set counts from the one that acted while measuring.
fn take(
    axis: &mut AxisState,
    who: &str,
    named: Option<f64>,
    wanted: Option<f64>,
) -> Option<String> {
    if let Some(um) = named {
        axis.backlash_um += um - wanted.unwrap_or(0.0);
    }
    let said = |um: Option<f64>| um.map_or_else(|| "none".to_string(), micrometres);
    let same = match (named, wanted) {
        (Some(named), Some(wanted)) => (named - wanted).abs() <= SAME_UM,
        (named, wanted) => named.is_none() && wanted.is_none(),
    };
    (!same).then(|| {
        format!(
            "backlash parameter of axis {}: {who} {}, the job asks for {}",
            axis.name,
            said(named),
            said(wanted)
        )
    })
}
