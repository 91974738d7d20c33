//! The error vector at any place, in a form that is cheap along a path: polynomials between the
//! nodes of each axis.

use crate::inputs::job::Job;
use crate::quantity::axis::Axis;
use crate::quantity::curve::{Interpolation, JUMP_MM};
use crate::volume::space::pair::cross;
use crate::volume::volume_model::VolumeModel;
use part_program::Place;

/// µrad × mm = 10⁻³ µm.
const PER_M: f64 = 1e-3;

/// Deviation (X, Y, Z, µm) and rotation (about X, Y, Z, µrad) of one axis where it stands.
pub type AxisPart = ([f64; 3], [f64; 3]);

/// Six cubics in the distance from the node on the left.
type Piece = [[f64; 6]; 4];

#[derive(Clone, Debug, PartialEq)]
struct AxisPieces {
    /// Where a curve bends, ascending.
    nodes: Vec<f64>,
    /// One more than nodes: before the first, between two, behind the last.
    pieces: Vec<Piece>,
    /// Where the lever counts from.
    origin: f64,
}

/// The errors of a machine along a path.
///
/// ```text
///   e = Σ dᵢ + r₁ × (a₂ + a₃) + r₂ × a₃ + (r₁ + r₂ + r₃) × t           1, 2, 3: workpiece → tool
/// ```
/// t is what the tool is longer than the one that was measured with: (0, 0, −ΔL). Rotations swing it;
/// squareness, a slope of dᵢ, tilts the way of an axis and not what it carries
/// ([`crate::volume::volume_model`]), so ΔL adds nothing to it.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMap {
    /// Numbers of the axes from the workpiece to the tool.
    order: [usize; 3],
    axes: [AxisPieces; 3],
    /// 1: linear curves, 3: cubic ones.
    degree: usize,
    /// Subtracted everywhere (datum), µm.
    zero: [f64; 3],
}

impl PathMap {
    /// The map of three axes.
    ///
    /// `order`: numbers of the axes from the workpiece to the tool; `nodes`: where the curves of an
    /// axis bend, ascending, at least one; `origins`: where levers count from, mm; `part`: what an
    /// axis contributes at a position; `cubic`: the curves are cubic between nodes, else straight.
    /// `None` where the order names an axis twice or nodes do not ascend.
    pub fn new(
        order: [usize; 3],
        nodes: [Vec<f64>; 3],
        origins: [f64; 3],
        cubic: bool,
        part: impl Fn(usize, f64) -> AxisPart,
    ) -> Option<PathMap> {
        let each_once = (0..3).all(|axis| order.contains(&axis));
        let ascend = |nodes: &Vec<f64>| {
            !nodes.is_empty()
                && nodes.iter().all(|node| node.is_finite())
                && nodes.windows(2).all(|pair| pair[0] < pair[1])
        };
        if !each_once || !nodes.iter().all(ascend) {
            return None;
        }
        let axes = [0, 1, 2].map(|axis| {
            let (nodes, pieces) = pieces(&nodes[axis], cubic, |at| part(axis, at));
            AxisPieces { nodes, pieces, origin: origins[axis] }
        });
        Some(PathMap { order, axes, degree: if cubic { 3 } else { 1 }, zero: [0.0; 3] })
    }

    /// The map less the mean error at these places (a datum that was probed on the machine).
    #[must_use]
    pub(crate) fn zeroed_at(mut self, places: &[Place]) -> PathMap {
        let errors = places.iter().map(|place| self.error_at(*place, 0.0));
        let sum = errors.fold([0.0; 3], plus);
        if !places.is_empty() {
            self.zero = plus(self.zero, sum.map(|um| um / places.len() as f64));
        }
        self
    }

    /// Whether the curves are straight between nodes.
    pub(super) fn is_linear(&self) -> bool {
        self.degree == 1
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
        if above && below {
            return hint;
        }
        nodes.partition_point(|node| *node < at)
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
        self.in_cell(cell).error_at(place, longer)
    }

    /// What the errors are made from in a cell, ready for many places.
    #[inline]
    pub(super) fn in_cell(&self, cell: [usize; 3]) -> Cell<'_> {
        let [first, _, third] = self.order;
        let pieces = |axis: usize| &self.axes[axis].pieces[cell[axis]];
        let left = |axis: usize| self.axes[axis].nodes[cell[axis].max(1) - 1];
        Cell {
            order: self.order,
            pieces: self.order.map(pieces),
            lefts: self.order.map(left),
            origins: [0, 1, 2].map(|axis| self.axes[axis].origin),
            beyond_first: [0, 1, 2].map(|axis| f64::from(u8::from(axis != first))),
            beyond_second: [0, 1, 2].map(|axis| f64::from(u8::from(axis == third))),
            degree: self.degree,
            zero: self.zero,
        }
    }
}

