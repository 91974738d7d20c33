//! The bytes of a directory, judged against a job.

use super::inputs::{Asked, cannot_emulate, judged};
use super::loaded::Loaded;
use super::made::doubts;
use super::{Inputs, field};
use crate::control::control_state::ControlState;
use crate::control::table::Tables;
use crate::judge::active::ActiveControl;
use crate::judge::conformity::Verdict;
use crate::judge::findings::not_emulated;
use crate::judge::forecast::{Forecast, forecast, judged_ranges};
use crate::read::{KitFile, emulator};
use crate::text::finding::{Finding, Severity, of_severity};
use crate::text::problem::Problems;
use crate::write::compensation::Compiled;
use crate::write::plan::Plan;

/// What `verify` finds.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The plan of the job.
    pub plan: Plan,
    /// What the job compiles to (assumptions, preconditions, notes).
    pub compiled: Compiled,
    /// What the files of the directory hold.
    pub found: Tables,
    /// The control outside the files, as they go with it.
    pub state: ControlState,
    /// What the tables will leave; absent where they cannot be emulated.
    pub forecast: Option<Forecast>,
    /// How the tables differ from what the job asks for; what no file does and what to see to on the
    /// control instead; what acts in addition to the tables (doubts, whatever is measured).
    pub findings: Vec<Finding>,
    /// Why the measured errors are doubtful, and what acts in addition to the tables.
    pub doubts: Vec<Finding>,
    /// Forecast against the acceptance; a disagreement fails, a doubt leaves it undecided.
    pub verdict: Verdict,
}

/// Judges the bytes of a directory against a job. Only these bytes and the state of the control
/// outside them go into the forecast: `state` of the kit's manifest, else what the job states.
/// `before` = what was found against the directory before, for instance changed hashes.
pub fn verify(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    named: Option<&serde_json::Value>,
    before: Vec<Finding>,
) -> Result<Verification, Problems> {
    let asked = Asked::of(inputs)?;
    let mut loaded = Loaded::kit(&asked, files, named)?;
    let wanted = &asked.compiled;
    emulator(&inputs.profile, &wanted.tables, &wanted.state).map_err(|e| cannot_emulate(&e))?;
    let field = field::differences(&asked, files)?;
    loaded.findings = [before, loaded.findings, field].concat();
    Ok(Verification::of(asked, loaded))
}

/// Judges what was read out of a control by what it does to the job's axes: whatever else it holds
/// was ignored, and its notes say so.
pub fn verify_read_out(inputs: &Inputs, control: &ActiveControl) -> Result<Verification, Problems> {
    let asked = Asked::of(inputs)?;
    let loaded = Loaded::read_out(&asked, control)?;
    Ok(Verification::of(asked, loaded))
}

impl Verification {
    /// The forecast of a control with the files, and the verdict.
    fn of(asked: Asked<'_>, loaded: Loaded) -> Verification {
        let Asked { inputs, plan, compiled } = asked;
        let mut findings = loaded.findings;
        let ranges = judged_ranges(&inputs.job, inputs.as_measured());
        let forecast = loaded.control.ok().and_then(|control| {
            let forecast = forecast(inputs.machine(), &plan, control.as_ref(), &ranges);
            forecast.map_err(|reason| findings.push(not_emulated(reason))).ok()
        });
        findings.dedup();
        let beside = of_severity(&findings, Severity::Doubt);
        let unread = loaded.unread.into_iter().collect();
        let mut verification = Verification {
            plan,
            compiled,
            found: loaded.tables,
            state: loaded.state,
            forecast,
            findings,
            doubts: [doubts(inputs), beside, unread].concat(),
            verdict: Verdict::Fail,
        };
        if let (Some(forecast), true) = (&verification.forecast, verification.agrees()) {
            verification.verdict = judged(forecast, inputs, &verification.doubts);
        }
        verification
    }

    /// How the tables differ from what the job asks for.
    pub fn disagreements(&self) -> Vec<Finding> {
        of_severity(&self.findings, Severity::Disagreement)
    }

    /// Whether the tables are what the job asks for.
    pub fn agrees(&self) -> bool {
        let mut findings = self.findings.iter();
        findings.all(|found| found.severity() != Severity::Disagreement)
    }

    /// What no file of the directory does, and what to see to on the control instead.
    pub fn notes(&self) -> Vec<Finding> {
        of_severity(&self.findings, Severity::Note)
    }

    /// What acts in addition to the tables.
    pub(crate) fn beside(&self) -> Vec<Finding> {
        of_severity(&self.findings, Severity::Doubt)
    }
}
