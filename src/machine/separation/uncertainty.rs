//! What the uncertainty of a measurement consists of: the noise of the readings, and causes that are stated in
//! `[measurement.uncertainty]`, each a column of the [linear model](super::linear).
//!
//! ```text
//!   noise        independent readings: σ²/r of a mean of r runs
//!   laser, temperature, expansion, beam    one false scale of X, Y, Z common to all set-ups: Σ_k strain_k u_dk (P_k(q) − P_k(0))
//!   set-up, beam                           a false scale of each set-up for itself; set-up: of each linear axis, too
//!   angles       a t and −b t² of each angle without a measurement, for each order of the axes that may be
//!   tilt         of a mirror, where the set-up is assumed perfect: η·(P(q) − P(0)) in both directions across each diagonal
//! ```
//! The beam counts here and there: it may lean alike in all set-ups, or in some of them only.

use super::campaign::{Campaign, MeasuredLine, Start};
use super::corrections::{REFERENCE_C, of_rotations};
use super::curves::{closure_sign, noise_gain};
use super::linear::{Cause, Layout, Model, Part, Row, Variance};
use super::noise::{Noise, coverage_factor, effective_freedom};
use super::readings::{Group, pass_of};
use crate::inputs::job::{AxisMaterial, Material, SetUp, StatedUncertainty};
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorTerm, Pass, PerAxis, PerDiagonal, Rotation, Squared,
    URAD_PER_ARCSEC, Volume, displaced, unit,
};
use std::sync::Arc;

/// A ramp below this share of the readings that make it is their rounding.
const ROUNDING: f64 = 1e-9;

/// How well a figure is known, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Standard uncertainty (k = 1).
    pub u: f64,
    /// Its effective degrees of freedom; `None` = unlimited.
    pub freedom: Option<f64>,
}

impl Uncertainty {
    /// U: with the coverage factor of its degrees of freedom.
    pub fn expanded(&self) -> f64 {
        self.u * coverage_factor(self.freedom)
    }
}

impl Variance {
    /// As standard uncertainty with its degrees of freedom.
    pub(super) fn uncertainty(self, noise: Noise) -> Uncertainty {
        let u = self.all.sqrt();
        Uncertainty { u, freedom: effective_freedom(u, self.noise.sqrt(), noise) }
    }
}

/// What the uncertainty of a measurement consists of.
#[derive(Clone, Copy)]
pub(super) struct Budget<'a> {
    pub(super) campaign: &'a Campaign<'a>,
    pub(super) start: &'a Start,
    /// Of a single reading; `None` = not known.
    pub(super) noise: Option<Noise>,
    /// Whether the axes ran past the end point; `None` = not known.
    pub(super) overrun: Option<bool>,
}

