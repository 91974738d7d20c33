//! Why as-left figures decide nothing in favour, and what whoever reads the page should know.

use super::measurement::AfterMeasurement;
use crate::inputs::error_table::Cause;
use crate::judge::findings::AsLeft;
use crate::machine::model::{ErrorModel, Measured, MeasuredTerm};
use crate::quantity::{Axis, ErrorCurve, ErrorTerm, Millimetres};
use crate::text::Finding;

/// Gaps between the positions measured again, in gaps of the first measurement, beyond which
/// nothing is known between them: every second position is enough, fewer are not.
const WIDEST_GAP: f64 = 2.0;
/// Positions of inch targets are rounded.
const ROUNDING: f64 = 1.0 + 1e-6;

/// Values that nobody measured; doubts; and notes.
pub(super) fn findings(
    measured_first: &ErrorModel,
    before: &ErrorModel,
    after: &AfterMeasurement,
) -> Vec<Finding> {
    let mut found = Vec::from_iter(not_measured(measured_first, after).map(Finding::from));
    match after {
        AfterMeasurement::Errors(model) => {
            found.extend(model.doubts(|_| true));
            let sparse = Axis::ALL.map(|axis| sparse(before, model, axis)).into_iter();
            let doubts =
                sparse.chain([reversal_not_seen(before, model), other_frame(before, model)]);
            found.extend(doubts.flatten().map(Finding::from));
            found.extend(repeats_bias(before, model).map(Finding::from));
            found.extend(model.remarks.notes.iter().cloned());
            found.extend(unseen_reversal(before, model).map(|reversal| reversal.found));
        }
        AfterMeasurement::Diagonals(runs) => {
            let labels = runs.labels.iter().cloned();
            let labels = labels.map(|label| AsLeft::RestsOn { label });
            found.extend(labels.chain([AsLeft::DiagonalsOnly]).map(Finding::from));
        }
    }
    found
}

/// Values that nobody measured after the tables were loaded.
fn not_measured(before: &ErrorModel, after: &AfterMeasurement) -> Option<AsLeft> {
    let measured_first = before.remarks.simulated().next().is_none();
    let flat = after.flat();
    if after.is_simulated() && measured_first {
        Some(AsLeft::Simulated)
    } else if !flat.is_empty() {
        Some(AsLeft::Flat { what: flat })
    } else {
        let is_copy =
            matches!(after, AfterMeasurement::Errors(model) if has_same_values(before, model));
        is_copy.then_some(AsLeft::Copy)
    }
}

/// Whether both measurements hold the same values at the same places, their zeros apart.
fn has_same_values(before: &ErrorModel, after: &ErrorModel) -> bool {
    /// Values that differ by less were not measured twice, µm.
    const SAME_UM: f64 = 0.01;
    let near = |(a, b): (&ErrorCurve, &ErrorCurve)| {
        let off = |at: &Millimetres| (a.at(*at) - b.at(*at)).um().abs();
        a.knots() == b.knots() && a.knots().iter().all(|at| off(at) < SAME_UM)
    };
    after.measured().all(|(term, second)| {
        before.terms[term].as_ref().is_some_and(|first| {
            first.curves().count() == second.curves().count()
                && first.curves().zip(second.curves()).all(near)
        })
    })
}

/// An axis that was measured again at far fewer positions.
fn sparse(before: &ErrorModel, after: &ErrorModel, axis: Axis) -> Option<AsLeft> {
    let terms = after.measured().filter(|(term, _)| term.along == axis);
    let gaps = terms.filter_map(|(term, measured)| {
        let first = before.terms[term].as_ref()?;
        Some((widest_gap_mm(first)?, widest_gap_mm(measured)?))
    });
    let (first_mm, second_mm) = gaps
        .filter(|(first, second)| *second > ROUNDING * WIDEST_GAP * first)
        .reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    Some(AsLeft::Sparse { axis, first_mm, second_mm })
}

