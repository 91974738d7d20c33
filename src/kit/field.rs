//! The field kit: sign proofs, rollback and checklist, made and read back (docs/visit.md).
//!
//! ```text
//!   sign_proof ─→ emit ─→ BYTES ─→ read ─→ its control ─→ what a gauge has to show ─┐
//!   read-out   ─→ emit ─→ BYTES ─→ read ─→ equal? ──────────────────────────────────┼→ checklist
//!   control with the real tables ─→ largest movement of each axis ──────────────────┘
//! ```
//! Above the steps of the checklist stands whether the kit is a rehearsal, doubtful, good enough; behind them what was
//! printed; its lists say what is overwritten, what has to be set, what the display shows.

mod proofs;

use crate::control::checklist::{KitFacts, List, ListText, Paragraph, parts};
use crate::control::claims::{Assumption, Precondition, SeenTo, shared};
use crate::control::controller::{KitFile, Mechanism, Role};
use crate::judge::active::Origin;

use crate::judge::conformity::Verdict;
use crate::judge::family::{Before, ChangedBy, Old, family};
use crate::judge::field::{Field, Pair};
use crate::judge::forecast::{self, Miss};
use crate::kit::findings::{FieldFault, InRollback, KitFinding};
use crate::kit::inputs::{Inputs, JobTables, remarks};
use crate::kit::loaded::BareKit;
use crate::quantity::{Axis, Direction, ErrorTerm, Millimetres, PerAxis};
use crate::read::emulate::{Emulated, Emulator, Response};
use crate::read::{ReadBack, emulator, read_apart};
use crate::text::{BLANK, BOX, Finding, Problems, grouped, joined};
use crate::write::compensation::{Compiled, displayed, uses};
use crate::write::emit::{self, FileSource, Words};
use crate::write::findings::TableFinding;
use crate::write::sign_proof::sign_proofs;
pub(super) use proofs::ProofFigures;
use proofs::Proofs;

/// Adds the field kit to a kit, and to its notes the mechanisms without a sign proof and a rollback that is not whole;
/// refused unless every file reads back to what was meant. What each sign proof has to show is for the manifest.
pub(super) fn add(made: &mut BareKit<'_>) -> Result<Vec<ProofFigures>, Problems> {
    let Proofs { shown, files, missing } = Proofs::of(made)?;
    let mut rollback = rollback(made)?;
    let note = rollback.note();
    rollback.not_written.splice(0..0, missing.iter().cloned());
    made.files.extend(files);
    made.files.append(&mut rollback.files);
    if made.inputs.profile.files.iter().any(|file| file.role == Role::Checklist) {
        made.files.extend(checklist(made, &shown, &rollback)?);
    }
    made.compiled.notes.extend(missing.into_iter().chain(note.map(Finding::from)));
    Ok(shown)
}

/// The steps at the machine, as pages.
fn checklist(
    made: &BareKit<'_>,
    shown: &[ProofFigures],
    rollback: &Rollback,
) -> Result<Vec<KitFile>, Problems> {
    let movement = switching(made)?;
    let (task, compiled) = (made.task(), &made.compiled);
    let lists = |list: List| match list {
        List::Places => places(made),
        List::Preconditions => preconditions(&made.compiled),
        List::Assumptions => assumptions(&made.compiled),
        List::Movement => movement.clone().into(),
        List::SignProofs => proofs::listed(made, shown),
        List::TypedBump => task
            .profile
            .typed()
            .map(|of| of.value.value.bump())
            .into_iter()
            .collect::<Vec<_>>()
            .into(),
        List::Display => displayed(task, compiled).into(),
        List::NotWritten => rollback.not_written.clone().into(),
        List::WayBack => rollback.by_hand.clone().into(),
        List::Enter => entered(&made.compiled, |p| format!("enter {}", p.value)).into(),
        List::PutBack => entered(&made.compiled, |_| "enter what was found".to_string()).into(),
    };
    let facts = KitFacts {
        files: made.files.iter().map(|file| (file.role, file.path.clone())).collect(),
        reference: task.reference_text(),
        uses: &|mechanism| uses(task, &made.plan, &compiled.tables, mechanism),
        list: &lists,
    };
    let parts = parts(&task.profile.checklist, &facts);
    let misses = misses(made);
    let words = Words { head: head(made, &misses), parts, about: about(made, &misses) };
    emit::render_checklist(task, compiled, &words)
}

