//! The nine errors as functions of position, zero at the reference point.
//!
//! ```text
//!   error table ─┬→ one curve per term (and direction) ─→ − value at the reference ─→ ErrorModel
//!   job ─────────┘   (+ squareness, if the slopes do not hold it)
//! ```
//! With two directions both curves are zeroed by the *same* value: that of the curve of the
//! reference direction at the reference point. The other curve then carries the reversal there
//! (contract §2.3, Zero).
//!
//! What is known of the uncertainty of measured values.
//!
//! Every curve is zero at the reference, so a value is a difference of two of the table:
//!
//! ```text
//!   u²(x) = u_value²(x) + u_value²(reference) + (laser · |x − reference|)²      u_value² = column² + noise²
//! ```
//! and 0 at the reference itself. The values of a table are taken as independent of each other, which
//! is cautious for differences to the reference where they rise together. The scale of the laser is one
//! error of all positions and axes: along a diagonal it counts once ([`ErrorModel::laser_um_per_m`]). A table that `separate` wrote states u = 0 where its curves
//! are zero and holds noise and scale of the laser already.

pub use self::measured::TermCurves;
use self::measured::{FEWEST_POSITIONS, UNLIKELY_SMALL_UM, measured_range};
pub(crate) use self::measured::{Range, within};
use crate::inputs::error_table::{Cause, ErrorTable, Heading, Kind, Remarks, Series, Sizes};
use crate::inputs::job::{Job, MachineAxis, MeasuredData, UseOf};
use crate::machine::findings::ModelFinding;
use crate::machine::separation::curves::{ReferenceLine, mean, range};
use crate::machine::separation::joint::zero;
use crate::quantity::{
    AT_PLACE_MM, Axis, Deviation, Direction, ErrorCurve, ErrorTerm, Millimetres, PerAxis, PerTerm,
    Plane, larger,
};
use crate::text::{Finding, Problems};

pub(in crate::machine) mod measured;

/// One measured term.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredTerm {
    /// Its curves, zero at the reference.
    pub measured: TermCurves,
    /// Standard uncertainty at each measured position; empty = not stated.
    pub uncertainty: Vec<PointUncertainty>,
    /// Where it was measured, if its curves have knots beside these: of old tables.
    pub(crate) places: Option<Vec<Millimetres>>,
}

impl MeasuredTerm {
    /// Measured at the knots of its curves.
    pub(crate) fn new(measured: TermCurves, uncertainty: Vec<PointUncertainty>) -> MeasuredTerm {
        MeasuredTerm { measured, uncertainty, places: None }
    }

    /// Largest standard uncertainty (k = 1) of a value against that at the reference, µm; `None` =
    /// not stated.
    pub(crate) fn u_um(&self) -> Option<f64> {
        self.uncertainty.iter().map(|point| point.u_um).reduce(larger)
    }

    /// Largest standard uncertainty (k = 1) of a value by itself, µm; `None` = not stated.
    pub(crate) fn u_value_um(&self) -> Option<f64> {
        self.uncertainty.iter().map(|point| point.value_um).reduce(larger)
    }

    /// Largest |deviation| over the measured range and all measured directions, µm.
    pub fn largest_um(&self) -> f64 {
        self.largest_within_um(None)
    }

    /// The same over the part of the measured range that lies within another one (the contract's
    /// `before_um`).
    pub(crate) fn largest_within_um(&self, range: Option<Range>) -> f64 {
        let largest = |curve: &ErrorCurve| {
            let (from, to) = within(curve.measured_range(), range);
            curve.largest_magnitude(from, to)
        };
        self.curves().map(largest).fold(0.0, larger)
    }

    /// Its curves, + before −.
    pub fn curves(&self) -> impl Iterator<Item = &ErrorCurve> {
        self.measured.ways().map(|(_, curve)| curve)
    }

    /// Reversal B = mean deviation moving + minus mean deviation moving − over the target
    /// positions that both directions cover (contract §1; ISO 230-2), µm.
    pub fn reversal(&self) -> Option<Deviation> {
        let TermCurves::BothWays { plus, minus } = &self.measured else {
            return None;
        };
        let difference = plus.difference(minus)?;
        let places = self.places.as_deref().unwrap_or(difference.knots());
        Some(Deviation::from_um(mean(places.iter().map(|at| difference.at(*at).um()))))
    }

