//! The machine's error along the path of a tool.
//!
//! ```text
//!   Move ─┬─ line ─────────────────→ split where a curve bends ─→ parts with a polynomial error
//!         └─ arc ─→ chords ─────────↗            │
//!                                                ├─→ extremes: ends and vertices of each part
//!                                                └─→ samples ─→ CSV, holes
//!                                                             └─→ hull ─→ profile accuracy
//! ```
//! Between two nodes of linear curves each component of the error is a parabola in the length of a
//! straight move (angle × lever), so its extremes, and that of |e|, are **exact**: they are not
//! looked for on samples. An arc is followed on chords that leave it by no more than a stated
//! tolerance; on each chord the same holds.

mod cloud;
mod extremes;
mod map;
mod profile;
#[cfg(test)]
mod tests;

pub use self::extremes::{Channel, Extreme, Range};
pub use self::map::PathMap;
pub(crate) use self::map::path_map;
pub use self::profile::{Moves, Outside, Profile, ProfileLimits, Sample, Summary, limits};
