//! Axes, units, signs, positions, curves.

mod axis;
mod chain;
mod curve;
mod diagonal;
mod fit;
pub mod pitch;
mod plane;
mod units;

pub use self::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm, Rotation, Xyz};
pub use self::chain::{Chain, LeverEffect, displaced, unit};
pub use self::curve::{ErrorCurve, Interpolation, JUMP_MM};
pub use self::diagonal::{Diagonal, LaserPath, Pass, PathKind, PerDiagonal, Run, Volume};
pub use self::fit::{Fit, Nodes, residual, table_values};
pub use self::pitch::USUAL_MM;
pub use self::plane::{PerPlane, Plane};
pub use self::units::{
    AT_PLACE_MM, Correction, Deviation, Figure, MM_PER_INCH, Millimetres, SAME_PLACE_MM, Squared,
    UM_PER_MM, URAD_PER_ARCSEC, ends, larger, picometres, power_of_ten, rounded, smaller,
};