    /// Adds a slope, µm/m. Outside the measured range the tilt is held with the curve, so off that range the line has its
    /// zero at the near end: the reference stays zero.
    fn tilt(&mut self, um_per_m: f64, machine: MachineAxis) {
        let homing = self.measured.curve(machine.homing());
        let Some(curve) = homing.or(self.curves().next()) else { return };
        let (low, high) = curve.measured_range();
        let zero = Millimetres::new(machine.reference.mm().clamp(low.mm(), high.mm()));
        self.each(|curve| curve.plus_slope(um_per_m, zero));
    }

    /// Adds the same everywhere.
    pub(crate) fn shift(&mut self, by: Deviation) {
        self.each(|curve| curve.less(Deviation::ZERO - by));
    }

    fn each(&mut self, of: impl Fn(&ErrorCurve) -> ErrorCurve) {
        let changed = TermCurves::of(self.measured.ways().map(|(way, curve)| (way, of(curve))));
        self.measured = changed.unwrap_or_else(|| self.measured.clone());
    }

    /// Takes what was measured in one direction for both.
    pub(crate) fn count_both_ways(&mut self) {
        if let TermCurves::OneWay(_, curve) = &self.measured {
            self.measured = TermCurves::Undirected(curve.clone());
            self.uncertainty.iter_mut().for_each(|point| point.direction = None);
        }
    }

    /// Slope of the line through the ends of the curve (mean of both directions), µm/m.
    pub(crate) fn end_point_slope_um_per_m(&self) -> f64 {
        mean(self.curves().map(ErrorCurve::end_point_slope_um_per_m))
    }
}

/// The measured errors of a machine as curves.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorModel {
    /// The measured terms; `None` = not measured.
    pub terms: PerTerm<Option<MeasuredTerm>>,
    /// The terms to which a squareness would be added that is not known.
    pub without_squareness: Vec<ErrorTerm>,
    /// The terms of which it is known apart from their slopes: the job states it, or readings of the diagonals hold it.
    pub known_squareness: Vec<ErrorTerm>,
    /// The measured rotations (`EAX` …), µrad in place of µm; as measured, or zero at
    /// `angles_zero_mm`. No table of a control holds them.
    pub rotations: PerTerm<Option<TermCurves>>,
    /// The measured range of each axis (where all its directions were measured).
    pub ranges: PerAxis<Option<Range>>,
    /// The heading under which each term stands in its error table.
    pub headings: PerTerm<Option<Heading>>,
    /// Standard uncertainty of the laser's scale that no column holds, µm/m; 0 = not stated.
    pub laser_um_per_m: f64,
    /// What was measured and this version does not use.
    pub unused: Vec<Finding>,
    /// What the table says of itself: doubts, terms that are not determined, notes.
    pub remarks: Remarks,
}

impl ErrorModel {
    /// Curves from a table and a job. All problems of both are given at once; a table without any
    /// deviation is refused.
    pub fn build(job: &Job, table: &ErrorTable) -> Result<ErrorModel, Problems> {
        ErrorModel::of(UseOf::Tables, job, table)
    }

