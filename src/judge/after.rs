//! As-left: what a second measurement found, beside what was found first and what was forecast.
//!
//! ```text
//!   as found ─ model ──┬──────────────────────────────┐
//!   bytes → emulator ──┴→ forecast ───────────────────┼→ comparison, term by term
//!   second measurement → model, or straight diagonals ┘   and diagonal by diagonal
//! ```
//! The second measurement is an error model of its own, zero at the reference (contract §5), and
//! its figures are those of [`crate::judge::forecast`] without a table: largest |deviation| of a term,
//! max − min along a diagonal. Straight runs of the diagonals give figures of the diagonals only.

mod ground;
mod measurement;

pub(crate) use self::ground::{
    ensure_same_machine, not_known, outside, same_slopes, unseen_reversal,
};
pub(crate) use self::measurement::observations;
pub use self::measurement::{
    AfterMeasurement, Observation, SeenDeviation, StraightRuns, before_um,
};

use self::ground::{common_terms, nine_terms_over};
use crate::inputs::error_table::Cause;
use crate::inputs::job::{Acceptance, Job};
use crate::judge::conformity::{Sigma, Verdict};
use crate::judge::field::Field;
use crate::judge::findings::AsLeft;
use crate::judge::forecast::{
    Basis, DiagonalForecast, Forecast, Machine, forecast, judged_ranges, range_of,
};
use crate::machine::model::ErrorModel;
use crate::quantity::{Axis, Diagonal, ErrorTerm, smaller};
use crate::text::{Finding, Problems};
use crate::write::plan::Plan;
use serde::Serialize;

/// What stands on one line of the page, and in the document; `None` = not measured, or no forecast.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedLine {
    /// `EXX`, or `PPP`.
    #[serde(skip)]
    pub name: String,
    /// As found, µm.
    pub before_um: Option<f64>,
    /// Forecast from the bytes of the tables, µm.
    pub forecast_um: Option<f64>,
    /// As left, measured, µm.
    pub after_um: Option<f64>,
    /// Standard uncertainty (k = 1) of an as-left value, µm; `None` = not stated.
    pub u_um: Option<f64>,
    /// U of the as-left figure, the largest of its values, with 95 %, µm; `None` = not stated.
    pub expanded_um: Option<f64>,
    /// What the as-left figure is at most, with 95 %, µm; `None` = not stated.
    pub at_most_um: Option<f64>,
    /// The figure that is judged, µm: as left.
    max_residual_um: Option<f64>,
    /// Largest |as left − forecast| over the positions measured afterwards, µm.
    pub difference_um: Option<f64>,
}

/// As found, forecast, as left.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The nine terms, as far as either measurement holds them.
    pub terms: Vec<ComparedLine>,
    /// The body diagonals.
    pub diagonals: Vec<ComparedLine>,
    /// The measured figures in the shape of a forecast, for verdict and misses.
    pub as_left: Forecast,
    /// The same where the rotation between both measurements is not known, in the frame in which least is left.
    pub in_best_frame: Option<Forecast>,
    /// Terms found before and not measured afterwards.
    pub missing: Vec<ErrorTerm>,
    /// Why the values afterwards are no measurement of this machine with its tables, or decide nothing in
    /// favour (doubts); what whoever reads the page should know.
    pub findings: Vec<Finding>,
}

impl Comparison {
    /// The verdict on the figures as left. Where both measurements count from different frames what is beyond the limit may be
    /// the rotation between them: only what is so in the best frame, too, is beyond for sure.
    pub(crate) fn verdict(&self, asked: Acceptance) -> Verdict {
        match (self.as_left.verdict(asked), &self.in_best_frame) {
            (Verdict::Fail, Some(best)) => best.verdict(asked).max(Verdict::Undecided),
            (verdict, _) => verdict,
        }
    }

    /// Whether the values afterwards may be a measurement of this machine with its tables.
    pub(crate) fn is_measured(&self) -> bool {
        use AsLeft::{Copy, Flat, SameSlopes, Simulated};
        let is_none = |found: &Finding| {
            matches!(found.kind(), Some(Simulated | Flat { .. } | Copy | SameSlopes { .. }))
        };
        !self.findings.iter().any(is_none)
    }
}

