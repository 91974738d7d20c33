//! What each value of the second measurement sees: which deviations, where, with which weight.

use crate::inputs::error_table::Cause;
use crate::judge::after::measurement::{AfterMeasurement, StraightRuns};
use crate::judge::field::Field;
use crate::judge::findings::AsLeft;
use crate::machine::model::{ErrorModel, Measured, MeasuredTerm};
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorCurve, ErrorTerm, Millimetres, Pass, PathKind, Squared,
};
use crate::text::Finding;

/// One deviation that a value sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Which error.
    pub term: ErrorTerm,
    /// The way its axis travels.
    pub direction: Direction,
    /// Where the axis stands.
    pub at: Millimetres,
    /// Its share: 1 for a term by itself, the direction cosine on a diagonal.
    pub weight: f64,
}

impl Part {
    /// The correction there, µm.
    pub(super) fn added_um(&self, control: &Field) -> f64 {
        control.correction(self.term, self.direction, self.at).um()
    }
}

/// One value of the second measurement: Σ weight · deviation, less a zero of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// What it sees.
    pub parts: Vec<Part>,
    /// The value, µm.
    pub um: f64,
    /// The same of the machine without tables, from the first measurement: Σ weight · deviation, µm.
    pub found_um: f64,
    /// Standard uncertainty (k = 1) by what the first measurement does not repeat, µm; `None` = not stated.
    pub u_um: Option<f64>,
    /// Variance of what the first measurement says, likewise, µm²; 0 = not stated.
    pub found_variance: f64,
    /// Number of the curve or pass it stands on.
    pub curve: usize,
    /// Values with the same number count from the same zero.
    pub zero: usize,
    /// The diagonal it stands on, if it was measured along one.
    pub diagonal: Option<Diagonal>,
}

impl Observation {
    /// Σ weight · value of each part; `None` where one is unknown.
    pub fn predicted(&self, value: impl Fn(&Part) -> Option<f64>) -> Option<f64> {
        weighted(&self.parts, value)
    }

    /// How far it is off what the first measurement and the tables say, µm.
    pub(crate) fn off_um(&self, control: &Field) -> f64 {
        let added_um = self.parts.iter().map(|part| part.weight * part.added_um(control));
        self.um - self.found_um - added_um.sum::<f64>()
    }

    /// Whether it is a value of this term by itself.
    pub(crate) fn is_of(&self, term: ErrorTerm) -> bool {
        self.diagonal.is_none() && self.parts.iter().all(|part| part.term == term)
    }
}

fn weighted(parts: &[Part], value: impl Fn(&Part) -> Option<f64>) -> Option<f64> {
    let values = parts.iter().map(|part| Some(part.weight * value(part)?));
    values.sum()
}

/// Every value of the second measurement that the first one has an answer to.
pub(crate) fn observations(before: &ErrorModel, after: &AfterMeasurement) -> Vec<Observation> {
    match after {
        AfterMeasurement::Diagonals(runs) => along_diagonals(before, runs),
        AfterMeasurement::Errors(model) => {
            let mut seen = Vec::new();
            for (zero, (term, measured)) in model.measured().enumerate() {
                of_term(before, model, (term, measured), zero, &mut seen);
            }
            seen
        }
    }
}

fn of_term(
    before: &ErrorModel,
    after: &ErrorModel,
    (term, measured): (ErrorTerm, &MeasuredTerm),
    zero: usize,
    seen: &mut Vec<Observation>,
) {
    let Some(first) = &before.terms[term] else {
        return;
    };
    let ways = measured.measured.ways();
    let u_um = after.u_anew_um(before, term);
    for (number, (way, curve)) in ways.enumerate() {
        seen.reserve_exact(curve.knots().len());
        for at in curve.knots() {
            let parts = parts_of(term, first, way, *at);
            if let Some(found_um) = found_um(before, &parts) {
                seen.push(Observation {
                    found_variance: variance(&parts, |term| before.u_anew_um(after, term)),
                    parts,
                    um: curve.at(*at).um(),
                    found_um,
                    u_um,
                    curve: 2 * zero + number,
                    zero,
                    diagonal: None,
                });
            }
        }
    }
}

