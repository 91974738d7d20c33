//! Axes, units, signs, positions, curves.

pub mod axis;
pub mod chain;
pub mod curve;
pub mod diagonal;
pub mod fit;
pub mod pitch;
pub mod plane;
pub mod units;
