//! A measurement with the tables active, judged: as found, forecast, as left, and why they differ.

use super::{Asked, Inputs, Verification};
use crate::inputs::job::Job;
use crate::judge::after::{AfterMeasurement, Comparison, compare, observations, unseen_reversal};
use crate::judge::causes::{Corrected, Diagnosis, Question, diagnose};
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::kit::findings::KitFinding;
use crate::quantity::{Direction, PerAxis};
use crate::text::{Finding, Problem, Problems, Severity, of_severity};

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
    corrected: impl FnOnce() -> Result<Vec<Corrected>, Problems>,
) -> Result<SecondLook, Problems> {
    let Asked { inputs, plan, .. } = &verification.loaded.asked;
    let (control, forecast) = (verification.effect.as_ref(), verification.forecast.as_ref());
    let (machine, job) = (inputs.machine(), &inputs.job);
    let comparison = compare(machine, plan, control, forecast, measured, job)?;
    let (mut diagnosis, mut lost_motion) = (None, None);
    let control = control.filter(|_| comparison.is_measured() && forecast.is_some());
    if let Some(control) = control {
        let diagnosed = |measured: &AfterMeasurement, corrected: &[Corrected]| {
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
    let doubts = doubts(verification, &comparison);
    let is_off = diagnosis.as_ref().is_some_and(|found| !found.as_forecast);
    let verdict = judged(verification, &comparison, is_off, &doubts);
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
    Asked { inputs, compiled, .. }: &Asked<'_>,
    control: &Field,
    measured: &AfterMeasurement,
    corrected: &[Corrected],
) -> Result<Diagnosis, Problem> {
    let axis = |axis| inputs.job.machine.axes[axis];
    let counts = compiled.placements.iter().map(|p| p.count_um);
    diagnose(&Question {
        before: &inputs.model,
        under_tables: inputs.under_tables.as_ref(),
        corrected,
        control,
        seen: &observations(&inputs.model, measured),
        homing: PerAxis::from_fn(|a| axis(a).map_or(Direction::Plus, |a| a.homing())),
        reference_mm: PerAxis::from_fn(|a| axis(a).map_or(0.0, |a| a.reference.mm())),
        alpha_per_k: alpha_per_k(&inputs.job),
        laser_um_per_m: inputs.model.laser_um_per_m.hypot(measured.laser_um_per_m()),
        count_um: counts.fold(0.0, f64::max),
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
fn judged(
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
    let verdict = comparison.as_left.verdict(asked);
    match asked.asks_nothing() && is_off || !doubts.is_empty() {
        true => verdict.max(Verdict::Undecided),
        false => verdict,
    }
}

/// Doubts, what acts in addition to the tables, and what the limit asks for and was not measured.
fn doubts(verification: &Verification<'_>, comparison: &Comparison) -> Vec<Finding> {
    let terms = comparison.missing.clone();
    let asked = verification.loaded.asked.inputs.job.acceptance;
    let is_asked = asked.max_deviation_um.is_some() && !terms.is_empty();
    let missing = is_asked.then(|| KitFinding::NotMeasuredAfterwards { terms }.into());
    let mut doubts = of_severity(&comparison.findings, Severity::Doubt);
    doubts.extend(of_severity(&verification.findings, Severity::Doubt).into_iter().chain(missing));
    doubts
}