    /// The same; for figures of the volume angles alone will do.
    pub(crate) fn of(of: UseOf, job: &Job, table: &ErrorTable) -> Result<ErrorModel, Problems> {
        let mut problems = Problems::none();
        measured::check_places(job, table, &mut problems);
        let terms = PerTerm::from_fn(|term| measured_term(job, table, term));
        let size = |(term, of): (ErrorTerm, &Option<MeasuredTerm>)| {
            let of = of.as_ref()?;
            let positions = of.curves().map(|curve| curve.knots().len()).max()?;
            (positions >= FEWEST_POSITIONS).then(|| (term, of.largest_um()))
        };
        let sizes: Vec<(ErrorTerm, f64)> = terms.iter().filter_map(size).collect();
        measured::refuse_unlikely(job, table, &sizes, &mut problems);
        let rotations = measured::rotations(job, table);
        let mut remarks = table.remarks.clone();
        remarks.doubtful = with_periods(job, remarks.doubtful);
        let optics = job.measurement.levers.straightness_optic.iter();
        let optics: Vec<Axis> = optics.filter_map(|(axis, at)| at.map(|_| axis)).collect();
        let are_judged = of == UseOf::Tables && !optics.is_empty();
        let lever = are_judged.then_some(ModelFinding::OpticNotInTables { axes: optics });
        remarks.doubts.extend(lever.map(Finding::from));
        let mut zeros = remarks.largest.iter().chain(&remarks.measured).map(|most| &most.zero);
        let other = zeros.clone().find(|own| **own != zero(job)).cloned();
        // What is anew has no zero of its own.
        if other.is_some() || zeros.next().is_none() {
            (remarks.largest, remarks.measured) = (None, None);
            (remarks.anew, remarks.same_laser) = (None, None);
        }
        let other = other.map(|zero| Finding::from(ModelFinding::OtherReference { zero }));
        let laser_ppm = job.measurement.uncertainty.laser_ppm;
        let angles_do = of == UseOf::Figures && rotations.iter().any(|(_, of)| of.is_some());
        let nothing = terms.iter().all(|(_, term)| term.is_none()) && !angles_do;
        if nothing && problems.is_empty() {
            problems.push(table.holds_nothing());
        }
        // Readings of the diagonals hold the squareness, however small: of a table that was separated it is known.
        let is_separated = table.remarks.frame.is_some() && table.is_single();
        let separated = Plane::ALL.map(Plane::carrier).into_iter().filter(|_| is_separated);
        let mut model = ErrorModel {
            terms,
            without_squareness: Vec::new(),
            known_squareness: separated.collect(),
            rotations,
            ranges: PerAxis::from_fn(|axis| measured_range(table.series(axis))),
            laser_um_per_m: beside_table(job, laser_ppm).unwrap_or(0.0),
            headings: PerTerm::from_fn(|term| table.heading(term).cloned()),
            unused: measured::not_compensated(table).into_iter().chain(other).collect(),
            remarks,
        };
        model.add_squareness(job, &mut problems);
        problems.or_ok(model)
    }

    /// Largest standard uncertainty (k = 1) of a value of a term, without what the other measurement of this machine
    /// repeats, µm; `None` = not stated.
    pub(crate) fn u_anew_um(&self, other: &ErrorModel, term: ErrorTerm) -> Option<f64> {
        let anew = self.remarks.anew_beside(&other.remarks);
        let of_value = || self.terms[term].as_ref().and_then(MeasuredTerm::u_value_um);
        anew.map_or_else(of_value, |anew| Some(anew.terms[term]))
    }

    /// Why figures that rest on these curves are doubtful; `asked` = the terms
    /// that the job wants. A verdict is then at most undecided.
    pub(crate) fn doubts(&self, asked: impl Fn(ErrorTerm) -> bool) -> Vec<Finding> {
        let missing = self.remarks.not_determined.iter().map(|(term, _)| *term);
        let terms: Vec<ErrorTerm> =
            missing.filter(|term| asked(*term) && self.terms[*term].is_none()).collect();
        let missing = (!terms.is_empty()).then_some(ModelFinding::NotDetermined { terms });
        let reversal = self.remarks.hidden_reversal_um;
        let reversal = reversal.map(|um| ModelFinding::HiddenReversal { um });
        let own = missing.into_iter().chain(reversal).map(Finding::from);
        self.remarks.doubts.iter().cloned().chain(own).collect()
    }

    /// Why the unit of errors is doubtful that are small throughout; `noise_um` = what the job states of
    /// a reading, k = 1. Errors above a stated noise are believed, curves of zeros are no errors.
    ///
    /// limits  judged for all terms together, since one alone may be small; the usual cause is values
    ///         in mm under a column in µm
    pub(crate) fn unlikely_small(&self, noise_um: Option<f64>) -> Option<Finding> {
        let largest = self.measured().map(|(_, measured)| measured.largest_um());
        let (largest_um, least_um) = (largest.fold(0.0, f64::max), UNLIKELY_SMALL_UM);
        let is_believed = noise_um.is_some_and(|noise| noise < largest_um);
        let found = ModelFinding::UnlikelySmall { largest_um, least_um };
        (largest_um > 0.0 && largest_um < least_um && !is_believed).then(|| found.into())
    }

    /// The measured terms in the contract's order.
    pub fn measured(&self) -> impl Iterator<Item = (ErrorTerm, &MeasuredTerm)> {
        self.terms.iter().filter_map(|(term, measured)| Some((term, measured.as_ref()?)))
    }

