//! What the uncertainty of a measurement consists of: the noise of the readings, and causes that are stated in
//! `[measurement.uncertainty]`, each a column of the [linear model](super::linear).
//!
//! ```text
//!   noise        independent readings: σ²/r of a mean of r runs
//!   laser, temperature, expansion, beam    one false scale of X, Y, Z common to all set-ups: Σ_k strain_k u_dk (P_k(q) − P_k(0))
//!   set-up, beam                           a false scale of each set-up for itself
//!   angles       a t and −b t² of each angle without a measurement, for each order of the axes that may be
//!   tilt         of a mirror, where the set-up is assumed perfect: η·(P(q) − P(0)) in both directions across each diagonal
//! ```
//! The beam counts here and there: it may lean alike in all set-ups, or in some of them only.

use super::campaign::{Campaign, MeasuredLine};
use super::corrections::{REFERENCE_C, Turning};
use super::linear::{Layout, Model, Variance};
use super::metric::PerPlane;
use super::noise::{Noise, coverage_factor, effective_freedom};
use super::readings::PassMeans;
use crate::inputs::job::{AxisMaterial, Material, SetUp, StatedUncertainty};
use crate::quantity::axis::{Axis, Direction, PerAxis, Rotation};
use crate::quantity::chain::unit;
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;

/// Radians of one second of arc, times 10⁶.
const URAD_PER_ARCSEC: f64 = 1e6 * std::f64::consts::PI / (180.0 * 3600.0);

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
#[derive(Clone, Debug)]
pub struct Budget<'a> {
    /// The measured box.
    pub volume: &'a Volume,
    /// Of a single reading; `None` = not known.
    pub noise: Option<Noise>,
    /// Runs of each pass.
    pub runs: &'a PerDiagonal<[f64; 2]>,
    /// Whether the axes turned without overrun, so that jumps are taken off the reverse passes.
    pub turned: bool,
    /// `[measurement.uncertainty]`.
    pub stated: StatedUncertainty,
    /// Expansion of the scales.
    pub material: Option<Material>,
}

impl Budget<'_> {
    /// Whether every diagonal was walked in both directions.
    pub(super) fn both_ways(&self) -> bool {
        self.runs.iter().all(|(_, runs)| runs[1] > 0.0)
    }

    /// The linear model of the readings of a campaign.
    pub(super) fn model(&self, campaign: &Campaign<'_>) -> Model {
        let (kind, lines) = (campaign.measurement.kind, &campaign.lines);
        let passes = &Pass::BOTH[..1 + usize::from(self.both_ways())];
        let nodes = self.volume.last_node(kind) + 1;
        let mut model = Model::new(Layout { nodes, passes: passes.len(), lines: lines.len() });
        let variance = self.noise.map_or(0.0, |noise| noise.sigma_um.squared());
        for (index, line) in lines.iter().enumerate() {
            model.other[model.layout.line(index)] = line.u_um_per_m.unwrap_or(0.0).squared();
        }
        for pass in passes {
            for d in Diagonal::ALL {
                let first = model.layout.reading(*pass, d, 0);
                let runs = self.runs[d][usize::from(*pass == Pass::Reverse)];
                model.noise[first..first + nodes].fill(variance / runs);
            }
        }
        let volume = self.volume;
        let scaled = |um_per_m: &dyn Fn(Diagonal) -> PerAxis<f64>| {
            model.layout.column(|_, d, node| {
                let start = volume.inside_mm(d, kind, 0);
                um_per_m(d).dot(volume.inside_mm(d, kind, node).minus(start)) / 1000.0
            })
        };
        let strains = self.common_um_per_m().into_iter().map(|strain| {
            scaled(&|d| {
                let laser = volume.laser(d);
                PerAxis::from_fn(|axis| laser[axis] * strain[axis])
            })
        });
        let only = |one: Diagonal, of: PerAxis<f64>| {
            scaled(&|d| if d == one { of } else { PerAxis::default() })
        };
        let tilt = campaign.stated.tilt_arcsec;
        let tilt = tilt.filter(|_| campaign.measurement.setup == SetUp::AssumePerfect);
        let tilts = Diagonal::ALL.into_iter().filter_map(|d| Some((d, tilt?)));
        let tilts = tilts.flat_map(|(d, arcsec)| {
            across(volume.laser(d)).map(|way| only(d, way.times(arcsec * URAD_PER_ARCSEC)))
        });
        let setups = Diagonal::ALL.map(|d| only(d, volume.laser(d)));
        let mut columns: Vec<Vec<f64>> = strains.collect();
        model.strains = 0..columns.len();
        columns.extend(tilts);
        model.tilts = model.strains.end..columns.len();
        columns.extend(setups);
        model.setups = model.tilts.end..columns.len();
        for order in unmeasured(campaign) {
            let first = columns.len();
            columns.extend(order.into_iter().map(|of: OfAngle| {
                let mut column = model.layout.column(|_, d, node| of.readings[d][node]);
                let first = model.layout.line(0);
                column[first..first + of.lines.len()].copy_from_slice(&of.lines);
                column
            }));
            model.angles.push(first..columns.len());
        }
        model.columns = columns;
        model.setup_ppm = self.stated.setup_ppm.unwrap_or(0.0);
        model.beam_ppm = self.stated.beam_ppm();
        model.angle_urad = self.stated.angle_urad;
        model
    }

    /// Causes that act alike in all set-ups, one after the other: the false scale of X, Y, Z that
    /// one standard uncertainty makes, µm/m. Temperature and coefficient of expansion are taken as
    /// wrong by the same amount on all axes, which for the totals is the largest they can do.
    fn common_um_per_m(&self) -> Vec<PerAxis<f64>> {
        let strain = |of: &dyn Fn(AxisMaterial) -> Option<f64>| {
            let material = |axis| self.material.and_then(|material| material.axes[axis]);
            PerAxis::from_fn(|axis| 1e6 * material(axis).and_then(of).unwrap_or(0.0))
        };
        let stated = self.stated;
        let alike = |ppm| PerAxis::from_fn(|_| ppm);
        let of_temperature = |u: f64| strain(&|m| Some(m.alpha_per_k * u));
        let of_alpha = |u: f64| strain(&|m| Some(u * (m.temperature_c? - REFERENCE_C)));
        let all = [
            stated.laser_ppm.map(alike),
            stated.temperature_k.map(of_temperature),
            stated.alpha_per_k.map(of_alpha),
        ];
        let acts = |strain: &PerAxis<f64>| strain.iter().any(|(_, um_per_m)| um_per_m.abs() > 0.0);
        all.into_iter().flatten().filter(acts).collect()
    }

    /// Standard uncertainty of a length along an axis by this laser in one set-up, without the noise of
    /// the readings, 10⁻⁶.
    pub(super) fn of_length_ppm(&self, axis: Axis) -> f64 {
        let common = self.common_um_per_m().into_iter();
        let own = self.stated.setup_ppm.unwrap_or(0.0).hypot(self.stated.beam_ppm());
        common.fold(own, |all, strain| all.hypot(strain[axis]))
    }
}

