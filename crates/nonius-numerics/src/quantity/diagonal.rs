//! The four body diagonals of the measured volume and the path along them.
//!
//! ```text
//!            Z                 step run: every cell is crossed by one move of each axis
//!            │   ┌────────┐
//!            │  ╱        ╱│            ·──► next cell
//!            │ ┌────────┐ │            │ Z
//!            │ │        │ │      ·─────┘
//!            │ │        │ ╱      │  Y
//!            │ └────────┘╱   ────┘
//!            └──────────── X   X
//! ```
//! `PPP` runs from the corner with the smallest coordinates to the one with the largest; `N` in a
//! name says that this axis travels negative on the forward run (contract §2.2).

use crate::quantity::{Axis, Deviation, Direction, Millimetres, PerAxis};
use serde::{Serialize, Serializer};
use std::fmt;
use std::ops::{Index, IndexMut};

/// A body diagonal, named by the signs of X, Y and Z on its forward run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Diagonal {
    /// X+, Y+, Z+.
    Ppp,
    /// X−, Y+, Z+.
    Npp,
    /// X+, Y−, Z+.
    Pnp,
    /// X+, Y+, Z−.
    Ppn,
}

impl Diagonal {
    /// The four of them, in the order of the contract.
    pub const ALL: [Diagonal; 4] = [Diagonal::Ppp, Diagonal::Npp, Diagonal::Pnp, Diagonal::Ppn];

    /// Its name, e.g. `NPP`.
    pub const fn name(self) -> &'static str {
        ["PPP", "NPP", "PNP", "PPN"][self as usize]
    }

    /// The name of the same line walked backwards, e.g. `PNN` for `NPP`.
    pub const fn reverse_name(self) -> &'static str {
        ["NNN", "PNN", "NPN", "NNP"][self as usize]
    }

    /// The diagonal of a name; `Pass::Reverse` where the name is that of the reverse run.
    pub fn from_name(name: &str) -> Option<(Diagonal, Pass)> {
        Diagonal::ALL.into_iter().find_map(|diagonal| {
            let names = [diagonal.name(), diagonal.reverse_name()];
            let pass = names.into_iter().zip(Pass::BOTH).find(|(own, _)| *own == name);
            pass.map(|(_, pass)| (diagonal, pass))
        })
    }

    /// Direction in which an axis travels on the forward run.
    pub const fn forward(self, axis: Axis) -> Direction {
        match (self, axis) {
            (Diagonal::Npp, Axis::X) | (Diagonal::Pnp, Axis::Y) | (Diagonal::Ppn, Axis::Z) => {
                Direction::Minus
            }
            _ => Direction::Plus,
        }
    }

    /// Direction in which an axis really travels on a pass.
    pub const fn travelled(self, axis: Axis, pass: Pass) -> Direction {
        match pass {
            Pass::Forward => self.forward(axis),
            Pass::Reverse => self.forward(axis).opposite(),
        }
    }

    /// s of the formulas: +1 where the axis travels positive on the forward run, else −1.
    pub const fn sign(self, axis: Axis) -> f64 {
        match self.forward(axis) {
            Direction::Plus => 1.0,
            Direction::Minus => -1.0,
        }
    }
}

impl fmt::Display for Diagonal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(self.name())
    }
}

/// One value for each body diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct PerDiagonal<T>([T; 4]);

impl<T> PerDiagonal<T> {
    /// The value of each diagonal from a function of the diagonal.
    pub fn from_fn(of: impl FnMut(Diagonal) -> T) -> Self {
        PerDiagonal(Diagonal::ALL.map(of))
    }

    /// Diagonal and value, in the order of [`Diagonal::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Diagonal, &T)> {
        Diagonal::ALL.into_iter().zip(&self.0)
    }
}

/// By the names of the diagonals.
impl<T: Serialize> Serialize for PerDiagonal<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.iter().map(|(diagonal, value)| (diagonal.name(), value)))
    }
}

impl<T> Index<Diagonal> for PerDiagonal<T> {
    type Output = T;
    fn index(&self, diagonal: Diagonal) -> &T {
        &self.0[diagonal as usize]
    }
}

impl<T> IndexMut<Diagonal> for PerDiagonal<T> {
    fn index_mut(&mut self, diagonal: Diagonal) -> &mut T {
        &mut self.0[diagonal as usize]
    }
}

/// The way along a diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Pass {
    /// In the direction of the diagonal's name.
    Forward,
    /// Back over the same nodes.
    Reverse,
}

