//! The faults that are tried, and what each makes of the corrections.

use super::MOST_KELVIN;
use super::data::{Data, Fit};
use super::question::Question;
use crate::after::Part;
use crate::axis::{Axis, ErrorTerm};
use crate::units::{MM_PER_INCH, Millimetres};

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
    /// The reversal is not compensated.
    BacklashNot(Option<Axis>),
    /// The scales of all axes are warmer or colder by the same amount.
    Temperature,
    /// The scale of one axis is.
    TemperatureOf(Axis),
    /// Every scale by its own amount.
    TemperatureEach,
}

/// Known factors beside −1, 0 and 2.
const UNIT_FACTORS: [f64; 4] = [1000.0, 1.0 / 1000.0, MM_PER_INCH, 1.0 / MM_PER_INCH];

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
            Fault::BacklashNot(_) => "backlash not",
            Fault::Temperature | Fault::TemperatureOf(_) | Fault::TemperatureEach => "temperature",
        }
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
            Fault::Shifted(axis) | Fault::BacklashTwice(axis) | Fault::BacklashNot(axis) => {
                usize::from(axis.is_some())
            }
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
    pub(super) fn is_plausible(&self, data: &Data<'_>, fit: &Fit) -> bool {
        let alpha = data.question.alpha_per_k;
        let kelvin = |axis: Axis, slope: f64| slope / (alpha[axis] * 1e6);
        let of = |axis: Axis, at: usize| {
            let slope = fit.fitted.get(at).copied().unwrap_or(0.0);
            kelvin(axis, slope).abs() <= MOST_KELVIN
        };
        match self {
            Fault::Temperature => of(Axis::X, 0),
            Fault::TemperatureOf(axis) => of(*axis, 0),
            Fault::TemperatureEach => Axis::ALL
                .into_iter()
                .enumerate()
                .all(|(at, axis)| of(axis, at)),
            _ => true,
        }
    }

    /// What acts on the machine where a part looks: corrections with this fault, plus what the
    /// temperature adds; µm.
    pub(super) fn effect(
        &self,
        question: &Question<'_>,
        fitted: &[f64],
        part: &Part,
        planned: Planned,
    ) -> f64 {
        let Planned { tables, constant } = planned;
        let number = |at: usize| fitted.get(at).copied().unwrap_or(0.0);
        match self {
            Fault::Times(scope, factor) if scope.holds(part.term) => factor * tables + constant,
            Fault::Factor(scope) if scope.holds(part.term) => number(0) * tables + constant,
            Fault::Nothing => 0.0,
            Fault::Unit(factor) => {
                let at = Millimetres::new(part.at.mm() / factor);
                factor * question.control.tables_um(part.term, part.direction, at) + constant
            }
            Fault::Shifted(axis) => self.shifted(question, *axis, fitted, part, planned),
            Fault::Exchanged(scope, map) if scope.holds(part.term) => {
                question
                    .control
                    .tables_um(came_from(map, part.term), part.direction, part.at)
                    + constant
            }
            Fault::Transposed if part.term.is_cross() => {
                let other = ErrorTerm {
                    of: part.term.along,
                    along: part.term.of,
                };
                question.control.tables_um(other, part.direction, part.at) + constant
            }
            Fault::Pair(one, two) if part.term == *one || part.term == *two => {
                let other = if part.term == *one { *two } else { *one };
                question.control.tables_um(other, part.direction, part.at) + constant
            }
            Fault::DirectionsTurned(scope) if scope.holds(part.term) => {
                question
                    .control
                    .tables_um(part.term, part.direction.opposite(), part.at)
                    + constant
            }
            Fault::BacklashTwice(axis) if concerns(*axis, part.term) => {
                tables + constant + question.parameter_um(part.term.along, part.direction)
            }
            Fault::BacklashNot(axis) if concerns(*axis, part.term) => {
                question.without_reversal_um(part)
            }
            Fault::Temperature => {
                tables
                    + constant
                    + expansion(
                        question,
                        part,
                        number(0) * question.alpha_per_k[part.term.along] / question.alpha_per_k.x,
                    )
            }
            Fault::TemperatureOf(axis) if part.term.along == *axis => {
                tables + constant + expansion(question, part, number(0))
            }
            Fault::TemperatureEach => {
                let own = Axis::ALL.iter().position(|axis| *axis == part.term.along);
                tables + constant + expansion(question, part, number(own.unwrap_or_default()))
            }
            _ => tables + constant,
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

/// A scale error of a positioning term: slope (µm/m) · (position − reference).
fn expansion(question: &Question<'_>, part: &Part, um_per_m: f64) -> f64 {
    if part.term.is_positioning() {
        um_per_m * (part.at.mm() - question.reference_mm[part.term.along]) / 1000.0
    } else {
        0.0
    }
}

/// The term whose tables act on `term` when those of X, Y, Z act on `map` instead.
fn came_from(map: &[Axis; 3], term: ErrorTerm) -> ErrorTerm {
    let back = |axis: Axis| {
        let own = map.iter().position(|to| *to == axis);
        own.map_or(axis, |own| Axis::ALL[own])
    };
    ErrorTerm {
        of: back(term.of),
        along: back(term.along),
    }
}

/// Every fault that can show in the data of a question.
pub(super) fn all_faults(question: &Question<'_>) -> Vec<Fault> {
    let tabled = |term: ErrorTerm| question.control.has_table(term);
    let shows = |scope: Scope| {
        question
            .terms()
            .into_iter()
            .any(|term| scope.holds(term) && tabled(term))
    };
    let mut faults = Vec::new();
    for scope in Scope::all().into_iter().filter(|scope| shows(*scope)) {
        for factor in [-1.0, 0.0, 2.0].into_iter().chain(UNIT_FACTORS) {
            faults.push(Fault::Times(scope, factor));
        }
        faults.push(Fault::Factor(scope));
        if question.has_two_tables() {
            faults.push(Fault::DirectionsTurned(scope));
        }
    }
    faults.extend([MM_PER_INCH, 1.0 / MM_PER_INCH].map(Fault::Unit));
    faults.extend(axis_faults(question));
    faults.extend(
        exchanges()
            .into_iter()
            .filter(|fault| acts_elsewhere(question, fault)),
    );
    faults.extend([Fault::Temperature, Fault::TemperatureEach]);
    if question.has_parameter() {
        faults.push(Fault::Nothing);
    }
    faults
}

fn axis_faults(question: &Question<'_>) -> Vec<Fault> {
    let mut faults = vec![Fault::Shifted(None)];
    let axes: Vec<Option<Axis>> = [None].into_iter().chain(Axis::ALL.map(Some)).collect();
    faults.extend(Axis::ALL.map(|axis| Fault::Shifted(Some(axis))));
    faults.extend(Axis::ALL.map(Fault::TemperatureOf));
    for axis in axes {
        faults.push(Fault::BacklashTwice(axis));
        faults.push(Fault::BacklashNot(axis));
    }
    let positioned = question.terms();
    let has = |axis: Axis| {
        positioned.contains(&ErrorTerm {
            of: axis,
            along: axis,
        })
    };
    faults.retain(|fault| match fault {
        Fault::TemperatureOf(axis) => has(*axis),
        Fault::BacklashTwice(axis) | Fault::BacklashNot(axis) => question.shows_reversal(*axis),
        Fault::Shifted(Some(axis)) => positioned.iter().any(|term| term.along == *axis),
        _ => true,
    });
    faults
}

fn exchanges() -> Vec<Fault> {
    use Axis::{X, Y, Z};
    let maps = [[Y, X, Z], [Z, Y, X], [X, Z, Y], [Y, Z, X], [Z, X, Y]];
    let mut faults = Vec::new();
    for scope in [Scope::All, Scope::Positioning, Scope::Cross] {
        faults.extend(maps.map(|map| Fault::Exchanged(scope, map)));
    }
    faults.push(Fault::Transposed);
    for (index, one) in ErrorTerm::ALL.into_iter().enumerate() {
        let others = ErrorTerm::ALL.into_iter().skip(index + 1);
        faults.extend(others.map(|two| Fault::Pair(one, two)));
    }
    faults
}

/// An exchange counts if a table of the kit comes to act on a term that was measured, or leaves it.
fn acts_elsewhere(question: &Question<'_>, fault: &Fault) -> bool {
    let tabled = |term: ErrorTerm| question.control.has_table(term);
    question.terms().into_iter().any(|term| {
        let other = match fault {
            Fault::Exchanged(scope, map) if scope.holds(term) => came_from(map, term),
            Fault::Transposed if term.is_cross() => ErrorTerm {
                of: term.along,
                along: term.of,
            },
            Fault::Pair(one, two) if term == *one => *two,
            Fault::Pair(one, two) if term == *two => *one,
            _ => term,
        };
        other != term && (tabled(term) || tabled(other))
    })
}

/// What is tried on one term by itself.
pub(super) fn alone(term: ErrorTerm) -> Vec<Fault> {
    let scope = Scope::Term(term);
    let factors = [0.0, -1.0, 2.0].map(|factor| Fault::Times(scope, factor));
    let mut tried = factors.to_vec();
    if term.is_positioning() {
        tried.push(Fault::TemperatureOf(term.along));
    }
    tried.push(Fault::Shifted(Some(term.along)));
    tried
}
