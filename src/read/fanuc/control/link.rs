//! What one axis adds to another, and a run of points.

use crate::control::controller::NumberRange;
use crate::quantity::axis::Direction;
use crate::quantity::units::Correction;
use crate::read::emulate::NodeTable;

/// What a base axis gives an output axis, by direction of the base.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Link {
    pub(super) plus: Way,
    pub(super) minus: Way,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Way {
    pub(super) tables: Vec<NodeTable>,
    pub(super) constant: Correction,
}

impl Default for Way {
    fn default() -> Self {
        Way {
            tables: Vec::new(),
            constant: Correction::ZERO,
        }
    }
}

impl Link {
    pub(super) fn way(&self, direction: Direction) -> &Way {
        match direction {
            Direction::Plus => &self.plus,
            Direction::Minus => &self.minus,
        }
    }

    pub(super) fn way_mut(&mut self, direction: Direction) -> &mut Way {
        match direction {
            Direction::Plus => &mut self.plus,
            Direction::Minus => &mut self.minus,
        }
    }
}

/// The points of one table and whose they are.
pub(super) struct Run {
    pub(super) owner: String,
    pub(super) points: NumberRange,
}

impl Run {
    pub(super) fn new(owner: String, points: NumberRange) -> Run {
        Run { owner, points }
    }
}
