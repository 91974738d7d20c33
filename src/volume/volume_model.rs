//! The rigid-body model of a three-axis machine: 21 errors → the error vector at a place.
//!
//! ```text
//!   e = Σ dᵢ + r₁ × (a₂ + a₃) + r₂ × a₃ + (r₁ + r₂ + r₃) × t + squareness        [µm; µrad·mm/1000]
//!
//!   1, 2, 3   the axes from the workpiece to the tool (chain)
//!   dᵢ, rᵢ    deviations (EX, EY, EZ) and rotations (EA, EB, EC) of axis i where it stands
//!   aᵢ        its position less `offsets_mm`, along its own direction
//!   t         tool offset: what the tool point lies away from the point that was measured
//! ```
//! The same formula holds for every chain, because all errors are those of the tool relative to the
//! workpiece; products of two small angles are left out (under 0.12 µm for 100 µrad on 12 m).
//! **Squareness** φ is a straight line in one deviation of one axis, so it needs no term of its own:
//! φxy is a slope of EXY, φ·(position − reference), held where the curve is held (contract §2.3). It
//! tilts the way that the axis goes, not what the axis carries: a tool that is longer by ΔL moves
//! along the same tilted line, so its error differs by nothing. (How the spindle is aligned to
//! the axis is none of the 21 errors.) So a slope in the table and a stated φ are the same machine,
//! with every tool.
//!
//! **An optic on the table** (`straightness_optic_mm`): r × (own travel) is added once, to the
//! straightness at the positions where it was measured; between them the curve runs as chosen.
//!
//! An error that was not measured is left out and *named* ([`VolumeModel::missing`]).

pub(crate) use self::map::of_both;
pub use self::map::{ErrorMap, Nodes};
pub use self::missing::{ERRORS, Missing};
use crate::inputs::job::{Job, Levers, MachineAxis};
use crate::machine::model::{ErrorModel, TermCurves};
use crate::quantity::{
    Axis, Chain, Deviation, Direction, ErrorCurve, ErrorTerm, Interpolation, Millimetres, PerAxis,
    PerTerm, Plane, Rotation, displaced, unit,
};
use crate::text::{Finding, Problems};
use serde::{Serialize, Serializer};
use std::fmt;

mod map;
mod missing;

/// mm in a metre: µrad × mm = 10⁻³ µm, and slopes are in µm/m.
const MM_PER_M: f64 = 1000.0;

/// The errors of a machine everywhere in its volume.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeModel {
    /// The order of the axes; only angles ask for it.
    pub chain: Chain,
    /// Whether the job states it; else all axes are taken to move the tool.
    pub chain_is_stated: bool,
    /// The nine deviations with stated squareness, zero at the reference; mean of the directions.
    deviations: PerTerm<Option<ErrorCurve>>,
    /// What the lever of an optic on the table adds to the straightness of its axis.
    optics: PerTerm<Option<ErrorCurve>>,
    /// The nine rotations, µrad; mean of the directions.
    rotations: PerTerm<Option<ErrorCurve>>,
    /// The same as they act through the positions of other axes: less what a control takes off there.
    swings: PerTerm<Option<ErrorCurve>>,
    /// Stated squareness.
    squareness: Vec<Squareness>,
    /// The terms to which a squareness would be added that is not known.
    without_squareness: Vec<ErrorTerm>,
    levers: Levers,
    /// Where levers count from: the stated offsets, else the reference.
    origin: PerAxis<f64>,
    /// Where the deviations of an axis are zero.
    machine: PerAxis<Option<MachineAxis>>,
    /// The range of each axis that the model holds for, mm; a single place where nothing is known.
    ranges: PerAxis<(f64, f64)>,
    /// What whoever reads a figure of this model has to know.
    pub labels: Vec<Finding>,
}

/// Stated squareness: the slope of one term.
#[derive(Clone, Debug, PartialEq)]
struct Squareness {
    term: ErrorTerm,
    um_per_m: f64,
    /// φ·(position − reference) over the measured range, held beyond it.
    line: ErrorCurve,
}

/// What one axis contributes where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisState {
    /// Its deviation with squareness, and its rotation × tool offset, µm.
    pub deviation_um: PerAxis<f64>,
    /// Its rotation as it acts through the positions of other axes, µrad.
    pub rotation_urad: PerAxis<f64>,
}

impl AxisState {
    /// All six values.
    pub(super) fn values(self) -> [f64; 6] {
        let AxisState { deviation_um: d, rotation_urad: r } = self;
        [d.x, d.y, d.z, r.x, r.y, r.z]
    }
}

