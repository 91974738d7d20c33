//! A checklist: what stands above its steps (whether the kit is a rehearsal, doubtful, good enough), and its
//! lists: what is overwritten, what has to be set, what the display shows.

use crate::control::checklist::{Listed, Paragraph};
use crate::control::claims::{Precondition, SeenTo, shared};
use crate::judge::conformity::Verdict;
use crate::kit::made::Made;
use crate::kit::remarks;
use crate::text::html::BLANK;
use crate::write::compensation::Compiled;

/// What stands above the steps.
pub(super) fn head(made: &Made<'_>) -> Vec<Paragraph> {
    let remarks = &made.inputs.model.remarks;
    let simulated = remarks.simulated().map(|note| format!("**{note}**"));
    let doubts = made.doubts.iter();
    let doubts = doubts.map(|doubt| format!("**DOUBTFUL:** {doubt}"));
    simulated
        .chain(doubts)
        .map(|text| paragraph(text, Vec::new()))
        .chain([verdict(made)])
        .chain(known(made))
        .collect()
}

/// What was printed when the kit was made, for the person who has only this page.
fn known(made: &Made<'_>) -> Option<Paragraph> {
    let known = remarks(&made.plan, &made.compiled, Some(&made.forecast));
    (!known.is_empty()).then(|| paragraph("About these tables:", known))
}

fn paragraph(text: impl Into<String>, items: Vec<String>) -> Paragraph {
    let text = text.into();
    Paragraph { text, items }
}

fn verdict(made: &Made<'_>) -> Paragraph {
    let nothing_asked = made.inputs.job.acceptance.asks_nothing();
    match made.verdict {
        Verdict::Pass if nothing_asked => {
            let sentence =
                "Verdict: no acceptance is stated in the job, so there is nothing to judge.";
            paragraph(sentence, Vec::new())
        }
        verdict => {
            let sentence = format!(
                "Verdict of the forecast against the acceptance of the job, {}: **{}**.",
                made.forecast.range_words(),
                verdict.word()
            );
            let misses = made.forecast.misses(made.inputs.job.acceptance);
            paragraph(sentence, misses.iter().map(ToString::to_string).collect())
        }
    }
}

/// Where each term goes: what is overwritten.
pub(super) fn places(made: &Made<'_>) -> Listed {
    let placements = made.compiled.placements.iter();
    let places: Vec<String> = placements
        .map(|p| format!("{}: {} ({} points)", p.term, p.place, p.points))
        .collect();
    vec![places.join("; ")].into()
}

pub(super) fn preconditions(compiled: &Compiled) -> Listed {
    let mut list = shared(&compiled.preconditions);
    list.retain(|(_, p)| p.when != SeenTo::After);
    let item = |(what, p): &(String, &Precondition)| match p.when {
        SeenTo::Entered => format!("{what}: found {BLANK}; {} is entered below", p.value),
        _ => format!("{what} must be {}; found: {BLANK}", p.value),
    };
    let note = |(what, p): &(String, &Precondition)| format!("{what}: {} *({})*", p.why, p.source);
    Listed {
        items: list.iter().map(item).collect(),
        notes: list.iter().map(note).collect(),
    }
}

/// Values that belong to the tables and that no file holds.
pub(super) fn entered(compiled: &Compiled, how: impl Fn(&Precondition) -> String) -> Vec<String> {
    let list = shared(&compiled.preconditions);
    let list = list.iter().filter(|(_, p)| p.when == SeenTo::Entered);
    list.map(|(what, p)| format!("{what}: {}", how(p)))
        .collect()
}

/// What is assumed of the control and matters for this kit.
pub(super) fn assumptions(compiled: &Compiled) -> Listed {
    let list = compiled.assumptions.iter();
    let list = list.filter(|a| a.without_effect.is_none());
    Listed {
        items: Vec::new(),
        notes: list
            .map(|a| format!("{} = {}; if wrong: {}", a.fact, a.value, a.consequence))
            .collect(),
    }
}
