//! What is known when a cause is asked for.

use crate::judge::after::{Observation, Part, before_um};
use crate::judge::field::Field;
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::diagonal::Diagonal;
use crate::quantity::units::Deviation;

/// A correction that no laser resolves is none, µm.
const SMALLEST_UM: f64 = 0.01;

/// What may have been recorded wrongly of the first measurement. To the closure an order of the steps
/// is the same as one way to share out the names (docs/method.md §4). Separated they are not: the
/// names put other readings to an axis, the order another axis to the readings. So the second
/// measurement tells them apart, and both are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slip {
    /// The readings of two diagonals were saved under each other's name.
    Names(Diagonal, Diagonal),
    /// The steps went in this order, not in that of the job.
    Order([Axis; 3]),
}

impl Slip {
    /// The six exchanges of two names and the five orders other than the recorded one.
    pub fn all(recorded: [Axis; 3]) -> Vec<Slip> {
        let names = Diagonal::ALL.into_iter().enumerate();
        let pairs = names.flat_map(|(index, one)| {
            let others = Diagonal::ALL.into_iter().skip(index + 1);
            others.map(move |other| Slip::Names(one, other))
        });
        let others = Axis::ORDERS.into_iter().filter(|order| *order != recorded);
        pairs.chain(others.map(Slip::Order)).collect()
    }

    /// What settles it.
    pub(super) const fn check(self) -> &'static str {
        match self {
            Slip::Names(..) => {
                "compare the names in the file of the first readings with the programs that were run, or run one of the two diagonals again"
            }
            Slip::Order(_) => {
                "compare the order in the job of the first measurement with the programs that were run"
            }
        }
    }
}

/// What the first readings are once a slip is taken back.
#[derive(Clone, Debug)]
pub struct Corrected {
    /// The slip.
    pub slip: Slip,
    /// The machine without tables, from the same readings, filed right.
    pub before: ErrorModel,
}

impl Corrected {
    /// What a part was as found beyond what the records say, µm; `None` = not measured there.
    pub(super) fn beyond_um(&self, question: &Question<'_>, part: &Part) -> Option<f64> {
        Some(before_um(&self.before, part)? - before_um(question.before, part)?)
    }
}

/// What is known when a cause is asked for.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// As found.
    pub before: &'a ErrorModel,
    /// As found under the tables that were active then, which are part of `before` no more; `None` =
    /// none were active.
    pub under_tables: Option<&'a ErrorModel>,
    /// The same readings with one slip of their records taken back; empty = none is tried.
    pub corrected: &'a [Corrected],
    /// What the loaded tables add.
    pub control: &'a Field,
    /// The values of the second measurement.
    pub seen: &'a [Observation],
    /// Direction of the reference return of each axis.
    pub homing: PerAxis<Direction>,
    /// Reference point of each axis, mm.
    pub reference_mm: PerAxis<f64>,
    /// Expansion of each scale, 1/K.
    pub alpha_per_k: PerAxis<f64>,
    /// Standard uncertainty (k = 1) of the laser's scale, of both measurements together, where no other holds it, µm/m.
    pub laser_um_per_m: f64,
    /// Largest count of the tables, µm.
    pub count_um: f64,
    /// The display of the control that shows the correction that acts; `None` = none is known.
    pub display: Option<&'a str>,
}