/// What an angle does to the readings by node, µm, the same on the way back, and to linear axes and beams, µm/m.
pub(super) struct OfAngle {
    pub(super) readings: PassMeans,
    lines: Vec<f64>,
}

/// What unmeasured angles do, for each order of the axes that may be: one standard uncertainty for a bound of 1 µrad.
///
/// formula  α(t) − α(0) = a t − b t²   t = −1 … 1 over the box; a, b independent, uniform within ± bound/2
/// limits   the figures are those of the lines through the middle of the box, where α is 0: a constant angle
///          is squareness. Levers count from there, the tool has none; linear axes are taken as measured there,
///          beams without ends as going through. A straight part or a bow above half of the bound is not held,
///          nor an angle that differs between the directions.
pub(super) fn unmeasured(campaign: &Campaign<'_>) -> Vec<Vec<OfAngle>> {
    let evidence = campaign.angle_evidence();
    let measurement = campaign.measurement;
    let volume = &measurement.volume;
    let half = |axis: Axis| volume.size[axis].mm() / 2.0;
    let middle = PerAxis::from_fn(|axis| volume.start[axis].mm() + half(axis));
    let u = 0.5 / 3_f64.sqrt();
    let shapes: [fn(f64) -> f64; 2] = [|t| t, |t| -t * t];
    let column = |order: [Axis; 3], rotation: &Rotation, shape: fn(f64) -> f64| {
        let turning = Turning {
            order,
            rotation: &|axis, position, _| {
                let urad = u * shape((position - middle[axis]) / half(axis));
                let size = if axis == rotation.along { urad } else { 0.0 };
                unit(rotation.about).times(size)
            },
            origin: middle,
            tool: PerAxis::default(),
            reflector: measurement.target,
        };
        let line = |line: &MeasuredLine| {
            let Some(ends) = line.ends else { return 0.0 };
            let [from, to] = ends.map(|end| PerAxis::from_fn(|axis| end[axis].mm()));
            let error = |place| turning.at(place, |_| Direction::Plus)[0];
            let rise = line.direction.dot(error(to).minus(error(from)));
            1000.0 * rise / to.minus(from).length()
        };
        let walk = |d| turning.effect_um(volume, measurement.kind, d, Pass::Forward);
        OfAngle {
            readings: PerDiagonal::from_fn(walk),
            lines: campaign.lines.iter().map(line).collect(),
        }
    };
    let of_order = |order: &[Axis; 3]| {
        let pairs = evidence.missing.iter().flat_map(|r| shapes.map(|shape| (r, shape)));
        pairs.map(|(rotation, shape)| column(*order, rotation, shape)).collect()
    };
    let orders = evidence.order.as_ref();
    orders.map_or(&Axis::ORDERS[..], std::slice::from_ref).iter().map(of_order).collect()
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
