//! Which faults are tried: those that can show in the data; and how each is said on the shop floor.

use super::fault::{Act, Fault, Fitted, Scope, number};
use super::question::{Question, Slip};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::units::{Figure, MM_PER_INCH};

/// Known factors of the tables.
const FACTORS: [(f64, &str, &str); 3] = [
    (-1.0, "sign turned", "act with the sign turned: they add where they should take away"),
    (0.0, "not active", NOT_ACTIVE),
    (
        2.0,
        "applied twice",
        "act twice: loaded beside an older compensation of the same errors, or with a doubled weight",
    ),
];

const NOT_ACTIVE: &str = "do not act: not switched on, not loaded, or the axes were not referenced";

/// Factors of a wrong unit.
const UNITS: [(f64, &str); 4] = [
    (1000.0, "1000 times too large"),
    (1.0 / 1000.0, "1000 times too small"),
    (MM_PER_INCH, "25.4 times too large, millimetres taken for inches"),
    (1.0 / MM_PER_INCH, "25.4 times too small, inches taken for millimetres"),
];

impl Fault {
    fn new(kind: &'static str, act: Act, subject: String, predicate: impl Into<String>) -> Fault {
        Fault {
            kind,
            act,
            label: format!("{kind} ({subject})"),
            subject,
            predicate: predicate.into(),
        }
    }

    /// With another label than its subject.
    fn called(mut self, label: impl std::fmt::Display) -> Fault {
        self.label = format!("{} ({label})", self.kind);
        self
    }
}

/// Every fault that can show in the data of a question; of one kind the widest first.
pub(super) fn all_faults(question: &Question<'_>) -> Vec<Fault> {
    let tabled = |term: ErrorTerm| question.control.has_table(term);
    let terms = question.terms();
    let shows = |scope: Scope| terms.iter().any(|term| scope.holds(*term) && tabled(*term));
    let mut faults = Vec::new();
    if question.has_parameter() {
        let subject = "all tables and backlash parameters".to_string();
        faults.push(Fault::new("not active", Act::Nothing, subject, NOT_ACTIVE));
    }
    faults.extend(UNITS[2..].iter().map(|(factor, words)| {
        let said = format!("are read in another unit: positions and values {words}");
        let fault = Fault::new("wrong unit", Act::Unit(*factor), tables(Scope::All), said);
        fault.called(format!("positions too, {words}"))
    }));
    for scope in Scope::all().into_iter().filter(|scope| shows(*scope)) {
        faults.extend(of_scope(scope, question.has_two_tables()));
    }
    faults.extend(
        shifts()
            .filter(|(axis, _)| axis.is_none_or(|a| shows_along(&terms, a)))
            .map(|(_, fault)| fault),
    );
    faults.extend(reversals(question));
    let acts_elsewhere = |fault: &Fault| {
        let Act::From(from) = &fault.act else {
            return false;
        };
        let moves =
            |term: &ErrorTerm| from[*term] != *term && (tabled(*term) || tabled(from[*term]));
        terms.iter().any(moves)
    };
    faults.extend(exchanges(question).into_iter().filter(acts_elsewhere));
    faults.extend(temperatures(question));
    if question.under_tables.is_some() {
        faults.extend(
            [
                (
                    "old tables active",
                    false,
                    "still act, the new ones do not: not loaded, or not switched on",
                ),
                (
                    "old beside new",
                    true,
                    "act in addition to the new ones, which hold their values already",
                ),
            ]
            .map(|(kind, beside, said)| {
                let subject = "the tables that were active while measuring".to_string();
                Fault::new(kind, Act::Old { beside }, subject, said)
            }),
        );
    }
    faults.extend(of_measurements(question));
    faults
}

fn shows_along(terms: &[ErrorTerm], axis: Axis) -> bool {
    terms.iter().any(|term| term.along == axis)
}

