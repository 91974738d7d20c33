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

use super::campaign::{Campaign, MeasuredLine};
use super::closure::Start;
use super::corrections::{REFERENCE_C, of_rotations};
use super::linear::{Layout, Model, Variance};
use super::metric::PerPlane;
use super::noise::{Noise, coverage_factor, effective_freedom};
use super::readings::PassMeans;
use super::steps::Steps;
use crate::inputs::job::{AxisMaterial, Material, SetUp, StatedUncertainty};
use crate::quantity::axis::{Axis, PerAxis, Rotation};
use crate::quantity::chain::{displaced, unit};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;

/// Radians of one second of arc, times 10⁶.
const URAD_PER_ARCSEC: f64 = 1e6 * std::f64::consts::PI / (180.0 * 3600.0);

/// A ramp below this share of the readings that make it is their rounding.
const ROUNDING: f64 = 1e-9;

/// How well a slope is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeUncertainty {
    /// Standard uncertainty, µm/m.
    pub u_um_per_m: f64,
    /// Its effective degrees of freedom; `None` = unlimited.
    pub freedom: Option<f64>,
}

impl SlopeUncertainty {
    /// U, µm/m: with the coverage factor of its degrees of freedom.
    pub(crate) fn expanded_um_per_m(&self) -> f64 {
        coverage_factor(self.freedom) * self.u_um_per_m
    }
}

impl Variance {
    /// As standard uncertainty with its degrees of freedom.
    pub(super) fn as_slope(self, noise: Noise) -> SlopeUncertainty {
        let u_um_per_m = self.all.sqrt();
        let freedom = effective_freedom(u_um_per_m, self.noise.sqrt(), noise);
        SlopeUncertainty { u_um_per_m, freedom }
    }
}

/// What the uncertainty of a measurement consists of.
#[derive(Clone, Copy)]
pub(super) struct Budget<'a> {
    pub(super) campaign: &'a Campaign<'a>,
    pub(super) start: &'a Start,
    /// Of a single reading; `None` = not known.
    pub(super) noise: Option<Noise>,
    /// Whether the axes turned without overrun, so that jumps are taken off the reverse passes.
    pub(super) turned: bool,
}

