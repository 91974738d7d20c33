//! Causes in words for the shop floor.

use crate::judge::causes::data::Data;
use crate::judge::causes::fault::Fit;

use super::fault::{Fault, Scope};
use super::question::Question;
use crate::judge::after::Observation;
use crate::judge::causes::corrected::Slip;
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::units::{Figure, MM_PER_INCH, Millimetres};

/// How many faults of one kind are named; they look the same in the data.
const NAMED: usize = 3;

/// One sentence for a cause: what happened to which tables, and what it usually comes from. Faults
/// of which the same can be said share it.
pub(super) fn cause(question: &Question<'_>, faults: &[Fault], numbers: &Numbers) -> String {
    let mut said: Vec<(Vec<String>, String)> = Vec::new();
    for fault in faults {
        let (subject, predicate) = (
            subject(question, fault),
            predicate(question, fault, numbers),
        );
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

/// Many that look the same in the data are cut.
fn first_few(words: &[String], between: &str) -> String {
    let joined = words[..words.len().min(NAMED)].join(between);
    if words.len() > NAMED {
        format!("{joined}{between}others like them")
    } else {
        joined
    }
}

/// A fault in a few words.
pub(super) fn label(question: &Question<'_>, fault: &Fault) -> String {
    let what = match fault {
        Fault::Times(scope, factor) if fault.kind() == "wrong unit" => {
            format!("{}, {}", tables(*scope), inch(*factor))
        }
        Fault::Unit(factor) => format!("positions too, {}", inch(*factor)),
        Fault::Exchanged(scope, map) => {
            format!("{} on {}, {}, {}", tables(*scope), map[0], map[1], map[2])
        }
        Fault::OneTable(axis, way) => format!("{}: table of {way} both ways", of_axis(*axis)),
        Fault::BacklashNot(axis) => format!("{}: no parameter", of_axis(*axis)),
        Fault::FirstTurned => "the first".to_string(),
        Fault::Recorded(Slip::Names(one, other)) => format!("{one} and {other}"),
        Fault::Recorded(Slip::Order(order)) => Axis::letters(order),
        Fault::SecondTurned => "the second, and tables not active".to_string(),
        fault => subject(question, fault),
    };
    format!("{} ({what})", fault.kind())
}

/// Where and by how much a term is off the forecast.
pub(super) fn off_forecast(um: f64, seen: &Observation) -> String {
    let place = match seen.parts.as_slice() {
        [] => String::new(),
        [one] => format!(" at {} mm moving {}", short(one.at), one.direction),
        [mean, ..] => format!(" at {} mm", short(mean.at)),
    };
    format!("{:+.3} µm off the forecast{place}, ", Figure(um))
}

/// A position without zeros at its end.
pub(super) fn short(at: Millimetres) -> String {
    let text = format!("{:.3}", Figure(at.mm()));
    text.trim_end_matches('0').trim_end_matches('.').to_string()
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

fn of_axis(axis: Option<Axis>) -> String {
    axis.map_or_else(|| "every axis".to_string(), |axis| format!("axis {axis}"))
}

fn subject(question: &Question<'_>, fault: &Fault) -> String {
    match fault {
        Fault::Times(scope, _) | Fault::Factor(scope) | Fault::DirectionsTurned(scope) => {
            tables(*scope)
        }
        Fault::None | Fault::Unit(_) => tables(Scope::All),
        Fault::Nothing => "all tables and backlash parameters".to_string(),
        Fault::Shifted(None) => "the tables of every axis".to_string(),
        Fault::Shifted(Some(axis)) => tables(Scope::Along(*axis)),
        Fault::Exchanged(scope, _) => tables(*scope),
        Fault::Transposed => "the tables of the cross terms".to_string(),
        Fault::Pair(one, two) => format!(
            "the tables of {one} and {two}{}",
            absent(question, *one, *two)
        ),
        Fault::BacklashTwice(axis) | Fault::BacklashNot(axis) | Fault::OneTable(axis, _) => {
            format!("the reversal of {}", of_axis(*axis))
        }
        Fault::OldTables | Fault::OldBeside => {
            "the tables that were active while measuring".to_string()
        }
        Fault::FirstTurned => "the first measurement".to_string(),
        Fault::SecondTurned => "the second measurement".to_string(),
        Fault::Recorded(slip) => slip.subject(),
        Fault::Temperature | Fault::TemperatureEach => "the scales of all axes".to_string(),
        Fault::TemperatureOf(axis) => format!("the scale of axis {axis}"),
    }
}

fn absent(question: &Question<'_>, one: ErrorTerm, two: ErrorTerm) -> String {
    let without = [one, two]
        .into_iter()
        .find(|term| !question.control.has_table(*term));
    without.map_or_else(String::new, |term| format!(" ({term} has none)"))
}

fn predicate(question: &Question<'_>, fault: &Fault, numbers: &Numbers) -> String {
    let number = |at: usize| numbers.fitted.get(at).copied().unwrap_or(0.0);
    let fixed = match fault {
        Fault::None => "act as forecast",
        Fault::Nothing => NOT_ACTIVE,
        Fault::Transposed => {
            "act with base and corrected axis exchanged (EYX as EXY): look at input and output axis"
        }
        Fault::Pair(..) => "are exchanged, or stand at the wrong axis",
        Fault::DirectionsTurned(_) => "for + and - act in the other direction",
        Fault::BacklashTwice(_) => {
            "is counted once too often: a backlash parameter acts beside the tables"
        }
        Fault::BacklashNot(_) => "is not compensated: the backlash parameter is 0",
        Fault::OldTables => "still act, the new ones do not: not loaded, or not switched on",
        Fault::OldBeside => "act beside the new ones, which hold their values already",
        Fault::FirstTurned => "has the wrong sign (direction of the laser), and so have the tables",
        Fault::SecondTurned => {
            "has the wrong sign (direction of the laser), and the tables do not act"
        }
        fault => return with_numbers(question, fault, numbers, number),
    };
    fixed.to_string()
}

/// What is said with a number or an axis in it.
fn with_numbers(
    question: &Question<'_>,
    fault: &Fault,
    numbers: &Numbers,
    number: impl Fn(usize) -> f64,
) -> String {
    match fault {
        Fault::Times(_, factor) => times(*factor),
        Fault::Recorded(slip) => slip.predicate(),
        Fault::Factor(_) => format!(
            "act {:.3} times as strong as planned: look at magnification, detection unit, weight of the table, radius or diameter",
            number(0)
        ),
        Fault::Unit(factor) => format!(
            "are read in another unit: positions and values {}",
            inch(*factor)
        ),
        Fault::Shifted(axis) => shift(*axis, numbers),
        Fault::Exchanged(_, map) => format!(
            "were made for X, Y, Z and act on {}, {}, {}: the control counts its axes in another order",
            map[0], map[1], map[2]
        ),
        Fault::OneTable(_, way) => {
            format!("is not compensated: the table for {way} acts in both directions")
        }
        Fault::TemperatureOf(axis) => kelvin(question, &[(*axis, number(0))]),
        Fault::Temperature => kelvin(question, &Axis::ALL.map(|axis| (axis, number(0)))),
        Fault::TemperatureEach => {
            let axes = Axis::ALL.into_iter().enumerate();
            let each: Vec<(Axis, f64)> = axes.map(|(at, axis)| (axis, number(at))).collect();
            kelvin(question, &each)
        }
        _ => String::new(),
    }
}

const NOT_ACTIVE: &str = "do not act: not switched on, not loaded, or the axes were not referenced";

fn times(factor: f64) -> String {
    if factor < 0.0 {
        return "act with the sign turned: they add where they should take away".to_string();
    }
    if factor == 0.0 {
        return NOT_ACTIVE.to_string();
    }
    if (factor - 2.0).abs() < 1e-12 {
        return "act twice: loaded beside an older compensation of the same errors, or with a doubled weight".to_string();
    }
    format!("act in another unit: {}", inch(factor))
}

fn inch(factor: f64) -> String {
    if (factor - MM_PER_INCH).abs() < 1e-9 {
        "25.4 times too large, millimetres taken for inches".to_string()
    } else if factor > 1.0 {
        format!("{factor:.0} times too large")
    } else if (factor * MM_PER_INCH - 1.0).abs() < 1e-9 {
        "25.4 times too small, inches taken for millimetres".to_string()
    } else {
        format!("{:.0} times too small", 1.0 / factor)
    }
}

fn shift(axis: Option<Axis>, numbers: &Numbers) -> String {
    let fitted = numbers.fitted.iter().zip(&numbers.uncertainty_mm);
    let each = fitted.enumerate().map(|(at, (mm, u))| {
        let decimals = usize::from(*u < 10.0);
        let named = axis.map_or_else(|| format!("{} ", Axis::ALL[at]), |_| String::new());
        let mm = Figure(*mm);
        format!("{named}{mm:+.decimals$} ± {u:.decimals$} mm")
    });
    format!(
        "act {} away from their place: the reference point is another one than in the job, or positions count from another zero",
        each.collect::<Vec<String>>().join(", ")
    )
}

/// Warmer scales: the growth of each, and the temperature; one number where all share it.
fn kelvin(question: &Question<'_>, axes: &[(Axis, f64)]) -> String {
    let grows = |(axis, kelvin): &(Axis, f64)| {
        let alpha = question.alpha_per_k[*axis] * 1e6;
        let um_per_m = question.um_per_m(*axis, *kelvin);
        if alpha > 0.0 {
            let (um_per_m, kelvin) = (Figure(um_per_m), Figure(*kelvin));
            format!("{axis} {um_per_m:+.2} µm/m ({kelvin:+.2} K at {alpha:.1}e-6 per K)")
        } else {
            format!("{axis} does not grow (0e-6 per K)")
        }
    };
    let each: Vec<String> = axes.iter().map(grows).collect();
    format!(
        "grew: {}: temperature of scale or workpiece, or its correction in the laser",
        each.join(", ")
    )
}

/// The numbers of a cause as they are printed.
pub(super) struct Numbers {
    /// As [`Cause::fitted`].
    pub(super) fitted: Vec<f64>,
    /// How far a shift may be off, mm; empty for other faults.
    uncertainty_mm: Vec<f64>,
}

impl Numbers {
    pub(super) fn of(data: &Data<'_>, fault: &Fault, fit: &Fit) -> Numbers {
        Numbers {
            fitted: fit.fitted.clone(),
            uncertainty_mm: data.shift_uncertainty_mm(fault, fit),
        }
    }
}
