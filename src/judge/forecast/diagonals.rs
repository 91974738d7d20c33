//! What the tables leave along the four body diagonals of the measured box.
//!
//! The deviation along the beam is a sum over the nine terms. Between two places where a curve or
//! a correction bends, it is a cubic of the way, so its extremes are found without sampling.

use super::{DiagonalForecast, Machine, Range, within};
use crate::judge::conformity::Sigma;
use crate::judge::field::Field;
use crate::machine::model::{ErrorModel, Measured, MeasuredTerm, PointUncertainty};
use crate::quantity::{
    AT_PLACE_MM, Axis, Diagonal, Direction, ErrorCurve, ErrorTerm, Millimetres, Pass, PerAxis,
    Squared, Volume, larger,
};
use crate::read::emulate::Response;

/// The measured box; none where an axis was not measured.
fn measured_box(model: &ErrorModel, judged: &PerAxis<Option<Range>>) -> Option<Volume> {
    let of = |axis| Some(within(model.ranges[axis]?, judged[axis]));
    let ends = PerAxis::from_fn(of).all()?;
    let size = PerAxis::from_fn(|axis| ends[axis].1 - ends[axis].0);
    Some(Volume { start: PerAxis::from_fn(|axis| ends[axis].0), size, steps: 1, order: Axis::ALL })
}

/// How far inside its edge an axis stands at t of a diagonal, or at which t it stands so far inside, in parts of each.
fn turned(diagonal: Diagonal, axis: Axis, part: f64) -> f64 {
    match diagonal.forward(axis) {
        Direction::Plus => part,
        Direction::Minus => 1.0 - part,
    }
}

/// How far along a diagonal an axis stands somewhere, 0 to 1 on its forward run.
fn travelled(measured_box: &Volume, diagonal: Diagonal, axis: Axis, mm: f64) -> f64 {
    let (low, size) = (measured_box.start[axis], measured_box.size[axis]);
    turned(diagonal, axis, (mm - low.mm()) / size.mm())
}

/// Where an axis stands at t.
fn position(measured_box: &Volume, diagonal: Diagonal, axis: Axis, t: f64) -> Millimetres {
    let inside = turned(diagonal, axis, t) * measured_box.size[axis].mm();
    measured_box.start[axis] + Millimetres::new(inside)
}

/// The four diagonals; none where a term or a direction of it was not measured.
pub(super) fn forecast(
    machine: Machine<'_>,
    control: &Field,
    judged: &PerAxis<Option<Range>>,
    sigma: Sigma,
) -> Vec<DiagonalForecast> {
    let model = machine.as_measured;
    let Some(measured_box) = measured_box(model, judged) else {
        return Vec::new();
    };
    let one_way = |(_, m): (ErrorTerm, &MeasuredTerm)| matches!(m.measured, Measured::OneWay(..));
    if model.measured().count() < ErrorTerm::ALL.len() || model.measured().any(one_way) {
        // A diagonal travels some axis in the direction that was not measured.
        return Vec::new();
    }
    let travels = travels(machine, control, &measured_box);
    let of_diagonal = |diagonal: Diagonal| {
        let (mut before, mut after) = (Extent::default(), Extent::default());
        let [forward, reverse] =
            Pass::BOTH.map(|pass| Walk::new(&travels, &measured_box, diagonal, pass));
        forward.extremes(&mut before, &mut after);
        if reverse.parts != forward.parts {
            reverse.extremes(&mut before, &mut after);
        }
        let u_um = uncertainties(model, &measured_box, diagonal);
        let scale_um = model.laser_um_per_m * measured_box.diagonal_mm() / 1000.0;
        let sizes = [before.size(), after.size()];
        let largest_um =
            model.remarks.largest.as_ref().map(|largest| largest.single.diagonals[diagonal]);
        let doubtful_um =
            model.remarks.doubtful.as_ref().map_or(0.0, |sizes| sizes.diagonals[diagonal]);
        let name = diagonal.name();
        DiagonalForecast::new(name, sizes, sigma, &u_um, scale_um, largest_um, doubtful_um)
    };
    Diagonal::ALL.into_iter().map(of_diagonal).collect()
}

/// One term while its axis travels one way: its curves, its correction and where they bend.
#[derive(PartialEq)]
struct Travel<'a> {
    measured: &'a ErrorCurve,
    /// Without tables; absent where none was active while measuring.
    uncompensated: Option<&'a ErrorCurve>,
    response: &'a Response,
    /// Places inside the measured box where a curve or the correction bends or jumps, mm.
    bends: Vec<Vec<f64>>,
}

