//! A checklist: what stands above its steps (whether the kit is a rehearsal, doubtful, good enough), what stands
//! behind them, and its lists: what is overwritten, what has to be set, what the display shows.

use crate::control::checklist::{Listed, Paragraph};
use crate::control::claims::{Assumption, Precondition, SeenTo, shared};
use crate::judge::conformity::Verdict;
use crate::judge::forecast::Miss;
use crate::kit::made::Made;
use crate::kit::remarks;
use crate::text::html::{BLANK, BOX};
use crate::write::compensation::Compiled;
use crate::write::findings::TableFinding;

/// So many figures that miss the acceptance stand above the steps; [`about`] has all.
const MOST: usize = 3;

/// What stands above the steps.
pub(super) fn head(made: &Made<'_>, misses: &[Miss]) -> Vec<Paragraph> {
    let remarks = &made.inputs.model.remarks;
    let simulated = remarks.simulated().map(|note| format!("**{note}**"));
    let doubts = made.doubts.iter();
    let doubts = doubts.map(|doubt| format!("**DOUBTFUL:** {doubt}"));
    simulated
        .chain(doubts)
        .map(|text| paragraph(text, Vec::new()))
        .chain([verdict(made, misses)])
        .collect()
}

/// What was printed when the kit was made, for the person who has only this page; it stands in the annex.
pub(super) fn about(made: &Made<'_>, misses: &[Miss]) -> Vec<String> {
    let misses = misses.iter().map(ToString::to_string);
    let known = remarks(&made.plan, &made.compiled, Some(&made.forecast));
    misses.chain(known).collect()
}

/// What misses the acceptance, the worst first.
pub(super) fn misses(made: &Made<'_>) -> Vec<Miss> {
    let mut misses = made.forecast.misses(made.inputs.job.acceptance);
    misses.sort_by(Miss::worst_first);
    misses
}

fn paragraph(text: impl Into<String>, items: Vec<String>) -> Paragraph {
    let text = text.into();
    Paragraph { text, items }
}

fn verdict(made: &Made<'_>, misses: &[Miss]) -> Paragraph {
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
            let worst = misses.iter().take(MOST).map(ToString::to_string);
            let more = misses.len().saturating_sub(MOST);
            let more = (more > 0).then(|| format!("{more} more: annex"));
            paragraph(sentence, worst.chain(more).collect())
        }
    }
}

/// Where each term goes: what is overwritten.
pub(super) fn places(made: &Made<'_>) -> Listed {
    let placements = made.compiled.placements.iter();
    let places: Vec<String> =
        placements.map(|p| format!("{}: {} ({} points)", p.term, p.place, p.points)).collect();
    vec![places.join("; ")].into()
}

/// At the step what is overwritten, replaced or moves an axis; in the annex what only has to be compared.
pub(super) fn preconditions(compiled: &Compiled) -> Listed {
    let list = shared(&compiled.preconditions);
    let of = |when: SeenTo| list.iter().filter(move |(_, p)| p.when == when);
    let danger = |(what, p): &(String, &Precondition)| {
        let (value, why) = (&p.value, &p.why);
        format!("**{what} must be {value}**; found: {BLANK} Why: {why}")
    };
    let source = |(what, p): &(String, &Precondition)| format!("{what}: *{}*", p.source);
    let item = |(what, p): &(String, &Precondition)| {
        format!("{what}: found {BLANK}; {} is entered below", p.value)
    };
    let must = |(what, p): &(String, &Precondition)| {
        let (value, why, source) = (&p.value, &p.why, &p.source);
        format!("{what} must be {value}; found: {BLANK} Why: {why} *({source})*")
    };
    let why = |(what, p): &(String, &Precondition)| format!("{what}: {} *({})*", p.why, p.source);
    let boxed = of(SeenTo::Boxed).map(|own| format!("{BOX} {}", danger(own)));
    let items = of(SeenTo::Danger).map(danger).chain(boxed);
    let items = items.chain(of(SeenTo::Entered).map(item));
    let notes = of(SeenTo::Before).map(must);
    let notes = notes.chain(of(SeenTo::Danger).chain(of(SeenTo::Boxed)).map(source));
    Listed {
        items: items.chain(references_off(compiled)).collect(),
        notes: notes.chain(of(SeenTo::Entered).map(why)).collect(),
    }
}

/// Reference points outside the travel: if one is elsewhere, switching a table on moves axes.
fn references_off(compiled: &Compiled) -> impl Iterator<Item = String> {
    let off = compiled
        .notes
        .iter()
        .filter(|note| matches!(note.kind(), Some(TableFinding::ReferenceOff { .. })));
    off.map(|note| format!("{BOX} {note}"))
}

/// Values that belong to the tables and that no file holds.
pub(super) fn entered(compiled: &Compiled, how: impl Fn(&Precondition) -> String) -> Vec<String> {
    let list = shared(&compiled.preconditions);
    let list = list.iter().filter(|(_, p)| p.when == SeenTo::Entered);
    list.map(|(what, p)| format!("{what}: {}", how(p))).collect()
}

/// What is assumed of the control and matters for this kit: at the step what has to be decided, with a box each.
pub(super) fn assumptions(compiled: &Compiled) -> Listed {
    let list = compiled.assumptions.iter();
    let list = list.filter(|a| a.without_effect.is_none());
    let (open, known): (Vec<&Assumption>, Vec<&Assumption>) = list.partition(|a| a.to_decide);
    let decide =
        |a: &&Assumption| format!("{BOX} **DECIDE,** assumed: {}; found: {BLANK}", a.words());
    Listed {
        items: open.iter().map(decide).collect(),
        notes: known.iter().map(|a| a.words()).collect(),
    }
}
