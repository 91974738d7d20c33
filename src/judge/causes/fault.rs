//! The faults that are tried, and what each makes of the corrections.

use super::question::{Question, Slip};
use crate::judge::after::{Part, before_um};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::units::Millimetres;

/// Which tables a fault concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    /// All of them.
    All,
    /// The positioning tables (pitch error, ENC_COMP).
    Positioning,
    /// The tables of the cross terms (straightness, CEC).
    Cross,
    /// Those looked up along this axis.
    Along(Axis),
    /// Those that correct this axis.
    Of(Axis),
    /// Those of one term.
    Term(ErrorTerm),
}

impl Scope {
    /// All scopes, the widest first.
    pub(super) fn all() -> Vec<Scope> {
        let wide = [Scope::All, Scope::Positioning, Scope::Cross];
        let along = Axis::ALL.map(Scope::Along);
        let of = Axis::ALL.map(Scope::Of);
        let terms = ErrorTerm::ALL.map(Scope::Term);
        [&wide[..], &along, &of, &terms].concat()
    }

    /// Whether a term's tables belong to it.
    pub(super) fn holds(self, term: ErrorTerm) -> bool {
        match self {
            Scope::All => true,
            Scope::Positioning => term.is_positioning(),
            Scope::Cross => term.is_cross(),
            Scope::Along(axis) => term.along == axis,
            Scope::Of(axis) => term.of == axis,
            Scope::Term(own) => term == own,
        }
    }
}

/// For each axis the place of its number among those that are fitted; `None` = it is left alone.
pub(super) type Fitted = PerAxis<Option<usize>>;

/// What a fault does.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Act {
    /// Nothing: all is as the forecast says.
    AsForecast,
    /// The tables act with a factor: −1 sign turned, 0 not active, 2 twice, 1000, 25.4 …; `None` =
    /// fitted.
    Times(Scope, Option<f64>),
    /// Neither tables nor backlash parameters act.
    Nothing,
    /// Positions and values are read in another unit: f·T(x/f).
    Unit(f64),
    /// The tables of an axis act s mm further in +, fitted.
    Shifted(Fitted),
    /// On a term acts the table that was made for another one.
    From(Box<PerTerm<ErrorTerm>>),
    /// Moving + and − the tables act that were made for these directions.
    Ways(Scope, [Direction; 2]),
    /// A backlash parameter acts once more than planned.
    BacklashTwice(Scope),
    /// The backlash parameter that the job asks for is 0.
    BacklashNot(Scope),
    /// The tables that were active while measuring act, instead of the new ones or beside them.
    Old { beside: bool },
    /// The first measurement has the wrong sign, so the tables have it too.
    FirstTurned,
    /// The tables do not act, and the second measurement has the wrong sign.
    SecondTurned,
    /// The first measurement was recorded wrongly, so the tables are those of another machine.
    Recorded(Slip),
    /// Scales are warmer or colder by some K, fitted.
    Warmer(Fitted),
}

/// One fault: what it does, and how it is said.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    /// Its kind, one of the words of docs/verify.md.
    pub(super) kind: &'static str,
    pub(super) act: Act,
    /// Whom it concerns.
    pub(super) subject: String,
    /// What happened to it, and what it usually comes from; fitted numbers are put in later.
    pub(super) predicate: String,
    /// Its label beside others of its kind.
    pub(super) label: String,
}

/// What a part sees, without any fault.
#[derive(Clone, Copy)]
pub(super) struct Planned {
    pub(super) tables: f64,
    pub(super) constant: f64,
}

impl Planned {
    pub(super) fn of(question: &Question<'_>, part: &Part) -> Planned {
        let control = question.control;
        Planned {
            tables: control.tables_um(part.term, part.direction, part.at),
            constant: control.constant_um(part.term, part.direction),
        }
    }
}

/// A scale error of more than this is no temperature of a workshop, K.
const MOST_KELVIN: f64 = 20.0;

impl Fault {
    /// All is as the forecast says.
    pub(super) fn none() -> Fault {
        Fault {
            kind: "as forecast",
            act: Act::AsForecast,
            subject: String::new(),
            predicate: String::new(),
            label: String::new(),
        }
    }

    /// Its place among causes that the data cannot tell apart: what happens often stands first.
    pub(super) fn rank(&self) -> usize {
        const USUAL_FIRST: [&str; 14] = [
            "not active",
            "old tables active",
            "sign turned",
            "old beside new",
            "applied twice",
            "backlash not",
            "backlash twice",
            "directions exchanged",
            "wrong axis",
            "shifted",
            "temperature",
            "names exchanged",
            "wrong order",
            "measurement turned",
        ];
        let place = USUAL_FIRST.iter().position(|kind| *kind == self.kind);
        place.unwrap_or(USUAL_FIRST.len())
    }

    /// Whether two faults of one kind concern the same tables of the kit.
    pub(super) fn is_the_same_on(&self, question: &Question<'_>, other: &Fault) -> bool {
        let scope = |fault: &Fault| match fault.act {
            Act::Times(scope, _) => Some(scope),
            Act::Ways(scope, [plus, minus]) if plus != minus => Some(scope),
            _ => None,
        };
        let (Some(own), Some(others)) = (scope(self), scope(other)) else {
            return false;
        };
        let terms = ErrorTerm::ALL.into_iter();
        let mut tabled = terms.filter(|term| question.control.has_table(*term));
        tabled.all(|term| own.holds(term) == others.holds(term))
    }

