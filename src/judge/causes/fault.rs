//! The faults that are tried, and what each makes of the corrections.

use super::question::{Question, deviation_um};
use super::records::beyond_um;
use crate::judge::after::Part;
use crate::judge::causes::corrected::Slip;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::units::Millimetres;

/// Which tables a fault concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
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
    pub fn all() -> Vec<Scope> {
        let wide = [Scope::All, Scope::Positioning, Scope::Cross];
        let along = Axis::ALL.map(Scope::Along);
        let of = Axis::ALL.map(Scope::Of);
        let terms = ErrorTerm::ALL.map(Scope::Term);
        [&wide[..], &along, &of, &terms].concat()
    }

    /// Whether a term's tables belong to it.
    pub fn holds(self, term: ErrorTerm) -> bool {
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

/// One fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// All is as the forecast says.
    None,
    /// The tables act with a known factor: −1 sign turned, 0 not active, 2 twice, 1000, 25.4 …
    Times(Scope, f64),
    /// The tables act with some other factor, which is fitted.
    Factor(Scope),
    /// Neither tables nor backlash parameters act.
    Nothing,
    /// Positions and values are read in another unit: f·T(x/f).
    Unit(f64),
    /// The tables of this axis (`None` = of every axis) act s mm further in +, fitted.
    Shifted(Option<Axis>),
    /// The tables made for the axes X, Y, Z act on these axes instead.
    Exchanged(Scope, [Axis; 3]),
    /// Base and corrected axis of every cross term are exchanged (EYX acts as EXY).
    Transposed,
    /// The tables of two terms are exchanged.
    Pair(ErrorTerm, ErrorTerm),
    /// The tables for + and − act in the other direction.
    DirectionsTurned(Scope),
    /// A backlash parameter acts once more than planned.
    BacklashTwice(Option<Axis>),
    /// The backlash parameter that the job asks for is 0.
    BacklashNot(Option<Axis>),
    /// The table made for this direction acts in both.
    OneTable(Option<Axis>, Direction),
    /// The tables that were active while measuring still act, the new ones do not.
    OldTables,
    /// They act beside the new ones.
    OldBeside,
    /// The first measurement has the wrong sign, so the tables have it too.
    FirstTurned,
    /// The tables do not act, and the second measurement has the wrong sign.
    SecondTurned,
    /// The first measurement was recorded wrongly, so the tables are those of another machine.
    Recorded(Slip),
    /// The scales of all axes are warmer or colder by the same K.
    Temperature,
    /// The scale of one axis is.
    TemperatureOf(Axis),
    /// Every scale by its own K.
    TemperatureEach,
}

/// What a part sees, without any fault.
#[derive(Clone, Copy)]
pub(super) struct Planned {
    pub(super) tables: f64,
    pub(super) constant: f64,
}

impl Fault {
    /// Its kind, one of the words of docs/verify.md.
    pub fn kind(&self) -> &'static str {
        match self {
            Fault::None => "as forecast",
            Fault::Times(_, factor) if *factor < 0.0 => "sign turned",
            Fault::Times(_, factor) if *factor == 0.0 => "not active",
            Fault::Nothing => "not active",
            Fault::Times(_, factor) if (*factor - 2.0).abs() < 1e-12 => "applied twice",
            Fault::Times(..) | Fault::Unit(_) => "wrong unit",
            Fault::Factor(_) => "other factor",
            Fault::Shifted(_) => "shifted",
            Fault::Exchanged(..) | Fault::Transposed | Fault::Pair(..) => "wrong axis",
            Fault::DirectionsTurned(_) => "directions exchanged",
            Fault::BacklashTwice(_) => "backlash twice",
            Fault::BacklashNot(_) | Fault::OneTable(..) => "backlash not",
            Fault::OldTables => "old tables active",
            Fault::OldBeside => "old beside new",
            Fault::FirstTurned | Fault::SecondTurned => "measurement turned",
            Fault::Recorded(slip) => slip.kind(),
            Fault::Temperature | Fault::TemperatureOf(_) | Fault::TemperatureEach => "temperature",
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
        let place = USUAL_FIRST.iter().position(|kind| *kind == self.kind());
        place.unwrap_or(USUAL_FIRST.len())
    }

    /// Sorts the faults of one kind, the widest first.
    pub(super) fn breadth(&self) -> usize {
        let scopes = Scope::all();
        let of = |scope: &Scope| scopes.iter().position(|s| s == scope).unwrap_or_default();
        match self {
            Fault::Times(scope, _) | Fault::Factor(scope) | Fault::DirectionsTurned(scope) => {
                of(scope) + 1
            }
            Fault::Exchanged(scope, _) => of(scope),
            Fault::Pair(..) => scopes.len(),
            Fault::Shifted(axis)
            | Fault::BacklashTwice(axis)
            | Fault::BacklashNot(axis)
            | Fault::OneTable(axis, _) => usize::from(axis.is_some()),
            _ => 0,
        }
    }

    fn scope(&self) -> Option<Scope> {
        match self {
            Fault::Times(scope, _) | Fault::Factor(scope) | Fault::DirectionsTurned(scope) => {
                Some(*scope)
            }
            _ => None,
        }
    }

    /// Whether two faults of one kind concern the same tables of the kit.
    pub(super) fn is_the_same_on(&self, question: &Question<'_>, other: &Fault) -> bool {
        let (Some(own), Some(others)) = (self.scope(), other.scope()) else {
            return false;
        };
        let mut tabled = ErrorTerm::ALL
            .into_iter()
            .filter(|term| question.control.has_table(*term));
        tabled.all(|term| own.holds(term) == others.holds(term))
    }