impl<'a> Budget<'a> {
    /// The measured box.
    pub(super) fn volume(&self) -> &'a Volume {
        &self.campaign.measurement.volume
    }

    /// Whether every diagonal was walked in both directions.
    pub(super) fn both_ways(&self) -> bool {
        self.start.walked_back()
    }

    /// The linear model of the readings of a campaign.
    pub(super) fn model(&self) -> Model {
        let (campaign, stated) = (self.campaign, self.campaign.stated);
        let (volume, kind, lines) = (self.volume(), campaign.measurement.kind, &campaign.lines);
        let passes = &Pass::BOTH[..1 + usize::from(self.both_ways())];
        let nodes = volume.last_node(kind) + 1;
        let mut model =
            Model::new(Layout { nodes, passes: passes.len(), lines: lines.len(), apart: 0 });
        let variance = self.noise.map_or(0.0, |noise| noise.sigma_um.squared());
        for (index, line) in lines.iter().enumerate() {
            let of_setup = stated.setup_ppm.unwrap_or(0.0);
            let u_um_per_m = line.u_um_per_m.unwrap_or(0.0).hypot(of_setup);
            model.other[model.layout.line(index)] = u_um_per_m.squared();
        }
        for pass in passes {
            for d in Diagonal::ALL {
                let first = model.layout.reading(*pass, d, 0);
                let runs = self.start.counts[d][usize::from(*pass == Pass::Reverse)];
                model.noise[first..first + nodes].fill(variance / runs);
            }
        }
        let scaled = |um_per_m: &dyn Fn(Diagonal) -> PerAxis<f64>| {
            model.layout.column(|_, d, node| {
                let start = volume.inside_mm(d, kind, 0);
                um_per_m(d).dot(volume.inside_mm(d, kind, node).minus(start)) / 1000.0
            })
        };
        let common = common_um_per_m(stated, self.start.material).into_iter();
        let strains = common.map(|strain| {
            scaled(&|d| {
                let laser = volume.laser(d);
                PerAxis::from_fn(|axis| laser[axis] * strain[axis])
            })
        });
        let only = |one: Diagonal, of: PerAxis<f64>| {
            scaled(&|d| if d == one { of } else { PerAxis::default() })
        };
        let tilt =
            stated.tilt_arcsec.filter(|_| campaign.measurement.setup == SetUp::AssumePerfect);
        let tilts = Diagonal::ALL.into_iter().filter_map(|d| Some((d, tilt?)));
        let tilts = tilts.flat_map(|(d, arcsec)| {
            across(volume.laser(d)).map(|way| only(d, way.times(arcsec * URAD_PER_ARCSEC)))
        });
        let setups = Diagonal::ALL.map(|d| only(d, volume.laser(d)));
        let mut columns: Vec<Vec<f64>> = strains.collect();
        model.strains = 0..columns.len();
        model.laser = (stated.of_laser_ppm() > 0.0).then_some(0);
        columns.extend(tilts);
        model.tilts = model.strains.end..columns.len();
        columns.extend(setups);
        model.setups = model.tilts.end..columns.len();
        let unmeasured = Unmeasured::stated(campaign);
        let first = columns.len();
        model.evidence = campaign.angle_evidence();
        model.rotations = vec![None; first];
        model.rotations.extend(unmeasured.parts.iter().map(|of| Some(of.rotation)));
        columns.extend(unmeasured.parts.into_iter().map(|of| {
            let mut column = model.layout.column(|_, d, node| of.readings[d][node]);
            let line = model.layout.line(0);
            column[line..line + of.lines.len()].copy_from_slice(&of.lines);
            column
        }));
        let of_order = |acting: Vec<usize>| acting.into_iter().map(|part| first + part).collect();
        model.angles = unmeasured.orders.into_iter().map(of_order).collect();
        model.columns = columns;
        model.setup_ppm = stated.setup_ppm.unwrap_or(0.0);
        model.beam_ppm = stated.beam_ppm();
        model
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

/// What an angle does to the readings by node, µm, the same on the way back, and to linear axes and beams, µm/m.
pub(super) struct OfAngle {
    rotation: Rotation,
    pub(super) readings: PassMeans,
    lines: Vec<f64>,
}

/// What unmeasured angles with a stated bound do: one standard uncertainty of each part.
#[derive(Default)]
pub(super) struct Unmeasured {
    pub(super) parts: Vec<OfAngle>,
    /// Which of the parts act, for each order of the axes that may be.
    pub(super) orders: Vec<Vec<usize>>,
}

impl Unmeasured {
    /// formula  α(t) − α(0) = a t − b t²   t = −1 … 1 over the box; a, b independent, uniform within ± bound/2;
    ///          of a measured angle with a stated u, the same of its error with u²(a) = u²(b) = u²/2
    /// limits   the figures are those of the lines through the middle of the box, where α is 0: a constant angle
    ///          is squareness. Levers count from there, the tool has none; linear axes are taken as measured there,
    ///          beams without ends as going through. A straight part or a bow above half of the bound is not held,
    ///          nor an angle that differs between the directions.
    pub(super) fn stated(campaign: &Campaign<'_>) -> Unmeasured {
        let evidence = campaign.angle_evidence();
        let bound_urad = campaign.stated.angle_urad.filter(|bound| *bound > 0.0);
        let missing = bound_urad.map(|bound| 0.5 * bound / 3_f64.sqrt()).into_iter();
        let missing = missing.flat_map(|u| evidence.missing.iter().map(move |of| (*of, u)));
        let measured = evidence.uncertain.iter().map(|(of, u)| (*of, u / 2_f64.sqrt()));
        let rotations: Vec<(Rotation, f64)> = missing.chain(measured).collect();
        if rotations.is_empty() {
            return Unmeasured::default();
        }
        let mut known: Vec<(Rotation, [bool; 3])> = Vec::new();
        let mut parts = Vec::new();
        let mut of_order = |order: &[Axis; 3]| -> Vec<usize> {
            let mut acting = Vec::new();
            for (rotation, u_urad) in &rotations {
                // What a rotation does hangs on the axes that it swings, not on what moves it.
                let swung = order.iter().skip_while(|axis| **axis != rotation.along).skip(1);
                let swung: Vec<Axis> =
                    swung.filter(|axis| **axis != rotation.about).copied().collect();
                let key = (*rotation, Axis::ALL.map(|axis| swung.contains(&axis)));
                let at = known.iter().position(|known| *known == key).unwrap_or_else(|| {
                    known.push(key);
                    parts.extend(of_rotation(campaign, *u_urad, *order, *rotation));
                    known.len() - 1
                });
                acting.extend([2 * at, 2 * at + 1]);
            }
            acting
        };
        let orders = evidence.order.as_ref();
        let orders = orders.map_or(&Axis::ORDERS[..], std::slice::from_ref);
        let orders = orders.iter().map(&mut of_order).collect();
        Unmeasured { parts, orders }
    }
}

/// What rolls do to the readings that make ramps of the closure of this size, µm from its first interval to its
/// last: for each axis, by each order of the axes that may be.
pub(super) fn rolls(
    campaign: &Campaign<'_>,
    layout: Layout,
    ramps_um: &PerAxis<f64>,
) -> Vec<Vec<Vec<f64>>> {
    let volume = &campaign.measurement.volume;
    let evidence = campaign.angle_evidence();
    let orders = evidence.order.as_ref().map_or(&Axis::ORDERS[..], std::slice::from_ref);
    let steps = Steps::new(volume, layout, false);
    let of_axis = |axis: Axis| {
        let rotation = Rotation { about: axis, along: axis };
        let of_order = |order: &[Axis; 3]| {
            let [straight, _] = of_rotation(campaign, 1.0, *order, rotation);
            let column = layout.column(|_, d, node| straight.readings[d][node]);
            let w = |at| steps.mean(|group| steps.closure(group, axis, at)).dot(&column);
            let ramp = w(volume.steps - 1) - w(0);
            let share = ramps_um[axis] / ramp;
            let largest = column.iter().fold(0.0, |most: f64, um| most.max(um.abs()));
            (ramp.abs() > ROUNDING * largest).then(|| column.iter().map(|um| share * um).collect())
        };
        orders.iter().filter_map(of_order).collect()
    };
    Axis::ALL.into_iter().filter(|axis| ramps_um[*axis] > 0.0).map(of_axis).collect()
}

/// The straight part and the bow of an angle, each of this size at the ends of the box, µrad.
fn of_rotation(
    campaign: &Campaign<'_>,
    u_urad: f64,
    order: [Axis; 3],
    rotation: Rotation,
) -> [OfAngle; 2] {
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
        OfAngle {
            rotation,
            readings: PerDiagonal::from_fn(|d| of_rotations(ray, d, at)),
            lines: campaign.lines.iter().map(line).collect(),
        }
    })
}

/// Two unit vectors at right angles to a direction and to each other.
fn across(u: PerAxis<f64>) -> [PerAxis<f64>; 2] {
    let z = PerAxis { x: 0.0, y: 0.0, z: 1.0 };
    let one = u.cross(z);
    let one = one.times(1.0 / one.length());
    [one, u.cross(one)]
}

/// u(φ) = R/(2 V_j V_k)·u(e_end), µm/m.
pub(super) fn u_squareness(volume: &Volume, u_end_um: f64) -> PerPlane<f64> {
    PerPlane::from_fn(|plane| {
        let (a, b) = plane.axes();
        let area = volume.size[a].mm() * volume.size[b].mm();
        1000.0 * volume.diagonal_mm() / (2.0 * area) * u_end_um
    })
}
