//! Slips in the records of the first measurement: its readings belong to another machine than the
//! one that was separated from them.
//!
//! ```text
//!   readings, filed right ─→ separated again ─→ as found, truly
//!   as found, truly + what the loaded tables add  =  as left
//! ```
//! To the closure an order of the steps is the same as one way to share out the names (docs/method.md
//! §4). Separated they are not: the names put other readings to an axis, the order another axis to
//! the readings. So the second measurement tells them apart, and both are tried.

use crate::judge::causes::corrected::{Corrected, Slip};

use super::question::{Question, deviation_um};
use crate::judge::after::Part;

impl Corrected {
    /// What a part was as found beyond what the records say, µm; `None` = not measured there.
    fn beyond_um(&self, question: &Question<'_>, part: &Part) -> Option<f64> {
        Some(deviation_um(&self.before, part)? - deviation_um(question.before, part)?)
    }

    /// Whether it has an answer wherever the second measurement looked.
    pub(super) fn answers(&self, question: &Question<'_>) -> bool {
        let mut parts = question.seen.iter().flat_map(|o| &o.parts);
        parts.all(|part| self.beyond_um(question, part).is_some())
    }
}

/// What the machine was beyond the records if they hold this slip, µm.
pub(super) fn beyond_um(question: &Question<'_>, slip: Slip, part: &Part) -> f64 {
    let mut all = question.corrected.iter();
    let own = all.find(|corrected| corrected.slip == slip);
    // Only what answers everywhere is tried.
    own.and_then(|own| own.beyond_um(question, part))
        .unwrap_or(0.0)
}