/// What is tried on all tables of a scope alike.
fn of_scope(scope: Scope, has_two_tables: bool) -> Vec<Fault> {
    let mut faults = factors(scope);
    faults.extend(UNITS.map(|(factor, words)| {
        let said = format!("act in another unit: {words}");
        let fault = Fault::new("wrong unit", Act::Times(scope, Some(factor)), tables(scope), said);
        fault.called(format!("{}, {words}", tables(scope)))
    }));
    faults.push(Fault::new("other factor", Act::Times(scope, None), tables(scope), ""));
    if has_two_tables {
        let turned = Act::Ways(scope, [Direction::Minus, Direction::Plus]);
        let said = "for + and - act in the other direction";
        faults.push(Fault::new("directions exchanged", turned, tables(scope), said));
    }
    faults
}

fn factors(scope: Scope) -> Vec<Fault> {
    let fault = |(factor, kind, said)| {
        Fault::new(kind, Act::Times(scope, Some(factor)), tables(scope), said)
    };
    FACTORS.map(fault).into()
}

/// One number for this axis alone.
fn only(axis: Axis) -> Fitted {
    PerAxis::from_fn(|own| (own == axis).then_some(0))
}

/// A number for each axis.
fn each() -> Fitted {
    PerAxis::from_fn(|axis| Axis::ALL.iter().position(|own| *own == axis))
}

/// The tables of every axis, or of one, at another place.
fn shifts() -> impl Iterator<Item = (Option<Axis>, Fault)> {
    let all = Act::Shifted(each());
    let all = Fault::new("shifted", all, "the tables of every axis".to_string(), "");
    let one = |axis| {
        let act = Act::Shifted(only(axis));
        (Some(axis), Fault::new("shifted", act, tables(Scope::Along(axis)), ""))
    };
    std::iter::once((None, all)).chain(Axis::ALL.map(one))
}

/// Lost motion that is compensated twice, or not: of every axis, or of one.
fn reversals(question: &Question<'_>) -> Vec<Fault> {
    let mut faults = Vec::new();
    let axes = [None].into_iter().chain(Axis::ALL.map(Some));
    for axis in axes.filter(|axis| question.shows_reversal(*axis)) {
        let scope = axis.map_or(Scope::Positioning, |of| Scope::Term(ErrorTerm { of, along: of }));
        let whose = axis.map_or("every axis".to_string(), |axis| format!("axis {axis}"));
        let subject = || format!("the reversal of {whose}");
        let said = "is counted once too often: a backlash parameter acts in addition to the tables";
        faults.push(Fault::new("backlash twice", Act::BacklashTwice(scope), subject(), said));
        if question.sets_parameter(axis) {
            let said = "is not compensated: the backlash parameter is 0";
            let fault = Fault::new("backlash not", Act::BacklashNot(scope), subject(), said);
            faults.push(fault.called(format!("{whose}: no parameter")));
        }
        if question.corrects_each_way(axis) {
            faults.extend(Direction::BOTH.map(|way| {
                let said =
                    format!("is not compensated: the table for {way} acts in both directions");
                let fault =
                    Fault::new("backlash not", Act::Ways(scope, [way, way]), subject(), said);
                fault.called(format!("{whose}: table of {way} both ways"))
            }));
        }
    }
    faults
}

