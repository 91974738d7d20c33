//! The bytes of a directory, judged against a job, and a measurement with them active.

use super::inputs::{Inputs, JobTables, judged};
use super::loaded::{Loaded, doubts};
use crate::control::controller::KitFile;
use crate::inputs::job::Job;
use crate::judge::active::{ActiveControl, State};
use crate::judge::after::{AfterMeasurement, Comparison, compare, observations, unseen_reversal};
use crate::judge::causes::{Diagnosis, Question, WithoutSlip, diagnose};
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::judge::findings::not_emulated;
use crate::judge::forecast::Forecast;
use crate::kit::field;
use crate::kit::findings::KitFinding;
use crate::quantity::{Direction, PerAxis};
use crate::read::emulator;
use crate::text::{Finding, Problem, Problems, Severity, of_severity};
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
    files: &[KitFile],
    named: Option<&State>,
    before: Vec<Finding>,
) -> Result<Verification<'a>, Problems> {
    let loaded = Loaded::kit(JobTables::of(inputs)?, files, named)?;
    let wanted = &loaded.asked.compiled;
    emulator(&inputs.profile, &wanted.tables, &wanted.state)?;
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
    let loaded = Loaded::read_out(JobTables::of(inputs)?, control)?;
    let findings = loaded.findings.clone();
    Ok(Verification::of(loaded, findings))
}

/// Judges the tables of a job as those of its kit are. No file is made for the control and nothing is read back: the tables are
/// those as compiled, which [`generate`](super::generate) refuses to write unless its files read back to exactly them.
pub fn forecast(inputs: &Inputs) -> Result<Verification<'_>, Problems> {
    let asked = JobTables::of(inputs)?;
    let files = emit::render_unread(inputs.task(), &asked.compiled)?;
    Ok(Verification::of(Loaded::compiled(asked, &files), Vec::new()))
}

