//! The bump of a sign proof.

use crate::control::controller::Mechanism;
use crate::control::table::Tables;
use crate::quantity::axis::ErrorTerm;
use crate::quantity::units::{Deviation, Millimetres};
use crate::write::grid::Grid;

/// One bump of one mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct SignProof {
    /// What it proves the sign of.
    pub mechanism: Mechanism,
    /// The term whose table holds the bump.
    pub term: ErrorTerm,
    /// Its place and size.
    pub bump: Bump,
    /// Everything that the file writes.
    pub tables: Tables,
}

/// A bump on the grid of a moving axis: it rises over some sections and falls over as many.
///
/// **unit** whole counts of the table · **limits** at most `limits.max_bump_um`; at least one
/// section away from the reference; inside the travel; at most `limits.max_slope_um_per_mm` and,
/// on Fanuc, the largest increment in each section (four points: where there is room for that)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    pub(super) grid: Grid,
    pub(super) peak: i64,
    pub(super) rise: i64,
    pub(super) counts: i64,
    pub(super) count_um: f64,
}

impl Bump {
    /// Where it begins, is highest, and ends, machine coordinates.
    pub fn places(&self) -> [Millimetres; 3] {
        [self.peak - self.rise, self.peak, self.peak + self.rise].map(|n| self.grid.position(n))
    }

    /// The deviation that the table pretends at the peak.
    pub fn height(&self) -> Deviation {
        Deviation::from_um(as_number(self.counts) * self.count_um)
    }

    /// Counts at a node, counted from the reference; a half is rounded up.
    pub(super) fn counts_at(&self, node: i64) -> i64 {
        let inside = (self.rise - (node - self.peak).abs()).max(0);
        (2 * self.counts * inside + self.rise) / (2 * self.rise)
    }

    /// The deviations that a table of this grid pretends.
    pub(super) fn deviations(&self) -> Vec<Deviation> {
        (self.grid.first..=self.grid.last)
            .map(|node| Deviation::from_um(as_number(self.counts_at(node)) * self.count_um))
            .collect()
    }
}

#[allow(clippy::cast_precision_loss, reason = "far below 2^52 counts")]
pub(super) fn as_number(counts: i64) -> f64 {
    counts as f64
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "a bump has few counts, a grid few nodes; NaN and infinity saturate"
)]
pub(super) fn whole_below(number: f64) -> i64 {
    const DUST: f64 = 1e-9;
    (number + DUST).floor() as i64
}