/// Tables at other axes or terms than they were made for.
fn exchanges(question: &Question<'_>) -> Vec<Fault> {
    use Axis::{X, Y, Z};
    const KIND: &str = "wrong axis";
    let act = |from: &dyn Fn(ErrorTerm) -> ErrorTerm| Act::From(Box::new(PerTerm::from_fn(from)));
    let mut faults = Vec::new();
    for scope in [Scope::All, Scope::Positioning, Scope::Cross] {
        for map in [[Y, X, Z], [Z, Y, X], [X, Z, Y], [Y, Z, X], [Z, X, Y]] {
            let back = |axis: Axis| {
                let own = map.iter().position(|to| *to == axis);
                own.map_or(axis, |own| Axis::ALL[own])
            };
            let from = act(&|term: ErrorTerm| match scope.holds(term) {
                true => ErrorTerm { of: back(term.of), along: back(term.along) },
                false => term,
            });
            let on = format!("on {}, {}, {}", map[0], map[1], map[2]);
            let said = format!(
                "were made for X, Y, Z and act {on}: the control counts its axes in another order"
            );
            let fault = Fault::new(KIND, from, tables(scope), said);
            faults.push(fault.called(format!("{} {on}", tables(scope))));
        }
    }
    // A positioning term is its own transpose.
    let transposed = act(&ErrorTerm::twin);
    let said =
        "act with base and corrected axis exchanged (EYX as EXY): look at input and output axis";
    faults.push(Fault::new(KIND, transposed, tables(Scope::Cross), said));
    for (index, one) in ErrorTerm::ALL.into_iter().enumerate() {
        for two in ErrorTerm::ALL.into_iter().skip(index + 1) {
            let pair = act(&|term: ErrorTerm| match term {
                own if own == one => two,
                own if own == two => one,
                own => own,
            });
            let without = [one, two].into_iter().find(|term| !question.control.has_table(*term));
            let without = without.map_or(String::new(), |term| format!(" ({term} has none)"));
            let subject = format!("the tables of {one} and {two}{without}");
            let said = "are exchanged, or stand at the wrong axis";
            faults.push(Fault::new(KIND, pair, subject, said));
        }
    }
    faults
}

fn warmer(fitted: Fitted, subject: &str) -> Fault {
    Fault::new("temperature", Act::Warmer(fitted), subject.to_string(), "")
}

/// Scales that are warmer: each axis by itself, all by the same, each by its own.
fn temperatures(question: &Question<'_>) -> Vec<Fault> {
    let axes: Vec<Axis> =
        Axis::ALL.into_iter().filter(|axis| question.shows_growth(*axis)).collect();
    let one = axes.iter().map(|axis| warmer(only(*axis), &format!("the scale of axis {axis}")));
    let mut faults: Vec<Fault> = one.collect();
    if !axes.is_empty() {
        let all = PerAxis::from_fn(|_| Some(0));
        faults.extend([all, each()].map(|fitted| warmer(fitted, "the scales of all axes")));
    }
    faults
}

/// What may be wrong with the measurements themselves.
fn of_measurements(question: &Question<'_>) -> Vec<Fault> {
    let turned = [
        (
            Act::FirstTurned,
            "the first",
            "has the wrong sign (direction of the laser), and so have the tables",
        ),
        (
            Act::SecondTurned,
            "the second",
            "has the wrong sign (direction of the laser), and the tables do not act",
        ),
    ];
    let mut faults: Vec<Fault> = turned
        .map(|(act, which, said)| {
            let is_second = act == Act::SecondTurned;
            let fault = Fault::new("measurement turned", act, format!("{which} measurement"), said);
            fault.called(if is_second { "the second, and tables not active" } else { which })
        })
        .into();
    for corrected in question.corrected {
        let mut parts = question.seen.iter().flat_map(|o| &o.parts);
        if parts.all(|part| corrected.beyond_um(question, part).is_some()) {
            faults.push(recorded(corrected.slip));
        }
    }
    faults
}

fn recorded(slip: Slip) -> Fault {
    const MADE: &str = "and the tables were made from that";
    let (kind, subject, said, label) = match slip {
        Slip::Names(one, other) => (
            "names exchanged",
            format!("the readings of {one} and {other} of the first measurement"),
            format!("were saved under each other's name, {MADE}"),
            format!("{one} and {other}"),
        ),
        Slip::Order(order) => (
            "wrong order",
            "the steps of the first measurement".to_string(),
            format!("went {}, {}, {}, not as the job says, {MADE}", order[0], order[1], order[2]),
            Axis::letters(&order),
        ),
    };
    Fault::new(kind, Act::Recorded(slip), subject, said).called(label)
}

/// What is tried on one term by itself.
pub(super) fn alone(question: &Question<'_>, term: ErrorTerm) -> Vec<Fault> {
    let mut tried = factors(Scope::Term(term));
    if term.is_positioning() && question.shows_growth(term.along) {
        tried.push(warmer(only(term.along), ""));
    }
    let shift = shifts().find(|(axis, _)| *axis == Some(term.along));
    tried.extend(shift.map(|(_, fault)| fault));
    tried
}