    /// Those of a moving axis.
    pub(crate) fn measured_along(
        &self,
        axis: Axis,
    ) -> impl Iterator<Item = (ErrorTerm, &MeasuredTerm)> {
        self.measured().filter(move |(term, _)| term.along == axis)
    }

    /// Adds the angular errors of a table of their own. What both tables hold is a problem: nobody
    /// knows which of them counts. Deviations beside the angles are not read, and a note says so.
    pub(crate) fn add_angles(&mut self, job: &Job, table: &ErrorTable) -> Result<(), Problems> {
        self.rotations = measured::added(job, table, &self.rotations)?;
        let unused = measured::not_compensated(table).into_iter();
        self.unused = unused.chain(measured::deviations_beside(table)).collect();
        Ok(())
    }

    // The squareness of two axes in the curves of their cross terms: the sum of both slopes. A straightness that was evaluated
    // about its own line has no slope and holds none: then the job states it, and it is added to one of the two.

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
    fn add_squareness(&mut self, job: &Job, problems: &mut Problems) {
        for &(term, stated) in &job.measurement.squareness {
            let is_same = |own: &f64| (own.abs() - stated.abs()).abs() < SAME_SHARE * stated.abs();
            let (twice, terms) = (slopes(&self.terms, term).filter(is_same), [term, term.twin()]);
            let twice = twice.map(|slopes| ModelFinding::SquarenessTwice { terms, stated, slopes });
            self.remarks.doubts.extend(twice.map(Into::into));
            self.known_squareness.push(term);
            let machine = job.machine.axes[term.along];
            let (Some(measured), Some(machine)) = (self.terms[term].as_mut(), machine) else {
                let (of, along) = (term.of.key(), term.along.key());
                let key = format!("measurement.squareness_um_per_m.{of}{along}");
                let words = format!("squareness is added to {term}, but {term} was not measured");
                let help = format!(
                    "give the straightness {term} in the error table, or leave this squareness out"
                );
                problems.push(job.problem_at(&key, words).help(help));
                continue;
            };
            measured.tilt(stated, machine);
        }
    }

    /// The same in the frame in which the slopes of each plane are as small as a rotation makes them: both are half of the
    /// squareness; of one without the other nothing is left.
    pub(crate) fn in_best_frame(&self, job: &Job) -> ErrorModel {
        let mut model = self.clone();
        for term in ErrorTerm::ALL.into_iter().filter(|term| term.is_cross()) {
            let machine = job.machine.axes[term.along];
            if let (Some(own), Some(machine)) = (model.terms[term].as_mut(), machine) {
                let half = slopes(&self.terms, term).unwrap_or(0.0) / 2.0;
                own.tilt(half - own.end_point_slope_um_per_m(), machine);
            }
        }
        model
    }
}

/// A line that rises less from end to end is level, µm, if that is less than a tenth of what the curve spans.
const LEVEL_UM: f64 = 0.1;
/// Slopes whose size differs less from a stated squareness are probably the same figure, perhaps with the other sign.
const SAME_SHARE: f64 = 0.25;

fn measured_term(job: &Job, table: &ErrorTable, term: ErrorTerm) -> Option<MeasuredTerm> {
    let (between, machine) = (job.compensation.curve, job.machine.axes[term.along]?);
    let series = table.series(term.along).iter();
    let of = Kind::Deviation(term.of);
    let measured: Vec<&Series> = series.filter(|s| s.values.contains_key(&of)).collect();
    let homing = measured.iter().find(|s| s.direction == Some(machine.homing()));
    let zeroed = *homing.or(measured.first())?;
    let curve = |s: &Series| {
        let um = s.values.get(&of)?.iter().copied();
        let deviations: Vec<Deviation> = um.map(Deviation::from_um).collect();
        Some(ErrorCurve::through(&s.positions, &deviations, between))
    };
    let zero = curve(zeroed)?.at(machine.reference);
    let curves = measured.iter().filter_map(|s| Some((s.direction, curve(s)?.less(zero))));
    let uncertainty = points(job, (&measured, zeroed), term, machine);
    Some(MeasuredTerm::new(TermCurves::of(curves)?, uncertainty))
}

