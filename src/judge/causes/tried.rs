//! Which faults are tried: those that can show in the data.

use super::fault::{Fault, Scope, came_from};
use super::question::Question;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::units::MM_PER_INCH;

/// Known factors beside −1, 0 and 2.
const UNIT_FACTORS: [f64; 4] = [1000.0, 1.0 / 1000.0, MM_PER_INCH, 1.0 / MM_PER_INCH];

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
    if Axis::ALL
        .into_iter()
        .any(|axis| question.shows_growth(axis))
    {
        faults.extend([Fault::Temperature, Fault::TemperatureEach]);
    }
    if question.has_parameter() {
        faults.push(Fault::Nothing);
    }
    if question.under_tables.is_some() {
        faults.extend([Fault::OldTables, Fault::OldBeside]);
    }
    faults.extend([Fault::FirstTurned, Fault::SecondTurned]);
    let corrected = question.corrected.iter();
    let corrected = corrected.filter(|corrected| corrected.answers(question));
    faults.extend(corrected.map(|corrected| Fault::Recorded(corrected.slip)));
    faults
}

fn axis_faults(question: &Question<'_>) -> Vec<Fault> {
    let mut faults = vec![Fault::Shifted(None)];
    faults.extend(Axis::ALL.map(|axis| Fault::Shifted(Some(axis))));
    faults.extend(Axis::ALL.map(Fault::TemperatureOf));
    for axis in [None].into_iter().chain(Axis::ALL.map(Some)) {
        faults.push(Fault::BacklashTwice(axis));
        faults.push(Fault::BacklashNot(axis));
        faults.extend(Direction::BOTH.map(|way| Fault::OneTable(axis, way)));
    }
    let terms = question.terms();
    faults.retain(|fault| match fault {
        Fault::TemperatureOf(axis) => question.shows_growth(*axis),
        Fault::BacklashTwice(axis) => question.shows_reversal(*axis),
        Fault::BacklashNot(axis) => {
            question.shows_reversal(*axis) && question.sets_parameter(*axis)
        }
        Fault::OneTable(axis, _) => {
            question.shows_reversal(*axis) && question.corrects_each_way(*axis)
        }
        Fault::Shifted(Some(axis)) => terms.iter().any(|term| term.along == *axis),
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
pub(super) fn alone(question: &Question<'_>, term: ErrorTerm) -> Vec<Fault> {
    let scope = Scope::Term(term);
    let factors = [0.0, -1.0, 2.0].map(|factor| Fault::Times(scope, factor));
    let mut tried = factors.to_vec();
    if term.is_positioning() && question.shows_growth(term.along) {
        tried.push(Fault::TemperatureOf(term.along));
    }
    tried.push(Fault::Shifted(Some(term.along)));
    tried
}
