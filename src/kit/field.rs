//! The field kit: sign proofs, rollback and checklist, made and read back (docs/field-kit.md).
//!
//! ```text
//!   sign_proof ─→ emit ─→ BYTES ─→ read ─→ its control ─→ what a gauge has to show ─┐
//!   read-out   ─→ emit ─→ BYTES ─→ read ─→ equal? ──────────────────────────────────┼→ checklist
//!   control with the real tables ─→ largest movement of each axis (movement) ───────┘
//! ```

mod lists;
mod proofs;
mod reading;

use super::made::Made;
use super::{Inputs, movement, rollback};
use crate::control::checklist::{KitFacts, List, parts};
use crate::control::controller::{Mechanism, Role};
use crate::kit::findings::FieldFault;
use crate::kit::inputs::cannot_emulate;
use crate::read::{KitFile, ReadBack, read_apart};
use crate::text::finding::Finding;
use crate::text::problem::Problems;
use crate::write::compensation::{Compiled, displayed, uses};
use crate::write::emit::{self, RenderedFile};
use crate::write::plan::Plan;
use crate::write::sign_proof::{SignProof, sign_proofs};
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
    let proofs = Proofs::write(made)?;
    let shown = proofs.shown(made)?;
    let mut files = proofs.files;
    let mut not_written = proofs.missing.clone();
    let rollback = rollback::make(made)?;
    let left = rollback.note().map(Finding::from);
    let notes = proofs.missing.into_iter().chain(left).collect();
    files.extend(rollback.files);
    not_written.extend(rollback.not_written);
    let movement = movement::switching(made).map_err(|reason| cannot_emulate(&reason))?;
    let (task, compiled) = (made.task(), &made.compiled);
    let lists = |list: List| match list {
        List::Places => lists::places(made),
        List::Preconditions => lists::preconditions(&made.compiled),
        List::Assumptions => lists::assumptions(&made.compiled),
        List::Movement => movement.clone().into(),
        List::SignProofs => reading::listed(made, &shown),
        List::Display => displayed(task, compiled, &made.read.tables).into(),
        List::NotWritten => not_written.clone().into(),
        List::WayBack => rollback.by_hand.clone().into(),
        List::Enter => lists::entered(&made.compiled, |p| format!("enter {}", p.value)).into(),
        List::PutBack => {
            lists::entered(&made.compiled, |_| "enter what was found".to_string()).into()
        }
    };
    let facts = KitFacts {
        files: made
            .files
            .iter()
            .chain(&files)
            .map(|file| (file.role, file.path.clone()))
            .collect(),
        reference: task.reference_text(),
        uses: &|mechanism| uses(task, &made.plan, &compiled.tables, mechanism),
        list: &lists,
    };
    let parts = parts(&task.profile.checklist, &facts);
    let sign_proofs = shown.iter().map(proofs::document).collect();
    files.extend(emit::render_checklist(
        task,
        &made.templates,
        &made.context,
        &lists::head(made),
        &parts,
    )?);
    Ok(FieldKit {
        files,
        sign_proofs,
        notes,
    })
}

/// How the files of a directory that stand apart differ from those of the job.
pub(super) fn differences(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    files: &[KitFile<'_>],
) -> Result<Vec<Finding>, Problems> {
    let mut found: Vec<Finding> = Vec::new();
    if files.iter().any(|file| file.role == Role::SignProof) {
        let wanted = sign_proofs(inputs.task(), plan, compiled).proofs;
        for file in files.iter().filter(|file| file.role == Role::SignProof) {
            let read = read_apart(&inputs.profile, &[*file], Role::SignProof)?;
            let proof = proof_of(inputs, &wanted, file.path);
            if proof.is_none_or(|p| p.tables != read.tables) || sets_machine_data(&read) {
                let file = file.path.to_string();
                found.push(FieldFault::OtherProof { file }.into());
            }
            let unwritten = read.unwritten.into_iter();
            found.extend(unwritten.map(|parameter| {
                let file = file.path.to_string();
                FieldFault::NotWritten { file, parameter }.into()
            }));
        }
    }
    found.extend(rollback::differences(inputs, plan, compiled, files)?.map(Finding::from));
    Ok(found)
}

fn sets_machine_data(read: &ReadBack) -> bool {
    read.machine_data.iter().any(|file| !file.data.is_empty())
}

fn proof_of<'a>(inputs: &Inputs, proofs: &'a [SignProof], path: &str) -> Option<&'a SignProof> {
    let mut files = inputs.profile.files.iter();
    let known = files.find(|file| file.path.eq_ignore_ascii_case(path))?;
    let mechanism: Mechanism = known.mechanism?;
    proofs.iter().find(|proof| proof.of.mechanism == mechanism)
}
