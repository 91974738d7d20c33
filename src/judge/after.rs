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

mod doubts;
mod ground;
mod machine;
mod measurement;
mod observation;
mod reversal;

pub use self::machine::ensure_same_machine;
pub use self::measurement::{AfterMeasurement, StraightRuns, Walk};
pub use self::observation::{Control, Observation, Part, before_um, observations};
pub use self::reversal::{UnseenReversal, unseen_reversal};

use self::doubts::{doubts, not_measured, notes};
use self::ground::ensure_common_ground;
use crate::inputs::job::Job;
use crate::judge::conformity::Sigma;
use crate::judge::forecast::{
    Basis, DiagonalForecast, Forecast, Machine, TermForecast, forecast, judged_ranges, range_of,
};
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::diagonal::Diagonal;
use crate::quantity::units::smaller;
use crate::read::emulate::{CannotEmulate, Emulator, Response};
use crate::text::problem::{Problem, Problems};
use crate::write::plan::Plan;

/// What stands on one line of the page; `None` = not measured, or no forecast.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// `EXX`, or `PPP`.
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
    /// Largest |as left − forecast| over the positions measured afterwards, µm.
    pub difference_um: Option<f64>,
}

/// As found, forecast, as left.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The nine terms, as far as either measurement holds them.
    pub terms: Vec<Line>,
    /// The body diagonals.
    pub diagonals: Vec<Line>,
    /// The measured figures in the shape of a forecast, for verdict and misses.
    pub as_left: Forecast,
    /// Terms found before and not measured afterwards.
    pub missing: Vec<ErrorTerm>,
    /// Why the values afterwards are no measurement of this machine with its tables; `None` = they may be.
    pub not_measured: Option<String>,
    /// Why the as-left figures decide nothing in favour, one sentence each.
    pub doubts: Vec<String>,
    /// What whoever reads the page should know.
    pub notes: Vec<String>,
}

/// No table at all: what is left is what was measured.
struct Bare;

impl Emulator for Bare {
    fn connected_axes(&self) -> Vec<(String, String)> {
        Vec::new()
    }

    fn response(&self, _: &str, _: &str, _: Direction) -> Result<Response, CannotEmulate> {
        Ok(Response::default())
    }
}

/// Puts the three beside each other; `control` = what the bytes of the tables make of the
/// control, `None` where they cannot be emulated.
pub fn compare(
    machine: Machine<'_>,
    plan: &Plan,
    control: Option<&Control>,
    expected: Option<&Forecast>,
    after: &AfterMeasurement,
    job: &Job,
) -> Result<Comparison, Problems> {
    let before = machine.uncompensated;
    ensure_common_ground(before, after)?;
    let bare = |model: &ErrorModel| {
        let ranges = judged_ranges(job, model);
        forecast(Machine::alone(model), plan, &Bare, &ranges).map_err(not_evaluated)
    };
    let found = bare(machine.as_measured)?;
    let as_left = match after {
        AfterMeasurement::Errors(model) => bare(model)?,
        AfterMeasurement::Diagonals(runs) => figures(runs, job),
    };
    let as_left = Forecast {
        basis: Basis::Measured,
        ..as_left
    };
    let seen = observations(before, after);
    let left = |observation: &&Observation| {
        let control = control?;
        let added_um = observation.predicted(|part| Some(control.at(part)))?;
        Some((observation.um - observation.found_um - added_um).abs())
    };
    let terms = term_lines(&found, expected, &as_left, |term| {
        let of_term = seen.iter().filter(|o| o.is_of(term));
        of_term.filter_map(|o| left(&o)).reduce(f64::max)
    });
    let diagonals = match after {
        AfterMeasurement::Errors(_) => model_diagonals(&found, expected, &as_left),
        AfterMeasurement::Diagonals(runs) => run_diagonals(machine, control, runs, &seen, &as_left),
    };
    let measured: Vec<ErrorTerm> = before.measured().map(|(term, _)| term).collect();
    let missing: Vec<ErrorTerm> = measured
        .into_iter()
        .filter(|term| !as_left.terms.iter().any(|line| line.term == *term))
        .collect();
    let mut notes = notes(before, after);
    notes.extend(off_forecast(before, &as_left, &terms));
    Ok(Comparison {
        terms,
        diagonals,
        as_left,
        not_measured: not_measured(machine.as_measured, after),
        doubts: doubts(before, control, after),
        notes,
        missing,
    })
}

/// Probability with which no value of a right kit is named as off its forecast.
const NOT_OFF: f64 = 0.999;

/// Terms that are off the forecast at some position by more than both measurements explain,
/// u² = u²(as left) + u²(as found), each against its reference, with 99.9 % over all values. Only
/// where both uncertainties are stated.
fn off_forecast(before: &ErrorModel, as_left: &Forecast, terms: &[Line]) -> Option<String> {
    let values: usize = as_left.terms.iter().map(|term| term.figures.len()).sum();
    let fewest = [before.remarks.degrees_of_freedom, as_left.sigma.freedom()];
    let fewest = fewest.into_iter().flatten().reduce(smaller);
    let factor = Sigma::with_freedom(fewest).joint_at(values, NOT_OFF);
    let off = terms.iter().filter_map(|line| {
        let term = ErrorTerm::from_name(&line.name)?;
        let found = before.terms[term].as_ref()?.u_um()?;
        let u_um = factor * line.u_um?.hypot(found);
        let um = line.difference_um.filter(|um| *um > u_um)?;
        Some(format!("{term} {um:.3} µm (U = {u_um:.3} µm)"))
    });
    let off: Vec<String> = off.collect();
    (!off.is_empty()).then(|| {
        format!(
            "off the forecast at some position by more than both measurements explain (99.9 %, all positions together): {}",
            off.join(", ")
        )
    })
}

