//! The control that loaded the files of a kit.

use crate::after::Control;
use crate::axis::Axis;
use crate::compensation::compile;
use crate::kit::{Inputs, cannot_emulate, emulator};
use crate::plan::{Task, plan};
use crate::problem::Problems;
use crate::readback::kit::{KitFile, read};

/// Tables that were read from bytes, in an emulated control.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What the control adds to every term.
    pub(super) control: Control,
    /// What is taken from the job because no file holds it, one sentence each.
    pub notes: Vec<String>,
}

impl Loaded {
    /// Reads the files of a kit as the control of the job would.
    pub fn read(inputs: &Inputs, files: &[KitFile<'_>]) -> Result<Loaded, Problems> {
        let task = Task {
            job: &inputs.job,
            profile: &inputs.profile,
            model: &inputs.model,
        };
        let plan = plan(task)?;
        let state = compile(task, &plan)?.state;
        let read = read(&inputs.profile, files)?;
        let control = emulator(&inputs.profile, &read.tables, &state)
            .and_then(|emulator| Control::new(&inputs.model, &plan, emulator.as_ref()))
            .map_err(|reason| cannot_emulate(&reason))?;
        let parameter = |axis: Axis| {
            let name = plan.names[axis].first()?;
            let um = state.axis(name)?.backlash_um;
            (um.abs() > 0.0).then(|| {
                format!("backlash parameter of {axis}: {um:.3} µm as this job asks for it; it stands in no file of the kit")
            })
        };
        let mut notes = read.notes;
        notes.extend(Axis::ALL.into_iter().filter_map(parameter));
        Ok(Loaded { control, notes })
    }
}
