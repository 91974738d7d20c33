//! The bytes of a directory, judged against a job.

use super::inputs::{Asked, cannot_emulate, judged};
use super::loaded::Loaded;
use super::made::{as_read, doubts};
use super::{Inputs, field};
use crate::judge::active::ActiveControl;
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::judge::findings::not_emulated;
use crate::judge::forecast::Forecast;
use crate::read::{KitFile, emulator};
use crate::text::{Finding, Problems, Severity, of_severity};
use crate::write::emit;

/// What `verify` finds.
pub struct Verification<'a> {
    /// The control with the tables of the directory.
    pub(crate) loaded: Loaded<'a>,
    /// What the control adds with the tables; absent where they cannot be emulated.
    pub(crate) effect: Option<Field>,
    /// What that leaves.
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

/// Judges the tables of a job as those of its kit are. No file is made for the control and nothing is read back: the tables are
/// those as compiled, which [`generate`](super::generate) refuses to write unless its files read back to exactly them.
pub fn forecast(inputs: &Inputs) -> Result<Verification<'_>, Problems> {
    let asked = Asked::of(inputs)?;
    let files = emit::render_unread(inputs.task(), &asked.compiled)?;
    Ok(Verification::of(Loaded::compiled(asked, &as_read(&files)), Vec::new()))
}

impl<'a> Verification<'a> {
    /// The forecast of a control with the files, and the verdict.
    fn of(loaded: Loaded<'a>, mut findings: Vec<Finding>) -> Verification<'a> {
        let inputs = loaded.asked.inputs;
        let effect = loaded.control.as_deref().ok().and_then(|control| {
            let effect = loaded.field(control);
            effect.map_err(|reason| findings.push(not_emulated(reason))).ok()
        });
        let forecast = effect.as_ref().map(|effect| loaded.forecast(effect));
        findings.dedup();
        let beside = of_severity(&findings, Severity::Doubt);
        let unread = loaded.unread.iter().cloned().collect();
        let mut verification = Verification {
            loaded,
            effect,
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
}

#[cfg(test)]
mod tests {
    use super::{Inputs, forecast};
    use crate::control::controller::builtin;
    use crate::inputs::error_table::ErrorTable;
    use crate::inputs::job::Job;
    use crate::kit::generate;
    use crate::text::Source;
    use std::path::Path;

    fn source(path: &Path) -> Source {
        Source::from_bytes("", &std::fs::read(path).unwrap()).unwrap()
    }

    /// To the last bit: a number is shown with all its digits.
    #[test]
    fn the_forecast_without_files_is_that_of_the_kit() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
        let errors = ErrorTable::read(source(&folder.join("errors.csv"))).unwrap();
        let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let jobs: Vec<_> = all.filter(|path| path.extension().unwrap() == "toml").collect();
        assert!(jobs.len() >= 10);
        for path in jobs {
            let job = Job::read(source(&path)).unwrap();
            let profile = builtin::profile(&job.compensation.controller).unwrap();
            let inputs = Inputs::new(job, profile, &errors, Vec::new()).unwrap();
            let kit = generate(&inputs).unwrap();
            let of_kit = (Some(kit.forecast), kit.verdict, kit.manifest.doubts);
            let alone = forecast(&inputs).unwrap();
            let alone = (alone.forecast, alone.verdict, alone.doubts);
            assert_eq!(format!("{alone:?}"), format!("{of_kit:?}"), "{}", path.display());
        }
    }
}
