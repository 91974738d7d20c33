//! What the tables leave along the four body diagonals of the measured box.
//!
//! The deviation along the beam is a sum over the nine terms. Between two places where a curve or
//! a correction bends, it is a cubic of the way, so its extremes are found without sampling.

use super::within;
use super::{DiagonalForecast, Machine};
use crate::judge::conformity::Sigma;
use crate::machine::model::{ErrorModel, Measured, MeasuredTerm, PointUncertainty};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::{Millimetres, Squared, larger};
use crate::read::emulate::{CannotEmulate, Emulator, Response};
use crate::write::plan::{Plan, axis_pairs};

/// Sign of travel of X, Y, Z on the forward run of each diagonal (contract §2.2).
const DIAGONALS: [(&str, [f64; 3]); 4] = [
    ("PPP", [1.0, 1.0, 1.0]),
    ("NPP", [-1.0, 1.0, 1.0]),
    ("PNP", [1.0, -1.0, 1.0]),
    ("PPN", [1.0, 1.0, -1.0]),
];

/// The measured box: low corner and size of each axis, mm.
struct MeasuredBox {
    low: [f64; 3],
    size: [f64; 3],
}

impl MeasuredBox {
    fn of(
        model: &ErrorModel,
        judged: &PerAxis<Option<(Millimetres, Millimetres)>>,
    ) -> Option<MeasuredBox> {
        let ends = |axis: &Axis| {
            let (low, high) = within(model.ranges[*axis]?, judged[*axis]);
            Some((low.mm(), high.mm()))
        };
        let ends: Option<Vec<(f64, f64)>> = Axis::ALL.iter().map(ends).collect();
        let ends = ends?;
        Some(MeasuredBox {
            low: [ends[0].0, ends[1].0, ends[2].0],
            size: [
                ends[0].1 - ends[0].0,
                ends[1].1 - ends[1].0,
                ends[2].1 - ends[2].0,
            ],
        })
    }

    /// Low and high end of an axis.
    fn ends(&self, axis: usize) -> (Millimetres, Millimetres) {
        let (low, size) = (self.low[axis], self.size[axis]);
        (Millimetres::new(low), Millimetres::new(low + size))
    }

    fn length(&self) -> f64 {
        self.size.iter().map(|s| s * s).sum::<f64>().sqrt()
    }
}

/// The four diagonals; none where a term or a direction of it was not measured.
pub(super) fn forecast(
    machine: Machine<'_>,
    plan: &Plan,
    control: &dyn Emulator,
    judged: &PerAxis<Option<(Millimetres, Millimetres)>>,
    sigma: Sigma,
) -> Result<Vec<DiagonalForecast>, CannotEmulate> {
    let model = machine.as_measured;
    let Some(measured_box) = MeasuredBox::of(model, judged) else {
        return Ok(Vec::new());
    };
    let one_way = |(_, m): (ErrorTerm, &MeasuredTerm)| matches!(m.measured, Measured::OneWay(..));
    if model.measured().count() < ErrorTerm::ALL.len() || model.measured().any(one_way) {
        // A diagonal travels some axis in the direction that was not measured.
        return Ok(Vec::new());
    }
    let travels = travels(machine, plan, control, &measured_box)?;
    let of_diagonal = |(name, signs): &(&'static str, [f64; 3])| {
        let mut before = Extent::default();
        let mut after = Extent::default();
        let walk = |reverse| Walk::new(&travels, &measured_box, *signs, reverse);
        let (forward, reverse) = (walk(false), walk(true));
        forward.extremes(&mut before, &mut after);
        if reverse.parts != forward.parts {
            reverse.extremes(&mut before, &mut after);
        }
        let u_um = uncertainties(model, &measured_box, *signs);
        let scale_um = model.laser_um_per_m * measured_box.length() / 1000.0;
        let cosine = |axis| measured_box.size[index(axis)] / measured_box.length();
        DiagonalForecast {
            cosines: PerAxis::from_fn(cosine),
            ..DiagonalForecast::new(name, before.size(), after.size(), sigma, &u_um, scale_um)
        }
    };
    Ok(DIAGONALS.iter().map(of_diagonal).collect())
}

/// One term while its axis travels one way: its curves, its correction and where they bend.
#[derive(PartialEq)]
struct Travel<'a> {
    measured: &'a ErrorCurve,
    /// Without tables; absent where none was active while measuring.
    uncompensated: Option<&'a ErrorCurve>,
    response: Response,
    /// Places inside the measured box where a curve or the correction bends or jumps, mm.
    bends: Vec<Vec<f64>>,
}