impl<'a> Budget<'a> {
    /// The measured box.
    pub(super) fn volume(&self) -> &'a Volume {
        &self.campaign.measurement.volume
    }

    /// Whether every diagonal was walked in both directions.
    pub(super) fn both_ways(&self) -> bool {
        self.layout().passes == 2
    }

    /// Whether the axes turned without overrun, so that jumps are taken off the reverse passes.
    pub(super) fn turned(&self) -> bool {
        self.overrun == Some(false)
    }

    /// Whether what the first and last intervals close to is spoilt by a missing overrun.
    pub(super) fn skips_ends(&self) -> bool {
        self.both_ways() && self.overrun != Some(true)
    }

    /// What is measured.
    pub(super) fn layout(&self) -> Layout {
        self.start.layout(self.campaign.lines.len())
    }

    /// Writes the variance of each reading by its noise.
    pub(super) fn write_noise(&self, own: &mut [f64]) {
        let square = self.noise.map_or(0.0, |noise| noise.sigma_um.squared());
        own.iter_mut().zip(self.start.counts()).for_each(|(own, runs)| *own = square / runs);
    }

    /// The linear model of the readings of a campaign.
    pub(super) fn model(&self) -> Model {
        let (campaign, stated) = (self.campaign, self.campaign.stated);
        let (volume, kind) = (self.volume(), campaign.measurement.kind);
        let layout = self.layout();
        let setup_ppm = stated.setup_ppm.unwrap_or(0.0);
        let mut own = vec![0.0; layout.len()];
        self.write_noise(&mut own);
        for (index, line) in campaign.lines.iter().enumerate() {
            let u_um_per_m = line.u_um_per_m.unwrap_or(0.0).hypot(setup_ppm);
            own[layout.line(index)] = u_um_per_m.squared();
        }
        let moved = PerDiagonal::from_fn(|d| -> Vec<PerAxis<f64>> {
            let inside = |node| volume.inside_mm(d, kind, node);
            (0..layout.nodes).map(|node| inside(node).minus(inside(0))).collect()
        });
        let scaled = |part: Part, um_per_m: &dyn Fn(Diagonal) -> PerAxis<f64>| {
            let each = PerDiagonal::from_fn(um_per_m);
            let of = |d: Diagonal, node: usize| each[d].dot(moved[d][node]) / 1000.0;
            Cause { part, column: layout.column(of), variance: 1.0, of_beam: 0.0 }
        };
        let strain = |part: Part, strain: PerAxis<f64>| {
            scaled(part, &|d| {
                let laser = volume.laser(d);
                PerAxis::from_fn(|axis| laser[axis] * strain[axis])
            })
        };
        let only = |part: Part, one: Diagonal, of: PerAxis<f64>| {
            scaled(part, &|d| if d == one { of } else { PerAxis::default() })
        };
        let mut causes = vec![strain(Part::Beam, PerAxis::from_fn(|_| stated.beam_ppm()))];
        let laser = (stated.of_laser_ppm() > 0.0).then_some(causes.len());
        let common = common_um_per_m(stated, self.start.material);
        causes.extend(common.into_iter().map(|um_per_m| strain(Part::Laser, um_per_m)));
        let tilt =
            stated.tilt_arcsec.filter(|_| campaign.measurement.setup == SetUp::AssumePerfect);
        for (d, arcsec) in Diagonal::ALL.into_iter().filter_map(|d| Some((d, tilt?))) {
            let ways = across(volume.laser(d)).map(|way| way.times(arcsec * URAD_PER_ARCSEC));
            causes.extend(ways.map(|way| only(Part::Mirror, d, way)));
        }
        causes.extend(Diagonal::ALL.map(|d| Cause {
            variance: setup_ppm.squared(),
            of_beam: stated.beam_ppm().squared(),
            ..only(Part::SetUps, d, volume.laser(d))
        }));
        let angles = unmeasured(campaign, layout, &mut causes);
        let evidence = campaign.angles.evidence.clone();
        Model { layout, own, of_setup: setup_ppm.squared(), causes, laser, angles, evidence }
    }
}

/// One reading less another.
type Difference = [(usize, f64); 2];

/// Formulas (1) to (3) as rows over what was measured. The slopes hold the tilt of the mirror.
impl Budget<'_> {
    /// The groups of readings of one pass, or of both.
    pub(super) fn groups(&self) -> &'static [Group] {
        match self.layout().passes {
            2 => &[Some(Direction::Plus), Some(Direction::Minus)],
            _ => &[None],
        }
    }

    /// m: the reading at the end of a step less that at its beginning.
    fn increment(&self, group: Group, d: Diagonal, axis: Axis, at: usize) -> Difference {
        let step = self.volume().interval(d, axis, at);
        let is_turn = self.turned() && step + 1 == self.volume().steps;
        let pass = if is_turn { Pass::Forward } else { pass_of(group, d, axis) };
        self.moved(pass, d, axis, step)
    }

    /// The reading of a pass at the far end of a step less that at the near one.
    pub(super) fn moved(&self, pass: Pass, d: Diagonal, axis: Axis, step: usize) -> Difference {
        let far = self.layout().reading(pass, d, self.volume().node_after(axis, step));
        [(far, 1.0), (far - 1, -1.0)]
    }

    /// J: the reverse less the forward increment of the last step of an axis.
    pub(super) fn jump(&self, d: Diagonal, axis: Axis) -> Row {
        let of = |pass| self.moved(pass, d, axis, self.volume().steps - 1);
        Row::sum([(1.0, of(Pass::Reverse)), (-1.0, of(Pass::Forward))])
    }

    /// w: closure of an interval.
    pub(super) fn closure(&self, group: Group, axis: Axis, interval: usize) -> Row {
        let of = |d: Diagonal| (closure_sign(d, axis), self.increment(group, d, axis, interval));
        Row::sum(Diagonal::ALL.map(of))
    }

    /// δ of an interval of a term for one group of readings.
    pub(super) fn delta(&self, term: ErrorTerm, group: Group, interval: usize) -> Row {
        let gain = noise_gain(self.volume(), term.of) / 2.0;
        let of = |d: Diagonal| {
            let sign = gain * d.sign(term.along) * d.sign(term.of);
            (sign, self.increment(group, d, term.along, interval))
        };
        Row::sum(Diagonal::ALL.map(of))
    }

    /// The mean of the groups.
    pub(super) fn mean(&self, of: impl Fn(Group) -> Row) -> Row {
        match self.groups() {
            [only] => of(*only),
            all => Row::sum(all.iter().map(|group| (1.0 / all.len() as f64, of(*group)))),
        }
    }

    /// δ of each interval of a term, mean of the groups.
    pub(super) fn mean_of(&self, term: ErrorTerm) -> Arc<[Row]> {
        let interval = |at| self.mean(|group| self.delta(term, group, at));
        (0..self.volume().steps).map(interval).collect()
    }

    /// Sum of the increments of a (diagonal, axis) pair, mean of the groups.
    pub(super) fn sum(&self, d: Diagonal, axis: Axis) -> Row {
        let all = 0..self.volume().steps;
        let of = |group| all.clone().map(move |at| (1.0, self.increment(group, d, axis, at)));
        self.mean(|group| Row::sum(of(group)))
    }
}

