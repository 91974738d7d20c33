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
//! φxy is a slope of EXY, and so on (contract §2.3). Its lever is counted from the offset too.
//!
//! An error that was not measured is left out and *named* ([`VolumeModel::missing`]).

mod component;
mod map;
mod missing;

pub use self::component::Component;
pub use self::map::{ErrorMap, Nodes};
pub use self::missing::Missing;

use crate::axis::{Axis, ErrorTerm, PerAxis, PerTerm, Rotation};
use crate::chain::{Chain, unit};
use crate::curve::ErrorCurve;
use crate::job::{Job, Levers};
use crate::model::{ErrorModel, Measured};
use crate::problem::Problems;
use crate::units::Millimetres;

/// mm in a metre: µrad × mm = 10⁻³ µm, and slopes are in µm/m.
const MM_PER_M: f64 = 1000.0;

/// The errors of a machine everywhere in its volume.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeModel {
    /// The order of the axes; only angles ask for it.
    pub chain: Chain,
    /// Whether the job states it; else all axes are taken to move the tool.
    pub chain_is_stated: bool,
    /// The nine deviations without stated squareness, zero at the reference; mean of the directions.
    deviations: PerTerm<Option<ErrorCurve>>,
    /// The nine rotations, µrad; mean of the directions.
    rotations: PerTerm<Option<ErrorCurve>>,
    /// Stated squareness: slope in µm/m of one term.
    squareness: Vec<(ErrorTerm, f64)>,
    levers: Levers,
    /// Where levers count from: the stated offsets, else the reference.
    origin: PerAxis<f64>,
    /// The range of each axis that the model holds for, mm; a single place where nothing is known.
    ranges: PerAxis<(f64, f64)>,
    /// What whoever reads a figure of this model has to know, one sentence each.
    pub labels: Vec<String>,
}

/// What one axis contributes where it stands: a deviation, a rotation and a lever for the rotations
/// of the axes before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisState {
    /// Machine coordinate, mm.
    pub position_mm: f64,
    /// Its deviation with squareness, and its own rotation × tool offset, µm.
    pub deviation_um: PerAxis<f64>,
    /// Its rotation, µrad.
    pub rotation_urad: PerAxis<f64>,
    /// Its position less the offset along its own direction, mm.
    pub arm_mm: PerAxis<f64>,
}

impl VolumeModel {
    /// The model of a job's measured errors. Angles need the chain.
    pub fn build(job: &Job, model: &ErrorModel) -> Result<VolumeModel, Problems> {
        let has_angles = model.rotations.iter().any(|(_, angle)| angle.is_some());
        let Some(chain) = job
            .machine
            .chain
            .or((!has_angles).then_some(Chain::ALL_AXES_MOVE_THE_TOOL))
        else {
            return Err(job
                .problem_at("machine", "angles act through levers, which need the order of the axes: `machine.chain` is missing")
                .help("state it, e.g. `chain = \"wXYZt\"`")
                .into());
        };
        let levers = job.measurement.levers;
        check_optics(job, chain, levers)?;
        let squareness = job.measurement.squareness.clone();
        let reference = PerAxis::from_fn(|axis| job.machine.axes[axis].map(|a| a.reference.mm()));
        let origin = PerAxis::from_fn(|axis| {
            let offset = levers.offsets[axis].map(Millimetres::mm);
            offset.or(reference[axis]).unwrap_or(0.0)
        });
        let mut built = VolumeModel {
            chain,
            chain_is_stated: job.machine.chain.is_some(),
            deviations: PerTerm::from_fn(|term: ErrorTerm| {
                let curve = model.terms[term].as_ref()?.measured.mean();
                Some(without_squareness(job, &squareness, term, curve))
            }),
            rotations: PerTerm::from_fn(|term: ErrorTerm| {
                model.rotations[term].as_ref().map(Measured::mean)
            }),
            squareness,
            levers,
            origin,
            ranges: PerAxis::default(),
            labels: Vec::new(),
        };
        built.ranges = PerAxis::from_fn(|axis| built.range_of(job, axis));
        built.labels = built.statements(job, model);
        Ok(built)
    }

    /// The range of an axis: what all of its curves cover; of an axis without curves its travel,
    /// because the rotations of others swing it all the same.
    fn range_of(&self, job: &Job, axis: Axis) -> (f64, f64) {
        let covered = self.curves_along(axis).map(|curve| {
            let (low, high) = curve.measured_range();
            (low.mm(), high.mm())
        });
        let travel = job.machine.axes[axis].map(|a| (a.low.mm(), a.high.mm()));
        covered
            .reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
            .filter(|(low, high)| low <= high)
            .or(travel)
            .unwrap_or((self.origin[axis], self.origin[axis]))
    }

    fn curves_along(&self, axis: Axis) -> impl Iterator<Item = &ErrorCurve> {
        let deviations =
            Axis::ALL.map(|of| self.deviations[ErrorTerm { of, along: axis }].as_ref());
        let rotations =
            Axis::ALL.map(|about| self.rotations[Rotation { about, along: axis }].as_ref());
        deviations.into_iter().chain(rotations).flatten()
    }