/// Standard uncertainty (k = 1) at one measured position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointUncertainty {
    /// The way the axis travelled; `None` = both.
    pub direction: Option<Direction>,
    /// Where.
    pub at: Millimetres,
    /// Of the value by itself, without the scale of the laser, µm.
    pub value_um: f64,
    /// Of the value against that at the reference, µm.
    pub u_um: f64,
}

/// The uncertainty of a term at each of its measured positions, of which the second are those that are zero at the
/// reference; empty = not stated.
fn points(
    job: &Job,
    (measured, zeroed): (&[&Series], &Series),
    term: ErrorTerm,
    axis: MachineAxis,
) -> Vec<PointUncertainty> {
    let stated = job.measurement.uncertainty;
    let noise_um = beside_table(job, stated.noise_um);
    let laser_um_per_m = beside_table(job, stated.laser_ppm).filter(|_| term.is_positioning());
    let of = Kind::Deviation(term.of);
    let column = measured.iter().any(|s| s.uncertainties.contains_key(&of));
    if !column && noise_um.is_none() && laser_um_per_m.is_none() {
        return Vec::new();
    }
    let (noise_um, laser) = (noise_um.unwrap_or(0.0), laser_um_per_m.unwrap_or(0.0));
    let at_zero = nearest_um(zeroed, term, axis.reference).unwrap_or(0.0).hypot(noise_um);
    let mut points = Vec::new();
    for s in measured {
        let column = s.uncertainties.get(&of);
        for (row, at) in s.positions.iter().enumerate() {
            let from_zero = (*at - axis.reference).mm().abs();
            let own = column.and_then(|c| c.get(row)).copied().unwrap_or(0.0);
            let value_um = own.hypot(noise_um);
            let reach_um = laser * from_zero / 1000.0;
            let is_zero = from_zero <= AT_PLACE_MM && std::ptr::eq(zeroed, *s);
            let u_um = if is_zero { 0.0 } else { value_um.hypot(at_zero).hypot(reach_um) };
            points.push(PointUncertainty { direction: s.direction, at: *at, value_um, u_um });
        }
    }
    points
}

/// What may be off beside every uncertainty, with what the job states of errors between the targets.
fn with_periods(job: &Job, doubtful: Option<Sizes>) -> Option<Sizes> {
    let between = job.measurement.uncertainty.between();
    let own = doubtful.or((between.all_um() > 0.0).then(Sizes::default))?;
    Some(own.joined(&between, |own, between| own + between))
}

/// An uncertainty that the job states beside its table; that of separated readings holds it already. 0 states nothing.
fn beside_table(job: &Job, stated: Option<f64>) -> Option<f64> {
    let beside = matches!(job.measurement.data, MeasuredData::Errors(_));
    stated.filter(|u| beside && *u > 0.0)
}

/// The column's u where the curve is zeroed, µm: of the row at the reference, else the larger of its
/// neighbours.
fn nearest_um(series: &Series, term: ErrorTerm, reference: Millimetres) -> Option<f64> {
    let column = series.uncertainties.get(&Kind::Deviation(term.of))?;
    let places = &series.positions;
    let above = places.partition_point(|at| at.mm() < reference.mm() - AT_PLACE_MM);
    let is_there = places.get(above).is_some_and(|at| (*at - reference).mm() <= AT_PLACE_MM);
    let below = if is_there { above } else { above.saturating_sub(1) };
    column.iter().copied().take(above + 1).skip(below).reduce(larger)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Interpolation;

    #[test]
    fn nodes_of_old_tables_do_not_count_in_the_reversal() {
        let curve = |um: [f64; 4]| {
            let places = [0.0, 10.0, 20.0, 100.0].map(Millimetres::new);
            ErrorCurve::through(&places, &um.map(Deviation::from_um), Interpolation::Linear)
        };
        let (plus, minus) = (curve([0.0; 4]), curve([2.0, 3.0, 4.0, 12.0]));
        let mut term = MeasuredTerm::new(TermCurves::BothWays { plus, minus }, Vec::new());
        let reversal = |term: &MeasuredTerm| term.reversal().map(|b| b.um());
        assert_eq!(reversal(&term), Some(-5.25));
        term.places = Some([0.0, 100.0].map(Millimetres::new).to_vec());
        assert_eq!(reversal(&term), Some(-7.0));
    }
}