    /// How many numbers are fitted.
    pub(super) fn parameters(&self) -> usize {
        match self {
            Fault::Factor(_)
            | Fault::Temperature
            | Fault::TemperatureOf(_)
            | Fault::Shifted(Some(_)) => 1,
            Fault::TemperatureEach | Fault::Shifted(None) => 3,
            _ => 0,
        }
    }

    /// Whether another fault is a special case of this one, with fewer fitted numbers.
    pub(super) fn contains(&self, other: &Fault) -> bool {
        match (self, other) {
            (Fault::Factor(own), Fault::Times(scope, _)) => own == scope,
            (Fault::Shifted(None), Fault::Shifted(Some(_))) => true,
            (Fault::TemperatureEach, Fault::Temperature | Fault::TemperatureOf(_)) => true,
            _ => false,
        }
    }

    /// Whether its fitted numbers can be: no workshop is 20 K off.
    pub(super) fn is_plausible(&self, fit: &Fit) -> bool {
        match self {
            Fault::Temperature | Fault::TemperatureOf(_) | Fault::TemperatureEach => {
                fit.fitted.iter().all(|kelvin| kelvin.abs() <= MOST_KELVIN)
            }
            _ => true,
        }
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
        let number = || fitted.first().copied().unwrap_or(0.0);
        let tables_of =
            |term: ErrorTerm| question.control.tables_um(term, part.direction, part.at) + constant;
        match self {
            Fault::Times(scope, factor) if scope.holds(part.term) => factor * tables + constant,
            Fault::Factor(scope) if scope.holds(part.term) => number() * tables + constant,
            Fault::Nothing => 0.0,
            Fault::SecondTurned => constant,
            Fault::Unit(factor) => {
                let at = Millimetres::new(part.at.mm() / factor);
                factor * question.control.tables_um(part.term, part.direction, at) + constant
            }
            Fault::Shifted(axis) => self.shifted(question, *axis, fitted, part, planned),
            Fault::Exchanged(scope, map) if scope.holds(part.term) => {
                tables_of(came_from(map, part.term))
            }
            Fault::Transposed if part.term.is_cross() => tables_of(ErrorTerm {
                of: part.term.along,
                along: part.term.of,
            }),
            Fault::Pair(one, two) if part.term == *one => tables_of(*two),
            Fault::Pair(one, two) if part.term == *two => tables_of(*one),
            Fault::DirectionsTurned(scope) if scope.holds(part.term) => {
                let other = part.direction.opposite();
                question.control.tables_um(part.term, other, part.at) + constant
            }
            Fault::BacklashTwice(axis) if concerns(*axis, part.term) => {
                tables + constant + question.parameter_um(part.term.along, part.direction)
            }
            Fault::BacklashNot(axis) if concerns(*axis, part.term) => tables,
            Fault::OneTable(axis, way) if concerns(*axis, part.term) => {
                question.control.tables_um(part.term, *way, part.at) + constant
            }
            Fault::OldTables => question.old_um(part).unwrap_or(0.0),
            Fault::OldBeside => tables + constant + question.old_um(part).unwrap_or(0.0),
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
        let number = |at: usize| fitted.get(at).copied().unwrap_or(0.0);
        let along = part.term.along;
        // What was seen was measured both times; a part of it always has a deviation.
        let deviation = |model| deviation_um(model, part).unwrap_or(0.0);
        match self {
            Fault::FirstTurned => -2.0 * deviation(question.found()),
            // The opposite of what is there: as found, and what acts beside the tables.
            Fault::SecondTurned => -2.0 * (deviation(question.before) + planned.constant),
            Fault::Recorded(slip) => beyond_um(question, *slip, part),
            Fault::Temperature => expansion(question, part, number(0)),
            Fault::TemperatureOf(axis) if along == *axis => expansion(question, part, number(0)),
            Fault::TemperatureEach => {
                let own = Axis::ALL.iter().position(|axis| *axis == along);
                expansion(question, part, number(own.unwrap_or_default()))
            }
            _ => 0.0,
        }
    }

    fn shifted(
        &self,
        question: &Question<'_>,
        axis: Option<Axis>,
        fitted: &[f64],
        part: &Part,
        planned: Planned,
    ) -> f64 {
        let along = part.term.along;
        let own = Axis::ALL
            .iter()
            .position(|other| *other == along)
            .unwrap_or_default();
        let mm = match axis {
            None => fitted.get(own),
            Some(axis) if axis == along => fitted.first(),
            Some(_) => None,
        };
        match mm {
            None => planned.tables + planned.constant,
            Some(mm) => {
                let at = Millimetres::new(part.at.mm() - mm);
                question.control.tables_um(part.term, part.direction, at) + planned.constant
            }
        }
    }
}

fn concerns(axis: Option<Axis>, term: ErrorTerm) -> bool {
    term.is_positioning() && axis.is_none_or(|axis| axis == term.along)
}

/// A warmer scale of a positioning term: K · α · (position − reference), µm. A scale with α = 0
/// does not grow.
fn expansion(question: &Question<'_>, part: &Part, kelvin: f64) -> f64 {
    if part.term.is_positioning() {
        question.um_per_m(part.term.along, kelvin)
            * (part.at.mm() - question.reference_mm[part.term.along])
            / 1000.0
    } else {
        0.0
    }
}

/// The term whose tables act on `term` when those of X, Y, Z act on `map` instead.
pub(super) fn came_from(map: &[Axis; 3], term: ErrorTerm) -> ErrorTerm {
    let back = |axis: Axis| {
        let own = map.iter().position(|to| *to == axis);
        own.map_or(axis, |own| Axis::ALL[own])
    };
    ErrorTerm {
        of: back(term.of),
        along: back(term.along),
    }
}

/// A scale error of more than this is no temperature of a workshop, K.
const MOST_KELVIN: f64 = 20.0;

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
