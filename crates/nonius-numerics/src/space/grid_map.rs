//! The error vectors of a grid, kept as three lists of nodes instead of one vector a point; and the ranges of such lists.

use crate::quantity::Axis;
use std::collections::HashSet;
use std::ops::{Add, Mul, Sub};

/// An error vector, x, y, z in µm.
pub type Vector = [f64; 3];

/// A node of the grid: its place on the first, second and third axis of the chain.
pub type Node = [usize; 3];

/// What one axis does at one of its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct AxisNode {
    /// Translation x, y, z in µm, tool side relative to workpiece side.
    pub translation_um: Vector,
    /// Rotation about x, y, z in µrad, right-handed.
    pub rotation_urad: Vector,
    /// Lever of the axis in m: position less offset.
    pub arm_m: f64,
}

/// What an axis does at one of its nodes, components in the order of the chain: its shift, what it adds for a metre of the
/// axes behind it (of those without a lever 0), its lever in m.
pub(super) type AxisAtNode<T = f64> = [T; 7];

/// Component 1 for a metre of axis 2.
pub(super) const BY_SECOND: usize = 3;
/// Component 1 for a metre of axis 3.
pub(super) const BY_THIRD: usize = 4;
/// Component 3 for a metre of axis 2, less component 2 for a metre of axis 3.
pub(super) const ROLL: usize = 5;
/// The lever.
pub(super) const ARM: usize = 6;

/// Error vectors over a grid of a three-axis machine.
///
/// what   e(i,j,k) = A_i + B_j + C_k + r1_i × (a2_j + a3_k) + r2_j × a3_k, with translations A, B,
///        C, rotations r and levers a along their axis; 1, 2, 3 is the chain from workpiece to tool
/// unit   µm from µm, µrad and m
/// sign   actual − commanded, rotations right-handed
/// limits first order in the angles; r1 about its own axis counts once, r2 about axis 3 and all
///        of r3 have no lever, so their lists are read for their length only. A tool offset t is
///        folded in by the caller: r × t added to the translations; squareness likewise
#[derive(Clone, Debug, PartialEq)]
pub struct GridMap {
    chain: [Axis; 3],
    /// Place of x, y, z in the chain.
    place: [usize; 3],
    /// The nodes of axis 1, 2 and 3.
    pub(super) rows: [Vec<AxisAtNode>; 3],
}

impl GridMap {
    /// The map of three axes in the order of the chain. `None` where the chain names an axis
    /// twice, an axis has no node, a number is not finite or levers do not ascend.
    pub fn new(chain: [Axis; 3], axes: &[Vec<AxisNode>; 3]) -> Option<GridMap> {
        let roles = chain.map(|axis| axis as usize);
        let mut place = [3; 3];
        for (role, component) in roles.into_iter().enumerate() {
            place[component] = role;
        }
        if place.contains(&3) || !axes.iter().all(|nodes| is_sound(nodes)) {
            return None;
        }
        let right_handed = (roles[0] + 1) % 3 == roles[1];
        let parity = if right_handed { 1.0 } else { -1.0 };
        let rows = [0, 1, 2].map(|role| {
            let row = |node: &AxisNode| {
                let ([x, y, z], arm) = (roles.map(|axis| node.translation_um[axis]), node.arm_m);
                let [about_first, about_second, about_third] =
                    roles.map(|axis| parity * node.rotation_urad[axis]);
                match role {
                    0 => [x, y, z, -about_third, about_second, about_first, arm],
                    1 => [x, y, z, 0.0, about_second, about_first, arm],
                    _ => [x, y, z, 0.0, 0.0, 0.0, arm],
                }
            };
            axes[role].iter().map(row).collect()
        });
        Some(GridMap { chain, place, rows })
    }

    /// The axes from workpiece to tool.
    pub fn chain(&self) -> [Axis; 3] {
        self.chain
    }

    /// Nodes of the first, second and third axis of the chain.
    pub fn size(&self) -> Node {
        [0, 1, 2].map(|axis| self.rows[axis].len())
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.size().iter().product()
    }

    /// The error vector at a node, x, y, z in µm.
    ///
    /// Panics where the grid has no such node.
    #[inline]
    pub fn at(&self, node: Node) -> Vector {
        self.error([0, 1, 2].map(|axis| &self.rows[axis][node[axis]]))
    }