impl Pass {
    /// Both, forward first.
    pub const BOTH: [Pass; 2] = [Pass::Forward, Pass::Reverse];

    /// The word of the readings file.
    pub const fn word(self) -> &'static str {
        ["forward", "reverse"][self as usize]
    }
}

/// How the diagonals were walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathKind {
    /// One axis at a time: 3n + 1 nodes (the step-diagonal method).
    Step,
    /// All axes together: n + 1 nodes (the ordinary body-diagonal test).
    Straight,
}

/// The measured box and its division.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// The corner with the smallest machine coordinates.
    pub start: PerAxis<Millimetres>,
    /// Its edges, positive.
    pub size: PerAxis<Millimetres>,
    /// n: steps of each axis, at least 1.
    pub steps: usize,
    /// Order of the single-axis moves inside a cell, as on the forward run.
    pub order: [Axis; 3],
}

impl Volume {
    /// Its middle, machine coordinates.
    pub fn middle(&self) -> PerAxis<Millimetres> {
        PerAxis::from_fn(|axis| {
            Millimetres::new(self.start[axis].mm() + self.size[axis].mm() / 2.0)
        })
    }

    /// R: length of a body diagonal, mm.
    pub fn diagonal_mm(&self) -> f64 {
        PerAxis::from_fn(|axis| self.size[axis].mm()).length()
    }

    /// V/R: direction cosine of an axis along PPP.
    pub fn cosine(&self, axis: Axis) -> f64 {
        self.size[axis].mm() / self.diagonal_mm()
    }

    /// u of the formulas: unit vector of the laser, from the start corner to the end corner.
    pub fn laser(&self, diagonal: Diagonal) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| diagonal.sign(axis) * self.cosine(axis))
    }

    /// One step of an axis, mm.
    pub fn step_mm(&self, axis: Axis) -> f64 {
        self.size[axis].mm() / self.steps_f64()
    }

    /// Number of the last node of a run; the first is 0.
    pub const fn last_node(&self, kind: PathKind) -> usize {
        match kind {
            PathKind::Step => 3 * self.steps,
            PathKind::Straight => self.steps,
        }
    }

    /// The axis that moves from `node` − 1 to `node` on a forward step run; `node` ≥ 1.
    pub const fn moved(&self, node: usize) -> Axis {
        self.order[(node + 2) % 3]
    }

    /// Number of steps that an axis has made at a node of a forward run.
    pub fn steps_made(&self, kind: PathKind, node: usize, axis: Axis) -> usize {
        match kind {
            PathKind::Straight => node,
            PathKind::Step => {
                let turn = self.order.iter().position(|other| *other == axis);
                let already = turn.is_some_and(|turn| node % 3 > turn);
                node / 3 + usize::from(already)
            }
        }
    }

    /// Distance of an axis from the start corner's coordinate at a node, mm, 0 … size.
    pub fn inside_mm(&self, diagonal: Diagonal, kind: PathKind, node: usize) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| self.along_mm(axis, self.end_at(diagonal, kind, node, axis)))
    }

    /// The interval end that an axis stands at, lowest first.
    pub fn end_at(&self, diagonal: Diagonal, kind: PathKind, node: usize, axis: Axis) -> usize {
        let made = self.steps_made(kind, node, axis);
        if diagonal.sign(axis) > 0.0 { made } else { self.steps - made }
    }

    /// Commanded place of a node, machine coordinates.
    pub fn place(&self, diagonal: Diagonal, kind: PathKind, node: usize) -> PerAxis<Millimetres> {
        let inside = self.inside_mm(diagonal, kind, node);
        PerAxis::from_fn(|axis| self.start[axis] + Millimetres::new(inside[axis]))
    }

    /// Nominal displacement along the laser from the start corner to a node, mm.
    pub fn nominal_mm(&self, diagonal: Diagonal, kind: PathKind, node: usize) -> f64 {
        let laser = self.laser(diagonal);
        laser.dot(self.inside_mm(diagonal, kind, node).minus(self.inside_mm(diagonal, kind, 0)))
    }

    /// The machine interval (0 = lowest) that the step with running number `step` (0 = first)
    /// of an axis crosses: running numbers of an axis that travels negative count downwards.
    pub fn interval(&self, diagonal: Diagonal, axis: Axis, step: usize) -> usize {
        if diagonal.sign(axis) > 0.0 { step } else { self.steps - 1 - step }
    }

    /// The node at which the axis has just made its step with running number `step`.
    pub fn node_after(&self, axis: Axis, step: usize) -> usize {
        3 * step + self.order.iter().position(|other| *other == axis).unwrap_or(0) + 1
    }

    /// Distance of interval end `index` from the low end of an axis, mm; 0 … n.
    pub fn along_mm(&self, axis: Axis, index: usize) -> f64 {
        if index == self.steps {
            return self.size[axis].mm();
        }
        self.size[axis].mm() * index as f64 / self.steps_f64()
    }

    /// Positions of the interval ends of an axis, machine coordinates; n + 1 of them.
    pub fn positions(&self, axis: Axis) -> Vec<Millimetres> {
        let position = |index| self.start[axis] + Millimetres::new(self.along_mm(axis, index));
        (0..=self.steps).map(position).collect()
    }

    /// n as a number of formulas.
    pub fn steps_f64(&self) -> f64 {
        self.steps as f64
    }
}

