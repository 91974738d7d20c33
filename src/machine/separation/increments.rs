//! Increments of the reading errors, filed under the machine interval that a step crosses.

use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};

/// Mean reading errors of one pass along each diagonal, µm, by node of the forward path.
pub type PassMeans = PerDiagonal<Vec<f64>>;

/// m of formula (1): by diagonal and moving axis, one value for each machine interval, lowest
/// first; µm.
pub type Increments = PerDiagonal<PerAxis<Vec<f64>>>;

/// Which readings stand for a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// The forward pass of all diagonals: an axis that a diagonal walks in − is mixed in.
    ForwardOnly,
    /// Every axis moving in this direction: forward passes of the diagonals that travel so,
    /// reverse passes of the others.
    Moving(Direction),
}

impl Group {
    /// The pass along a diagonal on which this group finds the steps of an axis.
    pub const fn pass(self, diagonal: Diagonal, axis: Axis) -> Pass {
        match (self, diagonal.forward(axis)) {
            (Group::ForwardOnly, _)
            | (Group::Moving(Direction::Plus), Direction::Plus)
            | (Group::Moving(Direction::Minus), Direction::Minus) => Pass::Forward,
            (Group::Moving(_), _) => Pass::Reverse,
        }
    }
}

/// Mean reading errors of all passes that were walked.
#[derive(Clone, Debug, PartialEq)]
pub struct Means {
    /// Forward.
    pub forward: PassMeans,
    /// Reverse, if every diagonal was walked back.
    pub reverse: Option<PassMeans>,
}

impl Means {
    /// The readings of a pass; those of the forward pass where there is no other.
    pub fn of(&self, pass: Pass) -> &PassMeans {
        match (pass, &self.reverse) {
            (Pass::Reverse, Some(reverse)) => reverse,
            _ => &self.forward,
        }
    }

    /// The groups that the readings hold.
    pub fn groups(&self) -> &'static [Group] {
        match self.reverse {
            None => &[Group::ForwardOnly],
            Some(_) => &[
                Group::Moving(Direction::Plus),
                Group::Moving(Direction::Minus),
            ],
        }
    }

    /// Increments of a group. A step of an axis that travels in − on the forward run is filed
    /// from the far end; the sign of the increment stays, formula (1) has it.
    pub fn increments(&self, volume: &Volume, group: Group) -> Increments {
        PerDiagonal::from_fn(|diagonal| {
            PerAxis::from_fn(|axis| {
                let readings = &self.of(group.pass(diagonal, axis))[diagonal];
                filed(volume, diagonal, axis, readings)
            })
        })
    }
}

fn filed(volume: &Volume, diagonal: Diagonal, axis: Axis, readings: &[f64]) -> Vec<f64> {
    let first = volume.node_after(axis, 0);
    let steps = (first..).step_by(3).take(volume.steps);
    let mut increments: Vec<f64> = steps
        .map(|node| readings[node] - readings[node - 1])
        .collect();
    if diagonal.forward(axis) == Direction::Minus {
        increments.reverse();
    }
    increments
}

/// Mean of the increments of a (diagonal, axis) pair over its intervals and over the groups, µm.
pub(crate) fn mean_increments(groups: &[Increments]) -> PerDiagonal<PerAxis<f64>> {
    PerDiagonal::from_fn(|diagonal| {
        PerAxis::from_fn(|axis| {
            let all = groups.iter().flat_map(|group| &group[diagonal][axis]);
            let (mut sum, mut count) = (0.0, 0.0);
            for increment in all {
                sum += increment;
                count += 1.0;
            }
            sum / count
        })
    })
}