/// Σ (weight · u)² over the errors that a value sees; parts of one term move together.
fn variance(parts: &[Part], u_um: impl Fn(ErrorTerm) -> Option<f64>) -> f64 {
    let of = |term: ErrorTerm| {
        let weight: f64 = parts.iter().filter(|part| part.term == term).map(|p| p.weight).sum();
        (weight * u_um(term).unwrap_or(0.0)).squared()
    };
    ErrorTerm::ALL.into_iter().map(of).sum()
}

/// What the first measurement says of a value; `None` where it has no answer.
fn found_um(before: &ErrorModel, parts: &[Part]) -> Option<f64> {
    let found = weighted(parts, |part| before_um(before, part));
    found.filter(|_| !parts.is_empty())
}

/// A value without direction is the mean of the directions that were measured first; none where
/// the first measurement has no answer.
fn parts_of(
    term: ErrorTerm,
    first: &MeasuredTerm,
    way: Option<Direction>,
    at: Millimetres,
) -> Vec<Part> {
    let known = |direction: &Direction| {
        let curve = first.measured.curve(*direction);
        curve.is_some_and(|curve| {
            let (low, high) = curve.measured_range();
            at >= low && at <= high
        })
    };
    let ways = Direction::BOTH.into_iter();
    let ways: Vec<Direction> = ways
        .filter(|direction| way.is_none_or(|way| way == *direction) && known(direction))
        .collect();
    let weight = if ways.len() == 2 { 0.5 } else { 1.0 };
    let part = |direction| Part { term, direction, at, weight };
    ways.into_iter().map(part).collect()
}

fn along_diagonals(before: &ErrorModel, runs: &StraightRuns) -> Vec<Observation> {
    let mut seen = Vec::new();
    for (number, walk) in runs.walks.iter().enumerate() {
        let laser = runs.volume.laser(walk.diagonal);
        for (node, um) in walk.um.iter().enumerate() {
            let place = runs.volume.place(walk.diagonal, PathKind::Straight, node);
            let part = |term: ErrorTerm| Part {
                term,
                direction: walk.diagonal.travelled(term.along, walk.pass),
                at: place[term.along],
                weight: laser[term.of],
            };
            let parts: Vec<Part> = ErrorTerm::ALL.into_iter().map(part).collect();
            let Some(found_um) = found_um(before, &parts) else {
                continue; // refused before: every term was measured in every direction walked
            };
            let u_um =
                |term: ErrorTerm| before.terms[term].as_ref().and_then(MeasuredTerm::u_value_um);
            seen.push(Observation {
                found_variance: variance(&parts, u_um),
                parts,
                um: *um,
                found_um,
                u_um: runs.u_um,
                curve: number,
                zero: zero_of(runs.one_zero, walk.diagonal, walk.pass),
                diagonal: Some(walk.diagonal),
            });
        }
    }
    seen
}

/// Passes of one diagonal share a zero where the reverse pass counts from the forward start.
fn zero_of(one_zero: bool, diagonal: Diagonal, pass: Pass) -> usize {
    let own = Diagonal::ALL.into_iter().position(|other| other == diagonal);
    let back = usize::from(pass == Pass::Reverse && !one_zero);
    2 * own.unwrap_or_default() + back
}

/// The deviation as found where a part of an observation looks, µm; `None` = not measured in this
/// direction.
pub fn before_um(before: &ErrorModel, part: &Part) -> Option<f64> {
    let measured = before.terms[part.term].as_ref()?;
    Some(measured.measured.curve(part.direction)?.at(part.at).um())
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
    let found = not_measured(measured_first, after).into_iter();
    let mut found: Vec<Finding> = found.map(Finding::from).collect();
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
