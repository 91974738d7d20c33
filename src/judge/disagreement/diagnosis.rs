//! What the emulation of two sets of tables tells of them.

use crate::judge::findings::Difference;
use crate::text::Finding;

/// What emulation tells of two sets of tables.
#[derive(Clone, Debug, Default)]
pub struct Disagreements {
    /// One for each disagreement.
    pub findings: Vec<Finding>,
    /// The pairs of moving and corrected axis that they are about.
    pub pairs: Vec<(String, String)>,
}

impl Disagreements {
    /// Whether a finding is about these axes.
    pub(crate) fn explains(&self, base: &str, output: &str) -> bool {
        holds(&self.pairs, base, output)
    }

    pub(super) fn tell(&mut self, found: Difference, base: &str, output: &str) {
        self.findings.push(found.into());
        self.pairs.push((base.to_string(), output.to_string()));
    }
}

/// Whether a pair of axes is among these, in capitals or not.
pub(super) fn holds(pairs: &[(String, String)], base: &str, output: &str) -> bool {
    let is =
        |(b, o): &(String, String)| b.eq_ignore_ascii_case(base) && o.eq_ignore_ascii_case(output);
    pairs.iter().any(is)
}
