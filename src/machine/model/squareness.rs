//! The squareness of two axes in the curves of their cross terms.
//!
//! It is the sum of both slopes. A straightness that was evaluated about its own line has no slope and holds none: then
//! the job states it, and it is added to one of the two.

use super::measured::Measured;
use super::{ErrorModel, MeasuredTerm};
use crate::inputs::error_table::{Cause, ErrorTable};
use crate::inputs::job::Job;
use crate::machine::findings::ModelFinding;
use crate::machine::separation::curves::{ReferenceLine, range};
use crate::quantity::{Axis, ErrorTerm, Millimetres, PerTerm, Plane};
use crate::text::Problems;

/// A line that rises less from end to end is level, µm, if that is less than a tenth of what the curve spans.
const LEVEL_UM: f64 = 0.1;
/// Slopes whose size differs less from a stated squareness are probably the same figure, perhaps with the other sign.
const SAME_SHARE: f64 = 0.25;

impl ErrorModel {
    /// Readings of the diagonals hold the squareness, however small: of a table that was separated it is known.
    pub(super) fn know_separated(&mut self, table: &ErrorTable) {
        if table.remarks.frame.is_some() && table.is_single() {
            self.known_squareness.extend(Plane::ALL.map(Plane::carrier));
        }
    }

    /// Squareness φ = slope(E_jk) + slope(E_kj), µm/m, where both terms were measured and hold it; end-point
    /// slopes. Positive = the angle between the positive axis directions is less than 90°
    /// (contract §1).
    pub fn squareness_um_per_m(&self, first: Axis, second: Axis) -> Option<f64> {
        let pair = [(first, second), (second, first)].map(|(of, along)| ErrorTerm { of, along });
        let is_known = pair.iter().all(|term| !self.without_squareness.contains(term));
        slopes(&self.terms, pair[0]).filter(|_| is_known)
    }

    /// The terms to which a squareness would be added where neither slopes, the job nor readings of this measurement hold it.
    pub(crate) fn level(&self) -> Vec<ErrorTerm> {
        let all = Plane::ALL.into_iter().map(Plane::carrier);
        let open = all.filter(|term| !self.known_squareness.contains(term));
        open.filter(|term| are_level(&self.terms, *term)).collect()
    }

    /// Notes where the squareness of the machine is not known.
    pub(crate) fn lacks_squareness(&mut self, terms: Vec<ErrorTerm>) {
        let not_stated = &mut self.remarks.silence.not_stated;
        not_stated.retain(|cause| *cause != Cause::Squareness);
        not_stated.extend((!terms.is_empty()).then_some(Cause::Squareness));
        self.without_squareness = terms;
    }

    /// Adds what the job states. What the slopes seem to hold already is a doubt.
    pub(super) fn add_squareness(&mut self, job: &Job, problems: &mut Problems) {
        for (term, stated) in &job.measurement.squareness {
            let slopes = slopes(&self.terms, *term);
            let is_same = |own: &f64| (own.abs() - stated.abs()).abs() < SAME_SHARE * stated.abs();
            let twice = slopes.filter(is_same);
            let twice = twice.map(|slopes| ModelFinding::SquarenessTwice {
                terms: [*term, term.twin()],
                stated: *stated,
                slopes,
            });
            self.remarks.doubts.extend(twice.map(Into::into));
            add(job, &mut self.terms, *term, *stated, problems);
            self.known_squareness.push(*term);
        }
    }
}

fn slopes(terms: &PerTerm<Option<MeasuredTerm>>, term: ErrorTerm) -> Option<f64> {
    let slope = |term: ErrorTerm| Some(terms[term].as_ref()?.end_point_slope_um_per_m());
    Some(slope(term)? + slope(term.twin())?)
}

/// Whether a term was measured and neither it nor its twin has a slope: through the ends, or by least squares.
fn are_level(terms: &PerTerm<Option<MeasuredTerm>>, term: ErrorTerm) -> bool {
    let is_level = |measured: &MeasuredTerm| {
        let curve = measured.measured.mean();
        let positions: Vec<f64> = curve.knots().iter().map(|knot| knot.mm()).collect();
        let deviations: Vec<f64> = positions.iter().map(|at| curve.um_at(*at)).collect();
        let level_um = LEVEL_UM.min(range(deviations.iter().copied()) / 10.0);
        let (from, to) = curve.measured_range();
        let rise = |line: ReferenceLine| {
            line.slope_um_per_m(&positions, &deviations).abs() * (to - from).mm() / 1000.0
        };
        [ReferenceLine::EndPoints, ReferenceLine::LeastSquares]
            .into_iter()
            .any(|line| rise(line) <= level_um)
    };
    terms[term].as_ref().is_some_and(is_level) && terms[term.twin()].as_ref().is_none_or(is_level)
}

fn add(
    job: &Job,
    terms: &mut PerTerm<Option<MeasuredTerm>>,
    term: ErrorTerm,
    slope: f64,
    problems: &mut Problems,
) {
    let machine = job.machine.axes[term.along];
    let (Some(measured), Some(machine)) = (terms[term].as_mut(), machine) else {
        let key = format!("measurement.squareness_um_per_m.{}{}", term.of.key(), term.along.key());
        let words = format!("squareness is added to {term}, but {term} was not measured");
        let help = "in the error table, or leave this squareness out";
        let help = format!("give the straightness {term} {help}");
        problems.push(job.problem_at(&key, words).help(help));
        return;
    };
    // Outside the measured range the tilt is held with the curve, so off that range the line has
    // its zero at the near end: the reference stays zero.
    let homing = measured.measured.curve(machine.homing());
    let Some(curve) = homing.or(measured.curves().next()) else { return };
    let (low, high) = curve.measured_range();
    let zero = Millimetres::new(machine.reference.mm().clamp(low.mm(), high.mm()));
    let ways = measured.measured.ways();
    let tilted = Measured::of(ways.map(|(way, curve)| (way, curve.plus_slope(slope, zero))));
    measured.measured = tilted.unwrap_or_else(|| measured.measured.clone());
}