    /// How many numbers are fitted.
    pub(super) fn numbers(&self) -> usize {
        match &self.act {
            Act::Times(_, None) => 1,
            Act::Shifted(fitted) | Act::Warmer(fitted) => {
                let places = fitted.iter().filter_map(|(_, place)| *place);
                places.max().map_or(0, |last| last + 1)
            }
            _ => 0,
        }
    }

    /// Whether another fault is a special case of this one, with fewer fitted numbers.
    pub(super) fn contains(&self, other: &Fault) -> bool {
        let is_alike = match (&self.act, &other.act) {
            (Act::Times(own, _), Act::Times(scope, _)) => own == scope,
            (Act::Shifted(_), Act::Shifted(_)) | (Act::Warmer(_), Act::Warmer(_)) => true,
            _ => false,
        };
        is_alike && self.numbers() > other.numbers()
    }

    /// Whether its fitted numbers can be: no workshop is 20 K off.
    pub(super) fn is_plausible(&self, fit: &Fit) -> bool {
        let is_off = |kelvin: &f64| kelvin.abs() > MOST_KELVIN;
        !matches!(self.act, Act::Warmer(_)) || !fit.fitted.iter().any(is_off)
    }

    /// What shows on the machine where a part looks, beside the deviation as found: the
    /// corrections with this fault, and what comes from elsewhere; µm.
    pub(super) fn effect(
        &self,
        question: &Question<'_>,
        fitted: &[f64],
        part: &Part,
        planned: Planned,
    ) -> f64 {
        self.correction(question, fitted, part, planned)
            + self.beside(question, fitted, part, planned)
    }

    /// What the control adds with this fault, µm.
    pub(super) fn correction(
        &self,
        question: &Question<'_>,
        fitted: &[f64],
        part: &Part,
        planned: Planned,
    ) -> f64 {
        let Planned { tables, constant } = planned;
        let Part { term, direction, at, .. } = *part;
        let mm = |mm: f64| question.control.tables_um(term, direction, Millimetres::new(mm));
        let old = || question.old_um(part).unwrap_or(0.0);
        match &self.act {
            Act::Times(scope, factor) if scope.holds(term) => {
                factor.unwrap_or_else(|| number(fitted, Some(0))) * tables + constant
            }
            Act::Nothing => 0.0,
            Act::SecondTurned => constant,
            Act::Unit(factor) => factor * mm(at.mm() / factor) + constant,
            Act::Shifted(places) if places[term.along].is_some() => {
                mm(at.mm() - number(fitted, places[term.along])) + constant
            }
            Act::From(terms) if terms[term] != term => {
                question.control.tables_um(terms[term], direction, at) + constant
            }
            Act::Ways(scope, [plus, minus]) if scope.holds(term) => {
                let way = if direction == Direction::Plus { plus } else { minus };
                question.control.tables_um(term, *way, at) + constant
            }
            Act::BacklashTwice(scope) if scope.holds(term) => {
                tables + constant + question.parameter_um(term.along, direction)
            }
            Act::BacklashNot(scope) if scope.holds(term) => tables,
            Act::Old { beside: false } => old(),
            Act::Old { beside: true } => tables + constant + old(),
            _ => tables + constant,
        }
    }

    /// What the temperature adds to the machine, or a turned sign or a slip of the records to a
    /// measurement, µm.
    fn beside(
        &self,
        question: &Question<'_>,
        fitted: &[f64],
        part: &Part,
        planned: Planned,
    ) -> f64 {
        // What was seen was measured both times; a part of it always has a deviation.
        let deviation = |model| before_um(model, part).unwrap_or(0.0);
        match &self.act {
            Act::FirstTurned => -2.0 * deviation(question.found()),
            // The opposite of what is there: as found, and what acts in addition to the tables.
            Act::SecondTurned => -2.0 * (deviation(question.before) + planned.constant),
            Act::Recorded(slip) => {
                let mut all = question.corrected.iter();
                let own = all.find(|corrected| corrected.slip == *slip);
                // Only what answers everywhere is tried.
                own.and_then(|own| own.beyond_um(question, part)).unwrap_or(0.0)
            }
            // K · α · (position − reference); a scale with α = 0 does not grow.
            Act::Warmer(places) => {
                let along = part.term.along;
                let um_per_m = question.um_per_m(along, number(fitted, places[along]));
                question.grown_um(part, um_per_m)
            }
            _ => 0.0,
        }
    }
}

/// A fitted number; 0 where there is none.
pub(super) fn number(fitted: &[f64], place: Option<usize>) -> f64 {
    place.and_then(|place| fitted.get(place)).copied().unwrap_or(0.0)
}

/// A fault, fitted.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) fitted: Vec<f64>,
    /// Predicted values, µm, less their own zeros.
    pub(super) predicted_um: Vec<f64>,
    pub(super) residuals_um: Vec<f64>,
}

impl Fit {
    /// Largest difference of two predictions, µm.
    pub(super) fn differs_from(&self, other: &Fit) -> f64 {
        let pairs = self.predicted_um.iter().zip(&other.predicted_um);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}