    /// Every position where a curve of an axis bends or ends, mm, ascending; where it has none, the
    /// ends of its range.
    pub fn bends(&self, axis: Axis) -> Vec<f64> {
        let knots = self.curves_along(axis).flat_map(ErrorCurve::knots);
        let mut bends: Vec<f64> = knots.map(|knot| knot.mm()).collect();
        if bends.is_empty() {
            bends.extend([self.ranges[axis].0, self.ranges[axis].1]);
        }
        bends.sort_by(f64::total_cmp);
        bends.dedup_by(|next, kept| next <= kept);
        bends
    }

    /// Whether anything of an axis was measured.
    pub fn is_measured(&self, axis: Axis) -> bool {
        self.curves_along(axis).next().is_some()
    }

    /// The range of an axis that the figures hold for, mm.
    pub fn range(&self, axis: Axis) -> (f64, f64) {
        self.ranges[axis]
    }

    /// Where the levers of angles and squareness count from, mm: there they have no effect.
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
        let arm = position_mm - self.origin[axis];
        let rotation_urad = PerAxis::from_fn(|about| {
            let rotation = Rotation { about, along: axis };
            let curve = self.rotations[rotation].as_ref();
            let kept = curve.filter(|_| keep(Component::Rotation(rotation)));
            kept.map_or(0.0, |curve| curve.at(at).um())
        });
        let measured = PerAxis::from_fn(|of| {
            let term = ErrorTerm { of, along: axis };
            let curve = self.deviations[term].as_ref();
            let kept = curve.filter(|_| keep(Component::Deviation(term)));
            let lines = self
                .squareness
                .iter()
                .filter(|(sloped, _)| *sloped == term && keep(Component::Squareness(term)));
            let slope: f64 = lines.map(|(_, slope)| slope).sum();
            kept.map_or(0.0, |curve| curve.at(at).um()) + slope * (arm + tool[axis]) / MM_PER_M
        });
        let optic = self.levers.straightness_optic[axis];
        let own = unit(axis).times(optic.map_or(0.0, |optic| position_mm - optic.mm()));
        AxisState {
            position_mm,
            deviation_um: measured.plus(rotation_urad.cross(tool.plus(own)).times(1.0 / MM_PER_M)),
            rotation_urad,
            arm_mm: unit(axis).times(arm),
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
        let order = self.chain.order();
        let [first, second, third] = order.map(|axis| self.state(axis, place_mm[axis], &keep));
        error_of(&first, &second, &third)
    }

    /// The components that were measured or stated, in the order EXX … EZZ, EAX … ECZ, squareness.
    pub fn components(&self) -> Vec<Component> {
        let deviations = ErrorTerm::ALL.into_iter().map(Component::Deviation);
        let rotations = Rotation::all().map(Component::Rotation);
        let squareness = self.squareness.iter();
        deviations
            .chain(rotations)
            .filter(|component| match component {
                Component::Deviation(term) => self.deviations[*term].is_some(),
                Component::Rotation(rotation) => self.rotations[*rotation].is_some(),
                Component::Squareness(_) => false,
            })
            .chain(squareness.map(|(term, _)| Component::Squareness(*term)))
            .collect()
    }

    /// The machine with other deviations (as tables leave them); the rest stays.
    #[must_use]
    pub fn with_deviations(&self, deviations: PerTerm<Option<ErrorCurve>>) -> VolumeModel {
        VolumeModel {
            deviations,
            ..self.clone()
        }
    }

    /// The deviation of a term without stated squareness.
    pub fn deviation(&self, term: ErrorTerm) -> Option<&ErrorCurve> {
        self.deviations[term].as_ref()
    }

    /// Stated squareness, µm/m, by the term that it is a slope of.
    pub fn squareness(&self) -> &[(ErrorTerm, f64)] {
        &self.squareness
    }
}

/// e = Σ dᵢ + r₁ × (a₂ + a₃) + r₂ × a₃, µm; the states in chain order.
pub fn error_of(first: &AxisState, second: &AxisState, third: &AxisState) -> PerAxis<f64> {
    let sum = first.deviation_um.plus(second.deviation_um);
    let swung = first.rotation_urad.cross(second.arm_mm.plus(third.arm_mm));
    let swung = swung.plus(second.rotation_urad.cross(third.arm_mm));
    sum.plus(third.deviation_um)
        .plus(swung.times(1.0 / MM_PER_M))
}

/// The curve less the slope that the job added to it (contract §2.3, squareness).
fn without_squareness(
    job: &Job,
    squareness: &[(ErrorTerm, f64)],
    term: ErrorTerm,
    curve: ErrorCurve,
) -> ErrorCurve {
    let stated = squareness.iter().find(|(sloped, _)| *sloped == term);
    let (Some((_, slope)), Some(machine)) = (stated, job.machine.axes[term.along]) else {
        return curve;
    };
    let (low, high) = curve.measured_range();
    let zero = machine.reference.mm().clamp(low.mm(), high.mm());
    curve.plus_slope(-slope, Millimetres::new(zero))
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
            problems.push(
                job.problem_at(&key, words).help(
                    "remove it: the straightness of such an axis is measured at the tool point",
                ),
            );
        }
    }
    problems.or_ok(())
}
