//! The depths of a cycle, as they are written.

/// Modal values of a cycle. Its depths are kept as they are written: a change of zero or length
/// inside the cycle moves them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cycle {
    /// Where the tool stood along the third axis when the cycle was called, machine coordinate, mm.
    pub(super) initial: f64,
    /// The program's zero there at that time.
    pub(super) zero: Option<f64>,
    pub(super) retract: Option<Depth>,
    pub(super) bottom: Option<Depth>,
}

impl Cycle {
    pub(super) fn new(initial: f64, zero: Option<f64>) -> Cycle {
        Cycle {
            initial,
            zero,
            retract: None,
            bottom: None,
        }
    }
}

/// A depth as it is written, and the mode of that block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Depth {
    pub(super) mm: f64,
    pub(super) incremental: bool,
}
