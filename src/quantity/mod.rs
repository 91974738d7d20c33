//! Axes, units, signs, places, curves.

pub mod units;
pub mod axis;
pub mod chain;
pub mod diagonal;
pub mod curve;
pub mod fit;