/// The figures of a measurement by itself, as if no table were loaded.
pub(crate) fn alone(model: &ErrorModel, job: &Job) -> Forecast {
    let (plan, control) = (Plan::default(), Field::default());
    forecast(Machine::alone(model), &plan, &control, &judged_ranges(job, model))
}

/// Puts the three beside each other; `control` = what the bytes of the tables make of the
/// control, `None` where they cannot be emulated.
pub fn compare(
    machine: Machine<'_>,
    plan: &Plan,
    control: Option<&Field>,
    expected: Option<&Forecast>,
    after: &AfterMeasurement,
    job: &Job,
) -> Result<Comparison, Problems> {
    let before = machine.uncompensated;
    let found = alone(machine.as_measured, job);
    let as_left = match after {
        AfterMeasurement::Errors(model) => {
            common_terms(before, model)?;
            alone(model, job)
        }
        AfterMeasurement::Diagonals(runs) => {
            nine_terms_over(before, runs)?;
            figures(runs, job)
        }
    };
    let mut as_left = as_left.bounded(Basis::Measured);
    if let AfterMeasurement::Errors(model) = after {
        let stated = |of: ErrorTerm| job.measurement.squareness.iter().any(|(term, _)| *term == of);
        let corrected = |term: ErrorTerm| {
            plan.tables.iter().any(|table| [term, term.twin()].contains(&table.term))
        };
        // Tables that correct a slope leave none; what the job stated apart has to be stated again.
        let is_open = |term: &ErrorTerm| stated(*term) || !corrected(*term);
        let is_silent = model.level().iter().any(is_open);
        as_left.silence.not_stated.extend(is_silent.then_some(Cause::Squareness));
    }
    let seen = observations(before, after);
    let line = |name: &str| {
        line(name, [&found, &as_left], expected, off_forecast_um(name, control, &seen))
    };
    let terms: Vec<_> = ErrorTerm::ALL.iter().filter_map(|term| line(&term.to_string())).collect();
    let mut diagonals: Vec<_> = Diagonal::ALL.iter().filter_map(|d| line(d.name())).collect();
    if let AfterMeasurement::Diagonals(_) = after {
        for line in &mut diagonals {
            along_run(line, machine, control, &seen);
        }
    }
    let is_missing = |term: &ErrorTerm| !as_left.terms.iter().any(|line| line.term == *term);
    let missing = before.measured().map(|(term, _)| term).filter(is_missing).collect();
    let mut findings = ground::findings(machine.as_measured, before, after);
    findings.extend(off_forecast(before, after, &as_left, &terms).map(Finding::from));
    let rotates =
        |of: &Finding| matches!(of.kind(), Some(AsLeft::OtherFrame { .. } | AsLeft::OwnFrames));
    let in_best_frame = match after {
        AfterMeasurement::Errors(model) if findings.iter().any(rotates) => {
            Some(alone(&model.in_best_frame(job), job).bounded(Basis::Measured))
        }
        _ => None,
    };
    Ok(Comparison { terms, diagonals, as_left, in_best_frame, findings, missing })
}

/// Largest |as left − forecast| of a term over the positions measured afterwards, µm.
fn off_forecast_um(name: &str, control: Option<&Field>, seen: &[Observation]) -> Option<f64> {
    let (term, control) = (ErrorTerm::from_name(name)?, control?);
    seen.iter().filter(|o| o.is_of(term)).map(|o| o.off_um(control).abs()).reduce(f64::max)
}

/// Probability with which no value of a right kit is named as off its forecast.
const NOT_OFF: f64 = 0.999;

