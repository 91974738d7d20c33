//! What is tried: each change with its kind, how usual it is, and how it is said on the shop floor.

use super::change::{Change, Fitted, Scope, Terms, number};
use crate::judge::after::before_um;
use crate::judge::causes::change::{Question, Slip, WithoutSlip};
use crate::judge::field::Field;
use crate::quantity::{Axis, Direction, ErrorTerm, Figure, MM_PER_INCH, PerAxis, PerTerm};
use crate::text::{grouped, joined, once};

/// A kind of cause: its place among causes that the data cannot tell apart (what happens often stands first); its
/// word in docs/visit.md §7; what happened to what it concerns, and what it usually comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CauseKind(pub(super) u8, pub(super) &'static str, &'static str);

const NOT_ACTIVE: CauseKind = CauseKind(
    0,
    "not active",
    "do not act: not switched on, not loaded, or the axes were not referenced",
);
const OLD_ACTIVE: CauseKind = CauseKind(
    1,
    "old tables active",
    "still act, the new ones do not: not loaded, or not switched on",
);
const TURNED: CauseKind =
    CauseKind(2, "sign turned", "act with the sign turned: they add where they should take away");
const OLD_BESIDE: CauseKind = CauseKind(
    3,
    "old beside new",
    "act in addition to the new ones, which hold their values already",
);
const TWICE: CauseKind = CauseKind(
    4,
    "applied twice",
    "act twice: loaded beside an older compensation of the same errors, or with a doubled weight",
);
const BACKLASH_NOT: CauseKind =
    CauseKind(5, "backlash not", "is not compensated: the backlash parameter is 0");
const BACKLASH_TWICE: CauseKind = CauseKind(
    6,
    "backlash twice",
    "is counted once too often: a backlash parameter acts in addition to the tables",
);
const WAYS: CauseKind =
    CauseKind(7, "directions exchanged", "for + and - act in the other direction");
const WRONG_AXIS: CauseKind =
    CauseKind(8, "wrong axis", "are exchanged, or stand at the wrong axis");
const SHIFTED: CauseKind = CauseKind(9, "shifted", "");
const TEMPERATURE: CauseKind = CauseKind(10, "temperature", "");
const NAMES: CauseKind = CauseKind(11, "names exchanged", "were saved under each other's name");
const ORDER: CauseKind = CauseKind(12, "wrong order", "");
const MEASURED_TURNED: CauseKind =
    CauseKind(13, "measurement turned", "has the wrong sign (direction of the laser)");
const UNIT: CauseKind = CauseKind(14, "wrong unit", "");
const FACTOR: CauseKind = CauseKind(14, "other factor", "");

/// What tells whether it is a cause of this kind, beside a look at what acts, in the order of doing.
pub(super) const CHECKS: [(&str, &str); 5] = [
    ("sign turned", "one bump of at most 20 µm and a dial gauge prove sign and size of what acts"),
    ("measurement turned", "move an axis in + and look whether the laser counts in +"),
    ("temperature", "read the temperatures of scales and workpiece"),
    (
        "names exchanged",
        "compare the names in the file of the first readings with the programs that were run, or run one of the two diagonals again",
    ),
    (
        "wrong order",
        "compare the order in the job of the first measurement with the programs that were run",
    ),
];

/// Factors of a wrong unit.
const UNITS: [(f64, &str); 4] = [
    (1000.0, "1000 times too large"),
    (1.0 / 1000.0, "1000 times too small"),
    (MM_PER_INCH, "25.4 times too large, millimetres taken for inches"),
    (1.0 / MM_PER_INCH, "25.4 times too small, inches taken for millimetres"),
];

/// A change that may have happened, and how it is said.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hypothesis {
    pub(super) kind: CauseKind,
    pub(super) change: Change,
    /// Whom it concerns.
    subject: String,
    /// What happened to it; fitted numbers are put in later.
    predicate: String,
    /// Its label beside others of its kind.
    pub(super) label: String,
}

impl Hypothesis {
    fn new(kind: CauseKind, change: Change, subject: &str) -> Hypothesis {
        let (subject, predicate) = (subject.to_string(), kind.2.to_string());
        Hypothesis { label: format!("{} ({subject})", kind.1), kind, change, subject, predicate }
    }

    fn said(self, predicate: impl Into<String>) -> Hypothesis {
        Hypothesis { predicate: predicate.into(), ..self }
    }

    /// With another label than its subject.
    fn called(self, label: &str) -> Hypothesis {
        Hypothesis { label: format!("{} ({label})", self.kind.1), ..self }
    }