/// How the files of a directory that stand apart differ from those of the job.
pub(super) fn differences(
    asked: &JobTables<'_>,
    files: &[KitFile],
) -> Result<Vec<Finding>, Problems> {
    let inputs = asked.inputs;
    let mut found: Vec<Finding> = Vec::new();
    let proved = proof_files(inputs, files);
    if !proved.is_empty() {
        let wanted = sign_proofs(inputs.task(), &asked.plan, &asked.compiled).proofs;
        for (mechanism, files) in proved {
            let proof = wanted.iter().find(|p| Some(p.of.mechanism) == mechanism);
            let own = proof.map(|proof| proofs::files_of(inputs.task(), &asked.compiled, proof));
            let mut lacking = own.transpose()?.unwrap_or_default();
            lacking
                .retain(|own| !files.iter().any(|file| file.path.eq_ignore_ascii_case(&own.path)));
            let named =
                |files: &[KitFile]| joined(files.iter().map(|file| format!("`{}`", file.path)));
            let file = named(&files);
            if !lacking.is_empty() {
                let lacking = named(&lacking);
                found.push(FieldFault::PartOfProof { file: file.clone(), lacking }.into());
            }
            let read = read_apart(&inputs.profile, &[files, lacking].concat(), Role::SignProof)?;
            let sets_data = read.machine_data.iter().any(|file| !file.data.is_empty());
            if sets_data || proof.is_none_or(|p| p.tables != read.tables) {
                found.push(FieldFault::OtherProof { file: file.clone() }.into());
            }
            found.extend(read.unwritten.iter().map(|parameter| {
                let (file, parameter) = (file.clone(), parameter.clone());
                FieldFault::NotWritten { file, parameter }.into()
            }));
        }
    }
    found.extend(rollback_differs(asked, files)?.map(Finding::from));
    Ok(found)
}

/// The files of each sign proof, which are read together.
fn proof_files(inputs: &Inputs, files: &[KitFile]) -> Vec<(Option<Mechanism>, Vec<KitFile>)> {
    let mechanism = |file: &KitFile| inputs.profile.file(&file.path).and_then(|own| own.mechanism);
    let own = files.iter().filter(|file| file.role == Role::SignProof);
    grouped(own.map(|file| (mechanism(file), file.clone())))
}

/// So many figures that miss the acceptance stand above the steps; [`about`] has all.
const MOST: usize = 3;

/// What stands above the steps.
fn head(made: &BareKit<'_>, misses: &[Miss]) -> Vec<Paragraph> {
    let remarks = &made.inputs.model.remarks;
    let simulated = remarks.simulated().map(|note| format!("**{note}**"));
    let doubts = made.doubts.iter().map(|doubt| format!("**INCONSISTENT:** {doubt}"));
    let alone = simulated.chain(doubts).map(|text| Paragraph { text, items: Vec::new() });
    alone.chain([verdict(made, misses)]).collect()
}

/// What was printed when the kit was made, for the person who has only this page; it stands in the annex.
fn about(made: &BareKit<'_>, misses: &[Miss]) -> Vec<String> {
    let misses = misses.iter().map(ToString::to_string);
    misses.chain(remarks(&made.plan, &made.compiled, Some(&made.forecast))).collect()
}

/// What misses the acceptance, the worst first.
fn misses(made: &BareKit<'_>) -> Vec<Miss> {
    let mut misses = made.forecast.misses(made.inputs.job.acceptance);
    misses.sort_by(Miss::worst_first);
    misses
}

fn verdict(made: &BareKit<'_>, misses: &[Miss]) -> Paragraph {
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
            forecast::words(&made.forecast.ranges),
            made.verdict.word()
        ),
        items: worst.chain(more).collect(),
    }
}

