//! The changes that are tried, and what each makes of the corrections.

use super::question::Question;
use crate::judge::after::{Part, before_um};
use crate::quantity::{Axis, Direction, ErrorTerm, Millimetres, PerAxis, PerTerm};

/// The terms whose tables a change concerns.
pub(super) type Terms = PerTerm<bool>;

/// For each axis the place of its number among those that are fitted; `None` = it is left alone.
pub(super) type Fitted = PerAxis<Option<usize>>;

/// What happens to the tables, or to a measurement.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Change {
    /// Nothing: all is as the forecast says.
    None,
    /// The tables act with a factor: −1 sign turned, 0 not active, 2 twice, 1000, 25.4 …; `None` =
    /// fitted.
    Times(Terms, Option<f64>),
    /// Neither tables nor backlash parameters act.
    Inactive,
    /// Positions and values are read in another unit: f·T(x/f).
    Unit(f64),
    /// The tables of an axis act s mm further in +, fitted.
    Shifted(Fitted),
    /// On a term acts the table that was made for another one.
    From(Box<PerTerm<ErrorTerm>>),
    /// Moving + and − the tables act that were made for these directions.
    Ways(Terms, [Direction; 2]),
    /// A backlash parameter acts once more than planned.
    BacklashTwice(Terms),
    /// The backlash parameter that the job asks for is 0.
    BacklashNot(Terms),
    /// The tables that were active while measuring act, instead of the new ones or beside them.
    Old { beside: bool },
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
            Change::Times(terms, _) => Some(terms.clone()),
            Change::Ways(terms, [plus, minus]) if plus != minus => Some(terms.clone()),
            _ => None,
        };
        let (Some(own), Some(others)) = (terms(self), terms(other)) else { return false };
        let mut all = own.iter().zip(others.iter());
        all.all(|((term, a), (_, b))| a == b || !question.control.has_table(term))
    }

    /// Whether its fitted numbers can be: no workshop is 20 K off.
    pub(super) fn is_plausible(&self, fitted: &[f64]) -> bool {
        !matches!(self, Change::Warmer(_)) || fitted.iter().all(|k| k.abs() <= MOST_KELVIN)
    }

    /// What shows on the machine where a part looks, beside the deviation as found, µm: what the control
    /// adds with this change; and what the temperature adds to the machine, or a turned sign or a slip
    /// of the records to a measurement.
    pub(super) fn effect(&self, question: &Question<'_>, fitted: &[f64], part: &Part) -> [f64; 2] {
        let (term, way, at) = (part.term, part.direction, part.at.mm());
        let control = question.control;
        let tables = |term, way, mm| control.tables_um(term, way, Millimetres::new(mm));
        let (own, constant) = (tables(term, way, at), control.constant_um(term, way));
        let planned = own + constant;
        let added = match self {
            Change::Times(terms, factor) if terms[term] => {
                factor.unwrap_or_else(|| number(fitted, Some(0))) * own + constant
            }
            Change::Inactive => 0.0,
            Change::SecondTurned => constant,
            Change::Unit(factor) => factor * tables(term, way, at / factor) + constant,
            Change::Shifted(places) => {
                tables(term, way, at - number(fitted, places[term.along])) + constant
            }
            Change::From(terms) => tables(terms[term], way, at) + constant,
            Change::Ways(terms, [plus, minus]) if terms[term] => {
                let way = if way == Direction::Plus { plus } else { minus };
                tables(term, *way, at) + constant
            }
            Change::BacklashTwice(terms) if terms[term] => planned + question.parameter_um(part),
            Change::BacklashNot(terms) if terms[term] => own,
            Change::Old { beside: false } => question.old_um(part),
            Change::Old { beside: true } => planned + question.old_um(part),
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
