//! What stands above the steps of a checklist: whether the kit is a rehearsal, doubtful, good enough,
//! and what has to be known about its tables.

use super::Made;
use crate::forecast::Verdict;
use crate::job::Acceptance;
use crate::kit::remarks;

/// One paragraph each.
pub(super) fn lines(made: &Made<'_>) -> Vec<String> {
    let remarks = &made.inputs.model.remarks;
    let simulated = remarks.simulated().map(|note| format!("**{note}**"));
    let doubts = made.doubts.iter();
    let doubts = doubts.map(|doubt| format!("**DOUBTFUL:** {doubt}"));
    simulated
        .chain(doubts)
        .chain([verdict(made)])
        .chain(known(made))
        .collect()
}

/// What was printed when the kit was made, for the person who has only this page.
fn known(made: &Made<'_>) -> Option<String> {
    let remarks = remarks(made.plan, made.compiled, Some(made.forecast));
    let lines: Vec<String> = remarks.iter().map(|words| format!("- {words}")).collect();
    (!lines.is_empty()).then(|| format!("About these tables:\n{}", lines.join("\n")))
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
