//! What a laser along the body diagonals of the volume would read.

use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{Diagonal, PerDiagonal};
use crate::volume::volume_model::VolumeModel;

/// Range of the deviation along each body diagonal of the assessed box, µm: max − min of e · u.
///
/// between two places where a curve bends, e · u of straight curves is a parabola of the way
/// travelled (angle × lever), so its extreme is found from three places; of other curves it is
/// close.
pub fn diagonal_ranges(model: &VolumeModel) -> PerDiagonal<f64> {
    let bends = bends(model);
    PerDiagonal::from_fn(|diagonal| {
        let along = |t: f64| along(model, diagonal, t);
        let mut bends: Vec<f64> = bends
            .iter()
            .map(|(axis, t)| {
                if diagonal.sign(*axis) > 0.0 {
                    *t
                } else {
                    1.0 - t
                }
            })
            .collect();
        bends.sort_by(f64::total_cmp);
        let mut ends = (along(0.0), along(0.0));
        for pair in bends.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let (first, middle, last) = (along(a), along(f64::midpoint(a, b)), along(b));
            for value in [first, last].into_iter().chain(vertex(first, middle, last)) {
                ends = (ends.0.min(value), ends.1.max(value));
            }
        }
        ends.1 - ends.0
    })
}

/// Extreme of the parabola through three values at 0, ½ and 1, where it lies between them.
fn vertex(first: f64, middle: f64, last: f64) -> Option<f64> {
    let bent = 2.0 * (first - 2.0 * middle + last);
    let slope = last - first - bent;
    let place = -slope / (2.0 * bent);
    (place > 0.0 && place < 1.0).then_some(first + place * (slope + bent * place))
}

/// Parts of the travel (0 … 1) where a curve of an axis bends.
fn bends(model: &VolumeModel) -> Vec<(Axis, f64)> {
    let nodes = model.own_nodes();
    let of_axis = |axis: Axis| {
        let (low, high) = model.range(axis);
        let inside = nodes[axis].iter().filter(move |_| high > low);
        inside.map(move |node| (axis, (node - low) / (high - low)))
    };
    Axis::ALL.into_iter().flat_map(of_axis).collect()
}

/// e · u at the part t of a diagonal, µm.
fn along(model: &VolumeModel, diagonal: Diagonal, t: f64) -> f64 {
    let size = PerAxis::from_fn(|axis| {
        let (low, high) = model.range(axis);
        high - low
    });
    let length = size.length();
    if length <= 0.0 {
        return 0.0;
    }
    let way = PerAxis::from_fn(|axis| diagonal.sign(axis) * size[axis]);
    let place = PerAxis::from_fn(|axis| {
        let travelled = if diagonal.sign(axis) > 0.0 {
            t
        } else {
            1.0 - t
        };
        model.range(axis).0 + travelled * size[axis]
    });
    model.error_at(place).dot(way) / length
}