impl VolumeModel {
    /// The model of a job's measured errors. Angles need the chain.
    pub fn build(job: &Job, model: &ErrorModel) -> Result<VolumeModel, Problems> {
        let has_angles = model.rotations.iter().any(|(_, angle)| angle.is_some());
        let chain = match (job.machine.chain, has_angles) {
            (None, false) => Chain::ALL_AXES_MOVE_THE_TOOL,
            _ => job.chain_for_angles("machine")?,
        };
        let levers = job.measurement.levers;
        check_optics(job, chain, levers)?;
        let rotations = PerTerm::from_fn(|term: ErrorTerm| {
            model.rotations[term].as_ref().map(TermCurves::mean)
        });
        let mut built = VolumeModel {
            chain,
            chain_is_stated: job.machine.chain.is_some(),
            deviations: PerTerm::from_fn(|_| None),
            optics: PerTerm::from_fn(|_| None),
            swings: rotations.clone(),
            rotations,
            squareness: squareness(job, model),
            without_squareness: model.without_squareness.clone(),
            levers,
            origin: levers.origin(&job.machine.axes),
            machine: job.machine.axes,
            ranges: PerAxis::default(),
            labels: Vec::new(),
        };
        built.optics = built.optics(model, job.compensation.curve);
        built.deviations = built.deviations(model);
        built.ranges = built.common_ranges(job)?;
        built.labels = built.statements(job, model);
        Ok(built)
    }

    /// The same machine with the deviations of another model (without the tables that were active
    /// while measuring); judged over the range that was measured.
    #[must_use]
    pub(crate) fn with_errors_of(&self, model: &ErrorModel) -> VolumeModel {
        VolumeModel { deviations: self.deviations(model), ..self.clone() }
    }

    /// The curves of a model with the levers of optics. The mean of two
    /// directions is zero at the reference: which direction a return to it takes is no error
    /// of the volume.
    fn deviations(&self, model: &ErrorModel) -> PerTerm<Option<ErrorCurve>> {
        PerTerm::from_fn(|term: ErrorTerm| {
            let measured = &model.terms[term].as_ref()?.measured;
            let mut curve = measured.mean();
            if let (true, Some(machine)) = (measured.has_both_ways(), self.machine[term.along]) {
                curve = curve.rezeroed_at(machine.reference);
            }
            Some(self.optics[term].iter().fold(curve, |sum, optic| sum.plus(optic)))
        })
    }

    /// Every curve of an axis, rotations also as they act through the positions of others.
    pub(super) fn all_along(&self, axis: Axis) -> impl Iterator<Item = &ErrorCurve> {
        let swings =
            Axis::ALL.map(move |about| self.swings[Rotation { about, along: axis }].as_ref());
        self.curves_along(axis).chain(swings.into_iter().flatten())
    }

    /// Every position where a curve of an axis bends or ends, mm, ascending; where it has none, the
    /// ends of its range.
    pub fn bends(&self, axis: Axis) -> Vec<f64> {
        let knots = self.all_along(axis).flat_map(ErrorCurve::knots);
        let mut bends: Vec<f64> = knots.map(|knot| knot.mm()).collect();
        if bends.is_empty() {
            bends.extend([self.ranges[axis].0, self.ranges[axis].1]);
        }
        bends.sort_by(f64::total_cmp);
        bends.dedup_by(|next, kept| next <= kept);
        bends
    }

    /// Whether anything of an axis was measured.
    pub(crate) fn is_measured(&self, axis: Axis) -> bool {
        self.curves_along(axis).next().is_some()
    }

    /// The range of an axis that the figures hold for, mm.
    pub fn range(&self, axis: Axis) -> (f64, f64) {
        self.ranges[axis]
    }

    /// Where the levers of the angles count from, mm: there they have no effect.
    pub fn lever_origin(&self) -> PerAxis<f64> {
        self.origin
    }