/// Largest movement of each physical axis when the tables are switched, all base axes at their
/// worst place: a bound, not a place. Backlash parameters are not switched with the tables, but what a
/// table holds for one direction is (3627 on Fanuc).
fn switching(made: &BareKit<'_>) -> Emulated<Vec<String>> {
    let (names, tables) = (&made.plan.names, &made.plan.tables);
    let mut state = made.compiled.state.clone();
    state.axes.iter_mut().for_each(|axis| axis.backlash_um = 0.0);
    let control = emulator(&made.inputs.profile, &made.compiled.tables, &state)?;
    let has_table = |term: ErrorTerm| tables.iter().any(|table| table.term == term);
    let field = Field::of(names, control.as_ref(), has_table)?;
    let axes = &made.inputs.job.machine.axes;
    let references = PerAxis::from_fn(|axis| axes[axis].map(|own| own.reference));
    let zeros = PerAxis::from_fn(|axis| references[axis].map_or(0.0, Millimetres::mm));
    let line = |of: Axis| {
        let (mut anywhere, mut at_reference) = (0.0, 0.0);
        for along in Axis::ALL {
            let term = ErrorTerm { of, along };
            let ways = Direction::BOTH.into_iter().filter(|_| has_table(term));
            let ways = ways.flat_map(|direction| field.ways(term, direction));
            let ends = ways.map(|way| extremes(way, references[along]));
            let (largest, there) =
                ends.fold((0.0, 0.0), |all, of| (f64::max(all.0, of.0), f64::max(all.1, of.1)));
            anywhere += largest;
            at_reference += there;
        }
        let swing = |at: Option<PerAxis<f64>>| {
            names[of].iter().map(|name| control.swing(name, at).abs()).fold(0.0, f64::max)
        };
        anywhere += swing(None);
        at_reference += swing(Some(zeros));
        format!(
            "{}: at most {at_reference:.3} µm at the reference point, up to {anywhere:.1} µm elsewhere",
            made.axes(of)
        )
    };
    let moved = Axis::ALL.into_iter().filter(|axis| tables.iter().any(|t| t.term.of == *axis));
    Ok(moved.map(line).collect())
}

/// Largest |correction| at the nodes of all tables, between which it is no larger, and at the
/// reference.
fn extremes(response: &Response, reference: Option<Millimetres>) -> (f64, f64) {
    let at = |place: Millimetres| response.correction(place).um().abs();
    let there = reference.map_or(0.0, at);
    let nodes = response.tables().iter().flat_map(|table| table.nodes());
    (nodes.map(|(place, _)| at(place)).fold(there, f64::max), there)
}

/// Where each term goes: what is overwritten.
fn places(made: &BareKit<'_>) -> ListText {
    let placements = made.compiled.placements.iter();
    let places = placements.map(|p| format!("{}: {} ({} points)", p.term, p.place, p.points));
    vec![places.collect::<Vec<_>>().join("; ")].into()
}

