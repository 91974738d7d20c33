//! How far the vectors of a grid reach along a direction, without looking at all of them.
//!
//! Along a direction d the map is a sum of a few numbers an axis,
//! f(i,j,k) = α_i + γ_i·y_j + μ_j + (β_i + ν_j)·z_k + κ_k. Every axis is a tree with the ranges of its numbers; from a
//! branch of each axis follows what no f in that box exceeds. A box that may reach far enough is cut across the axis that
//! was cut least, down to single nodes, the half with the higher bound first.

use crate::volume::space::grid_map::{ARM, BY_SECOND, BY_THIRD, GridMap, Node, ROLL, Row, Vector};
use crate::volume::space::pair::dot;
use std::ops::{Add, Mul, Sub};

/// The side of a direction where it points.
pub(super) const AHEAD: f64 = 1.0;
/// The other side.
pub(super) const BEHIND: f64 = -1.0;

/// The sum f along a direction.
pub(super) struct Sight {
    /// Of each axis what it adds, by itself and for a metre of axis 2 and 3, and its lever.
    trees: [Vec<[Interval; 4]>; 3],
    /// Nodes of each axis.
    size: Node,
}

impl Sight {
    /// Some nodes of each axis, seen along `d`.
    pub(super) fn of(map: &GridMap, nodes: &[Vec<usize>; 3], d: &Vector) -> Sight {
        let d = map.along_chain(*d);
        let numbers = |row: &Row| {
            [
                Interval::of(dot(&d, &[row[0], row[1], row[2]])),
                Interval::of(d[0] * row[BY_SECOND] + d[2] * row[ROLL]),
                Interval::of(d[0] * row[BY_THIRD] - d[1] * row[ROLL]),
                Interval::of(row[ARM]),
            ]
        };
        let trees = [0, 1, 2]
            .map(|axis| tree(nodes[axis].iter().map(|n| numbers(&map.rows[axis][*n])).collect()));
        Sight { trees, size: nodes.each_ref().map(Vec::len) }
    }

    /// What no node reaches beyond on a side.
    pub(super) fn bound(&self, side: f64) -> f64 {
        self.bound_of([1; 3], side)
    }

    fn bound_of(&self, [i, j, k]: [usize; 3], side: f64) -> f64 {
        let (a, b, c) = (&self.trees[0][i], &self.trees[1][j], &self.trees[2][k]);
        let f = ((a[0] + b[0]) + c[0]) + (a[1] * b[3] + (a[2] + b[2]) * c[3]);
        if side > 0.0 { f.high } else { -f.low }
    }

    /// The node that reaches furthest to a side, and how far; `None` where that is less than `least`.
    pub(super) fn furthest(&self, side: f64, least: f64) -> Option<(f64, Node)> {
        let mut best = None;
        self.seek([1; 3], side, least, &mut |reach: f64, node| {
            best = Some((reach, node));
            reach.next_up()
        });
        best
    }

    /// The nodes that reach `least` on a side; `None` where they are more than `most`.
    pub(super) fn beyond(&self, side: f64, least: f64, most: usize) -> Option<Vec<Node>> {
        let mut nodes = Vec::new();
        self.seek([1; 3], side, least, &mut |_, node| {
            nodes.push(node);
            if nodes.len() > most { f64::INFINITY } else { least }
        });
        (nodes.len() <= most).then_some(nodes)
    }

    /// Tells `found` of the nodes in a box that reach `least`; its answer is the `least` from there on. Returns the last.
    fn seek(
        &self,
        branches: [usize; 3],
        side: f64,
        mut least: f64,
        found: &mut impl FnMut(f64, Node) -> f64,
    ) -> f64 {
        let cut = (0..3).filter(|axis| branches[*axis] < self.size[*axis]);
        let Some(axis) = cut.min_by_key(|axis| branches[*axis]) else {
            let node = [0, 1, 2].map(|axis| last_row(branches[axis], self.size[axis]));
            return found(self.bound_of(branches, side), node);
        };
        let [mut one, mut two] = [branches; 2];
        one[axis] = 2 * branches[axis];
        two[axis] = one[axis] + 1;
        let [one, two] = [(self.bound_of(one, side), one), (self.bound_of(two, side), two)];
        for (bound, part) in if one.0 < two.0 { [two, one] } else { [one, two] } {
            if bound >= least {
                least = self.seek(part, side, least, found);
            }
        }
        least
    }
}

// Ranges of numbers, how they are added and multiplied, and the ranges of rows of them as a tree.

/// All values from `low` to `high`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Add for Interval {
    type Output = Interval;
    fn add(self, other: Interval) -> Interval {
        Interval { low: self.low + other.low, high: self.high + other.high }
    }
}

impl Sub for Interval {
    type Output = Interval;
    fn sub(self, other: Interval) -> Interval {
        Interval { low: self.low - other.high, high: self.high - other.low }
    }
}

impl Mul for Interval {
    type Output = Interval;
    fn mul(self, other: Interval) -> Interval {
        let [a, b] = [self.low * other.low, self.low * other.high];
        let [c, d] = [self.high * other.low, self.high * other.high];
        Interval { low: a.min(b).min(c.min(d)), high: a.max(b).max(c.max(d)) }
    }
}

impl Interval {
    pub(super) fn of(value: f64) -> Interval {
        Interval { low: value, high: value }
    }

    fn or(self, other: Interval) -> Interval {
        let low = if other.low < self.low { other.low } else { self.low };
        let high = if other.high > self.high { other.high } else { self.high };
        Interval { low, high }
    }

    pub(super) fn largest(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    pub(super) fn smallest(self) -> f64 {
        self.low.max(-self.high).max(0.0)
    }
}

/// The ranges of rows, halved again and again: all of them are branch 1, the halves of branch n are 2n and 2n + 1, and
/// from the number of the rows on a branch is a single row.
pub(super) fn tree<const N: usize>(mut rows: Vec<[Interval; N]>) -> Vec<[Interval; N]> {
    let count = rows.len();
    rows.rotate_right(count.next_power_of_two() - count); // so that every branch is of neighbours
    let mut tree = [rows.as_slice(), &rows].concat();
    for n in (1..count).rev() {
        let [one, two] = [tree[2 * n], tree[2 * n + 1]];
        for m in 0..N {
            tree[n][m] = one[m].or(two[m]);
        }
    }
    tree
}

/// The last row of a branch, of so many; of a single one itself.
pub(super) fn last_row(mut branch: usize, count: usize) -> usize {
    while branch < count {
        branch = 2 * branch + 1;
    }
    (branch + count - count.next_power_of_two()) % count
}
