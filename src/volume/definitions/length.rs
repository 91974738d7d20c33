//! The largest error of a length: what does not change when the axes are aligned differently.

use crate::quantity::axis::PerAxis;
use crate::volume::volume_model::ErrorMap;

/// Nodes of which every pair is compared: more of them are thinned out.
const MOST_NODES: usize = 10_000;
/// Nodes an axis keeps when a map is thinned out.
const KEPT: usize = 21;
const UM_PER_MM: f64 = 1000.0;

/// Largest | |actual distance| − |nominal distance| | of two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthError {
    /// The largest that was found, µm.
    pub um: f64,
    /// Whether every pair of nodes was compared; else this is a lower bound, and VA an upper one.
    pub exact: bool,
    /// The two places, mm.
    pub places_mm: [PerAxis<f64>; 2],
}

/// The largest error of the distance of two nodes, µm.
///
/// what    | |p − q + e(p) − e(q)| − |p − q| |, all nodes p, q
/// limits  exact up to 10 000 nodes; beyond, at most 21 nodes of each axis are compared, the ends
///         among them, and the figure is a lower bound
pub fn length_error(map: &ErrorMap) -> LengthError {
    let exact = map.count() <= MOST_NODES;
    let counts = map.counts();
    let kept = PerAxis::from_fn(|axis| {
        if exact {
            counts[axis]
        } else {
            counts[axis].min(KEPT)
        }
    });
    let number = |index: usize, kept: usize, count: usize| match kept {
        0 | 1 => 0,
        _ => index * (count - 1) / (kept - 1),
    };
    let mut points = Vec::with_capacity(kept.x * kept.y * kept.z);
    for x in 0..kept.x {
        for y in 0..kept.y {
            for z in 0..kept.z {
                points.push(map.point(PerAxis {
                    x: number(x, kept.x, counts.x),
                    y: number(y, kept.y, counts.y),
                    z: number(z, kept.z, counts.z),
                }));
            }
        }
    }
    let (um, pair) = largest(&points);
    LengthError {
        um,
        exact,
        places_mm: pair.map(|index| points.get(index).map_or(PerAxis::default(), |p| p.0)),
    }
}

fn largest(points: &[(PerAxis<f64>, PerAxis<f64>)]) -> (f64, [usize; 2]) {
    let mut found = (0.0, [0, 0]);
    for (index, (place, error)) in points.iter().enumerate() {
        for (further, (other, other_error)) in points[..index].iter().enumerate() {
            let nominal = place.minus(*other).times(UM_PER_MM);
            let shift = error.minus(*other_error);
            // |n + s| − |n| without the loss of digits of a difference of two large numbers.
            let sum = nominal.plus(shift).length() + nominal.length();
            let change = shift.dot(nominal.times(2.0).plus(shift)) / sum;
            if change.abs() > found.0 {
                found = (change.abs(), [further, index]);
            }
        }
    }
    found
}
