//! The error vector at any place, in a form that is cheap along a path: polynomials between the
//! nodes of each axis.

use crate::inputs::job::Job;
use crate::quantity::{Axis, Interpolation, JUMP_MM, PerAxis};
use crate::volume::space::pair::cross;
use crate::volume::volume_model::{AxisState, Nodes, VolumeModel};
use part_program::Place;

/// µrad × mm = 10⁻³ µm.
const PER_M: f64 = 1e-3;

/// Six cubics in the distance from the node on the left.
type Piece = [[f64; 6]; 4];

#[derive(Clone, Debug, PartialEq)]
struct AxisPieces {
    /// Where a curve bends, ascending.
    nodes: Vec<f64>,
    /// One more than nodes: before the first, between two, behind the last.
    pieces: Vec<Piece>,
}

/// The errors of a machine along a path.
///
/// ```text
///   e = Σ dᵢ + r₁ × (a₂ + a₃) + r₂ × a₃ + (r₁ + r₂ + r₃) × t           1, 2, 3: workpiece → tool
/// ```
/// The formula of [`crate::quantity::displaced`], in half of its time. t is what the tool is longer than the one
/// that was measured with: (0, 0, −ΔL). Rotations swing it; squareness, a slope of dᵢ, tilts the way of an axis and not
/// what it carries ([`crate::volume::volume_model`]), so ΔL adds nothing to it.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMap {
    /// Numbers of the axes from the workpiece to the tool.
    order: [usize; 3],
    axes: [AxisPieces; 3],
    /// Where levers count from.
    origins: [f64; 3],
    /// 1 for the axes whose travel is a lever of the first axis, and of the second one, else 0.
    behind: [[f64; 3]; 2],
    /// Whether the curves are straight between nodes; else cubic.
    is_linear: bool,
    /// Subtracted everywhere (datum), µm.
    zero: [f64; 3],
}

impl PathMap {
    /// The map of three axes.
    ///
    /// `order`: the axes from the workpiece to the tool; `nodes`: where the curves of an axis bend, ascending, at
    /// least one; `origins`: where levers count from, mm; `state`: what an axis contributes at a position; `cubic`: the
    /// curves are cubic between nodes, else straight.
    pub fn new(
        order: [Axis; 3],
        nodes: &Nodes,
        origins: PerAxis<f64>,
        cubic: bool,
        state: impl Fn(Axis, f64) -> AxisState,
    ) -> PathMap {
        let axes = Axis::ALL.map(|axis| pieces(&nodes[axis], cubic, |at| state(axis, at).values()));
        let counts = |behind: &[Axis]| Axis::ALL.map(|axis| f64::from(behind.contains(&axis)));
        PathMap {
            behind: [counts(&order[1..]), counts(&order[2..])],
            order: order.map(|axis| axis as usize),
            origins: Axis::ALL.map(|axis| origins[axis]),
            axes,
            is_linear: !cubic,
            zero: [0.0; 3],
        }
    }

    /// The map less the mean error at these places (a datum that was probed on the machine).
    #[must_use]
    pub(crate) fn zeroed_at(mut self, places: &[Place]) -> PathMap {
        let errors: Vec<Place> = places.iter().map(|place| self.error_at(*place, 0.0)).collect();
        if !errors.is_empty() {
            let mean = |k: usize| errors.iter().map(|um| um[k]).sum::<f64>() / errors.len() as f64;
            self.zero = std::array::from_fn(|k| self.zero[k] + mean(k));
        }
        self
    }

    /// Whether the curves are straight between nodes.
    pub(super) fn is_linear(&self) -> bool {
        self.is_linear
    }

    /// The nodes of an axis.
    pub fn nodes(&self, axis: usize) -> &[f64] {
        &self.axes[axis].nodes
    }

    /// The piece of an axis that a position lies in.
    #[inline]
    pub(super) fn piece(&self, axis: usize, at: f64, hint: usize) -> usize {
        let nodes = &self.axes[axis].nodes;
        let above = hint == 0 || nodes[hint - 1] <= at;
        let below = hint == nodes.len() || at <= nodes[hint];
        if above && below { hint } else { nodes.partition_point(|node| *node < at) }
    }

    /// The cell that a place lies in: the numbers of its pieces.
    #[inline]
    pub(super) fn cell(&self, place: Place, hint: [usize; 3]) -> [usize; 3] {
        std::array::from_fn(|axis| self.piece(axis, place[axis], hint[axis]))
    }

    /// The error vector at a place with a tool that is `longer` by so many mm, µm.
    pub(crate) fn error_at(&self, place: Place, longer: f64) -> [f64; 3] {
        self.error_in(self.cell(place, [0; 3]), place, longer)
    }

    /// The same in a cell that is known.
    #[inline]
    pub(super) fn error_in(&self, cell: [usize; 3], place: Place, longer: f64) -> [f64; 3] {
        match self.is_linear {
            true => self.error_with(line_at, cell, place, longer),
            false => self.error_with(cubic_at, cell, place, longer),
        }
    }

