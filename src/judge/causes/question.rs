//! What is known when a cause is asked for.

use crate::judge::after::{Observation, Part, before_um};
use crate::judge::field::Field;
use crate::machine::model::ErrorModel;
use crate::quantity::{Axis, Diagonal, Direction, ErrorTerm, PerAxis};

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
}

/// What the first readings are once a slip is taken back.
#[derive(Clone, Debug)]
pub struct Corrected {
    /// The slip.
    pub slip: Slip,
    /// The machine without tables, from the same readings, filed right.
    pub before: ErrorModel,
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
    /// The deviations that the second measurement sees.
    pub(super) fn parts(&self) -> impl Iterator<Item = &Part> {
        self.seen.iter().flat_map(|observation| &observation.parts)
    }

    /// The terms that it sees.
    pub(super) fn terms(&self) -> Vec<ErrorTerm> {
        let seen = |term: &ErrorTerm| self.parts().any(|part| part.term == *term);
        ErrorTerm::ALL.into_iter().filter(seen).collect()
    }

    /// What the tables that were active while measuring added where a part looks, µm; where one
    /// way was measured only, what they added then; 0 where none were active or nothing is known.
    pub(super) fn old_um(&self, part: &Part) -> f64 {
        let old = |part: &Part| {
            Some(before_um(self.under_tables?, part)? - before_um(self.before, part)?)
        };
        let other_way = Part { direction: part.direction.opposite(), ..*part };
        old(part).or_else(|| old(&other_way)).unwrap_or(0.0)
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

    /// Whether the kit sets a backlash parameter.
    pub(super) fn has_parameter(&self) -> bool {
        let um = |term, way| self.control.constant_um(term, way).abs();
        let is_set = |term| Direction::BOTH.into_iter().any(|way| um(term, way) > SMALLEST_UM);
        ErrorTerm::ALL.into_iter().any(is_set)
    }

    /// What a backlash parameter of −B as found adds to a positioning error, µm: it acts away from the
    /// reference direction; 0 where B was not measured.
    pub(super) fn parameter_um(&self, part: &Part) -> f64 {
        let axis = part.term.along;
        let measured = self.before.terms[ErrorTerm::positioning(axis)].as_ref();
        let reversal = measured.and_then(|term| term.reversal());
        match (reversal, part.direction) {
            (Some(reversal), way) if way != self.homing[axis] => match way {
                Direction::Minus => reversal.um(),
                Direction::Plus => (-reversal).um(),
            },
            _ => 0.0,
        }
    }
}
