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
mod share;
mod silent;
mod words;

pub(crate) use self::share::range_of;
pub use self::share::{JudgedRange, judged_ranges};
pub use self::silent::Silent;

use crate::inputs::job::Acceptance;
use crate::judge::conformity::{
    Magnitude, Sigma, Verdict, expanded_um, judge_forecast, judge_measured, largest_um,
};
use crate::machine::model::{ErrorModel, Measured, MeasuredTerm};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::{Millimetres, larger};
use crate::read::emulate::{CannotEmulate, Emulator, Response};
use crate::write::grid::EDGE_MM;
use crate::write::plan::{Plan, axis_pairs};

/// Forecast of one term.
#[derive(Clone, Debug, PartialEq)]
pub struct TermForecast {
    /// Which error.
    pub term: ErrorTerm,
    /// Largest |deviation| as measured, relative to the reference, µm.
    pub before_um: f64,
    /// Largest |deviation + emulated correction|, µm.
    pub after_um: f64,
    /// `after_um`, but with straight lines between the points of a table where old tables were
    /// active, whose steps are not in `before_um` either.
    pub comparable_um: f64,
    /// Largest standard uncertainty (k = 1) of a value, µm; `None` = not stated.
    pub u_um: Option<f64>,
    /// U of `after_um`, the largest of its values, with 95 %, µm; `None` = not stated.
    pub expanded_um: Option<f64>,
    /// What is left around each measured position; one where no uncertainty is stated.
    pub figures: Vec<Magnitude>,
    /// Whether a table was planned for it.
    pub compensated: bool,
    /// `None` = measured both ways; else in which direction, without regard to it where it is `None`.
    pub one_way: Option<Option<Direction>>,
}

/// Forecast along one body diagonal of the measured box: max − min of the deviation along it.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagonalForecast {
    /// `PPP`, `NPP`, `PNP` or `PPN` (contract §2.2).
    pub name: &'static str,
    /// As measured, µm.
    pub before_um: f64,
    /// With the tables, µm.
    pub after_um: f64,
    /// `after_um` with straight lines, as of a term.
    pub comparable_um: f64,
    /// Standard uncertainty (k = 1) of a difference of two values on it, µm; `None` if any of the
    /// nine is not stated.
    pub u_um: Option<f64>,
    /// U of `after_um` with 95 %, µm; `None` = not stated.
    pub expanded_um: Option<f64>,
    /// Half of max − min with the uncertainty of a value, at each place of a measured position, one where none is stated:
    /// max − min keeps a limit where every value lies within half of it about the middle.
    pub halves: Vec<Magnitude>,
    /// Share of a deviation in X, Y, Z along the beam.
    pub cosines: PerAxis<f64>,
}

impl DiagonalForecast {
    /// A diagonal whose values have these standard uncertainties, µm; empty = not stated. `scale_um` =
    /// that of the laser over its length, which is one error of all values.
    pub fn new(
        name: &'static str,
        before_um: f64,
        after_um: f64,
        sigma: Sigma,
        u_um: &[f64],
        scale_um: f64,
    ) -> Self {
        let half = |u_um: f64| Magnitude {
            um: after_um / 2.0,
            u_um: u_um.hypot(scale_um / 2.0),
        };
        let mut halves: Vec<Magnitude> = u_um.iter().copied().map(half).collect();
        if halves.is_empty() {
            halves.push(half(0.0));
        }
        let largest = u_um.iter().copied().reduce(larger);
        DiagonalForecast {
            name,
            before_um,
            after_um,
            comparable_um: after_um,
            u_um: largest.map(|u| (std::f64::consts::SQRT_2 * u).hypot(scale_um)),
            expanded_um: largest.map(|_| 2.0 * expanded_um(&halves, sigma)),
            halves,
            cosines: PerAxis::default(),
        }
    }

    /// max − min as one figure: the difference of two values.
    fn difference(&self) -> Magnitude {
        Magnitude {
            um: self.after_um,
            u_um: self.u_um.unwrap_or(0.0),
        }
    }
}

/// What the figures come from, which decides how they are judged ([`crate::judge::conformity`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The emulated tables.
    Forecast,
    /// A measurement with the tables active.
    Measured,
}

