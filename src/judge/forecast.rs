//! What the tables will leave: deviation without compensation + emulated correction, over the
//! whole measured range, in every measured direction. Where tables were active while measuring,
//! what was measured and the deviation without them are two models of the same machine.
//!
//! ```text
//!   ErrorModel ───────────────┐
//!                             ├→ residual of every term, of every body diagonal → Forecast
//!   bytes → Tables → Emulator ┘
//! ```
//! Extremes are exact: a correction is a straight line between its breaks, a curve a cubic
//! between its knots, so no position has to be sampled.

mod diagonals;
mod figures;
mod reasons;
mod share;

pub(crate) use self::figures::Missed;
pub use self::figures::{Basis, Change, DiagonalForecast, Forecast, TermForecast};
pub(crate) use self::reasons::terms_words;
pub use self::reasons::{Grounds, Miss, Of, RestsOn};
pub use self::share::{JudgedRange, Machine};
use self::share::{Range, within};
pub(crate) use self::share::{is_whole_travel, judged_ranges, range_of, widest_gap_mm};

use crate::judge::conformity::{Magnitude, Sigma, expanded_um, largest_um};
use crate::judge::field::Field;
use crate::machine::model::{ErrorModel, Measured, MeasuredTerm, PointUncertainty};
use crate::quantity::{Axis, Direction, ErrorCurve, ErrorTerm, Millimetres, PerAxis, larger};
use crate::read::emulate::Response;
use crate::write::grid::EDGE_MM;
use crate::write::plan::Plan;

/// Computes the forecast from a machine and what the control adds, over the ranges that are judged.
pub fn forecast(
    machine: Machine<'_>,
    plan: &Plan,
    control: &Field,
    ranges: &[JudgedRange],
) -> Forecast {
    let model = machine.as_measured;
    let sigma = Sigma::with_freedom(model.remarks.degrees_of_freedom);
    let largest = model.remarks.largest.as_ref();
    let judged = share::stated(ranges);
    let comparable = machine.was_under_tables().then(|| control.straightened());
    let mut terms = Vec::new();
    for (term, measured) in model.measured() {
        let left = |control| residuals(machine, control, term, judged[term.along]);
        let figures = left(control);
        let (u_um, after_um) = (measured.u_um(), largest_um(&figures));
        terms.push(TermForecast {
            term,
            change: Change {
                before_um: measured.largest_within_um(judged[term.along]),
                after_um,
                comparable_um: comparable
                    .as_ref()
                    .map_or(after_um, |lines| largest_um(&left(lines))),
                u_um,
                expanded_um: u_um.map(|_| {
                    let largest_um = largest.map(|largest| largest.single.terms[term]);
                    expanded_um(&figures, sigma, largest_um)
                }),
                at_most_um: None,
            },
            figures,
            compensated: plan.tables.iter().any(|t| t.term == term),
            one_way: one_way(&measured.measured),
        });
    }
    let mut diagonals = diagonals::forecast(machine, control, &judged, sigma);
    if let Some(lines) = &comparable {
        let compared = diagonals::forecast(machine, lines, &judged, sigma);
        for (own, compared) in diagonals.iter_mut().zip(compared) {
            own.change.comparable_um = compared.change.after_um;
        }
    }
    let not_determined = model.remarks.not_determined.iter().map(|(term, _)| *term);
    let not_determined = not_determined.filter(|term| model.terms[*term].is_none());
    let forecast = Forecast {
        basis: Basis::Forecast,
        sigma,
        ranges: ranges.to_vec(),
        silence: model.remarks.silence.clone(),
        largest: largest.cloned(),
        measured: model.remarks.measured.clone(),
        doubtful: model.remarks.doubtful.clone().unwrap_or_default(),
        diagonals,
        terms,
        unmeasured: PerAxis::from_fn(|axis| unmeasured(model, plan, axis)),
        not_determined: not_determined.collect(),
        without_reversal_um: model.remarks.hidden_reversal_um,
    };
    forecast.bounded(Basis::Forecast)
}