/// Every measured term both ways; the four diagonals share them.
fn travels<'a>(
    machine: Machine<'a>,
    plan: &Plan,
    control: &dyn Emulator,
    measured_box: &MeasuredBox,
) -> Result<Vec<(ErrorTerm, Direction, Travel<'a>)>, CannotEmulate> {
    let mut travels = Vec::new();
    for (term, _) in machine.as_measured.measured() {
        for direction in Direction::BOTH {
            let Some((measured, uncompensated)) = machine.curves(term, direction) else {
                continue;
            };
            let Some((base, output)) = axis_pairs(&plan.names, term).first().copied() else {
                continue;
            };
            let uncompensated = (!std::ptr::eq(measured, uncompensated)).then_some(uncompensated);
            let response = control.response(base, output, direction)?;
            let (low, high) = measured_box.ends(index(term.along));
            let knots = |curve: &ErrorCurve| curve.knots().iter().map(|x| x.mm()).collect();
            let of_curves = [Some(measured), uncompensated]
                .into_iter()
                .flatten()
                .map(knots);
            let bends = of_curves.chain([response.breaks(low, high)]).collect();
            let travel = Travel {
                measured,
                uncompensated,
                response,
                bends,
            };
            travels.push((term, direction, travel));
        }
    }
    Ok(travels)
}

/// Standard uncertainty of the deviation along the beam, µm, wherever an axis stands at one of its
/// measured positions: three terms per axis, weighted with the direction cosine. A value by itself
/// counts, since max − min is a difference and the reference drops out. A term of which nothing is
/// stated counts as 0; empty where nothing is stated at all.
fn uncertainties(model: &ErrorModel, measured_box: &MeasuredBox, signs: [f64; 3]) -> Vec<f64> {
    if model.measured().all(|(_, m)| m.uncertainty.is_empty()) {
        return Vec::new();
    }
    let walk = Walk {
        parts: Vec::new(),
        measured_box,
        signs,
    };
    let mut places = Vec::new();
    for (term, measured) in model.measured() {
        let axis = index(term.along);
        let (low, size) = (measured_box.low[axis], measured_box.size[axis]);
        let travelled = measured
            .uncertainty
            .iter()
            .map(|p| (p.at.mm() - low) / size);
        places.extend(travelled.map(|t| if signs[axis] > 0.0 { t } else { 1.0 - t }));
    }
    places.retain(|t| (-SAME_PLACE..=1.0 + SAME_PLACE).contains(t));
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < SAME_PLACE);
    let u_um = |t: &f64| {
        let variances = model.measured().map(|(term, measured)| {
            let cosine = measured_box.size[index(term.of)] / measured_box.length();
            (cosine * near_um(measured, walk.position(index(term.along), *t))).squared()
        });
        variances.sum::<f64>().sqrt()
    };
    places.iter().map(u_um).collect()
}

/// Places on a diagonal that differ by less are one, in parts of its length.
const SAME_PLACE: f64 = 1e-9;

/// The larger of the uncertainties on either side of a place, µm.
fn near_um(measured: &MeasuredTerm, at: Millimetres) -> f64 {
    let distance = |point: &&PointUncertainty| (point.at - at).mm();
    let points = || measured.uncertainty.iter();
    let below = points().filter(|p| distance(p) <= AT_A_POINT_MM);
    let above = points().filter(|p| distance(p) >= -AT_A_POINT_MM);
    let nearest_below = below.map(|p| distance(&p)).reduce(larger);
    let nearest_above = above.map(|p| -distance(&p)).reduce(larger);
    let is_near = |p: &&PointUncertainty| {
        let near =
            |edge: Option<f64>, own: f64| edge.is_some_and(|e| (own - e).abs() < AT_A_POINT_MM);
        near(nearest_below, distance(p)) || near(nearest_above, -distance(p))
    };
    points()
        .filter(is_near)
        .map(|p| p.value_um)
        .fold(0.0, larger)
}

/// Nearer to a measured position than this is at it, mm.
const AT_A_POINT_MM: f64 = 1e-6;

const fn index(axis: Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}

/// Smallest and largest value met.
#[derive(Default)]
struct Extent {
    ends: Option<(f64, f64)>,
}

impl Extent {
    fn meet(&mut self, value: f64) {
        let (low, high) = self.ends.unwrap_or((value, value));
        self.ends = Some((low.min(value), high.max(value)));
    }

    fn size(&self) -> f64 {
        self.ends.map_or(0.0, |(low, high)| high - low)
    }
}

/// One run along a diagonal, t from 0 to 1.
struct Walk<'a> {
    parts: Vec<Part<'a>>,
    measured_box: &'a MeasuredBox,
    signs: [f64; 3],
}

/// One term on the way, and the cosine of the beam to its direction.
#[derive(PartialEq)]
struct Part<'a> {
    travel: &'a Travel<'a>,
    along: usize,
    cosine: f64,
}