/// Causes that act alike in all set-ups, one after the other: the false scale of X, Y, Z that
/// one standard uncertainty makes, µm/m. Temperature and coefficient of expansion are taken as
/// wrong by the same amount on all axes, which for the totals is the largest they can do.
fn common_um_per_m(stated: StatedUncertainty, material: Option<Material>) -> Vec<PerAxis<f64>> {
    let strain = |of: &dyn Fn(AxisMaterial) -> Option<f64>| {
        let material = |axis| material.and_then(|material| material.axes[axis]);
        PerAxis::from_fn(|axis| 1e6 * material(axis).and_then(of).unwrap_or(0.0))
    };
    let alike = |ppm| PerAxis::from_fn(|_| ppm);
    let of_temperature = |u: f64| strain(&|m| Some(m.alpha_per_k * u));
    let of_alpha = |u: f64| strain(&|m| Some(u * (m.temperature_c? - REFERENCE_C)));
    let all = [
        Some(alike(stated.of_laser_ppm())),
        stated.temperature_k.map(of_temperature),
        stated.alpha_per_k.map(of_alpha),
    ];
    let acts = |strain: &PerAxis<f64>| strain.iter().any(|(_, um_per_m)| um_per_m.abs() > 0.0);
    all.into_iter().flatten().filter(acts).collect()
}

/// Standard uncertainty of a length along an axis by this laser in one set-up, without the noise of
/// the readings, 10⁻⁶.
pub(super) fn of_length_ppm(
    stated: StatedUncertainty,
    material: Option<Material>,
    axis: Axis,
) -> f64 {
    let common = common_um_per_m(stated, material).into_iter();
    let own = stated.setup_ppm.unwrap_or(0.0).hypot(stated.beam_ppm());
    common.fold(own, |all, strain| all.hypot(strain[axis]))
}

/// Adds what unmeasured angles with a stated bound do: one standard uncertainty of each part. Which of the causes act,
/// for each order of the axes that may be.
///
/// formula  α(t) − α(0) = a t − b t²   t = −1 … 1 over the box; a, b independent, uniform within ± bound/2;
///          of a measured angle with a stated u, the same of its error with u²(a) = u²(b) = u²/2
/// limits   the figures are those of the lines through the middle of the box, where α is 0: a constant angle
///          is squareness. Levers count from there, the tool has none; linear axes are taken as measured there,
///          beams without ends as going through. A straight part or a bow above half of the bound is not held,
///          nor an angle that differs between the directions.
fn unmeasured(campaign: &Campaign<'_>, layout: Layout, causes: &mut Vec<Cause>) -> Vec<Vec<usize>> {
    let evidence = &campaign.angles.evidence;
    let bound_urad = campaign.stated.angle_urad.filter(|bound| *bound > 0.0);
    let missing = bound_urad.map(|bound| 0.5 * bound / 3_f64.sqrt()).into_iter();
    let missing = missing.flat_map(|u| evidence.missing.iter().map(move |of| (*of, u)));
    let measured = evidence.uncertain.iter().map(|(of, u)| (*of, u / 2_f64.sqrt()));
    let rotations: Vec<(Rotation, f64)> = missing.chain(measured).collect();
    let mut known: Vec<(Rotation, [bool; 3], usize)> = Vec::new();
    let mut of_order = |order: &[Axis; 3]| -> Vec<usize> {
        let mut acting = Vec::new();
        for (rotation, u_urad) in &rotations {
            // What a rotation does hangs on the axes that it swings, not on what moves it.
            let swung = order.iter().skip_while(|axis| **axis != rotation.along).skip(1);
            let swung: Vec<Axis> = swung.filter(|axis| **axis != rotation.about).copied().collect();
            let swung = Axis::ALL.map(|axis| swung.contains(&axis));
            let same = known.iter().find(|(of, axes, _)| (of, axes) == (rotation, &swung));
            let first = same.map_or(causes.len(), |(_, _, first)| *first);
            if first == causes.len() {
                known.push((*rotation, swung, first));
                causes.extend(of_rotation(campaign, layout, *u_urad, *order, *rotation));
            }
            acting.extend([first, first + 1]);
        }
        acting
    };
    let orders = evidence.orders().iter().filter(|_| !rotations.is_empty());
    orders.map(&mut of_order).collect()
}