/// Every measured term both ways; the four diagonals share them.
fn travels<'a>(
    machine: Machine<'a>,
    control: &'a Field,
    measured_box: &Volume,
) -> Vec<(ErrorTerm, Direction, Travel<'a>)> {
    let mut travels = Vec::new();
    for (term, _) in machine.as_measured.measured() {
        for direction in Direction::BOTH {
            let Some((measured, uncompensated)) = machine.curves(term, direction) else {
                continue;
            };
            let Some(response) = control.ways(term, direction).next() else {
                continue;
            };
            let uncompensated = (!std::ptr::eq(measured, uncompensated)).then_some(uncompensated);
            let low = measured_box.start[term.along];
            let high = low + measured_box.size[term.along];
            let knots = |curve: &ErrorCurve| curve.knots().iter().map(|x| x.mm()).collect();
            let of_curves = [Some(measured), uncompensated].into_iter().flatten().map(knots);
            let bends = of_curves.chain([response.breaks(low, high)]).collect();
            let travel = Travel { measured, uncompensated, response, bends };
            travels.push((term, direction, travel));
        }
    }
    travels
}

/// Standard uncertainty of the deviation along the beam, µm, wherever an axis stands at one of its
/// measured positions: three terms per axis, weighted with the direction cosine. A value by itself
/// counts, since max − min is a difference and the reference drops out. A term of which nothing is
/// stated counts as 0; empty where nothing is stated at all.
fn uncertainties(model: &ErrorModel, measured_box: &Volume, diagonal: Diagonal) -> Vec<f64> {
    if model.measured().all(|(_, m)| m.uncertainty.is_empty()) {
        return Vec::new();
    }
    let places = model.measured().flat_map(|(term, measured)| {
        let points = measured.uncertainty.iter();
        points.map(move |p| travelled(measured_box, diagonal, term.along, p.at.mm()))
    });
    let on_it = |t: &f64| (-SAME_PART..=1.0 + SAME_PART).contains(t);
    let mut places: Vec<f64> = places.filter(on_it).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < SAME_PART);
    let u_um = |t: &f64| {
        let variances = model.measured().map(|(term, measured)| {
            let at = position(measured_box, diagonal, term.along, *t);
            (measured_box.cosine(term.of) * near_um(measured, at)).squared()
        });
        variances.sum::<f64>().sqrt()
    };
    places.iter().map(u_um).collect()
}

/// Places on a diagonal that differ by less are one, in parts of its length.
const SAME_PART: f64 = 1e-9;

/// The larger of the uncertainties on either side of a place, µm.
fn near_um(measured: &MeasuredTerm, at: Millimetres) -> f64 {
    let distance = |point: &&PointUncertainty| (point.at - at).mm();
    let points = || measured.uncertainty.iter();
    let below = points().filter(|p| distance(p) <= AT_PLACE_MM);
    let above = points().filter(|p| distance(p) >= -AT_PLACE_MM);
    let nearest_below = below.map(|p| distance(&p)).reduce(larger);
    let nearest_above = above.map(|p| -distance(&p)).reduce(larger);
    let is_near = |p: &&PointUncertainty| {
        let near =
            |edge: Option<f64>, own: f64| edge.is_some_and(|e| (own - e).abs() < AT_PLACE_MM);
        near(nearest_below, distance(p)) || near(nearest_above, -distance(p))
    };
    points().filter(is_near).map(|p| p.value_um).fold(0.0, larger)
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
    measured_box: &'a Volume,
    diagonal: Diagonal,
}

/// One term on the way, and the cosine of the beam to its direction.
#[derive(PartialEq)]
struct Part<'a> {
    travel: &'a Travel<'a>,
    along: Axis,
    cosine: f64,
}

impl<'a> Walk<'a> {
    fn new(
        travels: &'a [(ErrorTerm, Direction, Travel<'a>)],
        measured_box: &'a Volume,
        diagonal: Diagonal,
        pass: Pass,
    ) -> Walk<'a> {
        let beam = measured_box.laser(diagonal);
        let part = |(term, direction, travel): &'a (ErrorTerm, Direction, Travel<'a>)| {
            (diagonal.travelled(term.along, pass) == *direction).then(|| Part {
                travel,
                along: term.along,
                cosine: beam[term.of],
            })
        };
        Walk { parts: travels.iter().filter_map(part).collect(), measured_box, diagonal }
    }

    /// Places t where a curve or a correction bends or jumps; the terms of an axis mostly share them.
    fn breaks(&self) -> Vec<f64> {
        let mut breaks = vec![0.0, 1.0];
        for axis in Axis::ALL {
            let own = self.parts.iter().filter(|part| part.along == axis);
            let mut bends: Vec<&[f64]> = Vec::new();
            for places in own.flat_map(|part| &part.travel.bends) {
                if !bends.contains(&places.as_slice()) {
                    bends.push(places);
                }
            }
            let places = bends.into_iter().flatten();
            breaks.extend(places.map(|mm| travelled(self.measured_box, self.diagonal, axis, *mm)));
        }
        breaks.retain(|t| (0.0..=1.0).contains(t));
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        breaks
    }

    /// Deviation along the beam at t, as measured and with the tables, µm.
    fn deviation(&self, t: f64) -> (f64, f64) {
        let mut before = 0.0;
        let mut after = 0.0;
        let places = PerAxis::from_fn(|axis| position(self.measured_box, self.diagonal, axis, t));
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