impl Question<'_> {
    /// The terms that the second measurement sees.
    pub fn terms(&self) -> Vec<ErrorTerm> {
        let seen = |term: &ErrorTerm| {
            let mut parts = self.seen.iter().flat_map(|o| &o.parts);
            parts.any(|part| part.term == *term)
        };
        ErrorTerm::ALL.into_iter().filter(seen).collect()
    }

    /// As found, as it was measured.
    pub(super) fn found(&self) -> &ErrorModel {
        self.under_tables.unwrap_or(self.before)
    }

    /// What the tables that were active while measuring added where a part looks, µm; where one
    /// way was measured only, what they added then. `None` = none were active, or the term was not
    /// measured.
    pub(super) fn old_um(&self, part: &Part) -> Option<f64> {
        let under = self.under_tables?;
        let old = |part: &Part| Some(before_um(under, part)? - before_um(self.before, part)?);
        let other_way = Part { direction: part.direction.opposite(), ..*part };
        old(part).or_else(|| old(&other_way))
    }

    /// Growth of a scale that is this much warmer, µm/m.
    pub(super) fn um_per_m(&self, axis: Axis, kelvin: f64) -> f64 {
        kelvin * self.alpha_per_k[axis] * 1e6
    }

    /// What a positioning error gains where its scale is longer by so much, µm; a cross term gains nothing.
    pub(super) fn grown_um(&self, part: &Part, um_per_m: f64) -> f64 {
        let from_zero = part.at.mm() - self.reference_mm[part.term.along];
        if part.term.is_positioning() { um_per_m * from_zero / 1000.0 } else { 0.0 }
    }

    /// Whether the second measurement sees the positions of an axis whose scale grows.
    pub(super) fn shows_growth(&self, axis: Axis) -> bool {
        self.alpha_per_k[axis] > 0.0 && self.terms().contains(&ErrorTerm::positioning(axis))
    }

    /// Where the second measurement looked along an axis, mm.
    pub(super) fn range_mm(&self, axis: Axis) -> Option<(f64, f64)> {
        let parts = self.seen.iter().flat_map(|o| &o.parts);
        let along = parts.filter(|part| part.term.along == axis);
        along.map(|part| part.at.mm()).fold(None, |range, mm| {
            let (low, high) = range.unwrap_or((mm, mm));
            Some((mm.min(low), mm.max(high)))
        })
    }

    pub(super) fn has_two_tables(&self) -> bool {
        ErrorTerm::ALL.into_iter().any(|term| self.is_directed(term))
    }

    /// Whether the tables for + and − of a term differ.
    fn is_directed(&self, term: ErrorTerm) -> bool {
        self.control.nodes(term).into_iter().any(|at| {
            let um = Direction::BOTH.map(|way| self.control.tables_um(term, way, at));
            (um[0] - um[1]).abs() > SMALLEST_UM
        })
    }

    pub(super) fn has_parameter(&self) -> bool {
        ErrorTerm::ALL.into_iter().any(|term| self.has_constant(term))
    }

    fn has_constant(&self, term: ErrorTerm) -> bool {
        let ways = Direction::BOTH.map(|way| self.control.constant_um(term, way));
        ways.into_iter().any(|um| um.abs() > SMALLEST_UM)
    }

    /// Whether a backlash parameter of the kit acts on an axis (`None` = on any).
    pub(super) fn sets_parameter(&self, axis: Option<Axis>) -> bool {
        of_any(axis, |axis| self.has_constant(ErrorTerm::positioning(axis)))
    }

    /// Whether an axis (`None` = any) has tables of its own for + and −.
    pub(super) fn corrects_each_way(&self, axis: Option<Axis>) -> bool {
        of_any(axis, |axis| self.is_directed(ErrorTerm::positioning(axis)))
    }

    /// What a backlash parameter of −B as found adds: it acts away from the reference direction.
    pub(super) fn parameter_um(&self, axis: Axis, direction: Direction) -> f64 {
        let reversal_um = self.reversal_um(axis).unwrap_or(0.0);
        match direction {
            own if own == self.homing[axis] => 0.0,
            Direction::Minus => reversal_um,
            Direction::Plus => (-Deviation::from_um(reversal_um)).um(),
        }
    }

    /// B of an axis as found, µm.
    pub(super) fn reversal_um(&self, axis: Axis) -> Option<f64> {
        let measured = self.before.terms[ErrorTerm::positioning(axis)].as_ref()?;
        Some(measured.reversal()?.um())
    }

    /// Whether the data see an axis (`None` = any) in both directions, and it had a reversal.
    pub(super) fn shows_reversal(&self, axis: Option<Axis>) -> bool {
        of_any(axis, |axis| {
            let term = ErrorTerm::positioning(axis);
            let sees = |way: Direction| {
                let mut values = self.seen.iter();
                values.any(|o| o.parts.iter().any(|p| p.term == term && p.direction == way))
            };
            self.reversal_um(axis).is_some() && Direction::BOTH.into_iter().all(sees)
        })
    }
}

/// Whether it holds for this axis, or where none is named for any.
fn of_any(axis: Option<Axis>, holds: impl Fn(Axis) -> bool) -> bool {
    match axis {
        Some(axis) => holds(axis),
        None => Axis::ALL.into_iter().any(holds),
    }
}