/// What rolls do to the readings that make ramps of the closure of this size, µm from its first interval to its
/// last: for each axis, by each order of the axes that may be.
pub(super) fn rolls(
    budget: &Budget<'_>,
    layout: Layout,
    ramps_um: &PerAxis<f64>,
) -> Vec<Vec<Vec<f64>>> {
    let (campaign, volume) = (budget.campaign, budget.volume());
    let evidence = &campaign.angles.evidence;
    let of_axis = |axis: Axis| {
        let rotation = Rotation { about: axis, along: axis };
        let of_order = |order: &[Axis; 3]| {
            let [Cause { mut column, .. }, _] =
                of_rotation(campaign, layout, 1.0, *order, rotation);
            column[layout.line(0)..].fill(0.0); // the readings alone
            let w = |at| budget.mean(|group| budget.closure(group, axis, at)).dot(&column);
            let ramp = w(volume.steps - 1) - w(0);
            let share = ramps_um[axis] / ramp;
            let largest = column.iter().fold(0.0, |most: f64, um| most.max(um.abs()));
            (ramp.abs() > ROUNDING * largest).then(|| column.iter().map(|um| share * um).collect())
        };
        evidence.orders().iter().filter_map(of_order).collect()
    };
    Axis::ALL.into_iter().filter(|axis| ramps_um[*axis] > 0.0).map(of_axis).collect()
}

/// What the straight part and the bow of an angle, each of this size at the ends of the box, µrad, do to the readings,
/// the same on the way back, and to linear axes and beams.
fn of_rotation(
    campaign: &Campaign<'_>,
    layout: Layout,
    u_urad: f64,
    order: [Axis; 3],
    rotation: Rotation,
) -> [Cause; 2] {
    let measurement = campaign.measurement;
    let volume = &measurement.volume;
    let half = volume.size[rotation.along].mm() / 2.0;
    let middle = volume.middle();
    let middle = PerAxis::from_fn(|axis| middle[axis].mm());
    let shapes: [fn(f64) -> f64; 2] = [|t| t, |t| -t * t];
    shapes.map(|shape| {
        let at = |place: PerAxis<f64>| {
            let lever = place.minus(middle);
            let urad = u_urad * shape(lever[rotation.along] / half);
            let about = |axis| f64::from(axis == rotation.along) * urad;
            let turned = |axis| unit(rotation.about).times(about(axis));
            displaced(order, turned, lever, PerAxis::default())
        };
        let ray = (volume, measurement.kind, measurement.target);
        let line = |line: &MeasuredLine| {
            let Some(ends) = line.ends else { return 0.0 };
            let [from, to] = ends.map(|end| PerAxis::from_fn(|axis| end[axis].mm()));
            let rise = line.direction.dot(at(to)[0].minus(at(from)[0]));
            1000.0 * rise / to.minus(from).length()
        };
        let readings = PerDiagonal::from_fn(|d| of_rotations(ray, d, at));
        let mut column = layout.column(|d, node| readings[d][node]);
        let lines = column[layout.line(0)..].iter_mut().zip(&campaign.lines);
        lines.for_each(|(um_per_m, of)| *um_per_m = line(of));
        Cause { part: Part::Angle(rotation), column, variance: 1.0, of_beam: 0.0 }
    })
}

/// Two unit vectors at right angles to a direction and to each other.
fn across(u: PerAxis<f64>) -> [PerAxis<f64>; 2] {
    let z = PerAxis { x: 0.0, y: 0.0, z: 1.0 };
    let one = u.cross(z);
    let one = one.times(1.0 / one.length());
    [one, u.cross(one)]
}