impl<'a> Verification<'a> {
    /// The forecast of a control with the files, and the verdict.
    fn of(loaded: Loaded<'a>, mut findings: Vec<Finding>) -> Verification<'a> {
        let inputs = loaded.asked.inputs;
        let effect = loaded.control.as_deref().ok().and_then(|control| {
            loaded.field(control).map_err(|reason| findings.push(not_emulated(reason))).ok()
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

// A measurement with the tables active, judged: as found, forecast, as left, and why they differ.

/// Steel, where the job states no scale's expansion, 1/K.
const STEEL_PER_K: f64 = 11.5e-6;

/// What the second measurement shows.
pub struct SecondLook {
    /// As found, forecast and as left beside each other.
    pub comparison: Comparison,
    /// Why they differ; `None` where the tables cannot be emulated.
    pub diagnosis: Option<Diagnosis>,
    /// Lost motion that the first measurement could not see, where it alone is off the forecast.
    pub lost_motion: Option<Finding>,
    /// What is missing or doubtful.
    pub doubts: Vec<Finding>,
    /// The as-left figures against the acceptance.
    pub verdict: Verdict,
}

/// Compares and judges. `corrected` = the machine as found under each slip of the first records: asked
/// for only where as left is not as forecast, since each takes a separation of its own.
pub(crate) fn second_look(
    verification: &Verification<'_>,
    measured: &AfterMeasurement,
    corrected: impl FnOnce() -> Result<Vec<WithoutSlip>, Problems>,
) -> Result<SecondLook, Problems> {
    let JobTables { inputs, plan, .. } = &verification.loaded.asked;
    let (control, forecast) = (verification.effect.as_ref(), verification.forecast.as_ref());
    let (machine, job) = (inputs.machine(), &inputs.job);
    let comparison = compare(machine, plan, control, forecast, measured, job)?;
    let (mut diagnosis, mut lost_motion) = (None, None);
    let control = control.filter(|_| comparison.is_measured() && forecast.is_some());
    if let Some(control) = control {
        let diagnosed = |measured: &AfterMeasurement, corrected: &[WithoutSlip]| {
            diagnosed(&verification.loaded.asked, control, measured, corrected)
        };
        let mut found = diagnosed(measured, &[])?;
        if !found.as_forecast {
            let corrected = corrected()?;
            if !corrected.is_empty() {
                found = diagnosed(measured, &corrected)?;
            }
        }
        if !found.as_forecast && found.causes.is_empty() {
            lost_motion = unseen(inputs, measured, |measured| diagnosed(measured, &[]))?;
        }
        diagnosis = Some(found);
    }
    let doubts = doubts_of(verification, &comparison);
    let is_off = diagnosis.as_ref().is_some_and(|found| !found.as_forecast);
    let verdict = judged_as_left(verification, &comparison, is_off, &doubts);
    Ok(SecondLook { comparison, diagnosis, lost_motion, doubts, verdict })
}

/// Lost motion that the first measurement could not see, if as left is as forecast without it.
fn unseen(
    inputs: &Inputs,
    measured: &AfterMeasurement,
    diagnosed: impl Fn(&AfterMeasurement) -> Result<Diagnosis, Problem>,
) -> Result<Option<Finding>, Problem> {
    let AfterMeasurement::Errors(model) = measured else {
        return Ok(None);
    };
    let Some(reversal) = unseen_reversal(&inputs.model, model) else {
        return Ok(None);
    };
    let without = diagnosed(&AfterMeasurement::Errors(Box::new(reversal.without)))?;
    Ok(without.as_forecast.then_some(reversal.found))
}

/// Why as left is not as forecast, by a control and what was measured.
fn diagnosed(
    JobTables { inputs, compiled, .. }: &JobTables<'_>,
    control: &Field,
    measured: &AfterMeasurement,
    corrected: &[WithoutSlip],
) -> Result<Diagnosis, Problem> {
    let axis = |axis| inputs.job.machine.axes[axis];
    diagnose(&Question {
        before: &inputs.model,
        under_tables: inputs.under_tables.as_ref(),
        old: &inputs.old,
        corrected,
        control,
        seen: &observations(&inputs.model, measured),
        homing: PerAxis::from_fn(|a| axis(a).map_or(Direction::Plus, |a| a.homing())),
        reference_mm: PerAxis::from_fn(|a| axis(a).map_or(0.0, |a| a.reference.mm())),
        alpha_per_k: alpha_per_k(&inputs.job),
        laser_um_per_m: inputs.model.laser_um_per_m.hypot(measured.laser_um_per_m()),
        count_um: compiled.placements.iter().map(|p| p.count_um).fold(0.0, f64::max),
        display: inputs.profile.display.as_ref().map(|f| f.value.as_str()),
    })
}

fn alpha_per_k(job: &Job) -> PerAxis<f64> {
    let material = job.measurement.diagonals().and_then(|how| how.material);
    let stated = |axis| material?.axes[axis].map(|scale| scale.alpha_per_k);
    PerAxis::from_fn(|axis| stated(axis).unwrap_or(STEEL_PER_K))
}

/// The as-left figures against the acceptance; what is missing or doubtful leaves it at best undecided,
/// and files that differ from the job fail. Without any limit a machine that is not as forecast is not
/// passed either.
fn judged_as_left(
    verification: &Verification<'_>,
    comparison: &Comparison,
    is_off: bool,
    doubts: &[Finding],
) -> Verdict {
    if !verification.agrees() {
        return Verdict::Fail;
    }
    if !comparison.is_measured() {
        return Verdict::Undecided;
    }
    let asked = verification.loaded.asked.inputs.job.acceptance;
    let verdict = comparison.verdict(asked);
    match asked.asks_nothing() && is_off || !doubts.is_empty() {
        true => verdict.max(Verdict::Undecided),
        false => verdict,
    }
}

/// Doubts, what acts in addition to the tables, and what the limit asks for and was not measured.
fn doubts_of(verification: &Verification<'_>, comparison: &Comparison) -> Vec<Finding> {
    let terms = comparison.missing.clone();
    let asked = verification.loaded.asked.inputs.job.acceptance;
    let is_asked = asked.max_deviation_um.is_some() && !terms.is_empty();
    let missing = is_asked.then(|| KitFinding::NotMeasuredAfterwards { terms }.into());
    let mut doubts = of_severity(&comparison.findings, Severity::Doubt);
    doubts.extend(of_severity(&verification.findings, Severity::Doubt).into_iter().chain(missing));
    doubts
}

#[cfg(test)]
mod tests {
    use super::{Inputs, KitFile, forecast, verify};
    use crate::control::controller::builtin;
    use crate::inputs::error_table::ErrorTable;
    use crate::inputs::job::Job;
    use crate::kit::generate;
    use crate::text::Source;
    use std::path::Path;

    fn source(path: &Path) -> Source {
        Source::from_bytes("", &std::fs::read(path).unwrap()).unwrap()
    }

    /// One file for each axis: what is missing is named, and what is left of it is right.
    #[test]
    fn what_a_directory_lacks_is_named() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
        let errors = ErrorTable::read(source(&folder.join("errors.csv"))).unwrap();
        let page = source(&folder.join("generic.toml")).text.replace("\"generic\"", "\"isg-axis\"");
        let job = Job::read(Source::from_bytes("", page.as_bytes()).unwrap()).unwrap();
        let profile = builtin::profile("isg-axis").unwrap();
        let inputs = Inputs::new(job, profile, &errors, Vec::new()).unwrap();
        let mut files = generate(&inputs).unwrap().files;
        let is_proof = |file: &KitFile| file.path.starts_with("sign-own-");
        files.retain(|file| !is_proof(file) || file.path == "sign-own-1.lis");
        let found = verify(&inputs, &files, None, Vec::new()).unwrap().disagreements();
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(
            found,
            [
                "the sign proof of this job is not whole: `sign-own-1.lis` without `sign-own-2.lis`, `sign-own-3.lis`",
            ]
        );
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