/// The tables of a scope.
fn tables(scope: Scope) -> String {
    match scope {
        Scope::All => "all tables".to_string(),
        Scope::Positioning => "the positioning tables".to_string(),
        Scope::Cross => "the tables of the cross terms".to_string(),
        Scope::Along(axis) => format!("the tables looked up along {axis}"),
        Scope::Of(axis) => format!("the tables that correct {axis}"),
        Scope::Term(term) => format!("the tables of {term}"),
    }
}

/// One sentence for a cause: what happened to which tables, and what it usually comes from. Faults
/// of which the same can be said share it. `uncertainty_mm` = how far each fitted shift may be off.
pub(super) fn cause(
    question: &Question<'_>,
    faults: &[Fault],
    fitted: &[f64],
    uncertainty_mm: &[f64],
) -> String {
    let mut said: Vec<(Vec<String>, String)> = Vec::new();
    for fault in faults {
        let subject = fault.subject.clone();
        let predicate = match &fault.act {
            Act::Times(_, None) => format!(
                "act {:.3} times as strong as planned: look at magnification, detection unit, weight of the table, radius or diameter",
                number(fitted, Some(0))
            ),
            Act::Shifted(places) => shift(places, fitted, uncertainty_mm),
            Act::Warmer(places) => kelvin(question, places, fitted),
            _ => fault.predicate.clone(),
        };
        match said.iter_mut().find(|(_, other)| *other == predicate) {
            Some((subjects, _)) if subjects.contains(&subject) => {}
            Some((subjects, _)) => subjects.push(subject),
            None => said.push((vec![subject], predicate)),
        }
    }
    let sentence = |(subjects, predicate): &(Vec<String>, String)| {
        format!("{} {predicate}", first_few(subjects, ", or "))
    };
    let sentences: Vec<String> = said.iter().map(sentence).collect();
    first_few(&sentences, "; or ")
}

/// Faults of one kind look the same in the data; many are cut.
fn first_few(words: &[String], between: &str) -> String {
    const NAMED: usize = 3;
    let joined = words[..words.len().min(NAMED)].join(between);
    if words.len() > NAMED { format!("{joined}{between}others like them") } else { joined }
}

fn shift(places: &Fitted, fitted: &[f64], uncertainty_mm: &[f64]) -> String {
    let each = places.iter().filter_map(|(axis, place)| {
        let (mm, u) = (number(fitted, *place), number(uncertainty_mm, *place));
        let decimals = usize::from(u < 10.0);
        let named = if fitted.len() > 1 { format!("{axis} ") } else { String::new() };
        let mm = Figure(mm);
        place.map(|_| format!("{named}{mm:+.decimals$} ± {u:.decimals$} mm"))
    });
    format!(
        "act {} away from their place: the reference point is another one than in the job, or positions count from another zero",
        each.collect::<Vec<String>>().join(", ")
    )
}

/// Warmer scales: the growth of each, and the temperature; one number where all share it.
fn kelvin(question: &Question<'_>, places: &Fitted, fitted: &[f64]) -> String {
    let grows = |(axis, place): (Axis, &Option<usize>)| {
        let kelvin = number(fitted, Some((*place)?));
        let alpha = question.alpha_per_k[axis] * 1e6;
        let um_per_m = Figure(question.um_per_m(axis, kelvin));
        let kelvin = Figure(kelvin);
        Some(match alpha > 0.0 {
            true => format!("{axis} {um_per_m:+.2} µm/m ({kelvin:+.2} K at {alpha:.1}e-6 per K)"),
            false => format!("{axis} does not grow (0e-6 per K)"),
        })
    };
    let each: Vec<String> = places.iter().filter_map(grows).collect();
    format!(
        "grew: {}: temperature of scale or workpiece, or its correction in the laser",
        each.join(", ")
    )
}