/// What the tables will leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// What the figures come from.
    pub basis: Basis,
    /// How the σ behind the uncertainties is known.
    pub sigma: Sigma,
    /// The part of each axis that is judged, and how much of it was measured.
    pub ranges: Vec<JudgedRange>,
    /// What no uncertainty holds because the job does not state it.
    pub silent: Vec<Silent>,
    /// Every measured term, in the contract's order.
    pub terms: Vec<TermForecast>,
    /// The four body diagonals; empty unless all nine errors were measured, none in one direction only.
    pub diagonals: Vec<DiagonalForecast>,
    /// Stretches of each axis where the table passes the measured range.
    pub unmeasured: PerAxis<Vec<(Millimetres, Millimetres)>>,
    /// Terms that the measurement was to give and did not.
    pub not_determined: Vec<ErrorTerm>,
    /// Reversal along the diagonals that no curve holds, µm: positioning and diagonals are
    /// forecast without it.
    pub without_reversal_um: Option<f64>,
}

impl Forecast {
    /// Largest residual of all measured terms, µm.
    pub fn max_residual_um(&self) -> f64 {
        let all = self.terms.iter().map(|term| term.after_um);
        all.fold(0.0, larger)
    }

    /// Figures that the tables make larger than they were measured, one sentence each.
    ///
    /// limits the steps of old tables between the measured positions are not in the figures as
    ///        measured; where only steps make a figure larger, the sentence says so
    pub fn worsened(&self) -> Vec<String> {
        let sentence = |name: String, before_um: f64, after_um: f64, comparable_um: f64| {
            let larger = |um: f64| um > before_um + SHOWN_UM;
            let why = match larger(comparable_um) {
                true => "",
                false => {
                    ", by the steps between the points; those of the old tables are not in the figure as measured"
                }
            };
            larger(after_um).then(|| {
                format!(
                    "{name} becomes larger with the tables: {before_um:.3} → {after_um:.3} µm{why}"
                )
            })
        };
        let terms = self.terms.iter();
        let terms = terms
            .filter_map(|t| sentence(t.term.to_string(), t.before_um, t.after_um, t.comparable_um));
        let diagonals = self.diagonals.iter();
        let diagonals = diagonals.filter_map(|d| {
            let name = format!("diagonal {}", d.name);
            sentence(name, d.before_um, d.after_um, d.comparable_um)
        });
        terms.chain(diagonals).collect()
    }

    /// What is left of all terms, at every measured position.
    fn figures(&self) -> Vec<Magnitude> {
        let all = self.terms.iter().flat_map(|term| &term.figures);
        all.copied().collect()
    }

    /// U of [`Forecast::max_residual_um`], the largest of all terms, with 95 %, µm; `None` = no
    /// uncertainty is stated.
    pub fn max_expanded_um(&self) -> Option<f64> {
        let stated = self.terms.iter().any(|term| term.u_um.is_some());
        stated.then(|| expanded_um(&self.figures(), self.sigma))
    }

    fn judge(&self, figures: &[Magnitude], limit_um: f64) -> Verdict {
        match self.basis {
            Basis::Forecast => judge_forecast(figures, self.sigma, limit_um),
            Basis::Measured => judge_measured(figures, self.sigma, limit_um),
        }
    }

    /// Diagonals of a forecast are judged together; a measured one passes on the difference of its
    /// two extreme values and fails on all its values.
    fn judge_diagonals(&self, diagonals: &[&DiagonalForecast], limit_um: f64) -> Verdict {
        let halves: Vec<Magnitude> = (diagonals.iter())
            .flat_map(|diagonal| diagonal.halves.clone())
            .collect();
        let together = self.judge(&halves, limit_um / 2.0);
        if self.basis == Basis::Forecast {
            return together;
        }
        let differences: Vec<Magnitude> = diagonals.iter().map(|d| d.difference()).collect();
        match judge_measured(&differences, self.sigma, limit_um) {
            Verdict::Pass => Verdict::Pass,
            _ => together.max(Verdict::Undecided),
        }
    }

    /// Compares with the acceptance of the job.
    pub fn verdict(&self, acceptance: Acceptance) -> Verdict {
        let terms = acceptance
            .max_deviation_um
            .map(|limit| self.judge(&self.figures(), limit));
        let all: Vec<&DiagonalForecast> = self.diagonals.iter().collect();
        let diagonals = acceptance
            .max_diagonal_um
            .map(|limit| match all.is_empty() {
                true => Verdict::Undecided,
                false => self.judge_diagonals(&all, limit),
            });
        let judged = [terms, diagonals].into_iter().flatten().max();
        let short = judged.is_some() && !self.is_range_known();
        let short = short.then_some(Verdict::Undecided);
        judged.max(short).unwrap_or(Verdict::Pass)
    }