    /// Whether it is tried on this term by itself: a known factor, a shift, a warmer scale.
    pub(super) fn is_of(&self, term: ErrorTerm) -> bool {
        match &self.change {
            Change::Times(scope, Some(_)) => {
                self.kind != UNIT && scope.terms == of_terms(|t| t == term)
            }
            Change::Shifted(places) => *places == only(term.along),
            Change::Warmer(places) => term.is_positioning() && *places == only(term.along),
            _ => false,
        }
    }
}

/// Everything that is tried; of one kind the widest first. What cannot show in the data predicts what the
/// forecast does, and falls with it.
pub(super) fn all(question: &Question<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (factor, words) in &UNITS[2..] {
        let unit = Hypothesis::new(UNIT, Change::Unit(*factor), "all tables");
        let said = format!("are read in another unit: positions and values {words}");
        all.push(unit.said(said).called(&format!("positions too, {words}")));
    }
    for (tables, scope) in with_parameters(&[question.control]) {
        let times =
            |kind, factor| Hypothesis::new(kind, Change::Times(scope.clone(), factor), &tables);
        let factors = [(TURNED, -1.0), (NOT_ACTIVE, 0.0), (TWICE, 2.0)];
        all.extend(factors.map(|(kind, factor)| times(kind, Some(factor))));
        // Parameters have a unit of their own.
        all.extend(UNITS.into_iter().filter(|_| !scope.parameters).map(|(factor, words)| {
            let unit = times(UNIT, Some(factor)).said(format!("act in another unit: {words}"));
            unit.called(&format!("{tables}, {words}"))
        }));
        all.push(times(FACTOR, None));
        let exchanged = Change::Ways(scope, [Direction::Minus, Direction::Plus]);
        all.push(Hypothesis::new(WAYS, exchanged, &tables));
    }
    all.push(Hypothesis::new(SHIFTED, Change::Shifted(each()), "the tables of every axis"));
    for axis in Axis::ALL {
        let (shifted, warmer) = (Change::Shifted(only(axis)), Change::Warmer(only(axis)));
        all.push(Hypothesis::new(SHIFTED, shifted, &format!("the tables looked up along {axis}")));
        all.push(Hypothesis::new(TEMPERATURE, warmer, &format!("the scale of axis {axis}")));
    }
    let warmer = [PerAxis::from_fn(|_| Some(0)), each()].map(Change::Warmer);
    all.extend(warmer.map(|all| Hypothesis::new(TEMPERATURE, all, "the scales of all axes")));
    all.extend(reversals(question));
    all.extend(exchanges(question));
    all.extend(of_old_tables(question));
    all.extend(of_measurements(question));
    all
}

fn of_terms(holds: impl Fn(ErrorTerm) -> bool) -> Terms {
    Terms::from_fn(holds)
}

/// Sets of tables, the widest first.
fn scopes() -> Vec<(String, Terms)> {
    let mut all = vec![
        ("all tables".to_string(), of_terms(|_| true)),
        ("the positioning tables".to_string(), of_terms(ErrorTerm::is_positioning)),
        ("the tables of the cross terms".to_string(), of_terms(ErrorTerm::is_cross)),
    ];
    let along =
        |axis| (format!("the tables looked up along {axis}"), of_terms(|t| t.along == axis));
    let of = |axis| (format!("the tables that correct {axis}"), of_terms(|t| t.of == axis));
    let term = |own| (format!("the tables of {own}"), of_terms(|t| t == own));
    all.extend(Axis::ALL.map(along).into_iter().chain(Axis::ALL.map(of)));
    all.extend(ErrorTerm::ALL.map(term));
    all
}

/// The same with the backlash parameters, where one of these holds any, and without.
fn with_parameters(held: &[&Field]) -> Vec<(String, Scope)> {
    let both = |(tables, terms): (String, Terms)| {
        let only = Scope::tables(terms);
        let has_one = only.any(|term| held.iter().any(|field| field.has_parameter(term)));
        let with = Scope { parameters: true, ..only.clone() };
        let with = has_one.then(|| (format!("{tables} and backlash parameters"), with));
        with.into_iter().chain([(tables, only)])
    };
    scopes().into_iter().flat_map(both).collect()
}

/// One number for this axis alone.
fn only(axis: Axis) -> Fitted {
    PerAxis::from_fn(|own| (own == axis).then_some(0))
}

/// A number for each axis.
fn each() -> Fitted {
    PerAxis { x: Some(0), y: Some(1), z: Some(2) }
}

