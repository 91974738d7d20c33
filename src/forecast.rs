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

use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::curve::ErrorCurve;
use crate::emulate::{CannotEmulate, Emulator, Response};
use crate::grid::EDGE_MM;
use crate::job::Acceptance;
use crate::model::{ErrorModel, Measured, MeasuredTerm};
use crate::plan::{Plan, axis_pairs};
use crate::units::Millimetres;

/// Forecast of one term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TermForecast {
    /// Which error.
    pub term: ErrorTerm,
    /// Largest |deviation| as measured, relative to the reference, µm.
    pub before_um: f64,
    /// Largest |deviation + emulated correction|, µm.
    pub after_um: f64,
    /// Largest standard uncertainty (k = 1), µm; `None` = not stated.
    pub u_um: Option<f64>,
    /// Whether a table was planned for it.
    pub compensated: bool,
}

/// Forecast along one body diagonal of the measured box: max − min of the deviation along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalForecast {
    /// `PPP`, `NPP`, `PNP` or `PPN` (contract §2.2).
    pub name: &'static str,
    /// As measured, µm.
    pub before_um: f64,
    /// With the tables, µm.
    pub after_um: f64,
    /// Standard uncertainty (k = 1) of the figure, µm; `None` if any of the nine is not stated.
    pub u_um: Option<f64>,
}

/// What the tables will leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
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
        self.terms
            .iter()
            .map(|term| term.after_um)
            .fold(0.0, f64::max)
    }

    /// Figures that the tables make larger than they were measured, one sentence each.
    pub fn worsened(&self) -> Vec<String> {
        let sentence = |name: String, before_um: f64, after_um: f64| {
            (after_um > before_um + SHOWN_UM).then(|| {
                format!("{name} becomes larger with the tables: {before_um:.3} → {after_um:.3} µm")
            })
        };
        let terms = self.terms.iter();
        let terms = terms.filter_map(|t| sentence(t.term.to_string(), t.before_um, t.after_um));
        let diagonals = self.diagonals.iter();
        let diagonals = diagonals
            .filter_map(|d| sentence(format!("diagonal {}", d.name), d.before_um, d.after_um));
        terms.chain(diagonals).collect()
    }

    /// Figures that do not keep the acceptance for sure, one sentence each.
    pub fn misses(&self, acceptance: Acceptance) -> Vec<String> {
        let sentence = |name: String, um: f64, u_um: Option<f64>, limit: Option<f64>| {
            let verdict = judge(um, u_um, limit);
            (verdict != Verdict::Pass).then(|| {
                let expanded = u_um.map_or_else(
                    || "U not stated".to_string(),
                    |u| format!("U = {:.3} µm", COVERAGE_FACTOR * u),
                );
                format!(
                    "{name} leaves {um:.3} µm ({expanded}), the limit is {} µm: {}",
                    limit.unwrap_or(f64::INFINITY),
                    verdict.word()
                )
            })
        };
        let terms = self.terms.iter().filter_map(|t| {
            sentence(
                t.term.to_string(),
                t.after_um,
                t.u_um,
                acceptance.max_deviation_um,
            )
        });
        let diagonals = self.diagonals.iter().filter_map(|d| {
            let name = format!("diagonal {}", d.name);
            sentence(name, d.after_um, d.u_um, acceptance.max_diagonal_um)
        });
        terms.chain(diagonals).collect()
    }

    /// Compares with the acceptance of the job.
    pub fn verdict(&self, acceptance: Acceptance) -> Verdict {
        let terms = self
            .terms
            .iter()
            .map(|t| judge(t.after_um, t.u_um, acceptance.max_deviation_um));
        let diagonals = self
            .diagonals
            .iter()
            .map(|d| judge(d.after_um, d.u_um, acceptance.max_diagonal_um));
        let missing = acceptance.max_diagonal_um.is_some() && self.diagonals.is_empty();
        terms
            .chain(diagonals)
            .chain(missing.then_some(Verdict::Undecided))
            .max()
            .unwrap_or(Verdict::Pass)
    }
}

