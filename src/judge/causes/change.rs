//! The changes that are tried, and what each makes of the corrections.

use crate::judge::after::{Observation, SeenDeviation, before_um};
use crate::judge::field::Field;
use crate::machine::model::ErrorModel;
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorCurve, ErrorTerm, Interpolation, Millimetres, PerAxis, PerTerm,
};

/// The terms whose tables a change concerns.
pub(super) type Terms = PerTerm<bool>;

/// What of the compensation a change concerns: of these terms the tables, the backlash parameters, or both.
/// What a table for one direction holds apart (3627 on Fanuc) is such a parameter, too.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scope {
    pub(super) terms: Terms,
    pub(super) tables: bool,
    pub(super) parameters: bool,
}

impl Scope {
    /// The tables of these terms.
    pub(super) const fn tables(terms: Terms) -> Scope {
        Scope { terms, tables: true, parameters: false }
    }

    /// Whether this is so of one of its terms.
    pub(super) fn any(&self, holds: impl Fn(ErrorTerm) -> bool) -> bool {
        self.terms.iter().any(|(term, is_in)| *is_in && holds(term))
    }

    /// What is added where others act in place of the planned ones: tables, and what is added beside them, µm.
    fn changed_um(&self, term: ErrorTerm, planned: [f64; 2], other: [f64; 2]) -> f64 {
        let is_in = [self.tables, self.parameters].map(|held| held && self.terms[term]);
        (0..2).map(|own| if is_in[own] { other[own] } else { planned[own] }).sum()
    }
}

/// For each axis the place of its number among those that are fitted; `None` = it is left alone.
pub(super) type Fitted = PerAxis<Option<usize>>;

/// What happens to the tables, or to a measurement.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Change {
    /// Nothing: all is as the forecast says.
    None,
    /// It acts with a factor: −1 sign turned, 0 not active, 2 twice, 1000, 25.4 …; `None` = fitted.
    Times(Scope, Option<f64>),
    /// Positions and values are read in another unit: f·T(x/f).
    Unit(f64),
    /// The tables of an axis act s mm further in +, fitted.
    Shifted(Fitted),
    /// On a term acts the table that was made for another one.
    From(Box<PerTerm<ErrorTerm>>),
    /// Moving + and − the tables act that were made for these directions.
    Ways(Scope, [Direction; 2]),
    /// A backlash parameter acts once more than planned.
    BacklashTwice(Terms),
    /// What was active while measuring acts in place of the new.
    Old(Scope),
    /// The tables that were active while measuring act in addition to the new ones; a parameter has one value.
    OldBeside(Terms),
    /// The first measurement has the wrong sign, so the tables have it too.
    FirstTurned,
    /// The tables do not act, and the second measurement has the wrong sign.
    SecondTurned,
    /// The first measurement was recorded wrongly, so the tables are those of another machine: that
    /// with this slip of [`Question::corrected`] taken back.
    Recorded(usize),
    /// Scales are warmer or colder by some K, fitted.
    Warmer(Fitted),
}

/// A scale error of more than this is no temperature of a workshop, K.
const MOST_KELVIN: f64 = 20.0;

impl Change {
    /// How many numbers are fitted.
    pub(super) fn numbers(&self) -> usize {
        match self {
            Change::Times(_, None) => 1,
            Change::Shifted(places) | Change::Warmer(places) => {
                places.iter().filter_map(|(_, place)| Some((*place)? + 1)).max().unwrap_or(0)
            }
            _ => 0,
        }
    }

    /// Shifted axes, each with the place of its number.
    pub(super) fn shifts(&self) -> Vec<(Axis, usize)> {
        let Change::Shifted(places) = self else { return Vec::new() };
        places.iter().filter_map(|(axis, place)| Some((axis, (*place)?))).collect()
    }

    /// Whether another one is a special case of it, with fewer fitted numbers.
    pub(super) fn contains(&self, other: &Change) -> bool {
        use Change::{Shifted, Times, Warmer};
        let is_alike = match (self, other) {
            (Times(own, _), Times(terms, _)) => own == terms,
            (Shifted(_), Shifted(_)) | (Warmer(_), Warmer(_)) => true,
            _ => false,
        };
        is_alike && self.numbers() > other.numbers()
    }

    /// Whether both concern the same tables of the kit.
    pub(super) fn is_the_same_on(&self, question: &Question<'_>, other: &Change) -> bool {
        let terms = |change: &Change| match change {
            Change::Times(scope, _) | Change::Old(scope) => Some(scope.clone()),
            Change::Ways(scope, [plus, minus]) if plus != minus => Some(scope.clone()),
            Change::OldBeside(terms) => Some(Scope::tables(terms.clone())),
            _ => None,
        };
        let (Some(own), Some(others)) = (terms(self), terms(other)) else { return false };
        let mut all = own.terms.iter().zip(others.terms.iter());
        let has_table = |term| question.control.has_table(term) || question.old.has_table(term);
        own.parameters == others.parameters
            && all.all(|((term, a), (_, b))| a == b || !has_table(term))
    }

    /// Whether its fitted numbers can be: no workshop is 20 K off.
    pub(super) fn is_plausible(&self, fitted: &[f64]) -> bool {
        !matches!(self, Change::Warmer(_)) || fitted.iter().all(|k| k.abs() <= MOST_KELVIN)
    }

