//! What was read out of a control, loaded into the emulated control of a job.

use super::loaded_state::read_out_state;
use super::{Inputs, LoadedControl, cannot_emulate};
use crate::active::ActiveControl;
use crate::compensation::Compiled;
use crate::control_state::ControlState;
use crate::disagreement;
use crate::emulate::{CannotEmulate, Emulator, emulator};
use crate::plan::{Plan, plan};
use crate::problem::Problems;

/// A read-out against what the job asks for.
pub(super) struct ReadOut {
    /// The control outside the tables, with the backlash parameters that it holds.
    pub(super) state: ControlState,
    /// The control with what was read out, or why nothing can be said of it.
    pub(super) control: Result<Box<dyn Emulator>, CannotEmulate>,
    /// How its tables differ in what they do to the job's axes, one sentence each.
    pub(super) disagreements: Vec<String>,
    /// What was passed over, and what is taken for granted.
    pub(super) notes: Vec<String>,
}

impl ReadOut {
    /// Judges what was read out by what it does to the job's axes.
    pub(super) fn of(
        inputs: &Inputs,
        plan: &Plan,
        compiled: &Compiled,
        active: &ActiveControl,
    ) -> Result<ReadOut, Problems> {
        let loaded = read_out_state(inputs, plan, compiled, active);
        let with = |tables, state| emulator(&inputs.profile, tables, state);
        let wanted =
            with(&compiled.tables, &compiled.state).map_err(|reason| cannot_emulate(&reason))?;
        let mut disagreements = disagreement::measuring_systems(&compiled.tables, &active.tables);
        match with(&active.tables, &compiled.state) {
            Ok(found) => {
                let differs = disagreement::compare(plan, wanted.as_ref(), found.as_ref());
                disagreements.extend(differs.words);
            }
            Err(reason) => disagreements.push(reason.0),
        }
        disagreements.extend(loaded.disagreements);
        Ok(ReadOut {
            control: with(&active.tables, &loaded.state),
            state: loaded.state,
            disagreements,
            notes: notes(active),
        })
    }
}

fn notes(active: &ActiveControl) -> Vec<String> {
    let assumed = active.assumptions.iter();
    let assumed = assumed.map(|a| format!("no file holds {}: it is taken to be on", a.fact));
    let parameters = active.backlash_um.iter().filter_map(|(axis, found)| {
        let um = found.filter(|um| um.abs() > 0.0)?;
        Some(format!(
            "the control holds a backlash parameter of {um} µm for {axis}"
        ))
    });
    let passed_over = active.notes.iter().cloned();
    passed_over.chain(assumed).chain(parameters).collect()
}

/// Loads what was read out of a control into the emulated control of a job.
pub fn load_read_out(inputs: &Inputs, active: &ActiveControl) -> Result<LoadedControl, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    let found = ReadOut::of(inputs, &plan, &compiled, active)?;
    Ok(LoadedControl {
        plan,
        control: found.control.map_err(|reason| cannot_emulate(&reason))?,
        disagreements: found.disagreements,
        notes: found.notes,
    })
}