/// Lost motion that is compensated twice, or not: of every axis, or of one.
fn reversals(question: &Question<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    let axes = Axis::ALL.map(|axis| (format!("axis {axis}"), ErrorTerm::positioning(axis)));
    let axes = axes.map(|(whose, own)| (whose, of_terms(|term| term == own)));
    let every = ("every axis".to_string(), of_terms(ErrorTerm::is_positioning));
    for (whose, terms) in [every].into_iter().chain(axes) {
        let subject = format!("the reversal of {whose}");
        all.push(Hypothesis::new(BACKLASH_TWICE, Change::BacklashTwice(terms.clone()), &subject));
        let not = |change| Hypothesis::new(BACKLASH_NOT, change, &subject);
        let parameters = Scope { tables: false, parameters: true, terms: terms.clone() };
        let zero = not(Change::Times(parameters.clone(), Some(0.0)));
        all.push(zero.called(&format!("{whose}: no parameter")));
        if parameters.any(|term| question.old.has_parameter(term)) {
            let is_replaced = parameters.any(|term| question.control.has_parameter(term));
            let old = Change::Old(parameters);
            let old = match is_replaced {
                true => not(old).said("is compensated as before: the backlash parameter is the one that was active while measuring"),
                false => Hypothesis::new(BACKLASH_TWICE, old, &subject),
            };
            all.push(old.called(&format!("{whose}: old parameter")));
        }
        for way in Direction::BOTH {
            // What a table for one direction holds apart goes with it.
            let both = Scope { parameters: true, ..Scope::tables(terms.clone()) };
            let said = format!("is not compensated: the table for {way} acts in both directions");
            let one = not(Change::Ways(both, [way, way])).said(said);
            all.push(one.called(&format!("{whose}: table of {way} both ways")));
        }
    }
    all
}

/// Tables at other axes or terms than they were made for.
fn exchanges(question: &Question<'_>) -> Vec<Hypothesis> {
    use Axis::{X, Y, Z};
    let from =
        |from: &dyn Fn(ErrorTerm) -> ErrorTerm| Change::From(Box::new(PerTerm::from_fn(from)));
    let mut all = Vec::new();
    for (tables, terms) in scopes().into_iter().take(3) {
        for map in [[Y, X, Z], [Z, Y, X], [X, Z, Y], [Y, Z, X], [Z, X, Y]] {
            let back = |axis| Axis::ALL.into_iter().zip(map).find(|(_, to)| *to == axis);
            let back = |axis| back(axis).map_or(axis, |(own, _)| own);
            let change = from(&|term: ErrorTerm| match terms[term] {
                true => ErrorTerm { of: back(term.of), along: back(term.along) },
                false => term,
            });
            let on = format!("on {}, {}, {}", map[0], map[1], map[2]);
            let said = format!(
                "were made for X, Y, Z and act {on}: the control counts its axes in another order"
            );
            let order = Hypothesis::new(WRONG_AXIS, change, &tables).said(said);
            all.push(order.called(&format!("{tables} {on}")));
        }
    }
    // A positioning term is its own transpose.
    let twins = from(&ErrorTerm::twin);
    all.push(Hypothesis::new(WRONG_AXIS, twins, "the tables of the cross terms").said(
        "act with base and corrected axis exchanged (EYX as EXY): look at input and output axis",
    ));
    for (index, one) in ErrorTerm::ALL.into_iter().enumerate() {
        for two in ErrorTerm::ALL.into_iter().skip(index + 1) {
            let change = from(&|term: ErrorTerm| match term {
                own if own == one => two,
                own if own == two => one,
                own => own,
            });
            let without = [one, two].into_iter().find(|term| !question.control.has_table(*term));
            let without = without.map_or(String::new(), |term| format!(" ({term} has none)"));
            let subject = format!("the tables of {one} and {two}{without}");
            all.push(Hypothesis::new(WRONG_AXIS, change, &subject));
        }
    }
    all
}

/// Tables and parameters that were active while measuring, where there were any.
fn of_old_tables(question: &Question<'_>) -> Vec<Hypothesis> {
    let (old, mut all) = (question.old, Vec::new());
    for (tables, scope) in with_parameters(&[question.control, old]) {
        let tables = format!("{tables} that were active while measuring");
        if scope.any(|term| old.has_table(term) || scope.parameters && old.has_parameter(term)) {
            let beside = (!scope.parameters).then(|| Change::OldBeside(scope.terms.clone()));
            all.extend(beside.map(|change| Hypothesis::new(OLD_BESIDE, change, &tables)));
            all.push(Hypothesis::new(OLD_ACTIVE, Change::Old(scope), &tables));
        }
    }
    all
}

