//! What stands above the steps of a checklist: whether the kit is a rehearsal, doubtful, good enough.

use super::Made;
use crate::forecast::Verdict;
use crate::job::Acceptance;

/// One paragraph each.
pub(super) fn lines(made: &Made<'_>) -> Vec<String> {
    let remarks = &made.inputs.model.remarks;
    let simulated = remarks.simulated().map(|note| format!("**{note}**"));
    let doubts = made.doubts.iter();
    let doubts = doubts.map(|doubt| format!("**DOUBTFUL:** {doubt}"));
    simulated.chain(doubts).chain([verdict(made)]).collect()
}

fn verdict(made: &Made<'_>) -> String {
    let nothing_asked = made.inputs.job.acceptance == Acceptance::default();
    match made.verdict {
        Verdict::Pass if nothing_asked => {
            "Verdict: no acceptance is stated in the job, so there is nothing to judge.".to_string()
        }
        verdict => {
            let sentence = format!(
                "Verdict of the forecast against the acceptance of the job: **{}**.",
                verdict.word()
            );
            let misses = made.forecast.misses(made.inputs.job.acceptance);
            let misses = misses.iter().map(|miss| format!("- {miss}"));
            let lines: Vec<String> = std::iter::once(sentence).chain(misses).collect();
            lines.join("\n")
        }
    }
}