    /// What an axis contributes at a position, of the components that are to be kept.
    pub fn state(
        &self,
        axis: Axis,
        position_mm: f64,
        keep: impl Fn(Component) -> bool,
    ) -> AxisState {
        let at = Millimetres::new(position_mm);
        let tool = PerAxis::from_fn(|axis| self.levers.tool.map_or(0.0, |tool| tool[axis].mm()));
        let rotation_of = |curves: &PerTerm<Option<ErrorCurve>>| {
            PerAxis::from_fn(|about| {
                let rotation = Rotation { about, along: axis };
                let curve = curves[rotation].as_ref();
                let kept = curve.filter(|_| keep(Component::Rotation(rotation)));
                kept.map_or(0.0, |curve| curve.at(at).um())
            })
        };
        let deviation = PerAxis::from_fn(|of| {
            let term = ErrorTerm { of, along: axis };
            let all = self.deviations[term].as_ref().map_or(0.0, |curve| curve.at(at).um());
            let stated = self.squareness.iter().filter(|s| s.term == term);
            let stated: f64 = stated.map(|s| s.line.at(at).um()).sum();
            match [Component::Deviation(term), Component::Squareness(term)].map(&keep) {
                [true, true] => all,
                [true, false] => all - stated,
                [false, true] => stated,
                [false, false] => 0.0,
            }
        });
        AxisState {
            deviation_um: deviation
                .plus(rotation_of(&self.rotations).cross(tool).times(1.0 / MM_PER_M)),
            rotation_urad: rotation_of(&self.swings),
        }
    }

    /// The error vector at a place, machine coordinates, µm: actual − commanded, tool relative to
    /// workpiece. Outside the measured range the curves are held.
    pub fn error_at(&self, place_mm: PerAxis<f64>) -> PerAxis<f64> {
        self.part_at(place_mm, |_| true)
    }

    /// The part of some components in the error vector at a place, µm.
    pub fn part_at(
        &self,
        place_mm: PerAxis<f64>,
        keep: impl Fn(Component) -> bool,
    ) -> PerAxis<f64> {
        let states = PerAxis::from_fn(|axis| self.state(axis, place_mm[axis], &keep));
        let rotation = |axis: Axis| states[axis].rotation_urad;
        let arm_mm = place_mm.minus(self.origin);
        let [swung, _] = displaced(self.chain.order(), rotation, arm_mm, PerAxis::default());
        states.iter().fold(swung, |sum, (_, state)| sum.plus(state.deviation_um))
    }

    /// The components that were measured or stated, in the order of [`Component::all`].
    pub fn components(&self) -> Vec<Component> {
        Component::all().filter(|component| self.holds(*component)).collect()
    }

    fn holds(&self, component: Component) -> bool {
        match component {
            Component::Deviation(term) => self.deviations[term].is_some(),
            Component::Rotation(rotation) => self.rotations[rotation].is_some(),
            Component::Squareness(term) => self.squareness.iter().any(|s| s.term == term),
        }
    }

    /// Adds what a control adds to one term. Squareness of this term is from now on part of it: a
    /// table takes off the sum, and what the two would contribute apart is nothing that is left.
    ///
    /// `at_reference`: what the control adds at the reference where the axis came there as it
    /// homes; the mean of two corrections that differ by a reversal is shifted to it, as that of
    /// the measured curves is.
    pub(crate) fn correct(
        &mut self,
        term: ErrorTerm,
        correction: &ErrorCurve,
        at_reference: Option<Deviation>,
    ) {
        let Some(curve) = self.deviation(term) else { return };
        let homing = self.homing(term.along).zip(at_reference);
        let reversal = homing.map(|((reference, _), um)| correction.at(reference) - um);
        let mean = reversal.map_or(correction.clone(), |um| correction.less(um));
        self.deviations[term] = Some(curve.plus(&mean));
        self.squareness.retain(|stated| stated.term != term);
    }

    /// Takes off what a rotation does through the positions of other axes; what it does at a tool stays.
    pub(crate) fn correct_rotation(&mut self, rotation: Rotation, correction: &ErrorCurve) {
        let own = self.swings[rotation].as_ref();
        self.swings[rotation] = own.map(|own| own.plus(correction));
    }

    /// The reference of an axis, and the direction in which it comes there.
    pub(crate) fn homing(&self, axis: Axis) -> Option<(Millimetres, Direction)> {
        self.machine[axis].map(|machine| (machine.reference, machine.homing()))
    }

    /// The deviation of a term with stated squareness.
    pub fn deviation(&self, term: ErrorTerm) -> Option<&ErrorCurve> {
        self.deviations[term].as_ref()
    }

    /// The deviation of a term with stated squareness, zero at the reference.
    pub(crate) fn against_reference(&self, term: ErrorTerm) -> Option<ErrorCurve> {
        let curve = self.deviation(term)?;
        Some(self.machine[term.along].map_or(curve.clone(), |m| curve.rezeroed_at(m.reference)))
    }

