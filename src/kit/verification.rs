//! The bytes of a directory, judged against a job.

use super::inputs::{Asked, cannot_emulate, judged};
use super::loaded::Loaded;
use super::made::doubts;
use super::{Inputs, field};
use crate::judge::active::ActiveControl;
use crate::judge::conformity::Verdict;
use crate::judge::findings::not_emulated;
use crate::judge::forecast::Forecast;
use crate::read::{KitFile, emulator};
use crate::text::finding::{Finding, Severity, of_severity};
use crate::text::problem::Problems;

/// What `verify` finds.
pub struct Verification<'a> {
    /// The control with the tables of the directory.
    pub(crate) loaded: Loaded<'a>,
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
pub fn verify<'a>(
    inputs: &'a Inputs,
    files: &[KitFile<'_>],
    named: Option<&serde_json::Value>,
    before: Vec<Finding>,
) -> Result<Verification<'a>, Problems> {
    let loaded = Loaded::kit(Asked::of(inputs)?, files, named)?;
    let wanted = &loaded.asked.compiled;
    emulator(&inputs.profile, &wanted.tables, &wanted.state).map_err(|e| cannot_emulate(&e))?;
    let field = field::differences(&loaded.asked, files)?;
    let findings = [before, loaded.findings.clone(), field].concat();
    Ok(Verification::of(loaded, findings))
}

/// Judges what was read out of a control by what it does to the job's axes: whatever else it holds
/// was ignored, and its notes say so.
pub fn verify_read_out<'a>(
    inputs: &'a Inputs,
    control: &ActiveControl,
) -> Result<Verification<'a>, Problems> {
    let loaded = Loaded::read_out(Asked::of(inputs)?, control)?;
    let findings = loaded.findings.clone();
    Ok(Verification::of(loaded, findings))
}

impl<'a> Verification<'a> {
    /// The forecast of a control with the files, and the verdict.
    fn of(loaded: Loaded<'a>, mut findings: Vec<Finding>) -> Verification<'a> {
        let inputs = loaded.asked.inputs;
        let forecast = loaded.control.as_deref().ok().and_then(|control| {
            let forecast = loaded.forecast(control);
            forecast.map_err(|reason| findings.push(not_emulated(reason))).ok()
        });
        findings.dedup();
        let beside = of_severity(&findings, Severity::Doubt);
        let unread = loaded.unread.iter().cloned().collect();
        let mut verification = Verification {
            loaded,
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
