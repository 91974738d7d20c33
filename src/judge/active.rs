//! The tables that were active while measuring: what the control held, and what it did.
//!
//! ```text
//!   kit directory, or files read out of the control ─→ readers ─→ ActiveControl
//!                                                                      ▼ emulate
//!   measured errors (residual under these tables) ──────────→ − old correction
//!                                                                      ▼
//!                                        model of the machine without compensation
//! ```
//! The new tables are planned for the machine without compensation, so new = old + residual. What
//! is forecast as *before* stays what was measured.
//!
//! A backlash parameter that the new tables do not replace acts before and after alike and is
//! left out of both; with `two-tables` and `curve-and-parameter`, which set it, it is part of the
//! old correction and has to be known.
//!
//! What acted is one thing, what a read-out holds another: [`Origin::ReadOut`] keeps all of it for the way
//! back, with the tables that were switched off and the parameters that no table needs.

mod kit;
mod machine;
mod manifest;
mod reading;

pub use self::kit::{Fault, faults, from_kit};
pub(crate) use self::machine::uncompensated;
pub use self::manifest::{HashedFile, KitManifest, Machine, Predecessor, State, hashed};
pub(crate) use self::reading::ReadOutReader;
pub use self::reading::{ActiveControl, Origin, Others, ReadOutFor, without_tables};
use self::reading::{at_key, backlash_of, stated};
use crate::control::claims::Precondition;
use crate::control::controller::{Profile, Role};
use crate::control::table::Tables;
use crate::inputs::job::Job;
use crate::judge::family::family;
use crate::judge::findings::InControl;
use crate::judge::refusals;
use crate::quantity::{Axis, PerAxis};
use crate::read::{file_name, read_out_text};
use crate::text::{Problems, Severity};
use crate::write::plan::axis_names;
use std::borrow::Cow;

// Files that were read out of the control: what concerns the job's axes, through the readers; and the old
// tables beside the new ones in one control.

/// Reads files of the control: tables, parameters.
pub fn from_read_out(
    job: &Job,
    profile: &Profile,
    path: &str,
    files: Vec<(String, Vec<u8>)>,
    purpose: ReadOutFor,
) -> Result<ActiveControl, Problems> {
    let names = axis_names(job, profile)?;
    let active = ActiveControl::bare(job, profile, path, PerAxis::default())?;
    let mut reading = ReadOutReader { job, texts: &[], names, purpose, active };
    let texts = texts(profile, path, &files, &mut reading)?;
    let texts: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (*name, &**text)).collect();
    reading.texts = &texts;
    family(&profile.dialect).read_out(&mut reading)?;
    let mut problems = Problems::none();
    let backlash_um = acted(&mut reading, profile, &mut problems);
    refuse(&reading, &mut problems);
    let (state, active) = (stated(job, profile, &backlash_um)?, reading.active);
    problems.or_ok(ActiveControl { files, state, backlash_um, ..active })
}

/// Old tables that contradict the job, or beside which something acts, cannot be built on.
fn refuse(reading: &ReadOutReader<'_>, problems: &mut Problems) {
    let is_grave = |severity| severity > Severity::Note && !reading.judges();
    for finding in reading.active.findings.iter().filter(|f| is_grave(f.severity())) {
        let help = finding.kind().map_or("", InControl::help);
        problems.push(at_key(reading.job, refusals::from_control(finding, help)));
    }
}

/// The backlash parameters that acted while measuring; of files that are judged nobody knows.
fn acted(
    reading: &mut ReadOutReader<'_>,
    profile: &Profile,
    problems: &mut Problems,
) -> PerAxis<Option<f64>> {
    if reading.judges() {
        return PerAxis::default();
    }
    let parameter = profile.family.backlash_parameter;
    let one = PerAxis::from_fn(|axis| one_backlash(reading, axis, parameter));
    backlash_of(reading.job, &one, problems)
}

/// One backlash parameter for an axis of the machine: the axes of a gantry have to hold the same,
/// and what only some of them hold does not tell the others'.
fn one_backlash(
    reading: &mut ReadOutReader<'_>,
    axis: Axis,
    parameter: &'static str,
) -> Option<f64> {
    let mut held = reading.active.held_backlash.clone();
    held.retain(|(name, _)| reading.names[axis].contains(name));
    let mut values = held.iter().filter_map(|(_, um)| *um);
    let first = values.next()?;
    if values.any(|um| (um - first).abs() > 0.0) {
        let axes = held.iter().map(|(name, _)| name.clone()).collect();
        reading.tell(InControl::GantryDiffers { axes });
    }
    let Some((axis, _)) = held.into_iter().find(|(_, um)| um.is_none()) else {
        return Some(first);
    };
    reading.tell(InControl::GantryUnknown { parameter, axis });
    None
}

/// Sign proofs, rollbacks and checklists of a kit, by their names.
fn stands_apart(profile: &Profile, name: &str) -> bool {
    let apart = |role: Role| role.stands_apart() || role == Role::Checklist;
    profile.files.iter().any(|file| apart(file.role) && file.is_called(file_name(name)))
}

/// The files as text, but those of a kit that are never loaded with its tables.
fn texts<'a>(
    profile: &Profile,
    path: &str,
    files: &'a [(String, Vec<u8>)],
    reading: &mut ReadOutReader<'_>,
) -> Result<Vec<(&'a str, Cow<'a, str>)>, Problems> {
    let mut problems = Problems::none();
    let mut texts = Vec::new();
    for (name, bytes) in files {
        let stands_apart = stands_apart(profile, name);
        if stands_apart && reading.judges() {
            reading.tell(InControl::NotLoaded { file: name.clone() });
            continue;
        }
        if stands_apart {
            problems.push(refusals::not_of_tables(name, path));
        }
        match read_out_text(profile, name, bytes) {
            Ok(text) => texts.push((name.as_str(), text)),
            Err(problem) => problems.push(problem),
        }
    }
    problems.or_ok(texts)
}

/// New tables at places that others own; all of them at once.
pub(crate) fn collisions(
    job: &Job,
    profile: &Profile,
    active: &ActiveControl,
    new: &Tables,
) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for (what, help) in family(&profile.dialect).taken(&active.others, new) {
        problems.push(at_key(job, refusals::in_use(what, help)));
    }
    problems.or_ok(())
}

/// Each of them has to be off.
pub(crate) fn switched_off(
    profile: &Profile,
    stale: &[String],
) -> impl Iterator<Item = Precondition> {
    const WHY: &str = "an old table that the new files do not overwrite would act in addition to them; the disable file, where the kit has one, switches it off";
    const SOURCE: &str = "the active tables that the job names";
    let off = profile.family.off;
    stale.iter().map(move |what| Precondition::new(what, off, WHY, SOURCE).dangerous())
}
