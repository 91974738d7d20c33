//! The error vectors of a grid, kept as three lists of nodes instead of one vector a point.
//!
//! The nodes of a part of a grid, without those that only repeat others.
//!
//! Two nodes of an axis with the same shift, the same rotation and a lever that nothing turns
//! give the same vectors. Of such nodes the first one stands for all: a map that depends on one
//! axis only is a curve, not a million equal points.

use crate::quantity::axis::Axis;

/// An error vector, x, y, z in µm.
pub type Vector = [f64; 3];

/// A node of the grid: its place on the first, second and third axis of the chain.
pub type Node = [usize; 3];

/// What one axis does at each of its nodes.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct AxisNodes {
    /// Translation x, y, z in µm, tool side relative to workpiece side.
    pub translation_um: Vec<Vector>,
    /// Rotation about x, y, z in µrad, right-handed.
    pub rotation_urad: Vec<Vector>,
    /// Lever of the axis in m: position less offset, strictly ascending.
    pub arm_m: Vec<f64>,
}

/// Node of axis 1, components in the order of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct First {
    pub(super) shift: Vector,
    /// Component 1 for a metre of axis 2.
    pub(super) by_second: f64,
    /// Component 1 for a metre of axis 3.
    pub(super) by_third: f64,
    /// Component 3 for a metre of axis 2, less component 2 for a metre of axis 3.
    pub(super) roll: f64,
}

/// Node of axis 2, components in the order of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Second {
    pub(super) shift: Vector,
    pub(super) arm: f64,
    /// Component 1 for a metre of axis 3.
    pub(super) by_third: f64,
    /// Less component 2 for a metre of axis 3.
    pub(super) roll: f64,
}

/// Node of axis 3, components in the order of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Third {
    pub(super) shift: Vector,
    pub(super) arm: f64,
}

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
    pub(super) first: Vec<First>,
    pub(super) second: Vec<Second>,
    pub(super) third: Vec<Third>,
}

impl GridMap {
    /// The map of three axes in the order of the chain. `None` where the chain names an axis
    /// twice, an axis has no node or lists of different lengths, a number is not finite or
    /// levers do not ascend.
    pub fn new(chain: [Axis; 3], axes: [AxisNodes; 3]) -> Option<GridMap> {
        let at = |axis: Axis| Axis::ALL.iter().position(|known| *known == axis);
        let roles = [at(chain[0])?, at(chain[1])?, at(chain[2])?];
        let mut place = [3; 3];
        for (role, component) in roles.into_iter().enumerate() {
            place[component] = role;
        }
        if place.contains(&3) || !axes.iter().all(AxisNodes::is_sound) {
            return None;
        }
        let right_handed = (roles[0] + 1) % 3 == roles[1];
        let parity = if right_handed { 1.0 } else { -1.0 };
        let nodes = axes.map(|axis| axis.in_order_of(roles));
        Some(GridMap {
            chain,
            place,
            first: nodes[0].iter().map(|node| node.first(parity)).collect(),
            second: nodes[1].iter().map(|node| node.second(parity)).collect(),
            third: nodes[2].iter().map(Plain::third).collect(),
        })
    }

    /// The axes from workpiece to tool.
    pub fn chain(&self) -> [Axis; 3] {
        self.chain
    }

    /// Nodes of the first, second and third axis of the chain.
    pub fn size(&self) -> Node {
        [self.first.len(), self.second.len(), self.third.len()]
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.size().iter().product()
    }

    /// The error vector at a node, x, y, z in µm. **The only place where one is computed.**
    ///
    /// Panics where the grid has no such node.
    #[inline]
    pub fn at(&self, node: Node) -> Vector {
        let (a, b, c) = (&self.first[node[0]], &self.second[node[1]], &self.third[node[2]]);
        let along_chain = [
            ((a.shift[0] + b.shift[0]) + c.shift[0])
                + (a.by_second * b.arm + (a.by_third + b.by_third) * c.arm),
            ((a.shift[1] + b.shift[1]) + c.shift[1]) - (a.roll + b.roll) * c.arm,
            ((a.shift[2] + b.shift[2]) + c.shift[2]) + a.roll * b.arm,
        ];
        self.place.map(|role| along_chain[role])
    }

    /// All vectors, the last axis of the chain fastest.
    pub fn vectors(&self) -> Vec<Vector> {
        (0..self.count()).map(|n| self.at(self.node(n))).collect()
    }

    /// The node of a place in [`GridMap::vectors`].
    #[inline]
    pub fn node(&self, number: usize) -> Node {
        let [_, second, third] = self.size();
        let line = number / third;
        [line / second, line % second, number % third]
    }

    /// The place of a node in [`GridMap::vectors`].
    #[inline]
    pub fn number(&self, node: Node) -> usize {
        let [_, second, third] = self.size();
        (node[0] * second + node[1]) * third + node[2]
    }

    /// Values given as x, y, z in the order of the chain.
    pub(crate) fn along_chain<T: Copy>(&self, xyz: [T; 3]) -> [T; 3] {
        let mut roles = xyz;
        for (component, role) in self.place.into_iter().enumerate() {
            roles[role] = xyz[component];
        }
        roles
    }
}

/// Shift, rotation and lever of a node, components in the order of the chain.
struct Plain {
    shift: Vector,
    rotation: Vector,
    arm: f64,
}

impl Plain {
    fn first(&self, parity: f64) -> First {
        First {
            shift: self.shift,
            by_second: -parity * self.rotation[2],
            by_third: parity * self.rotation[1],
            roll: parity * self.rotation[0],
        }
    }

    fn second(&self, parity: f64) -> Second {
        Second {
            shift: self.shift,
            arm: self.arm,
            by_third: parity * self.rotation[1],
            roll: parity * self.rotation[0],
        }
    }

    fn third(&self) -> Third {
        Third { shift: self.shift, arm: self.arm }
    }
}

impl AxisNodes {
    fn is_sound(&self) -> bool {
        let count = self.arm_m.len();
        let vectors = || self.translation_um.iter().chain(&self.rotation_urad);
        count > 0
            && self.translation_um.len() == count
            && self.rotation_urad.len() == count
            && vectors().flatten().chain(&self.arm_m).all(|v| v.is_finite())
            && self.arm_m.windows(2).all(|pair| pair[0] < pair[1])
    }

    fn in_order_of(&self, roles: [usize; 3]) -> Vec<Plain> {
        let vectors = self.translation_um.iter().zip(&self.rotation_urad);
        let nodes = vectors.zip(&self.arm_m);
        nodes
            .map(|((shift, rotation), arm)| Plain {
                shift: roles.map(|role| shift[role]),
                rotation: roles.map(|role| rotation[role]),
                arm: *arm,
            })
            .collect()
    }
}

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
        let (first, second, third) =
            (&map.first[i.clone()], &map.second[j.clone()], &map.third[k.clone()]);
        let zero = |v: f64| v.abs() <= 0.0;
        let turns_second = first.iter().any(|n| !zero(n.by_second) || !zero(n.roll));
        let turns_third = first.iter().any(|n| !zero(n.by_third) || !zero(n.roll))
            || second.iter().any(|n| !zero(n.by_third) || !zero(n.roll));
        let arm = |arm: f64, counts: bool| if counts { arm } else { 0.0 };
        let order = &mut self.order;
        distinct(first, i.start, order, &mut self.first, |n| {
            [n.shift[0], n.shift[1], n.shift[2], n.by_second, n.by_third, n.roll]
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
