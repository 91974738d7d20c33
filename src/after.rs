//! As-left: what a second measurement found, beside what was found first and what was forecast.
//!
//! ```text
//!   as found ─ model ──┬──────────────────────────────┐
//!   bytes → emulator ──┴→ forecast ───────────────────┼→ comparison, term by term
//!   second measurement → model, or straight diagonals ┘   and diagonal by diagonal
//! ```
//! The second measurement is an error model of its own, zero at the reference (contract §5), and
//! its figures are those of [`crate::forecast`] without a table: largest |deviation| of a term,
//! max − min along a diagonal. Straight runs of the diagonals give figures of the diagonals only.

mod machine;
mod observation;

pub use self::machine::ensure_same_machine;
pub use self::observation::{Control, Observation, Part, observations};

use crate::axis::{Axis, Direction, ErrorTerm};
use crate::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::emulate::{CannotEmulate, Emulator, Response};
use crate::forecast::{DiagonalForecast, Forecast, Machine, forecast};
use crate::model::{ErrorModel, MeasuredTerm};
use crate::plan::Plan;
use crate::problem::{Problem, Problems};

/// A measurement of the machine with its tables active.
#[derive(Clone, Debug, PartialEq)]
pub enum AfterMeasurement {
    /// Error curves, zero at the reference.
    Errors(Box<ErrorModel>),
    /// Straight runs along the body diagonals.
    Diagonals(StraightRuns),
}

/// Straight runs along the body diagonals: their means and figures.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightRuns {
    /// The box and its nodes.
    pub volume: Volume,
    /// Mean readings of each pass that was walked.
    pub walks: Vec<Walk>,
    /// Max − min along each diagonal, both passes, µm.
    pub range_um: PerDiagonal<f64>,
    /// Standard uncertainty (k = 1) of a mean reading, µm; `None` = neither stated nor repeated.
    pub u_um: Option<f64>,
    /// The reverse passes count from the forward start.
    pub one_zero: bool,
}

/// Mean readings of one pass, µm, by node of the forward path.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Forward or reverse.
    pub pass: Pass,
    /// Measured − nominal displacement, positive along the forward direction.
    pub readings_um: Vec<f64>,
}

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
    /// Standard uncertainty (k = 1) of the as-left figure, µm; `None` = not stated.
    pub u_um: Option<f64>,
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
) -> Result<Comparison, Problems> {
    let before = machine.uncompensated;
    ensure_common_ground(before, after)?;
    let bare = |model| forecast(Machine::alone(model), plan, &Bare).map_err(not_evaluated);
    let found = bare(machine.as_measured)?;
    let as_left = match after {
        AfterMeasurement::Errors(model) => bare(model)?,
        AfterMeasurement::Diagonals(runs) => figures(runs),
    };
    let seen = observations(before, after);
    let left = |observation: &&Observation| {
        let control = control?;
        let expected = observation.predicted(|part| before_um(before, part) + control.at(part))?;
        Some((observation.um - expected).abs())
    };
    let terms = term_lines(&found, expected, &as_left, |term| {
        let of_term = seen.iter().filter(|o| o.is_of(term));
        of_term.filter_map(|o| left(&o)).reduce(f64::max)
    });
    let diagonals = match after {
        AfterMeasurement::Errors(_) => model_diagonals(&found, expected, &as_left),
        AfterMeasurement::Diagonals(runs) => run_diagonals(machine, control, runs, &seen),
    };
    let measured: Vec<ErrorTerm> = before.measured().map(|(term, _)| term).collect();
    let missing: Vec<ErrorTerm> = measured
        .into_iter()
        .filter(|term| !as_left.terms.iter().any(|line| line.term == *term))
        .collect();
    Ok(Comparison {
        terms,
        diagonals,
        as_left,
        doubts: doubts(before, after),
        notes: notes(before, after),
        missing,
    })
}

fn not_evaluated(reason: CannotEmulate) -> Problems {
    Problem::new(reason.0).into()
}

