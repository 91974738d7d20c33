//! The nodes of a part of a grid, without those that only repeat others.
//!
//! Two nodes of an axis with the same shift, the same rotation and a lever that nothing turns
//! give the same vectors. Of such nodes the first one stands for all: a map that depends on one
//! axis only is a curve, not a million equal points.

use super::grid_map::{First, GridMap, Node, Second, Third};

/// A box of nodes: the lowest node and how many nodes of each axis of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The node with the smallest numbers.
    pub low: Node,
    /// Nodes of each axis.
    pub size: Node,
}

/// Nodes with their places on the axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Distinct {
    pub(super) first: Vec<(usize, First)>,
    pub(super) second: Vec<(usize, Second)>,
    pub(super) third: Vec<(usize, Third)>,
    order: Vec<([u64; 6], usize)>,
}

impl Distinct {
    /// Makes it the nodes of a window.
    pub(super) fn fill(&mut self, map: &GridMap, window: Window) {
        let [i, j, k] = [0, 1, 2].map(|a| window.low[a]..window.low[a] + window.size[a]);
        let (first, second, third) = (
            &map.first[i.clone()],
            &map.second[j.clone()],
            &map.third[k.clone()],
        );
        let zero = |v: f64| v.abs() <= 0.0;
        let turns_second = first.iter().any(|n| !zero(n.by_second) || !zero(n.roll));
        let turns_third = first.iter().any(|n| !zero(n.by_third) || !zero(n.roll))
            || second.iter().any(|n| !zero(n.by_third) || !zero(n.roll));
        let arm = |arm: f64, counts: bool| if counts { arm } else { 0.0 };
        let order = &mut self.order;
        distinct(first, i.start, order, &mut self.first, |n| {
            [
                n.shift[0],
                n.shift[1],
                n.shift[2],
                n.by_second,
                n.by_third,
                n.roll,
            ]
        });
        distinct(second, j.start, order, &mut self.second, |n| {
            let [x, y, z] = n.shift;
            [x, y, z, n.by_third, n.roll, arm(n.arm, turns_second)]
        });
        distinct(third, k.start, order, &mut self.third, |n| {
            let [x, y, z] = n.shift;
            [x, y, z, arm(n.arm, turns_third), 0.0, 0.0]
        });
    }

    /// Sum of the largest magnitudes that a vector is made of, µm.
    pub(super) fn size_um(&self) -> f64 {
        let largest =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
        let second_arm = largest(&mut self.second.iter().map(|n| n.1.arm));
        let third_arm = largest(&mut self.third.iter().map(|n| n.1.arm));
        let shifts = largest(&mut self.first.iter().flat_map(|n| n.1.shift))
            + largest(&mut self.second.iter().flat_map(|n| n.1.shift))
            + largest(&mut self.third.iter().flat_map(|n| n.1.shift));
        let first = &self.first;
        let by_second = largest(&mut first.iter().flat_map(|n| [n.1.by_second, n.1.roll]));
        let by_third = largest(&mut first.iter().flat_map(|n| [n.1.by_third, n.1.roll]))
            + largest(&mut self.second.iter().flat_map(|n| [n.1.by_third, n.1.roll]));
        3.0 * (shifts + by_second * second_arm + by_third * third_arm)
    }
}

fn distinct<T: Copy>(
    nodes: &[T],
    start: usize,
    order: &mut Vec<([u64; 6], usize)>,
    kept: &mut Vec<(usize, T)>,
    key: impl Fn(&T) -> [f64; 6],
) {
    order.clear();
    let bits = |node: &T| key(node).map(|v| (v + 0.0).to_bits());
    order.extend(nodes.iter().enumerate().map(|(n, node)| (bits(node), n)));
    order.sort_unstable();
    order.dedup_by_key(|(bits, _)| *bits);
    order.sort_unstable_by_key(|(_, n)| *n);
    kept.clear();
    kept.extend(order.iter().map(|(_, n)| (start + n, nodes[*n])));
}
