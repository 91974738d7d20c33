//! The largest value over the nodes of a grid, or over all pairs of them: branch and bound over boxes.
//!
//! Every axis is a tree: all of its nodes, cut in halves down to single ones, each branch with the ranges of what the axis
//! does there. A box is one branch of each axis; from the ranges follows what no node in it exceeds, and of two boxes
//! what no pair exceeds. The box with the highest bound is cut next, across the axis that lowers the bounds most. When
//! no bound is above what was found, that is the largest value; if the steps end first, the highest bound is left.

use super::diameter::Diameter;
use super::grid_map::{ARM, AxisAtNode, GridMap, Interval, Node, Vector, last_row, tree};
use super::pair::{dot, minus, room};
use std::collections::BinaryHeap;
use std::ops::Range;

/// The largest value of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Largest<const N: usize> {
    /// The largest that was found, µm.
    pub um: f64,
    /// No value is larger, µm: `um` itself, where the search came to its end, to within rounding.
    pub bound_um: f64,
    /// Its nodes: the number on axis 1, 2 and 3 of the chain; of a pair three more.
    pub at: [usize; N],
}

impl<const N: usize> Largest<N> {
    /// Whether the search came to its end.
    pub fn is_exact(&self) -> bool {
        self.bound_um <= self.um
    }
}

const UM_PER_M: f64 = 1e6;

/// A grid as trees, one an axis.
pub struct Boxes<'m> {
    map: &'m GridMap,
    trees: [Vec<AxisAtNode<Interval>>; 3],
    /// What a bound may be wrong by, µm.
    room: f64,
}

impl<'m> Boxes<'m> {
    /// The boxes of a map.
    pub fn of(map: &'m GridMap) -> Self {
        let of =
            |rows: &Vec<AxisAtNode>| tree(rows.iter().map(|row| row.map(Interval::of)).collect());
        let trees = map.rows.each_ref().map(of);
        Boxes { map, room: room(map.size_um()), trees }
    }

    /// Smallest and largest error in X, Y and Z over the nodes, µm.
    pub fn ranges(&self) -> [(f64, f64); 3] {
        let all = self.error([1; 3]);
        let furthest = |c, end| self.map.at(self.furthest([end; 3], c..c + 1, usize::MAX).at)[c];
        [0, 1, 2].map(|c| (furthest(c, all[c].high), furthest(c, all[c].low)))
    }

    /// The largest |e − `from`| over the nodes, in at most so many steps.
    pub fn furthest_from(&self, from: Vector, steps: usize) -> Largest<3> {
        self.furthest(from, 0..3, steps)
    }

    /// The same for some components only.
    fn furthest(&self, from: Vector, components: Range<usize>, steps: usize) -> Largest<3> {
        let part =
            |away: [f64; 3]| components.clone().map(|c| away[c] * away[c]).sum::<f64>().sqrt();
        let value = |node: &Node| part(minus(&self.map.at(*node), &from));
        let bound = |branches: &[usize; 3]| {
            let error = self.error(*branches);
            part([0, 1, 2].map(|c| (error[c] - Interval::of(from[c])).largest()))
        };
        self.largest([0; 3], value, bound, steps)
    }

    /// The largest error of a distance of two nodes, in at most so many steps; `widest` is the largest difference of
    /// their errors, where the search begins and which it never exceeds.
    ///
    /// what    | |n + s| − |n| | with n = p − q and s = e(p) − e(q), all nodes p, q
    /// why     it is |s · (2n + s)| / (|n + s| + |n|), and |2n + s| ≤ |n + s| + |n|: never more than the part of s along
    ///         2n + s, nor than |s|
    pub fn length_error(&self, widest: &Diameter, steps: usize) -> Largest<6> {
        let value = |ends: &[usize; 6]| {
            let [p, q] = both(*ends);
            let s = minus(&self.map.at(p), &self.map.at(q));
            let n = minus(&self.place_um(p), &self.place_um(q));
            let sum = length([0, 1, 2].map(|c| n[c] + s[c])) + length(n);
            let product = dot(&s, &[0, 1, 2].map(|c| 2.0 * n[c] + s[c]));
            if sum > 0.0 { (product / sum).abs() } else { 0.0 }
        };
        let [[a, b, c], [d, e, f]] = widest.nodes;
        let bound = |ends: &[usize; 6]| self.bound_of_length(both(*ends));
        let found = self.largest([a, b, c, d, e, f], value, bound, steps);
        Largest { bound_um: found.bound_um.min(widest.um).max(found.um), ..found }
    }