    /// Whether enough of every judged range was measured.
    fn is_range_known(&self) -> bool {
        self.ranges.iter().all(JudgedRange::is_known)
    }
}

/// Differences below the last digit that is shown are none, µm.
const SHOWN_UM: f64 = 0.001;

/// One machine, before and without compensation. Both are the same model where no table was
/// active while measuring.
#[derive(Clone, Copy, Debug)]
pub struct Machine<'a> {
    /// As it was measured: what the forecast compares with, and the range that is known.
    pub as_measured: &'a ErrorModel,
    /// Without any table: what corrections are added to.
    pub uncompensated: &'a ErrorModel,
}

impl<'a> Machine<'a> {
    /// A machine that was measured without any table.
    pub fn alone(model: &'a ErrorModel) -> Machine<'a> {
        Machine {
            as_measured: model,
            uncompensated: model,
        }
    }

    /// Whether tables were active while measuring.
    fn was_under_tables(self) -> bool {
        !std::ptr::eq(self.as_measured, self.uncompensated)
    }

    /// The curves of a term in a direction: as measured, and without tables.
    fn curves(
        self,
        term: ErrorTerm,
        direction: Direction,
    ) -> Option<(&'a ErrorCurve, &'a ErrorCurve)> {
        let of = |model: &'a ErrorModel| model.terms[term].as_ref()?.measured.curve(direction);
        Some((of(self.as_measured)?, of(self.uncompensated)?))
    }
}

/// A control that plays straight lines where the real one plays steps.
struct Straightened<'a>(&'a dyn Emulator);

impl Emulator for Straightened<'_> {
    fn connected_axes(&self) -> Vec<(String, String)> {
        self.0.connected_axes()
    }

    fn response(
        &self,
        base: &str,
        output: &str,
        direction: Direction,
    ) -> Result<Response, CannotEmulate> {
        Ok(self.0.response(base, output, direction)?.straightened())
    }
}

/// Computes the forecast from a machine and the emulated control, over the ranges that are judged.
pub fn forecast(
    machine: Machine<'_>,
    plan: &Plan,
    control: &dyn Emulator,
    ranges: &[JudgedRange],
) -> Result<Forecast, CannotEmulate> {
    let model = machine.as_measured;
    let sigma = Sigma::with_freedom(model.remarks.degrees_of_freedom);
    let judged = share::stated(ranges);
    let lines = Straightened(control);
    let comparable: Option<&dyn Emulator> = machine.was_under_tables().then_some(&lines);
    let mut terms = Vec::new();
    for (term, measured) in model.measured() {
        let left = |control| residuals(machine, plan, control, term, judged[term.along]);
        let figures = left(control)?;
        let u_um = measured.u_um();
        terms.push(TermForecast {
            term,
            before_um: measured.largest_within_um(judged[term.along]),
            after_um: largest_um(&figures),
            comparable_um: match comparable {
                Some(lines) => largest_um(&left(lines)?),
                None => largest_um(&figures),
            },
            u_um,
            expanded_um: u_um.map(|_| expanded_um(&figures, sigma)),
            figures,
            compensated: plan.tables.iter().any(|t| t.term == term),
            one_way: match measured.measured {
                Measured::BothWays { .. } => None,
                Measured::OneWay(direction, _) => Some(Some(direction)),
                Measured::Undirected(_) => Some(None),
            },
        });
    }
    let mut diagonals = diagonals::forecast(machine, plan, control, &judged, sigma)?;
    if let Some(lines) = comparable {
        let compared = diagonals::forecast(machine, plan, lines, &judged, sigma)?;
        for (own, compared) in diagonals.iter_mut().zip(compared) {
            own.comparable_um = compared.after_um;
        }
    }
    Ok(Forecast {
        basis: Basis::Forecast,
        sigma,
        ranges: ranges.to_vec(),
        silent: silent::of(&model.remarks),
        diagonals,
        terms,
        unmeasured: PerAxis::from_fn(|axis| unmeasured(model, plan, axis)),
        not_determined: {
            let missing = model.remarks.not_determined.iter().map(|(term, _)| *term);
            missing
                .filter(|term| model.terms[*term].is_none())
                .collect()
        },
        without_reversal_um: model.remarks.hidden_reversal_um,
    })
}