fn not_evaluated(reason: CannotEmulate) -> Problems {
    Problem::new(reason.0).into()
}

/// Measured figures of straight runs.
fn figures(runs: &StraightRuns, job: &Job) -> Forecast {
    let sigma = Sigma::with_freedom(runs.degrees_of_freedom);
    let scale_um = runs.scale_um_per_m * runs.volume.diagonal_mm() / 1000.0;
    let line = |(diagonal, range): (Diagonal, &f64)| {
        let own = runs.walks.iter().filter(|walk| walk.diagonal == diagonal);
        let values: usize = own.map(|walk| walk.readings_um.len()).sum();
        let u_um = runs.u_um.map_or_else(Vec::new, |u| vec![u; values]);
        DiagonalForecast::new(diagonal.name(), *range, *range, sigma, &u_um, scale_um)
    };
    let walked = |axis| range_of(job, axis, &runs.volume.positions(axis));
    Forecast {
        basis: Basis::Measured,
        sigma,
        ranges: Axis::ALL.into_iter().filter_map(walked).collect(),
        silent: Vec::new(),
        terms: Vec::new(),
        diagonals: runs.range_um.iter().map(line).collect(),
        unmeasured: crate::quantity::axis::PerAxis::default(),
        not_determined: Vec::new(),
        without_reversal_um: None,
    }
}

fn term_lines(
    found: &Forecast,
    expected: Option<&Forecast>,
    as_left: &Forecast,
    difference: impl Fn(ErrorTerm) -> Option<f64>,
) -> Vec<Line> {
    fn of(forecast: &Forecast, term: ErrorTerm) -> Option<&TermForecast> {
        forecast.terms.iter().find(|t| t.term == term)
    }
    let line = |term: ErrorTerm| {
        let before_um = of(found, term).map(|t| t.before_um);
        let after = of(as_left, term);
        (before_um.is_some() || after.is_some()).then(|| Line {
            name: term.to_string(),
            before_um,
            forecast_um: expected.and_then(|e| of(e, term)).map(|t| t.after_um),
            after_um: after.map(|t| t.after_um),
            u_um: after.and_then(|t| t.u_um),
            expanded_um: after.and_then(|t| t.expanded_um),
            difference_um: difference(term),
        })
    };
    ErrorTerm::ALL.into_iter().filter_map(line).collect()
}

fn model_diagonals(found: &Forecast, expected: Option<&Forecast>, as_left: &Forecast) -> Vec<Line> {
    fn of<'a>(forecast: &'a Forecast, name: &str) -> Option<&'a DiagonalForecast> {
        forecast.diagonals.iter().find(|d| d.name == name)
    }
    let line = |diagonal: Diagonal| {
        let name = diagonal.name();
        let (before, after) = (of(found, name), of(as_left, name));
        (before.is_some() || after.is_some()).then(|| Line {
            name: name.to_string(),
            before_um: before.map(|d| d.before_um),
            forecast_um: expected.and_then(|e| of(e, name)).map(|d| d.after_um),
            after_um: after.map(|d| d.after_um),
            u_um: after.and_then(|d| d.u_um),
            expanded_um: after.and_then(|d| d.expanded_um),
            difference_um: None,
        })
    };
    Diagonal::ALL.into_iter().filter_map(line).collect()
}

/// As found and forecast at the nodes that were walked afterwards.
fn run_diagonals(
    machine: Machine<'_>,
    control: Option<&Control>,
    runs: &StraightRuns,
    seen: &[Observation],
    as_left: &Forecast,
) -> Vec<Line> {
    let span = |diagonal: Diagonal, of: &dyn Fn(&Part) -> Option<f64>| {
        let along = seen.iter().filter(|o| o.diagonal == Some(diagonal));
        let values: Option<Vec<f64>> = along.map(|o| o.predicted(of)).collect();
        values.and_then(range)
    };
    let line = |diagonal: Diagonal| Line {
        name: diagonal.name().to_string(),
        before_um: span(diagonal, &|part| before_um(machine.as_measured, part)),
        forecast_um: span(diagonal, &|part| {
            Some(before_um(machine.uncompensated, part)? + control?.at(part))
        }),
        after_um: Some(runs.range_um[diagonal]),
        u_um: runs.u_range_um(),
        expanded_um: as_left
            .diagonals
            .iter()
            .find(|d| d.name == diagonal.name())
            .and_then(|d| d.expanded_um),
        difference_um: None,
    };
    Diagonal::ALL.into_iter().map(line).collect()
}

fn range(values: Vec<f64>) -> Option<f64> {
    let low = values.iter().copied().reduce(f64::min)?;
    let high = values.iter().copied().reduce(f64::max)?;
    Some(high - low)
}
