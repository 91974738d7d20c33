//! Whether the largest difference of the nodes is that of the whole volume.

use crate::quantity::axis::Axis;
use crate::volume::volume_model::{AxisState, Nodes, VolumeModel};

/// Rounding of a curve between two nodes, in parts of its values (and µm near 0).
const ROUNDING: f64 = 1e-9;
/// Places nearer than this are one, mm.
const SAME_MM: f64 = 1e-9;

/// Whether no place of the volume differs by more than the nodes do.
///
/// why    where each curve runs straight between neighbouring nodes, the error is a straight line
///        in each coordinate and |e(p) − e(q)| convex in it, so its largest value lies at nodes
/// limits a curve is straight here if it meets the line at ¼, ½ and ¾ between two places where
///        it bends: enough for the cubic pieces of a curve, times a lever
pub fn holds_everywhere(model: &VolumeModel, nodes: &Nodes) -> bool {
    let own = model.own_nodes();
    Axis::ALL.into_iter().all(|axis| {
        let among = |place: &f64| {
            let next = nodes[axis].partition_point(|node| *node < place - SAME_MM);
            nodes[axis].get(next).is_some_and(|n| *n <= place + SAME_MM)
        };
        let straight = |ends: &[f64]| is_straight(model, axis, [ends[0], ends[1]]);
        own[axis].iter().all(among) && own[axis].windows(2).all(straight)
    })
}

fn is_straight(model: &VolumeModel, axis: Axis, [from, to]: [f64; 2]) -> bool {
    let values = |part: f64| {
        let place = from + (to - from) * part;
        let AxisState {
            deviation_um: d,
            rotation_urad: r,
            ..
        } = model.state(axis, place, |_| true);
        [d.x, d.y, d.z, r.x, r.y, r.z]
    };
    let (first, last) = (values(0.0), values(1.0));
    [0.25, 0.5, 0.75].into_iter().all(|part| {
        let inside = values(part).into_iter().zip(first).zip(last);
        inside.into_iter().all(|((value, a), b)| {
            let room = ROUNDING * (1.0 + a.abs() + b.abs());
            (value - (a + (b - a) * part)).abs() <= room
        })
    })
}