/// At the step what is overwritten, replaced or moves an axis; in the annex what only has to be compared.
fn preconditions(compiled: &Compiled) -> ListText {
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
    let items = of(SeenTo::Danger).map(danger).chain(boxed).chain(of(SeenTo::Entered).map(item));
    let notes = of(SeenTo::Before).map(must);
    let notes = notes.chain(of(SeenTo::Danger).chain(of(SeenTo::Boxed)).map(source));
    ListText {
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
fn assumptions(compiled: &Compiled) -> ListText {
    let list = compiled.assumptions.iter().filter(|a| a.without_effect.is_none());
    let (open, known): (Vec<&Assumption>, Vec<&Assumption>) = list.partition(|a| a.to_decide);
    let decide =
        |a: &&Assumption| format!("{BOX} **DECIDE,** assumed: {}; found: {BLANK}", a.words());
    ListText {
        items: open.iter().map(decide).collect(),
        notes: known.iter().map(|a| a.words()).collect(),
    }
}

// Rollback: exactly what was read out of the control, for all that the kit changes.
//
// ```text
//   files read out ─→ held ─┐
//   what the kit overwrites ┴→ held? ─ all ──→ rollback files ─→ read back ─→ equal?
//   what it switches,       │          part ─→ the same, the rest named: by hand
//   what a precondition     │
//   changes ────────────────┘
// ```
// Nothing is invented, and what acted is not asked: a table that was switched off and a set that
// was not in use are old values like any other. Where the read-out does not hold every table,
// point and parameter that the files overwrite, there is no rollback file, and what is missing is
// named. Zeros are not a rollback.

/// What a kit writes for the rollback, and what it leaves to a person.
#[derive(Default)]
struct Rollback {
    files: Vec<KitFile>,
    /// Why there is no file, or what the files do not restore.
    not_written: Vec<Finding>,
    /// What a person does and sees after the files were loaded.
    by_hand: Vec<Finding>,
}

impl Rollback {
    fn none(why: InRollback) -> Rollback {
        Rollback { not_written: vec![why.into()], ..Rollback::default() }
    }

    /// That the files do not restore everything, for text and manifest.
    fn note(&self) -> Option<KitFinding> {
        let left = self.not_written.len();
        (!self.files.is_empty() && left > 0).then_some(KitFinding::LeftToAPerson { left })
    }
}

/// Makes the rollback files of a kit.
fn rollback(made: &BareKit<'_>) -> Result<Rollback, Problems> {
    let inputs = made.inputs;
    let wanted = |role: Role| inputs.profile.files.iter().any(|f| f.role == role);
    if !wanted(Role::Rollback) {
        return Ok(Rollback::default());
    }
    let (task, active) = (inputs.task(), inputs.active.as_ref());
    let before = active.and_then(|active| Before::of(task, &made.plan, &made.compiled, active));
    let Some(before) = before else {
        return Ok(Rollback::none(match active.map(|active| (active, &active.origin)) {
            Some((active, Origin::Kit { .. })) => InRollback::OfAKit { path: active.path.clone() },
            _ => InRollback::NothingReadOut,
        }));
    };
    let old = match family(&inputs.profile.dialect).old(&before) {
        Ok(old) => old,
        Err(missing) => return Ok(Rollback::none(InRollback::Incomplete { missing })),
    };
    before.written(&old)
}

impl Before<'_> {
    /// The files, read back, with what they do not do.
    fn written(&self, old: &Old) -> Result<Rollback, Problems> {
        let emitted = FileSource {
            tables: &old.tables,
            placements: &[],
            notice: Some("ROLLBACK: values as read out of the control before this kit"),
            as_read: true,
            ..FileSource::of_kit(self.task, self.compiled)
        };
        let files = emit::render_those(&emitted, |file| file.role == Role::Rollback)?;
        let read = read_apart(self.task.profile, &files, Role::Rollback);
        if !read.is_ok_and(|read| is_same(old, &read)) {
            return Ok(Rollback::none(InRollback::OtherForm));
        }
        let unknown = old.unknown.iter().map(|(what, by)| (what.clone(), *by == ChangedBy::File));
        let look = unknown.clone().map(|(what, by_file)| InRollback::Look { what, by_file });
        let by_hand = unknown.map(|(what, by_file)| InRollback::BringBack { what, by_file });
        let stays = old.stays.iter().cloned().map(|table| InRollback::Stays { table });
        let by_hand = by_hand.chain(stays).chain(way_back(self));
        Ok(Rollback {
            files,
            not_written: look.map(Finding::from).collect(),
            by_hand: by_hand.map(Finding::from).collect(),
        })
    }
}

fn is_same(old: &Old, read: &ReadBack) -> bool {
    read.tables == old.tables && read.unwritten.is_empty()
}

/// Movements below it are none, µm.
const NOTHING_UM: f64 = 1e-3;

/// Each physical axis that the old tables hold off zero at the reference point.
///
/// unit   µm, with the side it moves to · limits all axes at the reference point; the tables that
///        acted, not those that were switched off
fn way_back(before: &Before<'_>) -> Vec<InRollback> {
    let (profile, active) = (before.task.profile, before.active);
    let moved = emulator(profile, &active.tables, &active.state)
        .and_then(|control| moved(before, control.as_ref()));
    moved.unwrap_or_else(|reason| vec![InRollback::MovementUnknown { reason: reason.0 }])
}

fn moved(before: &Before<'_>, control: &dyn Emulator) -> Emulated<Vec<InRollback>> {
    let (names, axes) = (&before.plan.names, &before.task.job.machine.axes);
    let field = Field::of(names, control, |term| axes[term.along].is_some())?;
    // What an axis adds to another at its reference, having come from the reference return.
    let added = |(term, pair): (ErrorTerm, &Pair)| {
        let machine = axes[term.along].as_ref()?;
        let tables = pair.way(machine.homing()).tables().iter();
        Some(tables.map(|table| table.correction(machine.reference).um()).sum::<f64>())
    };
    let moved = Axis::ALL.into_iter().flat_map(|of| names[of].iter().map(move |name| (of, name)));
    let moved = moved.filter_map(|(axis, name)| {
        let own = field.pairs().filter(|(term, pair)| term.of == axis && pair.output == *name);
        let um: f64 = own.filter_map(added).sum();
        (um.abs() > NOTHING_UM).then(|| InRollback::MovesAtReference {
            axis,
            name: name.clone(),
            um,
        })
    });
    Ok(moved.collect())
}

/// Rollback files of a directory against what the job's read-out holds.
fn rollback_differs(
    asked: &JobTables<'_>,
    files: &[KitFile],
) -> Result<Option<FieldFault>, Problems> {
    let JobTables { inputs, plan, compiled } = asked;
    if !files.iter().any(|file| file.role == Role::Rollback) {
        return Ok(None);
    }
    let read = read_apart(&inputs.profile, files, Role::Rollback)?;
    let active = inputs.active.as_ref();
    let before = active.and_then(|active| Before::of(inputs.task(), plan, compiled, active));
    let old = before.and_then(|before| family(&inputs.profile.dialect).old(&before).ok());
    let same = old.is_some_and(|old| is_same(&old, &read));
    Ok((!same).then_some(FieldFault::OtherRollback))
}
