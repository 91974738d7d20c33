//! The control that loaded the files of a kit.

use crate::judge::active::{ActiveControl, named_axis};
use crate::judge::after::Control;
use crate::kit::findings::InRehearsal;
use crate::kit::inputs::{Asked, cannot_emulate};
use crate::kit::loaded::loaded_state;
use crate::kit::{Inputs, LoadedControl, emulator, load_read_out};
use crate::quantity::axis::Axis;
use crate::read::{KitFile, read};
use crate::text::finding::{Finding, Severity, of_severity};
use crate::text::problem::Problems;
use crate::write::compensation::compile;
use crate::write::plan::{Task, plan};
use serde_json::Value;

/// Tables that were read from bytes, in an emulated control.
#[derive(Clone, Debug)]
pub struct SimulatedTables {
    /// What the control adds to every term.
    pub(super) control: Control,
    /// What is taken from the job because no file holds it.
    pub notes: Vec<Finding>,
}

impl SimulatedTables {
    /// Reads the files of a kit as the control of the job would; `named` = `state` of its manifest.
    pub fn read(
        inputs: &Inputs,
        files: &[KitFile<'_>],
        named: Option<&Value>,
    ) -> Result<SimulatedTables, Problems> {
        let task = Task { job: &inputs.job, profile: &inputs.profile, model: &inputs.model };
        let plan = plan(task)?;
        let asked = Asked { inputs, compiled: compile(task, &plan)?, plan };
        let (state, findings) = loaded_state(&asked, named);
        let plan = &asked.plan;
        let read = read(&inputs.profile, files)?;
        let control = emulator(&inputs.profile, &read.tables, &state)
            .and_then(|emulator| Control::new(&inputs.model, plan, emulator.as_ref()))
            .map_err(|reason| cannot_emulate(&reason))?;
        let parameter = |axis: Axis| {
            let name = plan.names[axis].first()?;
            let um = state.axis(name)?.backlash_um;
            let found = InRehearsal::Backlash {
                axis,
                um,
                is_named: named.and_then(|state| named_axis(state, name)).is_some(),
            };
            (um.abs() > 0.0).then(|| found.into())
        };
        let mut notes = of_severity(&read.notes, Severity::Note);
        notes.extend(of_severity(&findings, Severity::Disagreement));
        notes.extend(Axis::ALL.into_iter().filter_map(parameter));
        Ok(SimulatedTables { control, notes })
    }

    /// What was read out of a control, in the control of the job.
    pub fn read_out(inputs: &Inputs, active: &ActiveControl) -> Result<SimulatedTables, Problems> {
        let LoadedControl { plan, control, findings } = load_read_out(inputs, active)?;
        let control = Control::new(&inputs.model, &plan, control.as_ref())
            .map_err(|reason| cannot_emulate(&reason))?;
        let notes = findings;
        Ok(SimulatedTables { control, notes })
    }
}