/// Differences below the last digit that is shown are none, µm.
const SHOWN_UM: f64 = 0.001;

/// Answer to the question whether a limit is kept; the worse one is the larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// |d| + U ≤ limit, or no limit is stated.
    Pass,
    /// Neither.
    Undecided,
    /// |d| − U > limit.
    Fail,
}

impl Verdict {
    /// `pass`, `fail` or `undecided`.
    pub const fn word(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Undecided => "undecided",
            Verdict::Fail => "fail",
        }
    }
}

/// Coverage factor of the expanded uncertainty U = k·u (contract §5).
pub const COVERAGE_FACTOR: f64 = 2.0;

/// Contract §5: pass if |d| + U ≤ limit, fail if |d| − U > limit; U = 0 where u is not stated.
pub fn judge(largest_um: f64, u_um: Option<f64>, limit_um: Option<f64>) -> Verdict {
    let Some(limit) = limit_um else {
        return Verdict::Pass;
    };
    let expanded = COVERAGE_FACTOR * u_um.unwrap_or(0.0);
    if largest_um + expanded <= limit {
        Verdict::Pass
    } else if largest_um - expanded > limit {
        Verdict::Fail
    } else {
        Verdict::Undecided
    }
}

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

/// Computes the forecast from a machine and the emulated control.
pub fn forecast(
    machine: Machine<'_>,
    plan: &Plan,
    control: &dyn Emulator,
) -> Result<Forecast, CannotEmulate> {
    let model = machine.as_measured;
    let mut terms = Vec::new();
    for (term, measured) in model.measured() {
        terms.push(TermForecast {
            term,
            before_um: measured.largest_um(),
            after_um: largest_residual(machine, plan, control, term)?,
            u_um: measured.u_um,
            compensated: plan.tables.iter().any(|t| t.term == term),
        });
    }
    Ok(Forecast {
        diagonals: diagonals(machine, plan, control)?,
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

fn largest_residual(
    machine: Machine<'_>,
    plan: &Plan,
    control: &dyn Emulator,
    term: ErrorTerm,
) -> Result<f64, CannotEmulate> {
    let mut largest = 0.0_f64;
    for direction in Direction::BOTH {
        let Some((measured, curve)) = machine.curves(term, direction) else {
            continue;
        };
        let (from, to) = measured.measured_range();
        for (base, output) in axis_pairs(&plan.names, term) {
            let response = control.response(base, output, direction)?;
            for stretch in response.stretches(from, to) {
                let (low, high) = curve.extremes_against_line(
                    stretch.from,
                    stretch.to,
                    stretch.at_from.um(),
                    stretch.at_to.um(),
                );
                largest = largest.max(high).max(-low);
            }
            for end in [from, to] {
                for beside in [-AT_THE_END_MM, AT_THE_END_MM] {
                    let correction = response.correction(end + Millimetres::new(beside));
                    largest = largest.max((curve.at(end) + correction).um().abs());
                }
            }
        }
    }
    Ok(largest)
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

/// Sign of travel of X, Y, Z on the forward run of each diagonal (contract §2.2).
const DIAGONALS: [(&str, [f64; 3]); 4] = [
    ("PPP", [1.0, 1.0, 1.0]),
    ("NPP", [-1.0, 1.0, 1.0]),
    ("PNP", [1.0, -1.0, 1.0]),
    ("PPN", [1.0, 1.0, -1.0]),
];

/// The measured box: low corner and size of each axis, mm.
struct MeasuredBox {
    low: [f64; 3],
    size: [f64; 3],
}

impl MeasuredBox {
    fn of(model: &ErrorModel) -> Option<MeasuredBox> {
        let ends: Option<Vec<(f64, f64)>> = Axis::ALL
            .iter()
            .map(|axis| model.ranges[*axis].map(|(low, high)| (low.mm(), high.mm())))
            .collect();
        let ends = ends?;
        Some(MeasuredBox {
            low: [ends[0].0, ends[1].0, ends[2].0],
            size: [
                ends[0].1 - ends[0].0,
                ends[1].1 - ends[1].0,
                ends[2].1 - ends[2].0,
            ],
        })
    }

    fn length(&self) -> f64 {
        self.size.iter().map(|s| s * s).sum::<f64>().sqrt()
    }
}

fn diagonals(
    machine: Machine<'_>,
    plan: &Plan,
    control: &dyn Emulator,
) -> Result<Vec<DiagonalForecast>, CannotEmulate> {
    let model = machine.as_measured;
    let Some(measured_box) = MeasuredBox::of(model) else {
        return Ok(Vec::new());
    };
    let one_way = |(_, m): (ErrorTerm, &MeasuredTerm)| matches!(m.measured, Measured::OneWay(..));
    if model.measured().count() < ErrorTerm::ALL.len() || model.measured().any(one_way) {
        // A diagonal travels some axis in the direction that was not measured.
        return Ok(Vec::new());
    }
    let u_um = diagonal_uncertainty(model, &measured_box);
    DIAGONALS
        .iter()
        .map(|(name, signs)| {
            let mut before = Extent::default();
            let mut after = Extent::default();
            let walk = |reverse| Walk::new(machine, plan, control, &measured_box, *signs, reverse);
            let (forward, reverse) = (walk(false)?, walk(true)?);
            forward.extremes(&mut before, &mut after);
            if reverse.parts != forward.parts {
                reverse.extremes(&mut before, &mut after);
            }
            Ok(DiagonalForecast {
                name,
                before_um: before.size(),
                after_um: after.size(),
                u_um,
            })
        })
        .collect()
}

/// u of max − min along a diagonal: two readings, each the sum of three terms per direction
/// weighted with the direction cosine; the largest u of each term is taken everywhere.
fn diagonal_uncertainty(model: &ErrorModel, measured_box: &MeasuredBox) -> Option<f64> {
    let mut variance = 0.0;
    for (term, measured) in model.measured() {
        let cosine = measured_box.size[index(term.of)] / measured_box.length();
        variance += (cosine * measured.u_um?).powi(2);
    }
    Some((2.0 * variance).sqrt())
}

const fn index(axis: Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}

/// Smallest and largest value met.
#[derive(Default)]
struct Extent {
    ends: Option<(f64, f64)>,
}

impl Extent {
    fn meet(&mut self, value: f64) {
        let (low, high) = self.ends.unwrap_or((value, value));
        self.ends = Some((low.min(value), high.max(value)));
    }

    fn size(&self) -> f64 {
        self.ends.map_or(0.0, |(low, high)| high - low)
    }
}

/// One run along a diagonal, t from 0 to 1.
struct Walk<'a> {
    parts: Vec<Part<'a>>,
    measured_box: &'a MeasuredBox,
    signs: [f64; 3],
}

/// One term on the way: its curves, its correction, and the cosine of the beam to its direction.
#[derive(PartialEq)]
struct Part<'a> {
    measured: &'a ErrorCurve,
    uncompensated: &'a ErrorCurve,
    response: Response,
    along: usize,
    cosine: f64,
}

impl<'a> Walk<'a> {
    fn new(
        machine: Machine<'a>,
        plan: &Plan,
        control: &dyn Emulator,
        measured_box: &'a MeasuredBox,
        signs: [f64; 3],
        reverse: bool,
    ) -> Result<Walk<'a>, CannotEmulate> {
        let mut parts = Vec::new();
        for (term, _) in machine.as_measured.measured() {
            let forward = (signs[index(term.along)] > 0.0) != reverse;
            let direction = if forward {
                Direction::Plus
            } else {
                Direction::Minus
            };
            let Some((measured, uncompensated)) = machine.curves(term, direction) else {
                continue;
            };
            let Some((base, output)) = axis_pairs(&plan.names, term).first().copied() else {
                continue;
            };
            parts.push(Part {
                measured,
                uncompensated,
                response: control.response(base, output, direction)?,
                along: index(term.along),
                cosine: signs[index(term.of)] * measured_box.size[index(term.of)]
                    / measured_box.length(),
            });
        }
        Ok(Walk {
            parts,
            measured_box,
            signs,
        })
    }

    fn position(&self, axis: usize, t: f64) -> Millimetres {
        let travelled = if self.signs[axis] > 0.0 { t } else { 1.0 - t };
        Millimetres::new(self.measured_box.low[axis] + travelled * self.measured_box.size[axis])
    }

    /// Places t where a curve or a correction bends or jumps.
    fn breaks(&self) -> Vec<f64> {
        let mut breaks = vec![0.0, 1.0];
        for part in &self.parts {
            let (low, size) = (
                self.measured_box.low[part.along],
                self.measured_box.size[part.along],
            );
            let from = Millimetres::new(low);
            let to = Millimetres::new(low + size);
            let stretches = part
                .response
                .stretches(from, to)
                .into_iter()
                .map(|s| s.from);
            let knots = [part.measured, part.uncompensated];
            let knots = knots.iter().flat_map(|curve| curve.knots().iter().copied());
            for x in knots.chain(stretches) {
                let travelled = (x.mm() - low) / size;
                breaks.push(if self.signs[part.along] > 0.0 {
                    travelled
                } else {
                    1.0 - travelled
                });
            }
        }
        breaks.retain(|t| (0.0..=1.0).contains(t));
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        breaks
    }

    /// Deviation along the beam at t, as measured and with the tables, µm.
    fn deviation(&self, t: f64) -> (f64, f64) {
        let mut before = 0.0;
        let mut after = 0.0;
        for part in &self.parts {
            let at = self.position(part.along, t);
            let left = part.uncompensated.at(at) + part.response.correction(at);
            before += part.cosine * part.measured.at(at).um();
            after += part.cosine * left.um();
        }
        (before, after)
    }

    /// Between two breaks both sums are cubics in t; four places determine each.
    fn extremes(&self, before: &mut Extent, after: &mut Extent) {
        const PLACES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
        for pair in self.breaks().windows(2) {
            let values = PLACES.map(|s| self.deviation(pair[0] + s * (pair[1] - pair[0])));
            cubic_extremes(values.map(|v| v.0), before);
            cubic_extremes(values.map(|v| v.1), after);
        }
        for corner in [0.0, 1.0] {
            let (measured, left) = self.deviation(corner); // a correction can jump just here
            before.meet(measured);
            after.meet(left);
        }
    }
}

/// Meets the extremes on 0…1 of the cubic through values at 1/8, 3/8, 5/8, 7/8.
fn cubic_extremes(values: [f64; 4], extent: &mut Extent) {
    // Newton's forward differences with u = (s − 1/8) / (1/4), so s = 0 and 1 are u = −½ and 3½.
    let d1 = values[1] - values[0];
    let d2 = values[2] - 2.0 * values[1] + values[0];
    let d3 = values[3] - 3.0 * values[2] + 3.0 * values[1] - values[0];
    let at = |u: f64| {
        values[0] + u * d1 + u * (u - 1.0) / 2.0 * d2 + u * (u - 1.0) * (u - 2.0) / 6.0 * d3
    };
    const FIRST: f64 = -0.5;
    const LAST: f64 = 3.5;
    extent.meet(at(FIRST));
    extent.meet(at(LAST));
    // derivative: d3/2·u² + (d2 − d3)·u + (d1 − d2/2 + d3/3)
    let (a, b, c) = (d3 / 2.0, d2 - d3, d1 - d2 / 2.0 + d3 / 3.0);
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    for u in [q / a, c / q] {
        if u > FIRST && u < LAST {
            extent.meet(at(u));
        }
    }
}