/// The deviation as found where a part of an observation looks, µm; 0 weight is never asked.
pub(crate) fn before_um(before: &ErrorModel, part: &Part) -> f64 {
    let measured = before.terms[part.term].as_ref();
    let curve = measured.and_then(|m| m.measured.curve(part.direction));
    curve.map_or(f64::NAN, |curve| curve.at(part.at).um())
}

/// Measured figures of straight runs.
fn figures(runs: &StraightRuns) -> Forecast {
    let u_um = runs.u_um.map(|u| std::f64::consts::SQRT_2 * u);
    let line = |(diagonal, range): (Diagonal, &f64)| DiagonalForecast {
        name: diagonal.name(),
        before_um: *range,
        after_um: *range,
        u_um,
    };
    Forecast {
        terms: Vec::new(),
        diagonals: runs.range_um.iter().map(line).collect(),
        unmeasured: crate::axis::PerAxis::default(),
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
    let of = |forecast: &Forecast, term: ErrorTerm| {
        forecast.terms.iter().find(|t| t.term == term).copied()
    };
    let line = |term: ErrorTerm| {
        let before_um = of(found, term).map(|t| t.before_um);
        let after = of(as_left, term);
        (before_um.is_some() || after.is_some()).then(|| Line {
            name: term.to_string(),
            before_um,
            forecast_um: expected.and_then(|e| of(e, term)).map(|t| t.after_um),
            after_um: after.map(|t| t.after_um),
            u_um: after.and_then(|t| t.u_um),
            difference_um: difference(term),
        })
    };
    ErrorTerm::ALL.into_iter().filter_map(line).collect()
}

fn model_diagonals(found: &Forecast, expected: Option<&Forecast>, as_left: &Forecast) -> Vec<Line> {
    let of = |forecast: &Forecast, name: &str| {
        forecast.diagonals.iter().find(|d| d.name == name).copied()
    };
    let line = |diagonal: Diagonal| {
        let name = diagonal.name();
        let (before, after) = (of(found, name), of(as_left, name));
        (before.is_some() || after.is_some()).then(|| Line {
            name: name.to_string(),
            before_um: before.map(|d| d.before_um),
            forecast_um: expected.and_then(|e| of(e, name)).map(|d| d.after_um),
            after_um: after.map(|d| d.after_um),
            u_um: after.and_then(|d| d.u_um),
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
) -> Vec<Line> {
    let span = |diagonal: Diagonal, of: &dyn Fn(&Part) -> Option<f64>| {
        let along = seen.iter().filter(|o| o.diagonal == Some(diagonal));
        let values: Option<Vec<f64>> = along.map(|o| o.predicted_by(of)).collect();
        values.and_then(range)
    };
    let line = |diagonal: Diagonal| Line {
        name: diagonal.name().to_string(),
        before_um: span(diagonal, &|part| Some(before_um(machine.as_measured, part))),
        forecast_um: span(diagonal, &|part| {
            Some(before_um(machine.uncompensated, part) + control?.at(part))
        }),
        after_um: Some(runs.range_um[diagonal]),
        u_um: runs.u_um.map(|u| std::f64::consts::SQRT_2 * u),
        difference_um: None,
    };
    Diagonal::ALL.into_iter().map(line).collect()
}

fn range(values: Vec<f64>) -> Option<f64> {
    let low = values.iter().copied().reduce(f64::min)?;
    let high = values.iter().copied().reduce(f64::max)?;
    Some(high - low)
}

/// Whether both measurements say anything about the same thing.
fn ensure_common_ground(before: &ErrorModel, after: &AfterMeasurement) -> Result<(), Problems> {
    match after {
        AfterMeasurement::Errors(model) => common_terms(before, model),
        AfterMeasurement::Diagonals(runs) => nine_terms_over(before, runs),
    }
}

fn common_terms(before: &ErrorModel, model: &ErrorModel) -> Result<(), Problems> {
    let names = |model: &ErrorModel| {
        let names: Vec<String> = model.measured().map(|(term, _)| term.to_string()).collect();
        names.join(", ")
    };
    if !model
        .measured()
        .any(|(term, _)| before.terms[term].is_some())
    {
        return Err(Problem::new(format!(
            "both measurements have no error in common: as found {}, afterwards {}",
            names(before),
            names(model)
        ))
        .help("measure the same errors again with the tables active")
        .into());
    }
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        let (Some(first), Some(second)) = (before.ranges[axis], model.ranges[axis]) else {
            continue;
        };
        if second.1 <= first.0 || second.0 >= first.1 {
            problems.push(
                Problem::new(format!(
                    "axis {axis} was measured from {} to {} mm as found and from {} to {} mm afterwards: no position in common",
                    first.0.mm(), first.1.mm(), second.0.mm(), second.1.mm()
                ))
                .help("both files count in machine coordinates; measure the same range again"),
            );
        }
    }
    problems.or_ok(())
}

fn nine_terms_over(before: &ErrorModel, runs: &StraightRuns) -> Result<(), Problems> {
    let missing = ErrorTerm::ALL.into_iter();
    let missing: Vec<String> = missing
        .filter(|term| before.terms[*term].is_none())
        .map(|term| term.to_string())
        .collect();
    if !missing.is_empty() {
        return Err(Problem::new(format!(
            "straight runs of the body diagonals show all nine errors together, but these were not measured as found: {}",
            missing.join(", ")
        ))
        .help("measure the errors of the first measurement again, each by itself")
        .into());
    }
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        let low = runs.volume.start[axis].mm();
        let high = low + runs.volume.size[axis].mm();
        let outside = |(first, last): (crate::units::Millimetres, crate::units::Millimetres)| {
            low < first.mm() - NEAR_MM || high > last.mm() + NEAR_MM
        };
        if let Some((first, last)) = before.ranges[axis].filter(|range| outside(*range)) {
            problems.push(
                Problem::new(format!(
                    "the box of the diagonals reaches from {low} to {high} mm of axis {axis}, as found only {} to {} mm were measured",
                    first.mm(), last.mm()
                ))
                .help("walk diagonals inside the box that was measured first"),
            );
        }
    }
    problems.or_ok(())
}

/// Targets may miss the end of a range by this much (rounding of inch positions), mm.
const NEAR_MM: f64 = 0.01;
/// Share of the range measured first that has to be measured again before a limit counts as kept:
/// the offset targets of an acceptance test stay clear of the ends by half a step or so.
const COVERED: f64 = 0.9;

fn doubts(before: &ErrorModel, after: &AfterMeasurement) -> Vec<String> {
    match after {
        AfterMeasurement::Errors(model) => {
            let mut doubts = model.doubts(|_| true);
            doubts.extend(
                Axis::ALL
                    .into_iter()
                    .filter_map(|axis| short(before, model, axis)),
            );
            doubts
        }
        AfterMeasurement::Diagonals(_) => Vec::new(),
    }
}

fn short(before: &ErrorModel, after: &ErrorModel, axis: Axis) -> Option<String> {
    let (first, second) = (before.ranges[axis]?, after.ranges[axis]?);
    let common = second.1.mm().min(first.1.mm()) - second.0.mm().max(first.0.mm());
    (common < COVERED * (first.1 - first.0).mm()).then(|| {
        format!(
            "axis {axis} was measured from {} to {} mm as found, afterwards only from {} to {} mm: nothing is known of the rest",
            first.0.mm(), first.1.mm(), second.0.mm(), second.1.mm()
        )
    })
}

fn notes(before: &ErrorModel, after: &AfterMeasurement) -> Vec<String> {
    let AfterMeasurement::Errors(model) = after else {
        return vec!["straight runs show the body diagonals only: the nine errors were not measured afterwards".to_string()];
    };
    let mut notes = model.remarks.notes.clone();
    let ways = |measured: &MeasuredTerm| measured.measured.has_both_ways();
    let fewer = model.measured().filter_map(|(term, measured)| {
        let first = before.terms[term].as_ref()?;
        (ways(first) && !ways(measured)).then(|| term.to_string())
    });
    let fewer: Vec<String> = fewer.collect();
    if !fewer.is_empty() {
        notes.push(format!(
            "found in both directions, measured afterwards without: {}; a fault of the reversal does not show",
            fewer.join(", ")
        ));
    }
    notes
}
