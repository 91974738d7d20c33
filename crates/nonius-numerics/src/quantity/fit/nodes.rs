//! The nodes of a table.

use crate::quantity::Millimetres;

/// The equally spaced points of a table, mm in machine coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nodes {
    /// Position of node 0.
    pub first: Millimetres,
    /// From one node to the next, > 0.
    pub step: Millimetres,
    /// How many nodes, ≥ 1.
    pub count: usize,
    /// The node at the reference position, < `count`; its value is 0.
    pub reference_node: usize,
}

impl Nodes {
    /// The position of a node: first + node · step.
    pub fn position(&self, node: usize) -> Millimetres {
        Millimetres::new(self.first.mm() + self.step.mm() * node as f64)
    }
}
