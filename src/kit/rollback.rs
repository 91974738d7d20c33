//! Rollback: exactly what was read out of the control, for all that the kit changes.
//!
//! ```text
//!   files read out ─→ Held ─┐
//!   what the kit overwrites ┴→ held? ─ all ──→ rollback files ─→ read back ─→ equal?
//!   what it switches,       │          part ─→ the same, the rest named: by hand
//!   what a precondition     │
//!   changes ────────────────┘
//! ```
//! Nothing is invented, and what acted is not asked: a table that was switched off and a set that
//! was not in use are old values like any other. Where the read-out does not hold every table,
//! point and parameter that the files overwrite, there is no rollback file, and what is missing is
//! named. Zeros are not a rollback.

use super::made::{Made, as_kit_file};
use super::{Inputs, movement};
use crate::control::controller::Role;
use crate::judge::active::Origin;
use crate::judge::before::{Before, Old, Unknown};
use crate::judge::family::family;
use crate::judge::findings::listed;
use crate::kit::findings::{FieldFault, KitFinding};
use crate::read::siemens::{MachineDatum, MachineValue};
use crate::read::{KitFile, ReadBack, read_apart};
use crate::text::problem::Problems;
use crate::write::compensation::Compiled;
use crate::write::emit::{self, Instead, RenderedFile, Switch, Templates};
use crate::write::plan::Plan;

/// What a kit writes for the rollback, and what it leaves to a person.
#[derive(Default)]
pub(super) struct Rollback {
    pub(super) files: Vec<RenderedFile>,
    /// Why there is no file, or what the files do not restore; one sentence each.
    pub(super) not_written: Vec<String>,
    /// What a person does and sees after the files were loaded; one sentence each.
    pub(super) by_hand: Vec<String>,
}

impl Rollback {
    fn none(why: String) -> Rollback {
        Rollback {
            not_written: vec![format!("no rollback file: {why}")],
            ..Rollback::default()
        }
    }

    /// That the files do not restore everything, for text and manifest.
    pub(super) fn note(&self) -> Option<KitFinding> {
        let left = self.not_written.len();
        (!self.files.is_empty() && left > 0).then_some(KitFinding::LeftToAPerson { left })
    }
}

/// Makes the rollback files of a kit.
pub(super) fn make(made: &Made<'_>) -> Result<Rollback, Problems> {
    let inputs = made.inputs;
    let wanted = |role: Role| inputs.profile.files.iter().any(|f| f.role == role);
    if !wanted(Role::Rollback) {
        return Ok(Rollback::default());
    }
    let (active, held) = match inputs.active.as_ref().map(|active| (active, &active.origin)) {
        Some((active, Origin::ReadOut(held))) => (active, held),
        Some((active, Origin::Kit { .. })) => return Ok(Rollback::none(format!(
            "`{}` is a kit, not files that were read out of the control; to roll back, load that kit again to it",
            active.path
        ))),
        Some((_, Origin::NoTables)) | None => return Ok(Rollback::none(
            "`active_while_measuring` names no files that were read out of the control, and zeros do not restore it".to_string(),
        )),
    };
    let before = Before {
        task: inputs.task(),
        plan: &made.plan,
        compiled: &made.compiled,
        active,
        held,
    };
    let old = match family(&inputs.profile.dialect).old(&before) {
        Ok(old) => old,
        Err(missing) => return Ok(Rollback::none(incomplete(&missing))),
    };
    before.written(&old, &made.templates)
}

fn incomplete(missing: &[String]) -> String {
    format!(
        "the files read out of the control do not hold all that this kit overwrites; missing: {}",
        listed(missing)
    )
}

impl Before<'_> {
    /// The files, read back, with what they do not do.
    fn written(&self, old: &Old, templates: &Templates) -> Result<Rollback, Problems> {
        let instead = Instead {
            notice: "ROLLBACK: values as read out of the control before this kit",
            names_terms: false,
            as_read: true,
            switches: old.data.iter().map(switch).collect(),
        };
        let is_own = |file: &crate::control::controller::EmittedFile| file.role == Role::Rollback;
        let files = emit::render_apart(
            self.task,
            templates,
            self.compiled,
            &old.tables,
            &instead,
            is_own,
        )?;
        let read_files: Vec<KitFile<'_>> = files.iter().map(as_kit_file).collect();
        let read = read_apart(self.task.profile, &read_files, Role::Rollback);
        if !read.is_ok_and(|read| is_same(old, &read)) {
            return Ok(Rollback::none("what was read out does not read back from files in the form of this profile; keep the files that were read out".to_string()));
        }
        let unknown = old.unknown.iter();
        let mut by_hand: Vec<String> = unknown.clone().map(Unknown::by_hand).collect();
        by_hand.extend(old.stays.iter().cloned());
        by_hand.extend(movement::way_back(self));
        Ok(Rollback {
            files,
            not_written: unknown.map(Unknown::not_written).collect(),
            by_hand,
        })
    }
}

fn is_same(old: &Old, read: &ReadBack) -> bool {
    let data: Vec<&MachineDatum> = read.machine_data.iter().flat_map(|f| &f.data).collect();
    read.tables == old.tables && read.unwritten.is_empty() && data.iter().copied().eq(&old.data)
}

fn switch(datum: &MachineDatum) -> Switch {
    Switch {
        name: datum.name.clone(),
        indices: datum.indices.join(","),
        value: match &datum.value {
            MachineValue::Number(number) => number.to_string(),
            MachineValue::Text(text) => format!("({text})"),
        },
    }
}

/// Rollback files of a directory against what the job's read-out holds.
pub(super) fn differences(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    files: &[KitFile<'_>],
) -> Result<Option<FieldFault>, Problems> {
    if !files.iter().any(|file| file.role == Role::Rollback) {
        return Ok(None);
    }
    let read = read_apart(&inputs.profile, files, Role::Rollback)?;
    let old = inputs.active.as_ref().and_then(|active| {
        let Origin::ReadOut(held) = &active.origin else {
            return None;
        };
        let before = Before {
            task: inputs.task(),
            plan,
            compiled,
            active,
            held,
        };
        family(&inputs.profile.dialect).old(&before).ok()
    });
    let same = old.is_some_and(|old| is_same(&old, &read));
    Ok((!same).then_some(FieldFault::OtherRollback))
}
