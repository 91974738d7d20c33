//! The one look that decides between causes: where the corrections that act differ most.
//!
//! A control may show the compensation value that acts; reading it costs nothing. No manual says
//! with which sign, so amounts are compared. Where no display is known the tables are read back;
//! where only a sign is in question a bump decides; where the control does as planned
//! (temperature), a linear run; where the first readings may be filed wrongly, their records.

use super::fault::{Act, Fault, Fit, Planned, number};
use super::question::{Question, Slip};
use crate::judge::after::Part;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::units::{Figure, Millimetres};

/// What a display and a dial gauge tell apart, µm.
const TOLD_APART_UM: f64 = 0.5;
/// The last digit that is shown, µm.
const SHOWN_UM: f64 = 0.001;
/// Largest bump of a proof of the sign, µm.
const BUMP_UM: u32 = 20;

/// Corrections that act at one place, coming there moving + and moving −, µm.
type BothWays = [f64; 2];

/// A place to look at, and what each fault shows there.
struct Look {
    term: ErrorTerm,
    at: Millimetres,
    shown_um: Vec<BothWays>,
    /// Groups of faults, and of the files, that differ there.
    groups: usize,
    /// Smallest distance of two groups, µm.
    gap_um: f64,
}

impl Look {
    /// Whether no two faults show the same.
    fn tells_all_apart(&self, told_apart_um: f64) -> bool {
        let shown = self.shown_um.iter().enumerate();
        let mut pairs =
            shown.flat_map(|(at, one)| self.shown_um[at + 1..].iter().map(|o| (*one, *o)));
        pairs.all(|(one, other)| apart_um(one, other) > told_apart_um)
    }
}

/// The sentence.
pub(super) fn decides(question: &Question<'_>, standing: &[(&Fault, Fit)]) -> String {
    let of_kind = |kind: &str| standing.iter().any(|(fault, _)| fault.kind == kind);
    let thermal = |(fault, _): &(&Fault, Fit)| fault.kind == "temperature";
    if standing.iter().all(thermal) {
        return linear_run(question, standing);
    }
    let of_records = checks_of_records(standing);
    if standing.iter().all(|(fault, _)| slip(fault).is_some()) {
        return of_records.join("; ");
    }
    let look = match question.display {
        Some(display) => by_display(question, standing, display),
        None => format!("no display of the correction is known of this control: {}", read_back()),
    };
    let mut steps = vec![look];
    if of_kind("sign turned") || question.display.is_none() {
        steps.push(format!(
            "one bump of at most {BUMP_UM} µm and a dial gauge prove sign and size of what acts"
        ));
    }
    if of_kind("measurement turned") {
        steps.push("move an axis in + and look whether the laser counts in +".to_string());
    }
    if standing.iter().any(thermal) {
        steps.push("read the temperatures of scales and workpiece".to_string());
    }
    steps.extend(of_records.into_iter().map(str::to_string));
    steps.join("; ")
}

const fn slip(fault: &Fault) -> Option<Slip> {
    match &fault.act {
        Act::Recorded(slip) => Some(*slip),
        _ => None,
    }
}

/// What to look at where the records of the first measurement may be wrong; the control does as
/// planned then.
fn checks_of_records(standing: &[(&Fault, Fit)]) -> Vec<&'static str> {
    let slips = standing.iter().filter_map(|(fault, _)| slip(fault));
    let mut checks: Vec<&str> = slips.map(Slip::check).collect();
    checks.dedup();
    checks
}

fn read_back() -> &'static str {
    "read tables and parameters out of the control and compare them with the files (`nonius verify JOB --tables DIR`), then look whether they are switched on, once"
}

fn by_display(question: &Question<'_>, standing: &[(&Fault, Fit)], display: &str) -> String {
    match best_look(question, standing) {
        Some(look) if look.tells_all_apart(told_apart_um(question)) => {
            display_at(question, standing, &look, display)
        }
        Some(look) => format!(
            "{}; where that leaves more than one, {}",
            display_at(question, standing, &look, display),
            read_back()
        ),
        None => format!(
            "where was measured, what {display} shows is the same for all within {:.3} µm: {}",
            told_apart_um(question),
            read_back()
        ),
    }
}

/// What a display tells apart, µm.
fn told_apart_um(question: &Question<'_>) -> f64 {
    TOLD_APART_UM.max(2.0 * question.count_um)
}

/// The place, among the nodes of the tables where the second measurement looked.
fn best_look(question: &Question<'_>, standing: &[(&Fault, Fit)]) -> Option<Look> {
    let looked = |term: ErrorTerm| {
        let range = question.range_mm(term.along);
        let within = move |at: &Millimetres| {
            range.is_some_and(|(low, high)| at.mm() >= low && at.mm() <= high)
        };
        question.control.nodes(term).into_iter().filter(within)
    };
    let places =
        question.terms().into_iter().flat_map(|term| looked(term).map(move |at| (term, at)));
    let looks = places.map(|(term, at)| look(question, standing, term, at));
    let better = |best: Look, other: Look| {
        if (other.groups, other.gap_um) > (best.groups, best.gap_um) { other } else { best }
    };
    looks.reduce(better).filter(|look| look.groups > 1)
}