/// Widest gap between neighbouring positions of a term, mm.
fn widest_gap_mm(measured: &MeasuredTerm) -> Option<f64> {
    let gaps = measured.curves().flat_map(|curve| {
        let pairs = curve.knots().windows(2);
        pairs.map(|pair| (pair[1] - pair[0]).mm())
    });
    gaps.reduce(f64::max)
}

/// Terms that are known in both directions as found, of which one, or the mean, was measured again.
fn reversal_not_seen(before: &ErrorModel, after: &ErrorModel) -> Option<AsLeft> {
    let both = |measured: &MeasuredTerm| measured.measured.has_both_ways();
    let known = |term: ErrorTerm| before.terms[term].as_ref().is_some_and(both);
    let seen = after.measured();
    let fewer = seen.filter(|(term, measured)| known(*term) && !both(measured));
    let terms: Vec<ErrorTerm> = fewer.map(|(term, _)| term).collect();
    (!terms.is_empty()).then_some(AsLeft::ReversalNotSeen { terms })
}

/// What neither measurement can show, as both were made alike.
fn repeats_bias(before: &ErrorModel, after: &ErrorModel) -> Option<AsLeft> {
    let both = [before, after].map(|model| &model.remarks);
    let [first, second] = both.map(|of| of.same_laser.as_ref().map(|(serial, _)| serial));
    let has_angles = both.iter().all(|of| of.anew.is_some());
    let silent = both.iter().all(|of| of.silence.not_stated.contains(&Cause::Angles));
    let (what, at_most) = match (first.is_some() && first == second, has_angles) {
        (true, true) => (
            "angles without a measurement and the scale of the same laser falsify",
            "\"at most\" holds what `angle_urad` and `laser_ppm` state of it",
        ),
        (true, false) if !silent => (
            "the scale of the same laser falsifies",
            "\"at most\" holds what `laser_ppm` states of it",
        ),
        (_, true) => (
            "angles without a measurement falsify",
            "\"at most\" holds what `angle_urad` states of it",
        ),
        (_, false) => {
            ("angles without a measurement falsify", "without `angle_urad` nothing holds it")
        }
    };
    let is_repeated = silent || before.remarks.anew_beside(&after.remarks).is_some();
    is_repeated.then_some(AsLeft::RepeatsBias { what, at_most })
}

/// Slopes of cross terms hold the rotation of the frame they are given in.
fn other_frame(before: &ErrorModel, after: &ErrorModel) -> Option<AsLeft> {
    let crossed =
        |(term, _): (ErrorTerm, &MeasuredTerm)| term.is_cross() && before.terms[term].is_some();
    let rotates = after.measured().any(crossed);
    let [first, second] = [before, after].map(|model| model.remarks.frame);
    (rotates && first != second).then_some(AsLeft::OtherFrame { first, second })
}

/// The reversal of a second measurement in both directions, where the first one did not tell them
/// apart.
#[derive(Clone, Debug)]
pub struct UnseenReversal {
    /// B of each of these errors.
    pub found: Finding,
    /// The second measurement with the mean of both directions in their place.
    pub without: ErrorModel,
}

/// What the first measurement could not see; `None` where both tell the directions apart, or
/// neither does.
pub(crate) fn unseen_reversal(before: &ErrorModel, after: &ErrorModel) -> Option<UnseenReversal> {
    let mut without = after.clone();
    let mut reversals_um = Vec::new();
    for term in ErrorTerm::ALL {
        let (Some(first), Some(second)) = (&before.terms[term], &mut without.terms[term]) else {
            continue;
        };
        let reversal = second.reversal();
        if let Some(reversal) = reversal.filter(|_| !first.measured.has_both_ways()) {
            reversals_um.push((term, reversal.um()));
            second.measured = Measured::Undirected(second.measured.mean());
        }
    }
    (!reversals_um.is_empty())
        .then(|| UnseenReversal { found: AsLeft::LostMotion { reversals_um }.into(), without })
}
