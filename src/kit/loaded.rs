//! Files in the emulated control of a job: those of a kit, or those that were read out of a
//! control; and how they differ from what the job asks for.

use super::loaded_state::{loaded_state, read_out_state};
use super::{Differences, Inputs, differences, generate};
use crate::control::control_state::ControlState;
use crate::control::table::Tables;
use crate::judge::active::ActiveControl;
use crate::judge::disagreement::{self, surroundings};
use crate::kit::inputs::cannot_emulate;
use crate::read::emulate::{CannotEmulate, Emulator};
use crate::read::emulator;
use crate::read::{KitFile, read, unread};
use crate::text::problem::Problems;
use crate::write::compensation::Compiled;
use crate::write::plan::{Plan, plan};

/// Files against what the job asks for.
pub(super) struct Loaded {
    /// What the files hold.
    pub(super) tables: Tables,
    /// The control outside the tables, as it goes with the files.
    pub(super) state: ControlState,
    /// The control with the tables, or why nothing can be said of it.
    pub(super) control: Result<Box<dyn Emulator>, CannotEmulate>,
    /// How the files differ from what the job asks for, one sentence each.
    pub(super) disagreements: Vec<String>,
    /// What no file does, what was passed over, and what is taken for granted.
    pub(super) notes: Vec<String>,
    /// What acts on the axes of the job and is not emulated: nothing is decided in favour.
    pub(super) beside: Vec<String>,
    /// Files that the control may load and no reader takes, in a sentence.
    pub(super) unread: Option<String>,
}

impl Loaded {
    /// The files of a kit; `named` = `state` of their manifest. Everything that they hold counts.
    pub(super) fn kit(
        inputs: &Inputs,
        plan: &Plan,
        compiled: &Compiled,
        files: &[KitFile<'_>],
        named: Option<&serde_json::Value>,
    ) -> Result<Loaded, Problems> {
        let outside = loaded_state(inputs, plan, compiled, named);
        let read = read(&inputs.profile, files)?;
        let Differences { mut words, found } = differences(inputs, plan, compiled, &read);
        words.extend(outside.disagreements);
        let mut notes = disagreement::absent(&inputs.profile, &compiled.tables, &read);
        notes.extend(outside.notes);
        Ok(Loaded {
            notes,
            beside: Vec::new(),
            unread: unread(&inputs.profile, files),
            control: found.and_then(|_| emulator(&inputs.profile, &read.tables, &outside.state)),
            tables: read.tables,
            state: outside.state,
            disagreements: words,
        })
    }

    /// What was read out of a control, judged by what it does to the job's axes.
    pub(super) fn read_out(
        inputs: &Inputs,
        plan: &Plan,
        compiled: &Compiled,
        active: &ActiveControl,
    ) -> Result<Loaded, Problems> {
        let outside = read_out_state(inputs, plan, compiled, active);
        let with = |tables, state| emulator(&inputs.profile, tables, state);
        let wanted =
            with(&compiled.tables, &compiled.state).map_err(|reason| cannot_emulate(&reason))?;
        let around = surroundings(plan, compiled, active);
        let mut words = [active.disagreements.clone(), around.disagreements].concat();
        match with(&active.tables, &compiled.state) {
            Ok(found) => {
                let differs = disagreement::compare(plan, wanted.as_ref(), found.as_ref());
                words.extend(differs.words);
            }
            Err(reason) => words.push(reason.0),
        }
        words.extend(outside.disagreements);
        Ok(Loaded {
            notes: [notes(active), around.notes, outside.notes].concat(),
            beside: [active.beside.clone(), around.beside].concat(),
            unread: None,
            control: with(&active.tables, &outside.state),
            tables: active.tables.clone(),
            state: outside.state,
            disagreements: words,
        })
    }

    fn with(self, plan: Plan) -> Result<LoadedControl, Problems> {
        Ok(LoadedControl {
            plan,
            control: self.control.map_err(|reason| cannot_emulate(&reason))?,
            disagreements: self.disagreements,
            notes: [self.notes, self.beside, self.unread.into_iter().collect()].concat(),
        })
    }
}

fn notes(active: &ActiveControl) -> Vec<String> {
    let assumed: Vec<&str> = active.assumptions.iter().map(|a| a.fact.as_str()).collect();
    let mut notes = active.notes.clone();
    if !assumed.is_empty() {
        notes.push(format!(
            "no file holds {}: taken to be on",
            assumed.join(", ")
        ));
    }
    notes
}

/// A control with tables in it, and the plan that names its axes.
pub struct LoadedControl {
    /// The plan of the job.
    pub plan: Plan,
    /// What the files make of the control.
    pub control: Box<dyn Emulator>,
    /// How the files differ from what the job asks for, one sentence each.
    pub disagreements: Vec<String>,
    /// What no file does, what was passed over, and what is taken for granted.
    pub notes: Vec<String>,
}

/// Loads the bytes of a kit into the emulated control of a job; `named` = `state` of their manifest.
pub fn load(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    named: Option<&serde_json::Value>,
) -> Result<LoadedControl, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    Loaded::kit(inputs, &plan, &compiled, files, named)?.with(plan)
}

/// Loads what was read out of a control into the emulated control of a job.
pub fn load_read_out(inputs: &Inputs, active: &ActiveControl) -> Result<LoadedControl, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    Loaded::read_out(inputs, &plan, &compiled, active)?.with(plan)
}

/// Makes the files of a job in memory and loads their bytes.
pub fn load_own(inputs: &Inputs) -> Result<LoadedControl, Problems> {
    let kit = generate(inputs)?;
    load(inputs, &kit.kit_files(), Some(&kit.manifest.state))
}
