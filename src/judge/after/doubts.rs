//! Why as-left figures decide nothing in favour, and what whoever reads the page should know.

use super::{AfterMeasurement, Control, StraightRuns, unseen_reversal};
use crate::machine::model::{ErrorModel, MeasuredTerm};
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::Millimetres;

/// Gaps between the positions measured again, in gaps of the first measurement, beyond which
/// nothing is known between them: every second position is enough, fewer are not.
const WIDEST_GAP: f64 = 2.0;
/// Positions of inch targets are rounded.
const ROUNDING: f64 = 1.0 + 1e-6;

/// Why the figures decide nothing in favour, one sentence each.
pub(super) fn doubts(
    before: &ErrorModel,
    control: Option<&Control>,
    after: &AfterMeasurement,
) -> Vec<String> {
    let mut doubts = match after {
        AfterMeasurement::Errors(model) => model.doubts(|_| true),
        AfterMeasurement::Diagonals(_) => Vec::new(),
    };
    if let AfterMeasurement::Errors(model) = after {
        let axes = Axis::ALL.into_iter();
        doubts.extend(axes.filter_map(|axis| sparse(before, model, axis)));
        doubts.extend(reversal_not_seen(before, control, model));
        doubts.extend(other_frame(before, model));
    }
    doubts
}

/// Values that nobody measured after the tables were loaded.
pub(super) fn not_measured(before: &ErrorModel, after: &AfterMeasurement) -> Option<String> {
    let measured_first = before.remarks.simulated().next().is_none();
    if after.is_simulated() && measured_first {
        return Some("the values afterwards were simulated, those as found were measured: a rehearsal says nothing of this machine".to_string());
    }
    let flat = after.flat();
    if !flat.is_empty() {
        return Some(format!(
            "the values afterwards are the same at all positions, which no laser reads: {}; an empty column, no measurement",
            flat.join(", ")
        ));
    }
    let same = matches!(after, AfterMeasurement::Errors(model) if has_same_values(before, model));
    same.then(|| {
        "the values afterwards are those of the first measurement: the same file, or a copy of it"
            .to_string()
    })
}

/// Values that differ by less were not measured twice, µm.
const SAME_UM: f64 = 0.01;

/// Whether both measurements hold the same values at the same places, their zeros apart.
fn has_same_values(before: &ErrorModel, after: &ErrorModel) -> bool {
    let near = |a: &ErrorCurve, b: &ErrorCurve| {
        let off = |at: &Millimetres| (a.at(*at) - b.at(*at)).um().abs();
        a.knots() == b.knots() && a.knots().iter().all(|at| off(at) < SAME_UM)
    };
    let same = |(term, second): (ErrorTerm, &MeasuredTerm)| {
        let first = before.terms[term].as_ref();
        first.is_some_and(|first| {
            let pairs = first.curves().zip(second.curves());
            first.curves().count() == second.curves().count()
                && pairs.into_iter().all(|(a, b)| near(a, b))
        })
    };
    after.measured().all(same)
}

/// An axis that was measured again at far fewer positions.
fn sparse(before: &ErrorModel, after: &ErrorModel, axis: Axis) -> Option<String> {
    let terms = after.measured().filter(|(term, _)| term.along == axis);
    let gaps = terms.filter_map(|(term, measured)| {
        let first = before.terms[term].as_ref()?;
        Some((widest_gap_mm(first)?, widest_gap_mm(measured)?))
    });
    let (first, second) = gaps
        .filter(|(first, second)| *second > ROUNDING * WIDEST_GAP * first)
        .reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    Some(format!(
        "axis {axis} was measured at positions {first:.3} mm apart as found, afterwards up to {second:.3} mm apart: nothing is known between them"
    ))
}

/// Widest gap between neighbouring positions of a term, mm.
fn widest_gap_mm(measured: &MeasuredTerm) -> Option<f64> {
    let gaps = measured.curves().flat_map(|curve| {
        let pairs = curve.knots().windows(2);
        pairs.map(|pair| (pair[1] - pair[0]).mm())
    });
    gaps.reduce(f64::max)
}

/// Terms that were found in both directions and not measured so again.
fn fewer_ways<'a>(
    before: &'a ErrorModel,
    after: &'a ErrorModel,
) -> impl Iterator<Item = (ErrorTerm, &'a MeasuredTerm)> {
    after.measured().filter(|(term, measured)| {
        let both = |m: &MeasuredTerm| m.measured.has_both_ways();
        before.terms[*term].as_ref().is_some_and(both) && !both(measured)
    })
}

/// Both directions are corrected apart, and only one of them, or their mean, was measured again.
fn reversal_not_seen(
    before: &ErrorModel,
    control: Option<&Control>,
    after: &ErrorModel,
) -> Option<String> {
    let control = control?;
    let terms = fewer_ways(before, after).filter(|(term, _)| !control.is_undirected(*term));
    let names = names(terms.map(|(term, _)| term));
    (!names.is_empty()).then(|| {
        format!("the two directions are corrected apart, but were not both measured afterwards, so nothing is known of the reversal that is left: {names}")
    })
}

/// Slopes of cross terms hold the rotation of the frame they are given in.
fn other_frame(before: &ErrorModel, after: &ErrorModel) -> Option<String> {
    let (first, second) = (frame(before), frame(after));
    let crossed =
        |(term, _): (ErrorTerm, &MeasuredTerm)| term.is_cross() && before.terms[term].is_some();
    let rotates = after.measured().any(crossed);
    (rotates && first != second).then(|| {
        let said = |frame: Option<&str>| frame.unwrap_or("as given").to_string();
        format!(
            "the two measurements count from different frames (as found: {}; afterwards: {}): the slopes of their cross terms differ by a rotation that neither measured, so what is off the forecast there, and the causes, may be the frame",
            said(first), said(second)
        )
    })
}

/// What a table that was separated says of its frame, without the explanation in brackets.
fn frame(model: &ErrorModel) -> Option<&str> {
    let mut notes = model.remarks.notes.iter();
    let note = notes.find(|note| note.starts_with("frame"))?;
    let end = note.find([';', '(']).unwrap_or(note.len());
    Some(note[..end].trim())
}

/// What whoever reads the page should know, one sentence each.
pub(super) fn notes(before: &ErrorModel, after: &AfterMeasurement) -> Vec<String> {
    match after {
        AfterMeasurement::Errors(model) => of_curves(before, model),
        AfterMeasurement::Diagonals(runs) => of_runs(runs),
    }
}

fn of_runs(runs: &StraightRuns) -> Vec<String> {
    let mut notes = runs.labels.clone();
    notes.push(
        "straight runs show the body diagonals only: the nine errors were not measured afterwards"
            .to_string(),
    );
    notes
}

fn of_curves(before: &ErrorModel, after: &ErrorModel) -> Vec<String> {
    let mut notes = after.remarks.notes.clone();
    let fewer = names(fewer_ways(before, after).map(|(term, _)| term));
    if !fewer.is_empty() {
        notes.push(format!(
            "found in both directions, measured afterwards without: {fewer}; a fault of the reversal does not show"
        ));
    }
    notes.extend(unseen_reversal(before, after).map(|reversal| reversal.words));
    notes
}

fn names(terms: impl Iterator<Item = ErrorTerm>) -> String {
    let names: Vec<String> = terms.map(|term| term.to_string()).collect();
    names.join(", ")
}
