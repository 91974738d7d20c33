//! Axes, units, signs, positions, curves: `nonius-numerics`, which is always optimised.

pub use nonius_numerics::quantity::*;