    fn bound_of_length(&self, [p, q]: [[usize; 3]; 2]) -> f64 {
        let [e, f] = [self.error(p), self.error(q)];
        let arm = |at: [usize; 3], axis: usize| self.trees[axis][at[axis]][ARM];
        let apart = [0, 1, 2].map(|axis| (arm(p, axis) - arm(q, axis)) * Interval::of(UM_PER_M));
        if apart[0].low > 0.0 {
            return 0.0; // the same pairs stand in the two boxes the other way round
        }
        let s = [0, 1, 2].map(|c| e[c] - f[c]);
        let n = self.map.xyz(apart);
        let along = [0, 1, 2].map(|c| n[c] + n[c] + s[c]);
        let part =
            (direction(along, 0) * s[0] + direction(along, 1) * s[1]) + direction(along, 2) * s[2];
        part.largest().min(length(s.map(Interval::largest)))
    }

    /// The error of all nodes in a box.
    fn error(&self, branches: [usize; 3]) -> [Interval; 3] {
        self.map.error([0, 1, 2].map(|axis| &self.trees[axis][branches[axis]]))
    }

    /// Where a node lies, x, y, z in µm from the places without a lever.
    fn place_um(&self, node: Node) -> Vector {
        self.map.xyz([0, 1, 2].map(|axis| self.map.rows[axis][node[axis]][ARM] * UM_PER_M))
    }

    /// The largest `value` of nodes; `bound`, at least 0, is nowhere below it in the boxes of some branches.
    fn largest<const N: usize>(
        &self,
        start: [usize; N],
        value: impl Fn(&[usize; N]) -> f64,
        bound: impl Fn(&[usize; N]) -> f64,
        steps: usize,
    ) -> Largest<N> {
        // The bits of numbers that are not negative are in their order.
        let open = |branches: [usize; N]| (bound(&branches).to_bits(), branches);
        let mut found = self.climbed(start, &value);
        let mut boxes = BinaryHeap::from([open([1; N])]);
        let mut steps = 0..steps;
        let size = self.map.size();
        while let Some((bits, branches)) = boxes.pop() {
            let least = found.um + self.room;
            let above = |bits: u64| (f64::from_bits(bits) - least).max(0.0);
            if above(bits) <= 0.0 {
                break;
            }
            if steps.next().is_none() {
                found.bound_um = f64::from_bits(bits);
                break;
            }
            let cuts = (0..N).filter(|n| branches[*n] < size[*n % 3]).map(|n| {
                [0, 1].map(|half| {
                    let mut part = branches;
                    part[n] = 2 * part[n] + half;
                    open(part)
                })
            });
            let sums =
                cuts.map(|parts| (parts.iter().map(|part| above(part.0)).sum::<f64>(), parts));
            let best = sums.min_by(|a, b| a.0.total_cmp(&b.0));
            for part in
                best.into_iter().flat_map(|(_, parts)| parts).filter(|part| above(part.0) > 0.0)
            {
                let corner = std::array::from_fn(|n| last_row(part.1[n], size[n % 3]));
                if value(&corner) > found.um {
                    found = self.climbed(corner, &value);
                }
                boxes.push(part);
            }
        }
        found
    }

    /// From some nodes to the best one on each axis in turn, as long as that finds a larger value.
    fn climbed<const N: usize>(
        &self,
        mut at: [usize; N],
        value: impl Fn(&[usize; N]) -> f64,
    ) -> Largest<N> {
        let mut um = value(&at);
        loop {
            let before = um;
            for n in 0..N {
                for node in 0..self.map.size()[n % 3] {
                    let mut next = at;
                    next[n] = node;
                    let there = value(&next);
                    (um, at) = if there > um { (there, next) } else { (um, at) };
                }
            }
            if um <= before {
                return Largest { um, bound_um: um, at };
            }
        }
    }
}

/// The two nodes, or boxes, of a pair.
fn both([a, b, c, d, e, f]: [usize; 6]) -> [[usize; 3]; 2] {
    [[a, b, c], [d, e, f]]
}

fn length(v: Vector) -> f64 {
    dot(&v, &v).sqrt()
}

/// What component `c` of the unit vectors along some vectors can be.
fn direction(vectors: [Interval; 3], c: usize) -> Interval {
    let others = [vectors[(c + 1) % 3], vectors[(c + 2) % 3]];
    let part = |value: f64, across: [f64; 2]| {
        let length = length([value, across[0], across[1]]);
        if length > 0.0 { value / length } else { 0.0 }
    };
    let [near, far] = [others.map(Interval::smallest), others.map(Interval::largest)];
    let Interval { low, high } = vectors[c];
    Interval {
        low: part(low, if low < 0.0 { near } else { far }),
        high: part(high, if high > 0.0 { near } else { far }),
    }
}