/// What acts at a place; temperature, a turned measurement and slips of its records leave the control as planned.
fn acting_um(
    question: &Question<'_>,
    fault: &Fault,
    fitted: &[f64],
    (term, at): (ErrorTerm, Millimetres),
) -> BothWays {
    Direction::BOTH.map(|direction| {
        let part = Part { term, direction, at, weight: 1.0 };
        let planned = Planned::of(question, &part);
        fault.correction(question, fitted, &part, planned)
    })
}

/// Distance of two amounts, the larger of both directions, µm.
fn apart_um(one: BothWays, other: BothWays) -> f64 {
    let way = |at: usize| (one[at].abs() - other[at].abs()).abs();
    way(0).max(way(1))
}

fn look(
    question: &Question<'_>,
    standing: &[(&Fault, Fit)],
    term: ErrorTerm,
    at: Millimetres,
) -> Look {
    let acting = |(fault, fit): &(&Fault, Fit)| acting_um(question, fault, &fit.fitted, (term, at));
    let shown_um: Vec<BothWays> = standing.iter().map(acting).collect();
    let planned = acting_um(question, &Fault::none(), &[], (term, at));
    let told_apart = told_apart_um(question);
    let mut groups: Vec<BothWays> = Vec::new();
    let mut gap_um = f64::INFINITY;
    for shown in [&planned].into_iter().chain(&shown_um) {
        let distance = groups.iter().map(|other| apart_um(*shown, *other));
        let nearest = distance.fold(f64::INFINITY, f64::min);
        if nearest > told_apart {
            groups.push(*shown);
            gap_um = gap_um.min(nearest);
        }
    }
    Look { term, at, shown_um, groups: groups.len(), gap_um }
}

fn display_at(
    question: &Question<'_>,
    standing: &[(&Fault, Fit)],
    look: &Look,
    display: &str,
) -> String {
    let Look { term, at, .. } = look;
    let planned = acting_um(question, &Fault::none(), &[], (*term, *at));
    let mut said: Vec<(String, BothWays)> = Vec::new();
    for ((fault, _), shown) in standing.iter().zip(&look.shown_um) {
        let label = &fault.label;
        match said.iter_mut().find(|(_, other)| apart_um(*shown, *other) < SHOWN_UM) {
            Some((words, _)) => add_label(words, label),
            None => said.push((label.clone(), *shown)),
        }
    }
    let shown = said.iter().map(|(_, shown)| *shown).chain([planned]);
    let alike = shown.into_iter().all(|[plus, minus]| (plus.abs() - minus.abs()).abs() < SHOWN_UM);
    let amount = |[plus, minus]: BothWays| {
        if alike {
            format!("{:.3} µm", plus.abs())
        } else {
            format!("{:.3} / {:.3} µm", plus.abs(), minus.abs())
        }
    };
    let cases: Vec<String> =
        said.iter().map(|(words, shown)| format!("{} if {words}", amount(*shown))).collect();
    let coming = if alike { "" } else { " coming there moving + / moving -," };
    format!(
        "look at {display}: {} at {} mm, the other axes at their reference points,{coming} the amount for axis {} is {} if the control does what the files say, {} (its sign on the display is not documented)",
        term.along,
        Figure(at.mm()).trimmed(3),
        term.of,
        amount(planned),
        cases.join(", ")
    )
}

/// Labels of one value are joined; many are cut.
fn add_label(words: &mut String, label: &str) {
    const MOST: usize = 3;
    let joined = words.matches(" or ").count() + 1;
    if words.contains(label) {
        return;
    }
    if joined < MOST {
        words.push_str(" or ");
        words.push_str(label);
    } else if !words.ends_with(" …") {
        words.push_str(" …");
    }
}

/// Temperature leaves the control alone: the axis on which the explanations differ most.
fn linear_run(question: &Question<'_>, standing: &[(&Fault, Fit)]) -> String {
    let slope = |axis: Axis, (fault, fit): &(&Fault, Fit)| match &fault.act {
        Act::Warmer(places) => question.um_per_m(axis, number(&fit.fitted, places[axis])),
        _ => 0.0,
    };
    let spread = |axis: &Axis| {
        let slopes: Vec<f64> = standing.iter().map(|found| slope(*axis, found)).collect();
        let high = slopes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let low = slopes.iter().copied().fold(f64::INFINITY, f64::min);
        if slopes.len() == 1 { high.abs() } else { high - low }
    };
    let axis = Axis::ALL.into_iter().max_by(|a, b| spread(a).total_cmp(&spread(b)));
    let axis = axis.unwrap_or(Axis::X);
    format!(
        "repeat one bidirectional linear run of axis {axis} with the machine at another temperature, with its sensors on scale and workpiece: a temperature moves the slope ({:.1} µm/m per K), a fault of the tables does not",
        question.alpha_per_k[axis] * 1e6
    )
}
