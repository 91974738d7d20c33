//! What stands above the steps of a checklist: whether the kit is a rehearsal, doubtful, good enough,
//! and what has to be known about its tables.

use super::Made;
use crate::judge::conformity::Verdict;
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
    let known = remarks(made.plan, made.compiled, Some(made.forecast));
    (!known.is_empty()).then(|| listed("About these tables:", &known))
}

/// A sentence with a list below it, as one paragraph.
fn listed(sentence: &str, lines: &[String]) -> String {
    let lines = lines.iter().map(|line| format!("\n- {line}"));
    std::iter::once(sentence.to_string()).chain(lines).collect()
}

fn verdict(made: &Made<'_>) -> String {
    let nothing_asked = made.inputs.job.acceptance.asks_nothing();
    match made.verdict {
        Verdict::Pass if nothing_asked => {
            "Verdict: no acceptance is stated in the job, so there is nothing to judge.".to_string()
        }
        verdict => {
            let sentence = format!(
                "Verdict of the forecast against the acceptance of the job, {}: **{}**.",
                made.forecast.range_words(),
                verdict.word()
            );
            let misses = made.forecast.misses(made.inputs.job.acceptance);
            listed(&sentence, &misses)
        }
    }
}
