//! The control that loaded the files of a kit.

use crate::axis::Axis;
use crate::compensation::compile;
use crate::emulate::Emulator;
use crate::kit::{Inputs, cannot_emulate, emulator};
use crate::plan::{Plan, Task, plan};
use crate::problem::Problems;
use crate::readback::kit::{KitFile, read};

/// Tables that were read from bytes, in an emulated control.
pub struct Loaded {
    /// The plan of the job: the control's names of the axes.
    pub(super) plan: Plan,
    /// The control.
    pub(super) control: Box<dyn Emulator>,
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
        let control =
            emulator(&inputs.profile, &read.tables, &state).map_err(|e| cannot_emulate(&e))?;
        let parameter = |axis: Axis| {
            let name = plan.names[axis].first()?;
            let um = state.axis(name)?.backlash_um;
            (um.abs() > 0.0).then(|| {
                format!("backlash parameter of {axis}: {um:.3} µm as this job asks for it; it stands in no file of the kit")
            })
        };
        let mut notes = read.notes;
        notes.extend(Axis::ALL.into_iter().filter_map(parameter));
        Ok(Loaded {
            plan,
            control,
            notes,
        })
    }
}
