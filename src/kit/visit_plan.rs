//! A visit before it is made: what a run of step diagonals and variants of it determine, how well, in what
//! time, and the cheapest of them that reaches the acceptance.
//!
//! ```text
//!   [program] or [measurement.step_diagonal] ─→ run ─→ variants ─┬→ motion ─→ minutes, mirror
//!                                                                └→ readings of 0 ─→ separation ─→ U
//!   acceptance ←─ forecast without tables ←─ error model ←─ error table of zeros with these U ←─┘
//! ```
//! U comes from the separation itself, the acceptance is judged as `generate` judges it, for a machine
//! without errors and tables that leave nothing: what a variant misses here, no tables reach.

mod assumed;
mod compared;
mod design;
mod variant;
mod what_decides;

pub use self::compared::{VisitPlan, plan};
pub use self::design::{Design, SetUpTimes};
pub(crate) use self::variant::listed;
pub use self::variant::{Share, Variant, Visit};
pub(crate) use self::what_decides::Judged;
pub use self::what_decides::{Act, Measured, WhatDecides};
