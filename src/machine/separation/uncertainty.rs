//! What the uncertainty of a measurement consists of: the noise of the readings, and causes that are stated in
//! `[measurement.uncertainty]`, each a column of the [linear model](nonius_numerics::rows).
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
use super::corrections::{REFERENCE_C, of_rotations};
use crate::inputs::job::{AxisMaterial, Material, SetUp, StatedUncertainty};
use crate::quantity::{
    Axis, Diagonal, PerAxis, PerDiagonal, Rotation, Squared, URAD_PER_ARCSEC, displaced, unit,
};
use nonius_numerics::rows::{Cause, Layout, Model, Part};

/// The linear model of the readings, their noise left out; `material`: with the temperatures that were recorded.
pub(super) fn model(campaign: &Campaign<'_>, material: Option<Material>, layout: Layout) -> Model {
    let (measurement, stated) = (campaign.measurement, campaign.stated);
    let volume = &measurement.volume;
    let [of_setup, of_beam] =
        [stated.setup_ppm.unwrap_or(0.0), stated.beam_ppm()].map(f64::squared);
    let mut own = vec![0.0; layout.entries()];
    for (index, line) in campaign.lines.iter().enumerate() {
        own[layout.line(index)] = line.u_um_per_m.unwrap_or(0.0).squared() + of_setup;
    }
    // What a unit of each does along the diagonals, µm/m.
    let moved = PerDiagonal::from_fn(|d| -> Vec<PerAxis<f64>> {
        let inside = |node| volume.inside_mm(d, measurement.kind, node);
        (0..layout.nodes).map(|node| inside(node).minus(inside(0))).collect()
    });
    let cause = |part, um_per_m: PerDiagonal<PerAxis<f64>>, [variance, of_beam]: [f64; 2]| {
        let column = layout.column(|d, node| um_per_m[d].dot(moved[d][node]) / 1000.0);
        Cause { part, column, variance, of_beam }
    };
    let strain = |part, strain: PerAxis<f64>| {
        let along = |d| PerAxis::from_fn(|axis| volume.laser(d)[axis] * strain[axis]);
        cause(part, PerDiagonal::from_fn(along), [1.0, 0.0])
    };
    let only = |part, one: Diagonal, of: PerAxis<f64>, size| {
        let of = |d| if d == one { of } else { PerAxis::default() };
        cause(part, PerDiagonal::from_fn(of), size)
    };
    let mut causes = vec![strain(Part::Beam, PerAxis::from_fn(|_| stated.beam_ppm()))];
    let laser = (stated.of_laser_ppm() > 0.0).then_some(causes.len());
    let common = common_um_per_m(stated, material).into_iter();
    causes.extend(common.map(|um_per_m| strain(Part::Laser, um_per_m)));
    let tilt = stated.tilt_arcsec.filter(|_| measurement.setup == SetUp::AssumePerfect);
    for (d, arcsec) in Diagonal::ALL.into_iter().filter_map(|d| Some((d, tilt?))) {
        let ways = across(volume.laser(d)).map(|way| way.times(arcsec * URAD_PER_ARCSEC));
        causes.extend(ways.map(|way| only(Part::Mirror, d, way, [1.0, 0.0])));
    }
    let set_up = |d| only(Part::SetUps, d, volume.laser(d), [of_setup, of_beam]);
    causes.extend(Diagonal::ALL.map(set_up));
    let angles = unmeasured(campaign, layout, &mut causes);
    Model { layout, freedom: None, own, of_setup, causes, laser, angles }
}

/// Causes that act alike in all set-ups, one after the other: the false scale of X, Y, Z that
/// one standard uncertainty makes, µm/m. Temperature and coefficient of expansion are taken as
/// wrong by the same amount on all axes, which for the totals is the largest they can do.
fn common_um_per_m(stated: StatedUncertainty, material: Option<Material>) -> Vec<PerAxis<f64>> {
    let strain = |of: &dyn Fn(AxisMaterial) -> Option<f64>| {
        let material = |axis| material.and_then(|material| material.axes[axis]);
        PerAxis::from_fn(|axis| 1e6 * material(axis).and_then(of).unwrap_or(0.0))
    };
    let [u_k, u_per_k] = [stated.temperature_k, stated.alpha_per_k].map(|u| u.unwrap_or(0.0));
    let all = [
        PerAxis::from_fn(|_| stated.of_laser_ppm()),
        strain(&|m| Some(m.alpha_per_k * u_k)),
        strain(&|m| Some(u_per_k * (m.temperature_c? - REFERENCE_C))),
    ];
    let acts = |strain: &PerAxis<f64>| strain.iter().any(|(_, um_per_m)| um_per_m.abs() > 0.0);
    all.into_iter().filter(acts).collect()
}

/// Standard uncertainty of a length along an axis by this laser, without the noise of the readings and without the change of
/// scale of a set-up, which counts for each line in the model, 10⁻⁶.
pub(super) fn of_length_ppm(
    stated: StatedUncertainty,
    material: Option<Material>,
    axis: Axis,
) -> f64 {
    let common = common_um_per_m(stated, material).into_iter();
    common.fold(stated.beam_ppm(), |all, strain| all.hypot(strain[axis]))
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
    let first = causes.len();
    let mut known: Vec<(Rotation, [bool; 3])> = Vec::new();
    let mut of_order = |order: &[Axis; 3]| -> Vec<usize> {
        let place = |axis: Axis| order.iter().position(|own| *own == axis);
        let of = |(rotation, u_urad): &(Rotation, f64)| {
            // What a rotation does hangs on the axes that it swings, not on what moves it.
            let Rotation { about, along } = *rotation;
            let swung = Axis::ALL.map(|axis| axis != about && place(axis) > place(along));
            let at = known.iter().position(|own| *own == (*rotation, swung)).unwrap_or_else(|| {
                known.push((*rotation, swung));
                causes.extend(of_rotation(campaign, layout, *u_urad, *order, *rotation));
                known.len() - 1
            });
            [first + 2 * at, first + 2 * at + 1]
        };
        rotations.iter().flat_map(of).collect()
    };
    evidence.orders().iter().filter(|_| !rotations.is_empty()).map(&mut of_order).collect()
}

/// What the straight part and the bow of an angle, each of this size at the ends of the box, µrad, do to the readings,
/// the same on the way back, and to linear axes and beams.
pub(super) fn of_rotation(
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
