//! The bytes of a directory, judged against a job.

use super::read_out::ReadOut;
use super::{
    Differences, Inputs, cannot_emulate, differences, doubts, field, judged, loaded_state,
};
use crate::active::ActiveControl;
use crate::compensation::Compiled;
use crate::control_state::ControlState;
use crate::disagreement;
use crate::emulate::{Emulator, emulator};
use crate::forecast::{Forecast, Verdict, forecast};
use crate::plan::{Plan, plan};
use crate::problem::Problems;
use crate::readback::kit::{KitFile, read};

/// What `verify` finds.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The plan of the job.
    pub plan: Plan,
    /// What the job compiles to (assumptions, preconditions, notes).
    pub compiled: Compiled,
    /// What the files of the directory hold.
    pub found: crate::table::Tables,
    /// The control outside the files, as they go with it.
    pub state: ControlState,
    /// What the tables will leave; absent where they cannot be emulated.
    pub forecast: Option<Forecast>,
    /// How the tables differ from what the job asks for, one sentence each.
    pub disagreements: Vec<String>,
    /// What no file of the directory does, and what to see to on the control instead.
    pub absent: Vec<String>,
    /// Why the measured errors are doubtful, one sentence each.
    pub doubts: Vec<String>,
    /// Forecast against the acceptance; a disagreement fails, a doubt leaves it undecided.
    pub verdict: Verdict,
}

/// Judges the bytes of a directory against a job. Only these bytes and the state of the control
/// outside them go into the forecast: `state` of the kit's manifest, else what the job states.
pub fn verify(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    named: Option<&serde_json::Value>,
    mut disagreements: Vec<String>,
) -> Result<Verification, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    let compiled = inputs.compile(&plan)?;
    let loaded = loaded_state(inputs, &plan, &compiled, named);
    let read = read(&inputs.profile, files)?;
    emulator(&inputs.profile, &compiled.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let Differences { words, found } = differences(inputs, &plan, &compiled, &read);
    disagreements.extend(words);
    disagreements.extend(loaded.disagreements);
    disagreements.extend(field::differences(inputs, &plan, &compiled, files)?);
    let found = found.and_then(|_| emulator(&inputs.profile, &read.tables, &loaded.state));
    let verification = Verification {
        absent: disagreement::absent(&inputs.profile, &compiled.tables, &read),
        plan,
        compiled,
        found: read.tables,
        state: loaded.state,
        forecast: None,
        disagreements,
        doubts: doubts(inputs),
        verdict: Verdict::Fail,
    };
    Ok(verification.forecast_with(inputs, found.ok().as_deref()))
}

/// Judges what was read out of a control by what it does to the job's axes: whatever else it holds
/// was passed over, and its notes say so.
pub fn verify_read_out(inputs: &Inputs, control: &ActiveControl) -> Result<Verification, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    let found = ReadOut::of(inputs, &plan, &compiled, control)?;
    let verification = Verification {
        absent: found.notes,
        plan,
        compiled,
        found: control.tables.clone(),
        state: found.state,
        forecast: None,
        disagreements: found.disagreements,
        doubts: doubts(inputs),
        verdict: Verdict::Fail,
    };
    Ok(verification.forecast_with(inputs, found.control.ok().as_deref()))
}

impl Verification {
    /// The forecast of a control, and the verdict.
    fn forecast_with(mut self, inputs: &Inputs, control: Option<&dyn Emulator>) -> Verification {
        match control.map(|control| forecast(inputs.machine(), &self.plan, control)) {
            Some(Ok(forecast)) => self.forecast = Some(forecast),
            Some(Err(reason)) => self.disagreements.push(reason.0),
            None => {}
        }
        self.disagreements.dedup();
        if let (Some(forecast), true) = (&self.forecast, self.disagreements.is_empty()) {
            self.verdict = judged(forecast, inputs, &self.doubts);
        }
        self
    }
}