    /// r × (x − optic) at the positions where the straightness was measured, e.g. of X: + ECX·(x − optic)
    /// to EYX, − EBX·(x − optic) to EZX, µm; less that at the reference, where every deviation is zero.
    ///
    /// source  docs/volume.md §2: once, as the data are read, not between the measured positions
    fn optics(&self, model: &ErrorModel, kind: Interpolation) -> PerTerm<Option<ErrorCurve>> {
        PerTerm::from_fn(|term: ErrorTerm| {
            let optic = self.levers.straightness_optic[term.along].filter(|_| term.is_cross())?;
            let curve = model.terms[term].as_ref()?.measured.mean();
            let added = |place: &Millimetres| self.swung(term, *place, optic);
            let added: Vec<Deviation> = curve.knots().iter().map(added).collect();
            let added = ErrorCurve::through(curve.knots(), &added, kind);
            Some(self.machine[term.along].map_or(added.clone(), |m| added.rezeroed_at(m.reference)))
        })
    }

    fn swung(&self, term: ErrorTerm, place: Millimetres, optic: Millimetres) -> Deviation {
        let rotation = PerAxis::from_fn(|about| {
            let curve = self.rotations[Rotation { about, along: term.along }].as_ref();
            curve.map_or(0.0, |curve| curve.at(place).um())
        });
        let own = unit(term.along).times((place - optic).mm());
        Deviation::from_um(rotation.cross(own)[term.of] / MM_PER_M)
    }
}

/// The lines of stated squareness, each over the range in which its term was measured, held beyond it; with the
/// reference outside the range a line is zero at the nearer end, which is what is held there.
fn squareness(job: &Job, model: &ErrorModel) -> Vec<Squareness> {
    let lines = job.measurement.squareness.iter().filter_map(|(term, um_per_m)| {
        let (low, high) = model.terms[*term].as_ref()?.measured.mean().measured_range();
        let machine = job.machine.axes[term.along];
        let zero = machine.map_or(low, |machine| machine.reference).mm().clamp(low.mm(), high.mm());
        let at = |place: Millimetres| Deviation::from_um(um_per_m * (place.mm() - zero) / MM_PER_M);
        let line = ErrorCurve::through(&[low, high], &[at(low), at(high)], Interpolation::Linear);
        Some(Squareness { term: *term, um_per_m: *um_per_m, line })
    });
    lines.collect()
}

/// An optic can ride on a table only.
fn check_optics(job: &Job, chain: Chain, levers: Levers) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for (axis, place) in levers.straightness_optic.iter() {
        if place.is_some() && !chain.moves_workpiece(axis) {
            let key = format!("measurement.straightness_optic_mm.{}", axis.key());
            let words = format!(
                "axis {axis} of the chain {chain} does not carry the workpiece, so no optic rides on its table"
            );
            let help = "remove it: the straightness of such an axis is measured at the tool point";
            problems.push(job.problem_at(&key, words).help(help));
        }
    }
    problems.or_ok(())
}

/// One of the 21 errors of a three-axis machine: nine deviations, nine rotations, three squareness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// `EXX` … `EZZ`.
    Deviation(ErrorTerm),
    /// `EAX` … `ECZ`.
    Rotation(Rotation),
    /// The squareness that is stated as a slope of this term: φxy of EXY.
    Squareness(ErrorTerm),
}

impl Component {
    /// All of them, in the order EXX … EZZ, EAX … ECZ, squareness XY, XZ, YZ.
    pub(super) fn all() -> impl Iterator<Item = Component> {
        let deviations = ErrorTerm::ALL.into_iter().map(Component::Deviation);
        let squareness = Plane::ALL.map(|plane| Component::Squareness(plane.carrier()));
        deviations.chain(Rotation::all().map(Component::Rotation)).chain(squareness)
    }

    /// Its name in ISO 230-1 with the sign that turns it into ours, where the two differ
    /// (contract §1): EC0Y = −φxy, EB0Z = +φxz, EA0Z = −φyz.
    pub(crate) fn iso_name(self) -> String {
        match self {
            Component::Squareness(term) => match (term.of.letter(), term.along.letter()) {
                ('X', 'Y') => "-EC0Y".to_string(),
                ('X', 'Z') => "EB0Z".to_string(),
                ('Y', 'Z') => "-EA0Z".to_string(),
                _ => self.to_string(),
            },
            _ => self.to_string(),
        }
    }
}

impl Serialize for Component {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl fmt::Display for Component {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Component::Deviation(term) => term.fmt(out),
            Component::Rotation(rotation) => rotation.fmt(out),
            Component::Squareness(term) => {
                out.pad(&format!("squareness_{}{}", term.of.key(), term.along.key()))
            }
        }
    }
}
