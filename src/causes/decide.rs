//! The one measurement that decides between causes: where their corrections differ most.
//!
//! A control shows the compensation value that acts; reading it costs nothing. Where the causes
//! leave the control as planned (temperature), a linear run decides.

use super::data::Fit;
use super::fault::{Fault, Planned};
use super::question::Question;
use super::words::label;
use crate::after::Part;
use crate::axis::{Axis, Direction, ErrorTerm};
use crate::units::Millimetres;

/// What a display and a dial gauge tell apart, µm.
const TOLD_APART_UM: f64 = 0.5;
/// The last digit that is shown, µm.
const SHOWN_UM: f64 = 0.001;
/// Largest bump of a proof of the sign, µm.
const BUMP_UM: u32 = 20;

/// A place to look at, and what each fault shows there.
struct Look {
    part: Part,
    values_um: Vec<f64>,
    /// Groups of faults that differ there.
    groups: usize,
    /// Smallest distance of two groups, µm.
    gap_um: f64,
}

/// The sentence.
pub(super) fn decides(question: &Question<'_>, standing: &[(&Fault, Fit)]) -> String {
    let thermal = |fault: &Fault| fault.kind() == "temperature";
    if standing.iter().all(|(fault, _)| thermal(fault)) {
        return linear_run(question, standing);
    }
    match best_look(question, standing) {
        Some(look) => display(question, standing, &look),
        None => format!(
            "these causes differ nowhere by more than {:.3} um on the tables of this kit: read the tables out of the control and compare their values with the files, then look whether they are switched on",
            told_apart_um(question)
        ),
    }
}

/// What a display tells apart, µm.
fn told_apart_um(question: &Question<'_>) -> f64 {
    TOLD_APART_UM.max(2.0 * question.count_um)
}

fn best_look(question: &Question<'_>, standing: &[(&Fault, Fit)]) -> Option<Look> {
    let mut best: Option<Look> = None;
    for term in ErrorTerm::ALL {
        for at in question.control.nodes(term) {
            for direction in Direction::BOTH {
                let part = Part {
                    term,
                    direction,
                    at,
                    weight: 1.0,
                };
                let look = look(question, standing, part);
                let better = best
                    .as_ref()
                    .is_none_or(|other| (look.groups, look.gap_um) > (other.groups, other.gap_um));
                if better {
                    best = Some(look);
                }
            }
        }
    }
    best.filter(|look| look.groups > 1)
}

/// What the display shows: the correction, without what the temperature does to the machine.
fn shown_um(question: &Question<'_>, fault: &Fault, fit: Option<&Fit>, part: &Part) -> f64 {
    let planned = Planned {
        tables: question
            .control
            .tables_um(part.term, part.direction, part.at),
        constant: question.control.constant_um(part.term, part.direction),
    };
    if fault.kind() == "temperature" {
        return planned.tables + planned.constant;
    }
    let fitted = fit.map(|fit| fit.fitted.as_slice()).unwrap_or_default();
    fault.effect(question, fitted, part, planned)
}

fn look(question: &Question<'_>, standing: &[(&Fault, Fit)], part: Part) -> Look {
    let mut values_um: Vec<f64> = standing
        .iter()
        .map(|(fault, fit)| shown_um(question, fault, Some(fit), &part))
        .collect();
    if standing.len() == 1 {
        values_um.push(shown_um(question, &Fault::None, None, &part));
    }
    let mut sorted = values_um.clone();
    sorted.sort_by(f64::total_cmp);
    let told_apart = told_apart_um(question);
    let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let gaps: Vec<f64> = gaps.filter(|gap| *gap > told_apart).collect();
    Look {
        part,
        values_um,
        groups: gaps.len() + 1,
        gap_um: gaps.iter().copied().reduce(f64::min).unwrap_or(0.0),
    }
}

fn display(question: &Question<'_>, standing: &[(&Fault, Fit)], look: &Look) -> String {
    let Part {
        term,
        direction,
        at,
        ..
    } = look.part;
    let planned = shown_um(question, &Fault::None, None, &look.part);
    let mut said: Vec<(String, f64)> = Vec::new();
    for ((fault, _), um) in standing.iter().zip(&look.values_um) {
        let label = label(question, fault);
        match said
            .iter_mut()
            .find(|(_, other)| (other - um).abs() < SHOWN_UM)
        {
            Some((words, _)) => add_label(words, &label),
            None => said.push((label, *um)),
        }
    }
    let cases: Vec<String> = said
        .iter()
        .map(|(words, um)| format!("{um:+.3} um if {words}"))
        .collect();
    let turned = standing
        .iter()
        .any(|(fault, _)| fault.kind() == "sign turned");
    let bump = if turned {
        format!(
            "; the sign of the display is the control's own: prove it with one bump of at most {BUMP_UM} um and a dial gauge"
        )
    } else {
        String::new()
    };
    format!(
        "look at the service display: with {} at {} mm, come there moving {direction}, the compensation of axis {} is {planned:+.3} um if the control does what the files say, {}{bump}",
        term.along,
        short(at),
        term.of,
        cases.join(", ")
    )
}

/// Labels of one value are joined; many are cut.
fn add_label(words: &mut String, label: &str) {
    const MOST: usize = 3;
    let joined = words.matches(" or ").count() + 1;
    if joined < MOST {
        words.push_str(" or ");
        words.push_str(label);
    } else if !words.ends_with(" …") {
        words.push_str(" …");
    }
}

fn short(at: Millimetres) -> String {
    let text = format!("{:.3}", at.mm());
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// Temperature leaves the control alone: the axis on which the explanations differ most.
fn linear_run(question: &Question<'_>, standing: &[(&Fault, Fit)]) -> String {
    let slope = |axis: Axis, (fault, fit): &(&Fault, Fit)| {
        let at = Millimetres::new(question.reference_mm[axis] + 1000.0);
        let part = Part {
            term: ErrorTerm {
                of: axis,
                along: axis,
            },
            direction: Direction::Plus,
            at,
            weight: 1.0,
        };
        let nothing = Planned {
            tables: 0.0,
            constant: 0.0,
        };
        fault.effect(question, &fit.fitted, &part, nothing)
    };
    let spread = |axis: &Axis| {
        let slopes: Vec<f64> = standing.iter().map(|found| slope(*axis, found)).collect();
        let high = slopes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let low = slopes.iter().copied().fold(f64::INFINITY, f64::min);
        if slopes.len() == 1 {
            high.abs()
        } else {
            high - low
        }
    };
    let axis = Axis::ALL
        .into_iter()
        .max_by(|a, b| spread(a).total_cmp(&spread(b)));
    let axis = axis.unwrap_or(Axis::X);
    format!(
        "repeat one bidirectional linear run of axis {axis} with the machine at another temperature, with its sensors on scale and workpiece: a temperature moves the slope ({:.1} um/m per K), a fault of the tables does not",
        question.alpha_per_k[axis] * 1e6
    )
}