/// One walk along a diagonal, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Number of the run, as in the file.
    pub number: u32,
    /// Forward or reverse.
    pub pass: Pass,
    /// Measured − nominal displacement, positive along the forward direction in both passes, at
    /// each node of the **forward** path (0 … last).
    pub deviations: Vec<Deviation>,
    /// Temperatures of the scales at each node, °C; `None` = not recorded.
    pub temperatures_c: PerAxis<Option<Vec<f64>>>,
}

/// What a set-up of the laser measures along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaserPath {
    /// A body diagonal.
    Diagonal(Diagonal),
    /// A single axis.
    Axis(Axis),
}

impl LaserPath {
    /// `PPP` …, or `x` …, as files have it.
    pub const fn name(self) -> &'static str {
        match self {
            LaserPath::Diagonal(diagonal) => diagonal.name(),
            LaserPath::Axis(axis) => axis.key(),
        }
    }

    /// Direction in which an axis travels on a pass; `None` = it rests.
    pub fn travelled(self, axis: Axis, pass: Pass) -> Option<Direction> {
        match (self, pass) {
            (LaserPath::Diagonal(diagonal), pass) => Some(diagonal.travelled(axis, pass)),
            (LaserPath::Axis(moving), _) if moving != axis => None,
            (LaserPath::Axis(_), Pass::Forward) => Some(Direction::Plus),
            (LaserPath::Axis(_), Pass::Reverse) => Some(Direction::Minus),
        }
    }
}

impl fmt::Display for LaserPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name().to_uppercase())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume() -> Volume {
        let edges = |x, y, z| PerAxis {
            x: Millimetres::new(x),
            y: Millimetres::new(y),
            z: Millimetres::new(z),
        };
        Volume {
            start: edges(100.0, 0.0, -720.0),
            size: edges(900.0, 720.0, 720.0),
            steps: 30,
            order: [Axis::Z, Axis::X, Axis::Y],
        }
    }

    #[test]
    fn names_and_reverse_names_are_told_apart() {
        assert_eq!(Diagonal::from_name("NPP"), Some((Diagonal::Npp, Pass::Forward)));
        assert_eq!(Diagonal::from_name("PNN"), Some((Diagonal::Npp, Pass::Reverse)));
        assert_eq!(Diagonal::from_name("XYZ"), None);
    }

    #[test]
    fn nodes_follow_the_order_of_the_moves() {
        let volume = volume();
        let moved: Vec<Axis> = (1..=4).map(|node| volume.moved(node)).collect();
        assert_eq!(moved, [Axis::Z, Axis::X, Axis::Y, Axis::Z]);
        let place = volume.place(Diagonal::Npp, PathKind::Step, 5);
        assert_eq!(place.x, Millimetres::new(940.0), "two steps down from 1000");
        assert_eq!(place.y, Millimetres::new(24.0), "one step");
        assert_eq!(place.z, Millimetres::new(-672.0), "two steps up from -720");
        assert_eq!(volume.node_after(Axis::X, 1), 5);
    }

    #[test]
    fn a_negative_axis_files_its_steps_from_the_far_end() {
        let volume = volume();
        assert_eq!(volume.interval(Diagonal::Npp, Axis::X, 0), 29);
        assert_eq!(volume.interval(Diagonal::Npp, Axis::Y, 0), 0);
    }

    #[test]
    fn the_nominal_displacement_ends_at_the_length_of_the_diagonal() {
        let volume = volume();
        for diagonal in Diagonal::ALL {
            for kind in [PathKind::Step, PathKind::Straight] {
                let end = volume.nominal_mm(diagonal, kind, volume.last_node(kind));
                assert!((end - volume.diagonal_mm()).abs() < 1e-9, "{diagonal}");
            }
        }
    }
}
