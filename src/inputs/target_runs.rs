//! The runs of one axis to its targets, as a positioning test measures them: every target several
//! times from either side (ISO 230-2).
//!
//! ```text
//!            P1        P2        P3        P4
//!  run 1 ↑ ──●─────────●─────────●─────────●──┐    moving up: approached in the + direction
//!  run 1 ↓ ──●─────────●─────────●─────────●──┘    moving down: approached in the - direction
//! ```
//!
//! `read` turns a file into [`Runs`]; [`crate::machine::standards`] turns them into figures.

mod header;
mod read;
mod runs;

pub use self::runs::{Runs, Stated, Values};

use crate::text::document::Source;
use crate::text::problem::Problems;

impl Runs {
    /// Reads a file of runs; all its problems are given at once.
    ///
    /// Two layouts: one row for each target (`target_mm,up1_mm,…,dn1_mm,…`), or one row for each
    /// reading (`target_mm,run,direction,deviation_um`). See docs/interface.md §2.4.
    pub fn read(source: &Source, stated: Stated) -> Result<Runs, Problems> {
        read::runs(source, stated)
    }
}
