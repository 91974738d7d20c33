//! The error vectors at the nodes of a grid, in the structured form that makes them cheap: three
//! lists of axis states instead of one list of places.

use super::{AxisState, Component, VolumeModel, error_of};
use crate::axis::{Axis, PerAxis};

/// The positions of each axis, mm, ascending.
pub type Nodes = PerAxis<Vec<f64>>;

/// The machine at the nodes of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    order: [Axis; 3],
    /// In the order of the chain.
    states: [Vec<AxisState>; 3],
}

impl VolumeModel {
    /// Every place where a curve bends, with the ends of the range: between neighbouring nodes of
    /// linear curves the error is a straight line in each coordinate, so its extremes and its
    /// largest differences lie at nodes.
    pub fn own_nodes(&self) -> Nodes {
        PerAxis::from_fn(|axis| {
            let (low, high) = self.range(axis);
            let knots = self.curves_along(axis).flat_map(|curve| curve.knots());
            let mut nodes: Vec<f64> = knots.map(|knot| knot.mm()).chain([low, high]).collect();
            nodes.retain(|node| *node >= low && *node <= high);
            nodes.sort_by(f64::total_cmp);
            nodes.dedup_by(|next, kept| next <= kept);
            nodes
        })
    }

    /// So many equally spaced nodes of each axis over its range; of a range of no length, one.
    pub fn equal_nodes(&self, counts: PerAxis<usize>) -> Nodes {
        PerAxis::from_fn(|axis| {
            let (low, high) = self.range(axis);
            if high <= low || counts[axis] < 2 {
                return vec![low];
            }
            let last = counts[axis] - 1;
            let place = |index: usize| low + (high - low) * part(index, last);
            (0..last).map(place).chain([high]).collect()
        })
    }

    /// The machine at these nodes.
    pub fn map(&self, nodes: &Nodes) -> ErrorMap {
        self.map_of(nodes, |_| true)
    }

    /// The machine with some of its components only, at these nodes.
    pub fn map_of(&self, nodes: &Nodes, keep: impl Fn(Component) -> bool) -> ErrorMap {
        let order = self.chain.order();
        ErrorMap {
            order,
            states: order.map(|axis| {
                let positions = nodes[axis].iter();
                positions
                    .map(|position| self.state(axis, *position, &keep))
                    .collect()
            }),
        }
    }
}

#[allow(
    clippy::cast_precision_loss,
    reason = "a grid has far fewer than 2^52 nodes"
)]
fn part(index: usize, last: usize) -> f64 {
    index as f64 / last as f64
}

impl ErrorMap {
    /// The axes from the workpiece to the tool.
    pub fn order(&self) -> [Axis; 3] {
        self.order
    }

    /// What each axis contributes at its nodes, in the order of the chain.
    pub fn states(&self) -> &[Vec<AxisState>; 3] {
        &self.states
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.states.iter().map(Vec::len).product()
    }

    /// Number of nodes of each axis.
    pub fn counts(&self) -> PerAxis<usize> {
        let mut counts = PerAxis::default();
        for (axis, states) in self.order.into_iter().zip(&self.states) {
            counts[axis] = states.len();
        }
        counts
    }

    /// Every node with its error vector, µm; X slowest, Z fastest, whatever the chain.
    pub fn points(&self) -> impl Iterator<Item = (PerAxis<f64>, PerAxis<f64>)> {
        let counts = self.counts();
        let indices = (0..counts.x).flat_map(move |x| {
            (0..counts.y).flat_map(move |y| (0..counts.z).map(move |z| PerAxis { x, y, z }))
        });
        indices.map(|index| self.point(index))
    }

    /// One node with its error vector, µm, by its numbers along X, Y and Z.
    pub fn point(&self, index: PerAxis<usize>) -> (PerAxis<f64>, PerAxis<f64>) {
        let [first, second, third] = &self.states;
        let [a, b, c] = self.order;
        let states = [&first[index[a]], &second[index[b]], &third[index[c]]];
        let mut place = PerAxis::default();
        for (axis, state) in self.order.into_iter().zip(states) {
            place[axis] = state.position_mm;
        }
        (place, error_of(states[0], states[1], states[2]))
    }
}