    #[inline(always)]
    fn error_with(
        &self,
        value: impl Fn(&Piece, f64) -> [f64; 6],
        cell: [usize; 3],
        place: Place,
        longer: f64,
    ) -> [f64; 3] {
        let part = |axis: usize| {
            let (AxisPieces { nodes, pieces }, number) = (&self.axes[axis], cell[axis]);
            value(&pieces[number], place[axis] - nodes[number.max(1) - 1])
        };
        let [first, second, third] = self.order;
        let [first, second, third] = [part(first), part(second), part(third)];
        let tool = [0.0, 0.0, -longer];
        let lever = |counts: &[f64; 3]| -> [f64; 3] {
            std::array::from_fn(|k| (place[k] - self.origins[k]) * counts[k] + tool[k])
        };
        let rotation = |part: &[f64; 6]| [part[3], part[4], part[5]];
        let by_first = cross(&rotation(&first), &lever(&self.behind[0]));
        let by_second = cross(&rotation(&second), &lever(&self.behind[1]));
        let by_third = cross(&rotation(&third), &tool);
        std::array::from_fn(|k| {
            let swung = (by_first[k] + by_second[k]) + by_third[k];
            (first[k] + second[k]) + third[k] + swung * PER_M - self.zero[k]
        })
    }
}

#[inline]
fn line_at(piece: &Piece, s: f64) -> [f64; 6] {
    std::array::from_fn(|k| piece[0][k] + piece[1][k] * s)
}

#[inline]
fn cubic_at(piece: &Piece, s: f64) -> [f64; 6] {
    std::array::from_fn(|k| piece[0][k] + s * (piece[1][k] + s * (piece[2][k] + s * piece[3][k])))
}

/// The cubics of an axis, through two or four values of each piece. Before the first node and
/// behind the last one the axis goes on as it does over one more millimetre: it is held. A jump
/// ([`JUMP_MM`]) is two pieces, the value before it and the value behind it: whichever way a path
/// goes, it meets both, and where exactly it is there does not matter. Gives the nodes between the
/// pieces too.
fn pieces(nodes: &[f64], cubic: bool, at: impl Fn(f64) -> [f64; 6]) -> AxisPieces {
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    let mut split = vec![first];
    let mut pieces = vec![straight(at(first), at(first - 1.0), -1.0)];
    for pair in nodes.windows(2) {
        let (left, width) = (pair[0], pair[1] - pair[0]);
        let ends = (at(left), at(pair[1]));
        if width < 2.0 * JUMP_MM {
            split.push(f64::midpoint(left, pair[1]));
            pieces.extend([straight(ends.0, ends.0, 1.0), straight(ends.1, ends.1, 1.0)]);
        } else if cubic {
            let inner = [1.0 / 3.0, 2.0 / 3.0].map(|part| at(left + width * part));
            pieces.push(through_four(ends.0, inner[0], inner[1], ends.1, width));
        } else {
            pieces.push(straight(ends.0, ends.1, width));
        }
        split.push(pair[1]);
    }
    pieces.push(straight(at(last), at(last + 1.0), 1.0));
    AxisPieces { nodes: split, pieces }
}

/// From a value on, with the slope to another one so far away.
fn straight(value: [f64; 6], other: [f64; 6], away: f64) -> Piece {
    let slope = std::array::from_fn(|k| (other[k] - value[k]) / away);
    [value, slope, [0.0; 6], [0.0; 6]]
}

/// The cubics through four equally spaced values, over a width.
fn through_four(a: [f64; 6], b: [f64; 6], c: [f64; 6], d: [f64; 6], width: f64) -> Piece {
    let third = width / 3.0;
    let mut piece = [a, [0.0; 6], [0.0; 6], [0.0; 6]];
    for k in 0..6 {
        let (d1, d2, d3) =
            (b[k] - a[k], c[k] - 2.0 * b[k] + a[k], d[k] - 3.0 * c[k] + 3.0 * b[k] - a[k]);
        piece[1][k] = (d1 - d2 / 2.0 + d3 / 3.0) / third;
        piece[2][k] = (d2 / 2.0 - d3 / 2.0) / (third * third);
        piece[3][k] = d3 / 6.0 / (third * third * third);
    }
    piece
}

/// The errors of a machine along a path, less the mean error at the probed places of the job.
pub(crate) fn path_map(job: &Job, volume: &VolumeModel) -> PathMap {
    let nodes = PerAxis::from_fn(|axis| volume.bends(axis));
    let cubic = job.compensation.curve != Interpolation::Linear;
    let state = |axis, mm| volume.state(axis, mm, |_| true);
    let map = PathMap::new(volume.chain.order(), &nodes, volume.lever_origin(), cubic, state);
    map.zeroed_at(&job.path.datum)
}
