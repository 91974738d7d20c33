//! Whether both measurements say anything about the same thing (one machine, errors and ranges in common), and why
//! figures as left decide nothing in favour.

use super::measurement::{AfterMeasurement, StraightRuns};
use crate::inputs::error_table::Cause;
use crate::inputs::job::{Acceptance, Frame, Job, Linear, LinearSlope};
use crate::judge::findings::{AsLeft, joined};
use crate::judge::refusals;
use crate::machine::model::{ErrorModel, MeasuredTerm, TermCurves};
use crate::machine::separation::curves::range;
use crate::quantity::{Axis, Direction, ErrorCurve, ErrorTerm, Volume};
use crate::text::{Finding, Problems, Severity};
use crate::write::grid::EDGE_MM;

/// Refuses a second job of another machine: serial number, travel, reference point and direction
/// of the reference return have to be those of the first, each shown at both places.
pub(crate) fn ensure_same_machine(first: &Job, second: &Job) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for ((key, what, here), (.., there)) in told(first).into_iter().zip(told(second)) {
        if let (Some(here), Some(there)) = (here, there)
            && here != there
        {
            let other = refusals::of_other_machine(&what, there, &here);
            problems.push(second.source.at(&key, other));
            problems.push(first.source.at(&key, refusals::as_found(what, here)));
        }
    }
    // Lengths that were brought to 20 °C cannot be compared with lengths that were not.
    let stated = |job: &Job| Some(job.measurement.diagonals()?.material.is_some());
    if (stated(first), stated(second)) == (Some(true), Some(false)) {
        problems.push(second.source.at("", refusals::no_material()));
    }
    if ![Acceptance::default(), first.acceptance].contains(&second.acceptance) {
        problems.push(second.source.at("acceptance", refusals::other_limits()));
    }
    problems.or_ok(())
}

/// Stated slopes of the linear axes that are all those of the first job, to the last digit.
pub(crate) fn same_slopes(first: &Job, second: &Job) -> Option<Finding> {
    let [before, after] = [first, second]
        .map(|job| job.measurement.diagonals().map_or(&[][..], |measured| &measured.linear));
    let is_copy = |own: &Linear| match own.slope {
        LinearSlope::Stated(slope) => {
            slope.abs() > 0.0 && before.iter().any(|b| (b.axis, &b.slope) == (own.axis, &own.slope))
        }
        LinearSlope::Errors(_) | LinearSlope::NotYet => false,
    };
    let axes: Vec<Axis> = after.iter().map(|linear| linear.axis).collect();
    let are_copies = !after.is_empty() && after.iter().all(is_copy);
    are_copies.then(|| AsLeft::SameSlopes { axes }.into())
}

/// What a job says of its machine: key, name, value.
fn told(job: &Job) -> Vec<(String, String, Option<String>)> {
    let serial = job.machine.serial.clone();
    let mut told = vec![("machine.serial".to_string(), "the serial number".to_string(), serial)];
    for axis in Axis::ALL {
        let own = job.machine.axes[axis];
        let travel = own.map(|a| format!("{} … {} mm", a.low.mm(), a.high.mm()));
        let reference = own.map(|a| format!("{} mm", a.reference.mm()));
        let homing = own.map(|a| a.homing().symbol().to_string());
        let rows = [
            ("travel_mm", "travel", travel),
            ("reference_mm", "reference point", reference),
            ("reference_direction", "direction of the reference return", homing),
        ];
        told.extend(rows.map(|(key, what, value)| {
            let key = format!("machine.axes.{}.{key}", axis.key());
            (key, format!("the {what} of axis {axis}"), value)
        }));
    }
    told
}

/// Refuses two measurements without a term or range in common.
pub(super) fn common_terms(before: &ErrorModel, model: &ErrorModel) -> Result<(), Problems> {
    let names = |model: &ErrorModel| joined(model.measured().map(|(term, _)| term));
    if !model.measured().any(|(term, _)| before.terms[term].is_some()) {
        return Err(refusals::no_common_error(names(before), names(model)).into());
    }
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        let (Some(first), Some(second)) = (before.ranges[axis], model.ranges[axis]) else {
            continue;
        };
        if second.1 <= first.0 || second.0 >= first.1 {
            let [[from, to], [low, high]] = [first, second].map(|(a, b)| [a.mm(), b.mm()]);
            problems.push(refusals::no_common_range(axis, from, to, low, high));
        }
    }
    problems.or_ok(())
}

pub(super) fn nine_terms_over(before: &ErrorModel, runs: &StraightRuns) -> Result<(), Problems> {
    let walks = |axis: Axis, direction: Direction| {
        runs.walks.iter().any(|walk| walk.diagonal.travelled(axis, walk.pass) == direction)
    };
    let mut problems = Problems::none();
    for words in not_known(before, walks).into_iter().chain(outside(before, &runs.volume)) {
        problems.push(refusals::not_told(words));
    }
    problems.or_ok(())
}

