//! `[machine]`: the machine and its axes.

use crate::quantity::axis::{Direction, PerAxis};
use crate::quantity::chain::Chain;
use crate::quantity::units::Millimetres;

/// The machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its name, as in reports.
    pub name: String,
    /// Serial number.
    pub serial: Option<String>,
    /// Kinematic chain in the notation of contract §1, e.g. `wXYZt`.
    pub chain: Option<Chain>,
    /// Its axes; absent where the job does not describe one.
    pub axes: PerAxis<Option<MachineAxis>>,
}

/// One axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineAxis {
    /// Smallest machine coordinate.
    pub low: Millimetres,
    /// Largest machine coordinate.
    pub high: Millimetres,
    /// Reference (home) point: every table is zero here.
    pub reference: Millimetres,
    /// Direction of the reference return, if the job states it.
    pub reference_direction: Option<Direction>,
    /// Largest feed, mm/min.
    pub max_feed: Option<f64>,
}

impl MachineAxis {
    /// The stated direction of the reference return, or +.
    pub fn homing(&self) -> Direction {
        self.reference_direction.unwrap_or(Direction::Plus)
    }
}