impl<'a> Walk<'a> {
    fn new(
        travels: &'a [(ErrorTerm, Direction, Travel<'a>)],
        measured_box: &'a MeasuredBox,
        signs: [f64; 3],
        reverse: bool,
    ) -> Walk<'a> {
        let part = |(term, direction, travel): &'a (ErrorTerm, Direction, Travel<'a>)| {
            let (of, along) = (index(term.of), index(term.along));
            let forward = (signs[along] > 0.0) != reverse;
            (forward == (*direction == Direction::Plus)).then(|| Part {
                travel,
                along,
                cosine: signs[of] * measured_box.size[of] / measured_box.length(),
            })
        };
        Walk {
            parts: travels.iter().filter_map(part).collect(),
            measured_box,
            signs,
        }
    }

    fn position(&self, axis: usize, t: f64) -> Millimetres {
        let travelled = if self.signs[axis] > 0.0 { t } else { 1.0 - t };
        Millimetres::new(self.measured_box.low[axis] + travelled * self.measured_box.size[axis])
    }

    /// Places t where a curve or a correction bends or jumps.
    fn breaks(&self) -> Vec<f64> {
        let mut breaks = vec![0.0, 1.0];
        for axis in 0..self.signs.len() {
            let (low, size) = (self.measured_box.low[axis], self.measured_box.size[axis]);
            let travelled = |x: &f64| (x - low) / size;
            for bends in self.bends(axis) {
                let forward = self.signs[axis] > 0.0;
                let places = bends.iter().map(travelled);
                breaks.extend(places.map(|t| if forward { t } else { 1.0 - t }));
            }
        }
        breaks.retain(|t| (0.0..=1.0).contains(t));
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        breaks
    }

    /// Where the curves and corrections along an axis bend, mm; the terms of an axis mostly share
    /// their places.
    fn bends(&self, axis: usize) -> Vec<&'a [f64]> {
        let mut all: Vec<&[f64]> = Vec::new();
        for part in self.parts.iter().filter(|part| part.along == axis) {
            for bends in &part.travel.bends {
                if !all.contains(&bends.as_slice()) {
                    all.push(bends);
                }
            }
        }
        all
    }

    /// Deviation along the beam at t, as measured and with the tables, µm.
    fn deviation(&self, t: f64) -> (f64, f64) {
        let mut before = 0.0;
        let mut after = 0.0;
        let places = [0, 1, 2].map(|axis| self.position(axis, t));
        for part in &self.parts {
            let (at, travel) = (places[part.along], part.travel);
            let measured = travel.measured.at(at);
            let bare = travel.uncompensated.map_or(measured, |curve| curve.at(at));
            before += part.cosine * measured.um();
            after += part.cosine * (bare + travel.response.correction(at)).um();
        }
        (before, after)
    }

    /// Between two breaks both sums are cubics in t; four places determine each.
    fn extremes(&self, before: &mut Extent, after: &mut Extent) {
        const PLACES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
        for pair in self.breaks().windows(2) {
            let values = PLACES.map(|s| self.deviation(pair[0] + s * (pair[1] - pair[0])));
            cubic_extremes(values.map(|v| v.0), before);
            cubic_extremes(values.map(|v| v.1), after);
        }
        for corner in [0.0, 1.0] {
            let (measured, left) = self.deviation(corner); // a correction can jump just here
            before.meet(measured);
            after.meet(left);
        }
    }
}

/// Meets the extremes on 0…1 of the cubic through values at 1/8, 3/8, 5/8, 7/8.
fn cubic_extremes(values: [f64; 4], extent: &mut Extent) {
    // Newton's forward differences with u = (s − 1/8) / (1/4), so s = 0 and 1 are u = −½ and 3½.
    let d1 = values[1] - values[0];
    let d2 = values[2] - 2.0 * values[1] + values[0];
    let d3 = values[3] - 3.0 * values[2] + 3.0 * values[1] - values[0];
    let at = |u: f64| {
        values[0] + u * d1 + u * (u - 1.0) / 2.0 * d2 + u * (u - 1.0) * (u - 2.0) / 6.0 * d3
    };
    const FIRST: f64 = -0.5;
    const LAST: f64 = 3.5;
    extent.meet(at(FIRST));
    extent.meet(at(LAST));
    // derivative: d3/2·u² + (d2 − d3)·u + (d1 − d2/2 + d3/3)
    let (a, b, c) = (d3 / 2.0, d2 - d3, d1 - d2 / 2.0 + d3 / 3.0);
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    for u in [q / a, c / q] {
        if u > FIRST && u < LAST {
            extent.meet(at(u));
        }
    }
}