/// Errors that the body diagonals show, all nine together, and that a model does not hold, one
/// sentence for each way in which axes walk.
pub(crate) fn not_known(
    model: &ErrorModel,
    walks: impl Fn(Axis, Direction) -> bool,
) -> Vec<String> {
    let terms = || ErrorTerm::ALL.into_iter();
    let missing = joined(terms().filter(|term| model.terms[*term].is_none()));
    if !missing.is_empty() {
        return vec![format!("the diagonals need all nine errors; not measured: {missing}")];
    }
    let unknown = |direction: Direction| {
        // Every diagonal moves some axis in either direction; a curve of the other one says nothing.
        let is_unknown = |term: &ErrorTerm| {
            let own = model.terms[*term].as_ref();
            walks(term.along, direction)
                && own.is_some_and(|m| m.measured.curve(direction).is_none())
        };
        let names = joined(terms().filter(is_unknown));
        (!names.is_empty()).then(|| {
            format!("the diagonals move every axis in both directions; not measured moving in {direction}: {names}")
        })
    };
    Direction::BOTH.into_iter().filter_map(unknown).collect()
}

/// Axes that the body diagonals of a volume take beyond the range that was measured, each in a sentence.
pub(crate) fn outside(model: &ErrorModel, volume: &Volume) -> Vec<String> {
    let of = |axis: Axis| {
        let from = volume.start[axis].mm();
        let to = from + volume.size[axis].mm();
        let (low, high) = model.ranges[axis]?;
        let (low, high) = (low.mm(), high.mm());
        (from < low - EDGE_MM || to > high + EDGE_MM).then(|| {
            format!("the diagonals take {axis} from {from} to {to} mm, but its errors are measured from {low} to {high} mm only")
        })
    };
    Axis::ALL.into_iter().filter_map(of).collect()
}

// Why as-left figures decide nothing in favour, and what whoever reads the page should know.

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
            let said = runs.labels.iter().cloned().map(|label| match label.severity() {
                Severity::Doubt => label,
                _ => AsLeft::RestsOn { label }.into(),
            });
            found.extend(said.chain([AsLeft::DiagonalsOnly.into()]));
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
        let off = a.knots().iter().map(|at| (a.at(*at) - b.at(*at)).um());
        a.knots() == b.knots() && range(off) < SAME_UM
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
        Some((widest_gap_mm(before.terms[term].as_ref()?)?, widest_gap_mm(measured)?))
    });
    let (first_mm, second_mm) = gaps
        .filter(|(first, second)| *second > ROUNDING * WIDEST_GAP * first)
        .reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    Some(AsLeft::Sparse { axis, first_mm, second_mm })
}

/// Widest gap between neighbouring positions of a term, mm.
fn widest_gap_mm(measured: &MeasuredTerm) -> Option<f64> {
    let pairs = measured.curves().flat_map(|curve| curve.knots().windows(2));
    pairs.map(|pair| (pair[1] - pair[0]).mm()).reduce(f64::max)
}

/// Terms that are known in both directions as found, of which one, or the mean, was measured again.
fn reversal_not_seen(before: &ErrorModel, after: &ErrorModel) -> Option<AsLeft> {
    let both = |measured: &MeasuredTerm| measured.measured.has_both_ways();
    let known = |term: ErrorTerm| before.terms[term].as_ref().is_some_and(both);
    let fewer = after.measured().filter(|(term, measured)| known(*term) && !both(measured));
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

/// Slopes of cross terms hold the rotation of the frame they are given in; as measured it is another one each time.
fn other_frame(before: &ErrorModel, after: &ErrorModel) -> Option<AsLeft> {
    let crossed =
        |(term, _): (ErrorTerm, &MeasuredTerm)| term.is_cross() && before.terms[term].is_some();
    let rotates = after.measured().any(crossed);
    let [first, second] = [before, after].map(|model| model.remarks.frame);
    match first == second {
        false => rotates.then_some(AsLeft::OtherFrame { first, second }),
        true => (rotates && first == Some(Frame::AsMeasured)).then_some(AsLeft::OwnFrames),
    }
}

/// The reversal of a second measurement in both directions, where the first one did not tell them
/// apart.
#[derive(Clone, Debug)]
pub(crate) struct UnseenReversal {
    /// B of each of these errors.
    pub(crate) found: Finding,
    /// The second measurement with the mean of both directions in their place.
    pub(crate) without: ErrorModel,
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
            second.measured = TermCurves::Undirected(second.measured.mean());
        }
    }
    (!reversals_um.is_empty())
        .then(|| UnseenReversal { found: AsLeft::LostMotion { reversals_um }.into(), without })
}
