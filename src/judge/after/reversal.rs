//! Lost motion that only the second measurement could see.

use crate::machine::model::{ErrorModel, Measured};
use crate::quantity::axis::ErrorTerm;
use crate::quantity::units::Figure;

/// The reversal of a second measurement in both directions, where the first one did not tell them
/// apart.
#[derive(Clone, Debug)]
pub struct UnseenReversal {
    /// B of each of these errors, in a sentence.
    pub words: String,
    /// The second measurement with the mean of both directions in their place.
    pub without: ErrorModel,
}

/// What the first measurement could not see; `None` where both tell the directions apart, or
/// neither does.
pub fn unseen_reversal(before: &ErrorModel, after: &ErrorModel) -> Option<UnseenReversal> {
    let mut without = after.clone();
    let mut found = Vec::new();
    for term in ErrorTerm::ALL {
        let (Some(first), Some(second)) = (&before.terms[term], &mut without.terms[term]) else {
            continue;
        };
        let reversal = second.reversal();
        if let Some(reversal) = reversal.filter(|_| !first.measured.has_both_ways()) {
            found.push(format!("{term} {:+.3}", Figure(reversal.um())));
            second.measured = Measured::Undirected(second.measured.mean());
        }
    }
    (!found.is_empty()).then(|| UnseenReversal {
        words: format!(
            "the first measurement did not tell the directions apart, so it did not see the lost motion, and its tables leave it; B (mean moving + minus mean moving -), µm: {}",
            found.join(", ")
        ),
        without,
    })
}
