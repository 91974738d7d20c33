//! The bytes of a directory, judged against a job.

use super::loaded::Loaded;
use super::{Inputs, doubts, field, judged};
use crate::control::control_state::ControlState;
use crate::judge::active::ActiveControl;
use crate::judge::conformity::Verdict;
use crate::judge::forecast::{Forecast, forecast, judged_ranges};
use crate::kit::inputs::cannot_emulate;
use crate::read::KitFile;
use crate::read::emulator;
use crate::text::problem::Problems;
use crate::write::compensation::Compiled;
use crate::write::plan::{Plan, plan};

/// What `verify` finds.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The plan of the job.
    pub plan: Plan,
    /// What the job compiles to (assumptions, preconditions, notes).
    pub compiled: Compiled,
    /// What the files of the directory hold.
    pub found: crate::control::table::Tables,
    /// The control outside the files, as they go with it.
    pub state: ControlState,
    /// What the tables will leave; absent where they cannot be emulated.
    pub forecast: Option<Forecast>,
    /// How the tables differ from what the job asks for, one sentence each.
    pub disagreements: Vec<String>,
    /// What no file of the directory does, and what to see to on the control instead.
    pub absent: Vec<String>,
    /// Why the measured errors are doubtful, and what acts beside the tables, one sentence each.
    pub doubts: Vec<String>,
    /// Those of the doubts that hold whatever is measured: what acts beside the tables.
    pub beside: Vec<String>,
    /// Forecast against the acceptance; a disagreement fails, a doubt leaves it undecided.
    pub verdict: Verdict,
}

/// Judges the bytes of a directory against a job. Only these bytes and the state of the control
/// outside them go into the forecast: `state` of the kit's manifest, else what the job states.
/// `remarks` = what was found against the directory before, for instance changed hashes.
pub fn verify(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    named: Option<&serde_json::Value>,
    remarks: Vec<String>,
) -> Result<Verification, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    let mut loaded = Loaded::kit(inputs, &plan, &compiled, files, named)?;
    emulator(&inputs.profile, &compiled.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let field = field::differences(inputs, &plan, &compiled, files)?;
    loaded.disagreements = [remarks, loaded.disagreements, field].concat();
    Ok(Verification::of(inputs, plan, compiled, loaded))
}

/// Judges what was read out of a control by what it does to the job's axes: whatever else it holds
/// was passed over, and its notes say so.
pub fn verify_read_out(inputs: &Inputs, control: &ActiveControl) -> Result<Verification, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    let loaded = Loaded::read_out(inputs, &plan, &compiled, control)?;
    Ok(Verification::of(inputs, plan, compiled, loaded))
}

impl Verification {
    /// The forecast of a control with the files, and the verdict.
    fn of(inputs: &Inputs, plan: Plan, compiled: Compiled, loaded: Loaded) -> Verification {
        let unread = loaded.unread.into_iter().collect();
        let doubts = [doubts(inputs), loaded.beside.clone(), unread].concat();
        let mut disagreements = loaded.disagreements;
        let control = loaded.control.ok();
        let ranges = judged_ranges(&inputs.job, inputs.as_measured());
        let forecast =
            control.map(|control| forecast(inputs.machine(), &plan, control.as_ref(), &ranges));
        let forecast = match forecast.transpose() {
            Ok(forecast) => forecast,
            Err(reason) => {
                disagreements.push(reason.0);
                None
            }
        };
        disagreements.dedup();
        let verdict = match &forecast {
            Some(forecast) if disagreements.is_empty() => judged(forecast, inputs, &doubts),
            _ => Verdict::Fail,
        };
        Verification {
            plan,
            compiled,
            found: loaded.tables,
            state: loaded.state,
            forecast,
            disagreements,
            absent: loaded.notes,
            doubts,
            beside: loaded.beside,
            verdict,
        }
    }
}
