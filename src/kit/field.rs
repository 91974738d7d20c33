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
use crate::kit::inputs::{Asked, cannot_emulate};
use crate::read::{KitFile, ReadBack, read_apart};
use crate::text::finding::Finding;
use crate::text::problem::Problems;
use crate::write::compensation::{displayed, uses};
use crate::write::emit::{self, RenderedFile};
use crate::write::sign_proof::sign_proofs;
use proofs::Proofs;
use serde_json::{Value, json};

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
        files: made.files.iter().chain(&files).map(|file| (file.role, file.path.clone())).collect(),
        reference: task.reference_text(),
        uses: &|mechanism| uses(task, &made.plan, &compiled.tables, mechanism),
        list: &lists,
    };
    let parts = parts(&task.profile.checklist, &facts);
    let sign_proofs = shown.iter().map(proofs::document).collect();
    let misses = lists::misses(made);
    files.extend(emit::render_checklist(
        task,
        &made.templates,
        compiled,
        json!({ "head": lists::head(made, &misses), "parts": parts, "about": lists::about(made, &misses) }),
    )?);
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
            let unwritten = read.unwritten.iter().cloned().map(|parameter| {
                let file = file.clone();
                FieldFault::NotWritten { file, parameter }.into()
            });
            let unwritten: Vec<Finding> = unwritten.collect();
            if proof.is_none_or(|p| p.tables != read.tables) || sets_machine_data(&read) {
                found.push(FieldFault::OtherProof { file }.into());
            }
            found.extend(unwritten);
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
    let mechanism_of = |path: &str| {
        let mut known = inputs.profile.files.iter();
        known.find(|file| file.is_called(path))?.mechanism
    };
    let mut proofs: Vec<(Option<Mechanism>, Vec<KitFile<'a>>)> = Vec::new();
    for file in files.iter().filter(|file| file.role == Role::SignProof) {
        let mechanism = mechanism_of(file.path);
        match proofs.iter_mut().find(|(own, _)| *own == mechanism) {
            Some((_, own)) => own.push(*file),
            None => proofs.push((mechanism, vec![*file])),
        }
    }
    proofs
}