/// What is left of a term around each of its measured positions, |deviation + correction|.
fn residuals(
    machine: Machine<'_>,
    plan: &Plan,
    control: &dyn Emulator,
    term: ErrorTerm,
    judged: Option<(Millimetres, Millimetres)>,
) -> Result<Vec<Magnitude>, CannotEmulate> {
    let mut figures: Vec<(Option<Direction>, Cell, f64)> = Vec::new();
    for direction in Direction::BOTH {
        let Some((measured, curve)) = machine.curves(term, direction) else {
            continue;
        };
        let range = within(measured.measured_range(), judged);
        let known = machine.as_measured.terms[term].as_ref();
        let cells = known.map_or_else(Vec::new, |known| cells(known, direction, range));
        for (base, output) in axis_pairs(&plan.names, term) {
            let response = control.response(base, output, direction)?;
            for (way, cell) in &cells {
                let um = largest_in(curve, &response, *cell);
                let same = figures.iter_mut().find(|(w, c, _)| w == way && c == cell);
                match same {
                    Some((_, _, largest)) => *largest = larger(*largest, um),
                    None => figures.push((*way, *cell, um)),
                }
            }
        }
    }
    let figure = |(_, cell, um): (_, Cell, f64)| Magnitude {
        um,
        u_um: cell.u_um,
    };
    Ok(figures.into_iter().map(figure).collect())
}

/// The stretch of a curve that a measured position stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    from: Millimetres,
    to: Millimetres,
    u_um: f64,
}

/// Half-way to the neighbouring positions on either side; the whole range where no uncertainty is
/// stated.
fn cells(
    known: &MeasuredTerm,
    direction: Direction,
    (from, to): (Millimetres, Millimetres),
) -> Vec<(Option<Direction>, Cell)> {
    let own = |way: Option<Direction>| way.is_none_or(|way| way == direction);
    let points = known.uncertainty.iter().filter(|p| own(p.direction));
    let points: Vec<_> = points.collect();
    if points.is_empty() {
        let u_um = 0.0;
        return vec![(None, Cell { from, to, u_um })];
    }
    let middle = |index: usize| {
        let (a, b) = (points[index].at, points[index + 1].at);
        Millimetres::new(f64::midpoint(a.mm(), b.mm()))
    };
    let mut cells = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        let low = if index == 0 { from } else { middle(index - 1) };
        let high = if index + 1 == points.len() {
            to
        } else {
            middle(index)
        };
        let (low, high) = within((low, high), Some((from, to)));
        if low < high {
            let cell = Cell {
                from: low,
                to: high,
                u_um: point.u_um,
            };
            cells.push((point.direction, cell));
        }
    }
    cells
}

/// Largest |deviation + correction| on a stretch, µm.
fn largest_in(curve: &ErrorCurve, response: &Response, cell: Cell) -> f64 {
    let mut largest = 0.0;
    for stretch in response.stretches(cell.from, cell.to) {
        let (low, high) = curve.extremes_against_line(
            stretch.from,
            stretch.to,
            stretch.at_from.um(),
            stretch.at_to.um(),
        );
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

/// What two ranges have in common; the first where there is no second.
fn within(
    (from, to): (Millimetres, Millimetres),
    other: Option<(Millimetres, Millimetres)>,
) -> (Millimetres, Millimetres) {
    let (low, high) = other.unwrap_or((from, to));
    let from = if low > from { low } else { from };
    let to = if high < to { high } else { to };
    (from, to)
}

/// A correction that jumps at an end of the measured range (a picometre either way) counts with
/// both its values there.
const AT_THE_END_MM: f64 = 1e-9;

fn unmeasured(model: &ErrorModel, plan: &Plan, axis: Axis) -> Vec<(Millimetres, Millimetres)> {
    let (Some(grid), Some((low, high))) = (plan.grids[axis], model.ranges[axis]) else {
        return Vec::new();
    };
    let (first, last) = grid.range();
    [(first, low), (high, last)]
        .into_iter()
        .filter(|(from, to)| to.mm() - from.mm() > EDGE_MM)
        .collect()
}