    /// The error vector of three rows, x, y, z; of ranges the range of it. **The only place where one is computed.**
    #[inline(always)]
    pub(super) fn error<T>(&self, rows: [&AxisAtNode<T>; 3]) -> [T; 3]
    where
        T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
    {
        let [a, b, c] = rows;
        let along_chain = [
            ((a[0] + b[0]) + c[0]) + (a[BY_SECOND] * b[ARM] + (a[BY_THIRD] + b[BY_THIRD]) * c[ARM]),
            ((a[1] + b[1]) + c[1]) - (a[ROLL] + b[ROLL]) * c[ARM],
            ((a[2] + b[2]) + c[2]) + a[ROLL] * b[ARM],
        ];
        self.xyz(along_chain)
    }

    /// Values given in the order of the chain as x, y, z.
    #[inline(always)]
    pub(super) fn xyz<T: Copy>(&self, along_chain: [T; 3]) -> [T; 3] {
        self.place.map(|role| along_chain[role])
    }

    /// All vectors, the last axis of the chain fastest.
    pub fn vectors(&self) -> Vec<Vector> {
        (0..self.count()).map(|n| self.at(self.node(n))).collect()
    }

    /// The node of a place in [`GridMap::vectors`].
    #[inline]
    pub fn node(&self, number: usize) -> Node {
        node(number, self.size())
    }

    /// The place of a node in [`GridMap::vectors`].
    #[inline]
    pub fn number(&self, node: Node) -> usize {
        number(node, self.size())
    }

    /// Values given as x, y, z in the order of the chain.
    pub fn along_chain<T: Copy>(&self, xyz: [T; 3]) -> [T; 3] {
        let mut roles = xyz;
        for (component, role) in self.place.into_iter().enumerate() {
            roles[role] = xyz[component];
        }
        roles
    }

    /// The nodes of a window on axis 1, 2 and 3, without those that only repeat others.
    ///
    /// Two nodes of an axis with the same shift, the same rotation and a lever that nothing turns give the same vectors. Of
    /// such nodes the first one stands for all: a map that depends on one axis only is a curve, not a million equal points.
    pub(super) fn distinct(&self, window: Window) -> [Vec<usize>; 3] {
        let nodes = [0, 1, 2].map(|axis| window.low[axis]..window.low[axis] + window.size[axis]);
        let turns = |axis: usize, terms: [usize; 2]| {
            let rows = &self.rows[axis][nodes[axis].clone()];
            rows.iter().any(|row| terms.iter().any(|term| row[*term].abs() > 0.0))
        };
        let lever_counts = [
            false,
            turns(0, [BY_SECOND, ROLL]),
            turns(0, [BY_THIRD, ROLL]) || turns(1, [BY_THIRD, ROLL]),
        ];
        [0, 1, 2].map(|axis| {
            let mut seen = HashSet::new();
            let is_new = |n: &usize| {
                let mut key = self.rows[axis][*n].map(|v| (v + 0.0).to_bits());
                key[ARM] = if lever_counts[axis] { key[ARM] } else { 0 };
                seen.insert(key)
            };
            nodes[axis].clone().filter(is_new).collect()
        })
    }

    /// Sum of the largest magnitudes that a vector is made of, µm.
    pub(super) fn size_um(&self) -> f64 {
        let [first, second, third] = self.rows.each_ref().map(|rows| {
            let larger =
                |m: AxisAtNode, row: &AxisAtNode| std::array::from_fn(|n| m[n].max(row[n].abs()));
            rows.iter().fold([0.0; 7], larger)
        });
        let shift = |row: &AxisAtNode| row[0].max(row[1]).max(row[2]);
        let turn = |row: &AxisAtNode, term: usize| row[term].max(row[ROLL]);
        let by_third = turn(&first, BY_THIRD) + turn(&second, BY_THIRD);
        let levers = turn(&first, BY_SECOND) * second[ARM] + by_third * third[ARM];
        3.0 * (shift(&first) + shift(&second) + shift(&third) + levers)
    }
}

/// The node with a number, the last axis fastest.
#[inline]
pub(super) fn node(number: usize, [_, second, third]: Node) -> Node {
    let line = number / third;
    [line / second, line % second, number % third]
}

/// The number of a node.
#[inline]
pub(super) fn number(node: Node, [_, second, third]: Node) -> usize {
    (node[0] * second + node[1]) * third + node[2]
}

fn is_sound(nodes: &[AxisNode]) -> bool {
    let vectors = nodes.iter().flat_map(|node| [node.translation_um, node.rotation_urad]);
    let mut numbers = vectors.flatten().chain(nodes.iter().map(|node| node.arm_m));
    let ascend = nodes.windows(2).all(|pair| pair[0].arm_m < pair[1].arm_m);
    !nodes.is_empty() && ascend && numbers.all(f64::is_finite)
}

/// A box of nodes: the lowest node and how many nodes of each axis of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The node with the smallest numbers.
    pub low: Node,
    /// Nodes of each axis.
    pub size: Node,
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