const fn one_way(measured: &Measured) -> Option<Option<Direction>> {
    match measured {
        Measured::BothWays { .. } => None,
        Measured::OneWay(direction, _) => Some(Some(*direction)),
        Measured::Undirected(_) => Some(None),
    }
}

/// What is left of a term around each of its measured positions, |deviation + correction|.
fn residuals(
    machine: Machine<'_>,
    control: &Field,
    term: ErrorTerm,
    judged: Option<Range>,
) -> Vec<Magnitude> {
    let mut figures: Vec<(Cell, f64)> = Vec::new();
    for direction in Direction::BOTH {
        let known = machine.as_measured.terms[term].as_ref();
        let Some((known, (measured, curve))) = known.zip(machine.curves(term, direction)) else {
            continue;
        };
        let cells = cells(known, direction, within(measured.measured_range(), judged));
        for response in control.ways(term, direction) {
            for cell in &cells {
                let um = largest_in(curve, response, *cell);
                match figures.iter_mut().find(|(known, _)| known == cell) {
                    Some((_, largest)) => *largest = larger(*largest, um),
                    None => figures.push((*cell, um)),
                }
            }
        }
    }
    let figure = |(cell, um): (Cell, f64)| Magnitude { um, u_um: cell.u_um };
    figures.into_iter().map(figure).collect()
}

/// The stretch of a curve that a measured position stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    /// In which it was measured.
    way: Option<Direction>,
    from: Millimetres,
    to: Millimetres,
    u_um: f64,
}

/// Half-way to the neighbouring positions on either side; the whole range where no uncertainty is
/// stated.
fn cells(known: &MeasuredTerm, direction: Direction, (from, to): Range) -> Vec<Cell> {
    let own = |way: Option<Direction>| way.is_none_or(|way| way == direction);
    let points = known.uncertainty.iter().filter(|p| own(p.direction));
    let points: Vec<_> = points.collect();
    if points.is_empty() {
        return vec![Cell { way: None, from, to, u_um: 0.0 }];
    }
    let middle = |index: usize| {
        let (a, b) = (points[index].at, points[index + 1].at);
        Millimetres::new(f64::midpoint(a.mm(), b.mm()))
    };
    let cell = |(index, point): (usize, &&PointUncertainty)| {
        let low = if index == 0 { from } else { middle(index - 1) };
        let high = if index + 1 == points.len() { to } else { middle(index) };
        let (low, high) = within((low, high), Some((from, to)));
        let (way, u_um) = (point.direction, point.u_um);
        (low < high).then_some(Cell { way, from: low, to: high, u_um })
    };
    points.iter().enumerate().filter_map(cell).collect()
}

/// Largest |deviation + correction| on a stretch, µm.
fn largest_in(curve: &ErrorCurve, response: &Response, cell: Cell) -> f64 {
    let mut largest = 0.0;
    for [(from, start), (to, end)] in response.stretches(cell.from, cell.to) {
        let (low, high) = curve.extremes_against_line(from, to, start.um(), end.um());
        largest = larger(largest, larger(high, -low));
    }
    for end in [cell.from, cell.to] {
        for beside in [-AT_THE_END_MM, AT_THE_END_MM] {
            let correction = response.correction(end + Millimetres::new(beside));
            largest = larger(largest, (curve.at(end) + correction).um().abs());
        }
    }
    largest
}

/// A correction that jumps at an end of the measured range (a picometre either way) counts with
/// both its values there.
const AT_THE_END_MM: f64 = 1e-9;

fn unmeasured(model: &ErrorModel, plan: &Plan, axis: Axis) -> Vec<Range> {
    let (Some(grid), Some((low, high))) = (plan.grids[axis], model.ranges[axis]) else {
        return Vec::new();
    };
    let (first, last) = grid.range();
    [(first, low), (high, last)]
        .into_iter()
        .filter(|(from, to)| to.mm() - from.mm() > EDGE_MM)
        .collect()
}