/// What may be wrong with the measurements themselves.
fn of_measurements(question: &Question<'_>) -> Vec<Hypothesis> {
    let turned = |change, which: &str, label, so| {
        let turned = Hypothesis::new(MEASURED_TURNED, change, &format!("the {which} measurement"));
        turned.said(format!("{}, and {so}", MEASURED_TURNED.2)).called(label)
    };
    let second = "the second, and tables not active";
    let mut all = vec![
        turned(Change::FirstTurned, "first", "the first", "so have the tables"),
        turned(Change::SecondTurned, "second", second, "the tables do not act"),
    ];
    for (place, WithoutSlip { slip, before }) in question.corrected.iter().enumerate() {
        if !question.parts().all(|part| before_um(before, part).is_some()) {
            continue;
        }
        let (kind, subject, said, label) = match slip {
            Slip::Names(one, other) => (
                NAMES,
                &*format!("the readings of {one} and {other} of the first measurement"),
                NAMES.2.to_string(),
                format!("{one} and {other}"),
            ),
            Slip::Order(order @ [a, b, c]) => (
                ORDER,
                "the steps of the first measurement",
                format!("went {a}, {b}, {c}, not as the job says"),
                Axis::letters(order),
            ),
        };
        let slip = Hypothesis::new(kind, Change::Recorded(place), subject);
        all.push(slip.said(format!("{said}, and the tables were made from that")).called(&label));
    }
    all
}

/// One sentence for a cause: what happened to which tables, and what it usually comes from. Hypotheses
/// of which the same can be said share it. `uncertainty_mm` = how far each fitted shift may be off.
pub(super) fn words(
    question: &Question<'_>,
    hypotheses: &[Hypothesis],
    fitted: &[f64],
    uncertainty_mm: &[f64],
) -> String {
    let said = hypotheses.iter().map(|Hypothesis { change, subject, predicate, .. }| {
        let predicate = match change {
            Change::Times(_, None) => format!(
                "act {:.3} times as strong as planned: look at magnification, detection unit, weight of the table, radius or diameter",
                number(fitted, Some(0))
            ),
            Change::Shifted(places) => shift(places, fitted, uncertainty_mm),
            Change::Warmer(places) => kelvin(question, places, fitted),
            _ => predicate.clone(),
        };
        (predicate, subject.clone())
    });
    let sentences = grouped(said).into_iter().map(|(predicate, subjects)| {
        format!("{} {predicate}", first_few(&once(subjects), ", or "))
    });
    first_few(&sentences.collect::<Vec<String>>(), "; or ")
}

/// Hypotheses of one kind look the same in the data; many are cut.
fn first_few(words: &[String], between: &str) -> String {
    const NAMED: usize = 3;
    let joined = words[..words.len().min(NAMED)].join(between);
    if words.len() > NAMED { format!("{joined}{between}others like them") } else { joined }
}

fn shift(places: &Fitted, fitted: &[f64], uncertainty_mm: &[f64]) -> String {
    let each = places.iter().filter_map(|(axis, place)| {
        let (mm, u) = (Figure(number(fitted, *place)), number(uncertainty_mm, *place));
        let decimals = usize::from(u < 10.0);
        let named = if fitted.len() > 1 { format!("{axis} ") } else { String::new() };
        place.map(|_| format!("{named}{mm:+.decimals$} ± {u:.decimals$} mm"))
    });
    format!(
        "act {} away from their place: the reference point is another one than in the job, or positions count from another zero",
        joined(each)
    )
}

/// Warmer scales: the growth of each, and the temperature; one number where all share it.
fn kelvin(question: &Question<'_>, places: &Fitted, fitted: &[f64]) -> String {
    let each = places.iter().filter_map(|(axis, place)| {
        let (kelvin, alpha) = (number(fitted, Some((*place)?)), question.alpha_per_k[axis] * 1e6);
        let um_per_m = Figure(question.um_per_m(axis, kelvin));
        Some(match alpha > 0.0 {
            true => format!(
                "{axis} {um_per_m:+.2} µm/m ({:+.2} K at {alpha:.1}e-6 per K)",
                Figure(kelvin)
            ),
            false => format!("{axis} does not grow (0e-6 per K)"),
        })
    });
    format!(
        "grew: {}: temperature of scale or workpiece, or its correction in the laser",
        joined(each)
    )
}
