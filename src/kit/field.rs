//! The field kit: sign proofs, rollback and checklist, made and read back (docs/visit.md).
//!
//! ```text
//!   sign_proof ─→ emit ─→ BYTES ─→ read ─→ its control ─→ what a gauge has to show ─┐
//!   read-out   ─→ emit ─→ BYTES ─→ read ─→ equal? ──────────────────────────────────┼→ checklist
//!   control with the real tables ─→ largest movement of each axis (movement) ───────┘
//! ```
//! Above the steps of the checklist stands whether the kit is a rehearsal, doubtful, good enough; behind them what was
//! printed; its lists say what is overwritten, what has to be set, what the display shows.

mod proofs;

use crate::control::checklist::{KitFacts, List, Listed, Paragraph, parts};
use crate::control::claims::{Assumption, Precondition, SeenTo, shared};
use crate::control::controller::{Mechanism, Role};
use crate::judge::conformity::Verdict;
use crate::judge::forecast::Miss;
use crate::kit::findings::FieldFault;
use crate::kit::inputs::{Asked, cannot_emulate};
use crate::kit::made::Made;
use crate::kit::{Inputs, movement, remarks, rollback};
use crate::read::{KitFile, ReadBack, read_apart};
use crate::text::{BLANK, BOX, Finding, Problems, grouped};
use crate::write::compensation::{Compiled, displayed, uses};
use crate::write::emit::{self, RenderedFile, Words};
use crate::write::findings::TableFinding;
use crate::write::sign_proof::sign_proofs;
use proofs::Proofs;
use serde_json::Value;

/// What is written beside the tables of a kit.
pub(super) struct FieldKit {
    pub(super) files: Vec<RenderedFile>,
    /// What each sign proof has to show, for the manifest.
    pub(super) sign_proofs: Vec<Value>,
    /// Mechanisms without a sign proof, and a rollback that is not whole.
    pub(super) notes: Vec<Finding>,
}

/// Makes the field kit; refused unless every file reads back to what was meant.
pub(super) fn make(made: &Made<'_>) -> Result<FieldKit, Problems> {
    let Proofs { shown, mut files, missing } = Proofs::of(made)?;
    let mut not_written = missing.clone();
    let rollback = rollback::make(made)?;
    let notes = missing.into_iter().chain(rollback.note().map(Finding::from)).collect();
    files.extend(rollback.files);
    not_written.extend(rollback.not_written);
    let sign_proofs = shown.iter().map(proofs::document).collect();
    if !made.inputs.profile.files.iter().any(|file| file.role == Role::Checklist) {
        return Ok(FieldKit { files, sign_proofs, notes });
    }
    let movement = movement::switching(made).map_err(|reason| cannot_emulate(&reason))?;
    let (task, compiled) = (made.task(), &made.compiled);
    let lists = |list: List| match list {
        List::Places => places(made),
        List::Preconditions => preconditions(&made.compiled),
        List::Assumptions => assumptions(&made.compiled),
        List::Movement => movement.clone().into(),
        List::SignProofs => proofs::listed(made, &shown),
        List::Display => displayed(task, compiled).into(),
        List::NotWritten => not_written.clone().into(),
        List::WayBack => rollback.by_hand.clone().into(),
        List::Enter => entered(&made.compiled, |p| format!("enter {}", p.value)).into(),
        List::PutBack => entered(&made.compiled, |_| "enter what was found".to_string()).into(),
    };
    let facts = KitFacts {
        files: made.files.iter().chain(&files).map(|file| (file.role, file.path.clone())).collect(),
        reference: task.reference_text(),
        uses: &|mechanism| uses(task, &made.plan, &compiled.tables, mechanism),
        list: &lists,
    };
    let parts = parts(&task.profile.checklist, &facts);
    let misses = misses(made);
    let words = Words { head: head(made, &misses), parts, about: about(made, &misses) };
    files.extend(emit::render_checklist(task, &made.templates, compiled, &words)?);
    Ok(FieldKit { files, sign_proofs, notes })
}

