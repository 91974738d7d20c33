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

use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::curve::ErrorCurve;
use crate::emulate::{CannotEmulate, Emulator, Response};
use crate::grid::EDGE_MM;
use crate::job::Acceptance;
use crate::model::ErrorModel;
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
    /// `after_um`, but with straight lines between the points of a table where old tables were
    /// active, whose steps are not in `before_um` either.
    pub comparable_um: f64,
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
    /// `after_um` with straight lines, as of a term.
    pub comparable_um: f64,
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

/// Computes the forecast from a machine and the emulated control.
pub fn forecast(
    machine: Machine<'_>,
    plan: &Plan,
    control: &dyn Emulator,
) -> Result<Forecast, CannotEmulate> {
    let model = machine.as_measured;
    let lines = Straightened(control);
    let comparable: Option<&dyn Emulator> = machine.was_under_tables().then_some(&lines);
    let mut terms = Vec::new();
    for (term, measured) in model.measured() {
        let after_um = largest_residual(machine, plan, control, term)?;
        terms.push(TermForecast {
            term,
            before_um: measured.largest_um(),
            after_um,
            comparable_um: match comparable {
                Some(lines) => largest_residual(machine, plan, lines, term)?,
                None => after_um,
            },
            u_um: measured.u_um,
            compensated: plan.tables.iter().any(|t| t.term == term),
        });
    }
    let mut diagonals = diagonals::forecast(machine, plan, control)?;
    if let Some(lines) = comparable {
        let compared = diagonals::forecast(machine, plan, lines)?;
        for (own, compared) in diagonals.iter_mut().zip(compared) {
            own.comparable_um = compared.after_um;
        }
    }
    Ok(Forecast {
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
                largest = largest.max(high.abs()).max(low.abs());
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