/// Terms that are off the forecast at some position by more than both measurements explain,
/// u² = u²(as left) + u²(as found), each against its reference and without what both repeat, with 99.9 % over
/// all values. Only where both uncertainties are stated.
fn off_forecast(
    before: &ErrorModel,
    after: &AfterMeasurement,
    as_left: &Forecast,
    terms: &[ComparedLine],
) -> Option<AsLeft> {
    let AfterMeasurement::Errors(left) = after else { return None };
    let values: usize = as_left.terms.iter().map(|term| term.figures.len()).sum();
    let fewest = [before.remarks.degrees_of_freedom, as_left.sigma.freedom()];
    let fewest = fewest.into_iter().flatten().reduce(smaller);
    let factor = Sigma::with_freedom(fewest).joint_at(values, NOT_OFF);
    let off = terms.iter().filter_map(|line| {
        let term = ErrorTerm::from_name(&line.name)?;
        let (found, left) = (&before.remarks, &left.remarks);
        let u_um = match (found.anew_beside(left), left.anew_beside(found)) {
            (Some(found), Some(left)) => found.terms[term].hypot(left.terms[term]),
            _ => line.u_um?.hypot(before.terms[term].as_ref()?.u_um()?),
        };
        let u_um = factor * u_um;
        Some((term, line.difference_um.filter(|um| *um > u_um)?, u_um))
    });
    let terms: Vec<(ErrorTerm, f64, f64)> = off.collect();
    (!terms.is_empty()).then_some(AsLeft::OffForecast { terms })
}

/// Measured figures of straight runs.
fn figures(runs: &StraightRuns, job: &Job) -> Forecast {
    let sigma = Sigma::with_freedom(runs.degrees_of_freedom);
    let scale_um = runs.scale_um_per_m * runs.volume.diagonal_mm() / 1000.0;
    let between = job.measurement.uncertainty.between();
    let line = |(diagonal, range): (Diagonal, &f64)| {
        let own = runs.walks.iter().filter(|walk| walk.diagonal == diagonal);
        let values: usize = own.map(|walk| walk.um.len()).sum();
        let u_um = runs.u_um.map_or_else(Vec::new, |u| vec![u; values]);
        let doubtful_um = between.diagonals[diagonal];
        DiagonalForecast::new(diagonal, [*range; 2], &sigma, &u_um, scale_um, None, doubtful_um)
    };
    let walked = |axis| range_of(job, axis, &runs.volume.positions(axis));
    Forecast {
        basis: Basis::Measured,
        diagonals: runs.range_um.iter().map(line).collect(),
        sigma,
        ranges: Axis::ALL.into_iter().filter_map(walked).collect(),
        ..Forecast::default()
    }
}

/// A line of a term or a diagonal as found, as forecast, as left; none where neither measurement has it.
fn line(
    name: &str,
    [found, as_left]: [&Forecast; 2],
    expected: Option<&Forecast>,
    difference_um: Option<f64>,
) -> Option<ComparedLine> {
    let (found, after) = (found.change(name), as_left.change(name));
    (found.is_some() || after.is_some()).then(|| ComparedLine {
        name: name.to_string(),
        before_um: found.map(|row| row.before_um),
        forecast_um: expected.and_then(|of| of.change(name)).map(|row| row.after_um),
        after_um: after.map(|row| row.after_um),
        u_um: after.and_then(|row| row.u_um),
        expanded_um: after.and_then(|row| row.expanded_um),
        at_most_um: after.and_then(|row| row.at_most_um),
        max_residual_um: after.map(|row| row.after_um),
        difference_um,
    })
}

/// As found and forecast at the nodes that were walked afterwards.
fn along_run(
    line: &mut ComparedLine,
    machine: Machine<'_>,
    control: Option<&Field>,
    seen: &[Observation],
) {
    let span = |of: &dyn Fn(&SeenDeviation) -> Option<f64>| {
        let along = seen.iter().filter(|o| o.diagonal.is_some_and(|d| d.name() == line.name));
        let values: Vec<f64> = along.map(|o| o.predicted(of)).collect::<Option<_>>()?;
        let low = values.iter().copied().reduce(f64::min)?;
        Some(values.into_iter().reduce(f64::max)? - low)
    };
    let before = span(&|part| before_um(machine.as_measured, part));
    let expected =
        span(&|part| Some(before_um(machine.uncompensated, part)? + part.added_um(control?)));
    (line.before_um, line.forecast_um) = (before, expected);
}
