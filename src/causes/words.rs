//! Causes in words for the shop floor.

use super::fault::{Fault, Scope};
use super::question::Question;
use crate::axis::{Axis, ErrorTerm};
use crate::units::MM_PER_INCH;

/// How many faults of one kind are named; they look the same in the data.
const NAMED: usize = 3;

/// One sentence for a cause: what happened to which tables, and what it usually comes from.
pub(super) fn cause(question: &Question<'_>, faults: &[Fault], fitted: &[f64]) -> String {
    let mut which: Vec<String> = Vec::new();
    for fault in faults {
        let words = subject(question, fault);
        if !which.contains(&words) {
            which.push(words);
        }
    }
    let more = which.len().saturating_sub(NAMED);
    which.truncate(NAMED);
    let mut which = which.join(", or ");
    if more > 0 {
        which = format!("{which}, or part of them");
    }
    format!("{which} {}", predicate(question, &faults[0], fitted))
}

/// A fault in a few words.
pub(super) fn label(question: &Question<'_>, fault: &Fault) -> String {
    format!("{} ({})", fault.kind(), subject(question, fault))
}

/// The tables of a scope.
fn tables(scope: Scope) -> String {
    match scope {
        Scope::All => "all tables".to_string(),
        Scope::Positioning => "the positioning tables".to_string(),
        Scope::Cross => "the tables of the cross terms".to_string(),
        Scope::Along(axis) => format!("the tables looked up along {axis}"),
        Scope::Of(axis) => format!("the tables that correct {axis}"),
        Scope::Term(term) => format!("the table of {term}"),
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
        Fault::Exchanged(scope, _) => format!("{}, made for X, Y, Z,", tables(*scope)),
        Fault::Transposed => "the tables of the cross terms".to_string(),
        Fault::Pair(one, two) => format!(
            "the tables of {one} and {two}{}",
            absent(question, *one, *two)
        ),
        Fault::BacklashTwice(axis) | Fault::BacklashNot(axis) => {
            format!("the reversal of {}", of_axis(*axis))
        }
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

fn predicate(question: &Question<'_>, fault: &Fault, fitted: &[f64]) -> String {
    let number = |at: usize| fitted.get(at).copied().unwrap_or(0.0);
    match fault {
        Fault::None => "act as forecast".to_string(),
        Fault::Times(_, factor) => times(*factor),
        Fault::Nothing => {
            "do not act: not switched on, not loaded, or the axes were not referenced".to_string()
        }
        Fault::Factor(_) => format!(
            "act {:.3} times as strong as planned: look at magnification, detection unit, weight of the table, radius or diameter",
            number(0)
        ),
        Fault::Unit(factor) => format!(
            "are read in another unit: positions and values {}",
            inch(*factor)
        ),
        Fault::Shifted(Some(_)) => shift(&[number(0)]),
        Fault::Shifted(None) => shift(fitted),
        Fault::Exchanged(_, map) => format!(
            "act on {}, {}, {}: the control counts its axes in another order",
            map[0], map[1], map[2]
        ),
        Fault::Transposed => {
            "act with base and corrected axis exchanged (EYX as EXY): look at input and output axis"
                .to_string()
        }
        Fault::Pair(..) => "are exchanged, or stand at the wrong axis".to_string(),
        Fault::DirectionsTurned(_) => "for + and - act in the other direction".to_string(),
        Fault::BacklashTwice(_) => {
            "is counted once too often: a backlash parameter acts beside the tables".to_string()
        }
        Fault::BacklashNot(_) => {
            "is not compensated: the backlash parameter is 0, or one table acts in both directions"
                .to_string()
        }
        Fault::Temperature => kelvin(question, Axis::X, number(0)),
        Fault::TemperatureOf(axis) => kelvin(question, *axis, number(0)),
        Fault::TemperatureEach => {
            let each: Vec<String> = Axis::ALL
                .into_iter()
                .enumerate()
                .map(|(at, axis)| format!("{axis} {}", kelvin(question, axis, number(at))))
                .collect();
            format!("differ each by its own: {}", each.join("; "))
        }
    }
}

fn times(factor: f64) -> String {
    if factor < 0.0 {
        return "act with the sign turned: they add where they should take away".to_string();
    }
    if factor == 0.0 {
        return "do not act: not switched on, not loaded, or the axes were not referenced"
            .to_string();
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

fn shift(fitted: &[f64]) -> String {
    let mm: Vec<String> = if let [only] = fitted {
        vec![format!("{only:+.3}")]
    } else {
        let pairs = Axis::ALL.into_iter().zip(fitted);
        pairs.map(|(axis, mm)| format!("{axis} {mm:+.3}")).collect()
    };
    format!(
        "act {} mm away from their place: the reference point is another one than in the job, or positions count from another zero",
        mm.join(", ")
    )
}

fn kelvin(question: &Question<'_>, axis: Axis, um_per_m: f64) -> String {
    let alpha = question.alpha_per_k[axis] * 1e6;
    format!(
        "{um_per_m:+.2} um/m, as from {:+.2} K at {alpha:.1}e-6 per K: temperature of scale or workpiece, or its correction in the laser",
        um_per_m / alpha
    )
}
