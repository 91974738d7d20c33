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

use super::inputs::Asked;
use super::made::{Made, as_read};
use super::movement;
use crate::control::controller::Role;
use crate::judge::active::Origin;
use crate::judge::before::{Before, ChangedBy, Old};
use crate::judge::family::family;
use crate::kit::findings::{FieldFault, InRollback, KitFinding};
use crate::read::siemens::{MachineDatum, MachineValue};
use crate::read::{KitFile, ReadBack, read_apart};
use crate::text::{Finding, Problems};
use crate::write::emit::{self, Emitted, RenderedFile, Switch, Templates};

/// What a kit writes for the rollback, and what it leaves to a person.
#[derive(Default)]
pub(super) struct Rollback {
    pub(super) files: Vec<RenderedFile>,
    /// Why there is no file, or what the files do not restore.
    pub(super) not_written: Vec<Finding>,
    /// What a person does and sees after the files were loaded.
    pub(super) by_hand: Vec<Finding>,
}

impl Rollback {
    fn none(why: InRollback) -> Rollback {
        Rollback { not_written: vec![why.into()], ..Rollback::default() }
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
    before.written(&old, &made.templates)
}

impl Before<'_> {
    /// The files, read back, with what they do not do.
    fn written(&self, old: &Old, templates: &Templates) -> Result<Rollback, Problems> {
        let emitted = Emitted {
            tables: &old.tables,
            placements: &[],
            notice: Some("ROLLBACK: values as read out of the control before this kit"),
            as_read: true,
            switches: old.data.iter().map(switch).collect(),
            ..Emitted::of_kit(self.task, self.compiled)
        };
        let files = emit::render_those(templates, &emitted, |file| file.role == Role::Rollback)?;
        let read = read_apart(self.task.profile, &as_read(&files), Role::Rollback);
        if !read.is_ok_and(|read| is_same(old, &read)) {
            return Ok(Rollback::none(InRollback::OtherForm));
        }
        let unknown = old.unknown.iter();
        let unknown = unknown.map(|of| (of.what.clone(), of.by == ChangedBy::File));
        let look = unknown.clone();
        let look = look.map(|(what, by_file)| InRollback::Look { what, by_file });
        let by_hand = unknown.map(|(what, by_file)| InRollback::BringBack { what, by_file });
        let stays = old.stays.iter().cloned();
        let stays = stays.map(|table| InRollback::Stays { table });
        let by_hand = by_hand.chain(stays).chain(movement::way_back(self));
        Ok(Rollback {
            files,
            not_written: look.map(Finding::from).collect(),
            by_hand: by_hand.map(Finding::from).collect(),
        })
    }
}

fn is_same(old: &Old, read: &ReadBack) -> bool {
    let data: Vec<&MachineDatum> = read.machine_data.iter().flat_map(|f| &f.data).collect();
    read.tables == old.tables && read.unwritten.is_empty() && data.iter().copied().eq(&old.data)
}

fn switch(datum: &MachineDatum) -> Switch {
    let (name, indices) = datum.variable.split_once('[').unwrap_or((&*datum.variable, ""));
    Switch {
        name: name.trim_start_matches('$').to_string(),
        indices: indices.trim_end_matches(']').to_string(),
        value: match &datum.value {
            MachineValue::Number(number) => number.to_string(),
            MachineValue::Text(text) => format!("({text})"),
        },
    }
}

/// Rollback files of a directory against what the job's read-out holds.
pub(super) fn differences(
    asked: &Asked<'_>,
    files: &[KitFile<'_>],
) -> Result<Option<FieldFault>, Problems> {
    let Asked { inputs, plan, compiled } = asked;
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