/// The errors between neighbouring nodes of all axes.
pub(super) struct Cell<'m> {
    order: [usize; 3],
    /// Of the axes from the workpiece to the tool.
    pieces: [&'m Piece; 3],
    lefts: [f64; 3],
    origins: [f64; 3],
    /// 1 for the axes whose travel is a lever of the first axis, else 0.
    beyond_first: [f64; 3],
    /// 1 for the axis whose travel is a lever of the second axis, else 0.
    beyond_second: [f64; 3],
    degree: usize,
    zero: [f64; 3],
}

impl Cell<'_> {
    /// The error vector at a place of the cell. **The only place where an error is computed.**
    #[inline(always)]
    pub(super) fn error_at(&self, place: Place, longer: f64) -> [f64; 3] {
        if self.degree == 1 {
            self.error_with(line_at, place, longer)
        } else {
            self.error_with(cubic_at, place, longer)
        }
    }

    #[inline(always)]
    fn error_with(
        &self,
        value: impl Fn(&Piece, f64) -> [f64; 6],
        place: Place,
        longer: f64,
    ) -> [f64; 3] {
        let part = |n: usize| value(self.pieces[n], place[self.order[n]] - self.lefts[n]);
        let [first, second, third] = [part(0), part(1), part(2)];
        let tool = [0.0, 0.0, -longer];
        let travel: [f64; 3] = std::array::from_fn(|k| place[k] - self.origins[k]);
        let lever = |counts: &[f64; 3]| -> [f64; 3] {
            std::array::from_fn(|k| travel[k] * counts[k] + tool[k])
        };
        let rotation = |part: &[f64; 6]| [part[3], part[4], part[5]];
        let swung = plus(
            cross(&rotation(&first), &lever(&self.beyond_first)),
            cross(&rotation(&second), &lever(&self.beyond_second)),
        );
        let swung = plus(swung, cross(&rotation(&third), &tool));
        std::array::from_fn(|k| (first[k] + second[k]) + third[k] + swung[k] * PER_M - self.zero[k])
    }
}

#[inline]
fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + b[k])
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
fn pieces(nodes: &[f64], cubic: bool, part: impl Fn(f64) -> AxisPart) -> (Vec<f64>, Vec<Piece>) {
    let at = |position: f64| {
        let (deviation, rotation) = part(position);
        let mut six = [0.0; 6];
        six[..3].copy_from_slice(&deviation);
        six[3..].copy_from_slice(&rotation);
        six
    };
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    let (before, behind) = (at(first - 1.0), at(last + 1.0));
    let mut split = vec![first];
    let mut pieces = vec![straight(at(first), slopes(before, at(first), 1.0))];
    for pair in nodes.windows(2) {
        let (left, width) = (pair[0], pair[1] - pair[0]);
        let ends = (at(left), at(pair[1]));
        if width < 2.0 * JUMP_MM {
            split.push(f64::midpoint(left, pair[1]));
            pieces.extend([straight(ends.0, [0.0; 6]), straight(ends.1, [0.0; 6])]);
        } else if cubic {
            let inner = [1.0 / 3.0, 2.0 / 3.0].map(|part| at(left + width * part));
            pieces.push(through_four(ends.0, inner[0], inner[1], ends.1, width));
        } else {
            pieces.push(straight(ends.0, slopes(ends.0, ends.1, width)));
        }
        split.push(pair[1]);
    }
    pieces.push(straight(at(last), slopes(at(last), behind, 1.0)));
    (split, pieces)
}

fn slopes(from: [f64; 6], to: [f64; 6], width: f64) -> [f64; 6] {
    std::array::from_fn(|k| (to[k] - from[k]) / width)
}

fn straight(value: [f64; 6], slope: [f64; 6]) -> Piece {
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
/// `None` where curves do not ascend, which a model that exists does not do.
pub(crate) fn path_map(job: &Job, volume: &VolumeModel) -> Option<PathMap> {
    let number = |axis: Axis| Axis::ALL.iter().position(|other| *other == axis);
    let [first, second, third] = volume.chain.order().map(number);
    let origin = volume.lever_origin();
    let cubic = job.compensation.curve != Interpolation::Linear;
    let map = PathMap::new(
        [first?, second?, third?],
        Axis::ALL.map(|axis| volume.bends(axis)),
        Axis::ALL.map(|axis| origin[axis]),
        cubic,
        |axis, position_mm| {
            let state = volume.state(Axis::ALL[axis], position_mm, |_| true);
            (
                Axis::ALL.map(|of| state.deviation_um[of]),
                Axis::ALL.map(|about| state.rotation_urad[about]),
            )
        },
    )?;
    Some(map.zeroed_at(&job.path.datum))
}