/// How the files of a directory that stand apart differ from those of the job.
pub(super) fn differences(
    asked: &Asked<'_>,
    files: &[KitFile<'_>],
) -> Result<Vec<Finding>, Problems> {
    let inputs = asked.inputs;
    let mut found: Vec<Finding> = Vec::new();
    let proved = proof_files(inputs, files);
    if !proved.is_empty() {
        let wanted = sign_proofs(inputs.task(), &asked.plan, &asked.compiled).proofs;
        for (mechanism, files) in proved {
            let read = read_apart(&inputs.profile, &files, Role::SignProof)?;
            let proof = wanted.iter().find(|p| Some(p.of.mechanism) == mechanism);
            let names: Vec<&str> = files.iter().map(|file| file.path).collect();
            let file = names.join("`, `");
            if proof.is_none_or(|p| p.tables != read.tables) || sets_machine_data(&read) {
                found.push(FieldFault::OtherProof { file: file.clone() }.into());
            }
            found.extend(read.unwritten.iter().map(|parameter| {
                let (file, parameter) = (file.clone(), parameter.clone());
                FieldFault::NotWritten { file, parameter }.into()
            }));
        }
    }
    found.extend(rollback::differences(asked, files)?.map(Finding::from));
    Ok(found)
}

fn sets_machine_data(read: &ReadBack) -> bool {
    read.machine_data.iter().any(|file| !file.data.is_empty())
}

/// The files of each sign proof, which are read together.
fn proof_files<'a>(
    inputs: &Inputs,
    files: &[KitFile<'a>],
) -> Vec<(Option<Mechanism>, Vec<KitFile<'a>>)> {
    let mechanism =
        |file: &KitFile<'_>| inputs.profile.file(file.path).and_then(|own| own.mechanism);
    let own = files.iter().filter(|file| file.role == Role::SignProof);
    grouped(own.map(|file| (mechanism(file), *file)))
}

/// So many figures that miss the acceptance stand above the steps; [`about`] has all.
const MOST: usize = 3;

/// What stands above the steps.
fn head(made: &Made<'_>, misses: &[Miss]) -> Vec<Paragraph> {
    let remarks = &made.inputs.model.remarks;
    let simulated = remarks.simulated().map(|note| format!("**{note}**"));
    let doubts = made.doubts.iter();
    let doubts = doubts.map(|doubt| format!("**INCONSISTENT:** {doubt}"));
    let alone = simulated.chain(doubts).map(|text| Paragraph { text, items: Vec::new() });
    alone.chain([verdict(made, misses)]).collect()
}

/// What was printed when the kit was made, for the person who has only this page; it stands in the annex.
fn about(made: &Made<'_>, misses: &[Miss]) -> Vec<String> {
    let misses = misses.iter().map(ToString::to_string);
    let known = remarks(&made.plan, &made.compiled, Some(&made.forecast));
    misses.chain(known).collect()
}

/// What misses the acceptance, the worst first.
fn misses(made: &Made<'_>) -> Vec<Miss> {
    let mut misses = made.forecast.misses(made.inputs.job.acceptance);
    misses.sort_by(Miss::worst_first);
    misses
}

fn verdict(made: &Made<'_>, misses: &[Miss]) -> Paragraph {
    if made.verdict == Verdict::Pass && made.inputs.job.acceptance.asks_nothing() {
        let text = "Verdict: no acceptance is stated in the job, so there is nothing to judge.";
        return Paragraph { text: text.to_string(), items: Vec::new() };
    }
    let worst = misses.iter().take(MOST).map(ToString::to_string);
    let more = misses.len().saturating_sub(MOST);
    let more = (more > 0).then(|| format!("{more} more: annex"));
    Paragraph {
        text: format!(
            "Verdict of the forecast against the acceptance of the job, {}: **{}**.",
            made.forecast.range_words(),
            made.verdict.word()
        ),
        items: worst.chain(more).collect(),
    }
}

/// Where each term goes: what is overwritten.
fn places(made: &Made<'_>) -> Listed {
    let placements = made.compiled.placements.iter();
    let places = placements.map(|p| format!("{}: {} ({} points)", p.term, p.place, p.points));
    vec![places.collect::<Vec<_>>().join("; ")].into()
}

/// At the step what is overwritten, replaced or moves an axis; in the annex what only has to be compared.
fn preconditions(compiled: &Compiled) -> Listed {
    let list = shared(&compiled.preconditions);
    let of = |when: SeenTo| list.iter().filter(move |(_, p)| p.when == when);
    type Shared<'a> = (String, &'a Precondition);
    let danger = |(what, p): &Shared<'_>| {
        let (value, why) = (&p.value, &p.why);
        format!("**{what} must be {value}**; found: {BLANK} Why: {why}")
    };
    let source = |(what, p): &Shared<'_>| format!("{what}: *{}*", p.source);
    let item =
        |(what, p): &Shared<'_>| format!("{what}: found {BLANK}; {} is entered below", p.value);
    let must = |(what, p): &Shared<'_>| {
        let (value, why, source) = (&p.value, &p.why, &p.source);
        format!("{what} must be {value}; found: {BLANK} Why: {why} *({source})*")
    };
    let why = |(what, p): &Shared<'_>| format!("{what}: {} *({})*", p.why, p.source);
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
    let is_off = |note: &&Finding| matches!(note.kind(), Some(TableFinding::ReferenceOff { .. }));
    compiled.notes.iter().filter(is_off).map(|note| format!("{BOX} {note}"))
}

/// Values that belong to the tables and that no file holds.
fn entered(compiled: &Compiled, how: impl Fn(&Precondition) -> String) -> Vec<String> {
    let list = shared(&compiled.preconditions);
    let list = list.iter().filter(|(_, p)| p.when == SeenTo::Entered);
    list.map(|(what, p)| format!("{what}: {}", how(p))).collect()
}

/// What is assumed of the control and matters for this kit: at the step what has to be decided, with a box each.
fn assumptions(compiled: &Compiled) -> Listed {
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