    /// What shows on the machine where a part looks, beside the deviation as found, µm: what the control
    /// adds with this change; and what the temperature adds to the machine, or a turned sign or a slip
    /// of the records to a measurement.
    pub(super) fn effect(
        &self,
        question: &Question<'_>,
        fitted: &[f64],
        part: &SeenDeviation,
    ) -> [f64; 2] {
        let (term, way, at) = (part.term, part.direction, part.at.mm());
        let control = question.control;
        let tables = |term, way, mm| control.tables_um(term, way, Millimetres::new(mm));
        let by = |field: &Field, way| {
            [field.tables_um(term, way, part.at), field.constant_um(term, way)]
        };
        let acting = by(control, way);
        let [own, constant] = acting;
        let planned = own + constant;
        let added = match self {
            Change::Times(scope, factor) => {
                let factor = factor.unwrap_or_else(|| number(fitted, Some(0)));
                scope.changed_um(term, acting, acting.map(|um| factor * um))
            }
            Change::SecondTurned => constant,
            Change::Unit(factor) => factor * tables(term, way, at / factor) + constant,
            Change::Shifted(places) => {
                tables(term, way, at - number(fitted, places[term.along])) + constant
            }
            Change::From(terms) => tables(terms[term], way, at) + constant,
            Change::Ways(scope, [plus, minus]) if control.has_two_tables(term) => {
                let other = if way == Direction::Plus { plus } else { minus };
                scope.changed_um(term, acting, by(control, *other))
            }
            Change::BacklashTwice(terms) if terms[term] => planned + question.parameter_um(part),
            Change::Old(scope) => scope.changed_um(term, acting, by(question.old, way)),
            Change::OldBeside(terms) if terms[term] => planned + by(question.old, way)[0],
            _ => planned,
        };
        // What was seen was measured both times; a part of it always has a deviation.
        let deviation = |model| before_um(model, part).unwrap_or(0.0);
        let beside = match self {
            Change::FirstTurned => {
                -2.0 * deviation(question.under_tables.unwrap_or(question.before))
            }
            // The opposite of what is there: as found, and what acts in addition to the tables.
            Change::SecondTurned => -2.0 * (deviation(question.before) + constant),
            Change::Recorded(place) => {
                deviation(&question.corrected[*place].before) - deviation(question.before)
            }
            // K · α · (position − reference); a scale with α = 0 does not grow.
            Change::Warmer(places) => {
                let kelvin = number(fitted, places[term.along]);
                question.grown_um(part, question.um_per_m(term.along, kelvin))
            }
            _ => 0.0,
        };
        [added, beside]
    }
}

/// A fitted number; 0 where there is none.
pub(super) fn number(fitted: &[f64], place: Option<usize>) -> f64 {
    place.and_then(|place| fitted.get(place)).copied().unwrap_or(0.0)
}

// What is known when a cause is asked for.

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
        let pairs = Diagonal::ALL.into_iter().enumerate().flat_map(|(index, one)| {
            Diagonal::ALL.into_iter().skip(index + 1).map(move |other| Slip::Names(one, other))
        });
        let others = Axis::ORDERS.into_iter().filter(|order| *order != recorded);
        pairs.chain(others.map(Slip::Order)).collect()
    }
}

/// What the first readings are once a slip is taken back.
#[derive(Clone, Debug)]
pub struct WithoutSlip {
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
    /// What these added.
    pub old: &'a Field,
    /// The same readings with one slip of their records taken back; empty = none is tried.
    pub corrected: &'a [WithoutSlip],
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
    pub(super) fn parts(&self) -> impl Iterator<Item = &SeenDeviation> {
        self.seen.iter().flat_map(|observation| &observation.parts)
    }

    /// The terms that it sees.
    pub(super) fn terms(&self) -> Vec<ErrorTerm> {
        let seen = |term: &ErrorTerm| self.parts().any(|part| part.term == *term);
        ErrorTerm::ALL.into_iter().filter(seen).collect()
    }

    /// What the first measurement may have missed where a part looks, µm: what a straight line and a spline through its
    /// targets differ by, nothing at a target.
    pub(super) fn unseen_um(&self, part: &SeenDeviation) -> f64 {
        let measured = self.under_tables.unwrap_or(self.before).terms[part.term].as_ref();
        measured.and_then(|term| term.measured.curve(part.direction)).map_or(0.0, |curve| {
            const NEAR: usize = 4; // farther targets bend a spline by less than a hundredth
            let knots = curve.knots();
            let place = knots.partition_point(|knot| *knot < part.at);
            let near = &knots[place.saturating_sub(NEAR)..knots.len().min(place + NEAR)];
            let values: Vec<_> = near.iter().map(|at| curve.at(*at)).collect();
            let by = |kind| ErrorCurve::through(near, &values, kind).at(part.at);
            (by(Interpolation::NaturalSpline) - by(Interpolation::Linear)).um().abs()
        })
    }

    /// Growth of a scale that is this much warmer, µm/m.
    pub(super) fn um_per_m(&self, axis: Axis, kelvin: f64) -> f64 {
        kelvin * self.alpha_per_k[axis] * 1e6
    }

    /// What a positioning error gains where its scale is longer by so much, µm; a cross term gains nothing.
    pub(super) fn grown_um(&self, part: &SeenDeviation, um_per_m: f64) -> f64 {
        let from_zero = part.at.mm() - self.reference_mm[part.term.along];
        if part.term.is_positioning() { um_per_m * from_zero / 1000.0 } else { 0.0 }
    }

    /// What a backlash parameter of −B as found adds to a positioning error, µm: it acts away from the
    /// reference direction; 0 where B was not measured.
    pub(super) fn parameter_um(&self, part: &SeenDeviation) -> f64 {
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
