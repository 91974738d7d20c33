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

use crate::control::controller::Role;
use crate::judge::active::Origin;
use crate::judge::before::{Before, ChangedBy, Old};
use crate::judge::family::family;
use crate::judge::field::{Field, Pair};
use crate::kit::findings::{FieldFault, InRollback, KitFinding};
use crate::kit::inputs::Asked;
use crate::kit::made::{Made, as_kit_file};
use crate::quantity::{Axis, Direction, ErrorTerm, Millimetres, PerAxis};
use crate::read::emulate::{Emulated, Emulator, Response};
use crate::read::siemens::{MachineDatum, MachineValue};
use crate::read::{KitFile, ReadBack, emulator, read_apart};
use crate::text::{Finding, Problems};
use crate::write::emit;
use crate::write::emit::{Emitted, Instead, RenderedFile, Switch, Templates};

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
        let instead = Instead {
            notice: "ROLLBACK: values as read out of the control before this kit",
            names_terms: false,
            as_read: true,
            switches: old.data.iter().map(switch).collect(),
        };
        let emitted = Emitted {
            task: self.task,
            compiled: self.compiled,
            tables: &old.tables,
            instead: &instead,
        };
        let files = emit::render_those(templates, &emitted, |file| file.role == Role::Rollback)?;
        let read_files: Vec<KitFile<'_>> = files.iter().map(as_kit_file).collect();
        let read = read_apart(self.task.profile, &read_files, Role::Rollback);
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
        let by_hand = by_hand.chain(stays).chain(way_back(self));
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

// How the axes move: when the tables of a kit are switched, and at the reference point when the old ones
// act again.

/// Largest movement of each physical axis when the tables are switched, all base axes at their
/// worst place: a bound, not a place. Backlash parameters are not switched with the tables, but what a
/// table holds for one direction is (3627 on Fanuc).
pub(super) fn switching(made: &Made<'_>) -> Emulated<Vec<String>> {
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
    let largest = nodes.map(|(place, _)| at(place)).fold(there, f64::max);
    (largest, there)
}

/// Movements below it are none, µm.
const NOTHING_UM: f64 = 1e-3;

/// Each physical axis that the old tables hold off zero at the reference point.
///
/// unit   µm, with the side it moves to · limits all axes at the reference point; the tables that
///        acted, not those that were switched off
pub(super) fn way_back(before: &Before<'_>) -> Vec<InRollback> {
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
