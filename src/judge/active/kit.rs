//! A kit of this program as the tables that were active.
//!
//! The files that the manifest lists as `table`, `parameters` and `enable` were loaded; every
//! listed file has to be the one that was made. The manifest's `state` says for which reference,
//! unit and axes, and which backlash parameter was named; its `machine` for which machine.

use super::manifest::{AxisOfState, HashedFile, KitManifest, Machine, State};
use super::reading::{ActiveControl, Origin, at_key, backlash_of};
use crate::control::claims::Assumption;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{KitFile, Profile, Role};
use crate::inputs::job::{Job, day};
use crate::judge::findings::{FileFault, InControl};
use crate::judge::refusals;
use crate::quantity::PerAxis;
use crate::read::read;
use crate::text::{Finding, Problem, Problems, json_page, sha256, shown};
use crate::write::plan::axis_names;
use std::borrow::Cow;
use std::collections::BTreeMap;

const SAME: f64 = 1e-6; // mm, µm

/// Reads a kit from the bytes of its manifest and its files.
pub fn from_kit(
    job: &Job,
    profile: &Profile,
    path: &str,
    manifest: &[u8],
    files: Vec<(String, Vec<u8>)>,
) -> Result<ActiveControl, Problems> {
    let damaged = |error| at_key(job, refusals::damaged_manifest(path, error));
    let document: KitManifest = json_page(manifest).map_err(damaged)?;
    let files = acting(job, path, &document.files, files)?;
    let mut problems = Problems::none();
    let controller = document.controller.unwrap_or_default();
    if controller != profile.id {
        let wrong = refusals::other_control(shown(&controller), &profile.id);
        problems.push(at_key(job, wrong));
    }
    let dates = [&job.measurement.date, &document.machine.measured];
    if let [Some(own), Some(made)] = dates.map(|date| day(date.as_ref()))
        && own < made
    {
        problems.push(at_key(job, refusals::made_later(made, own)));
    }
    let findings = check_machine(job, document.machine, &mut problems);
    let state = document.state.as_ref();
    let found = backlash(&axis_names(job, profile)?, state);
    let backlash_um = backlash_of(job, &found, &mut problems);
    let mut own = ActiveControl::bare(job, profile, path, backlash_um)?;
    if let Some(state) = state {
        check_state(job, &own.state, state, &mut problems);
        take_switches(&mut own.state, state);
    }
    problems.or_ok(())?;
    let tables = read(profile, &files)?.tables;
    let origin =
        Origin::Kit { manifest: manifest.to_vec(), tool: document.tool.unwrap_or_default() };
    let loaded = format!("the kit `{path}` was loaded and switched on as it was made");
    let wrong = "the new tables would hold corrections that were not active: read the tables out of the control and name them instead";
    Ok(ActiveControl {
        files: files.into_iter().map(|file| (file.path, file.bytes)).collect(),
        assumptions: vec![Assumption::of_job("active_tables", loaded, wrong)],
        findings,
        tables,
        origin,
        ..own
    })
}

/// The files that act, after every listed one was compared with its hash.
fn acting(
    job: &Job,
    path: &str,
    listed: &[HashedFile],
    files: Vec<(String, Vec<u8>)>,
) -> Result<Vec<KitFile>, Problems> {
    let mut problems = Problems::none();
    let mut files: BTreeMap<String, Vec<u8>> = files.into_iter().collect();
    let bytes = |name: &str| Ok(files.get(name).map(|bytes| (None, bytes.as_slice().into())));
    for Fault { kind, role } in faults(listed, bytes) {
        let is_written_into = role.is_some_and(Role::is_written_into);
        let (name, what) = match kind {
            FileFault::Changed { .. } if is_written_into => continue,
            FileFault::Changed { file } => (file, "was changed after it was made"),
            FileFault::ListedTwice { file } => (file, "is listed twice"),
            FileFault::Missing { file } | FileFault::NoPlainName { file } => (file, "is missing"),
            FileFault::NotReadable { message } => (message, "cannot be read"),
        };
        problems.push(at_key(job, refusals::other_file(name, path, what)));
    }
    let acts = |role: &Role| matches!(role, Role::Table | Role::Parameters | Role::Enable);
    let acting = listed.iter().filter_map(|file| {
        let role = file.role.filter(acts)?;
        Some(KitFile { path: file.path.clone(), role, bytes: files.remove(&file.path)? })
    });
    problems.or_ok(acting.collect())
}

/// A difference of the files from what their manifest lists.
pub struct Fault {
    /// Which.
    pub kind: FileFault,
    /// What the file is for, as far as known.
    pub role: Option<Role>,
}

/// Purpose (where it is known better than from the manifest) and bytes of a file.
type Bytes<'a> = (Option<Role>, Cow<'a, [u8]>);

/// How the files of a directory differ from what its manifest lists.
pub fn faults<'a, 'b>(
    listed: &'b [HashedFile],
    bytes_of: impl Fn(&str) -> Result<Option<Bytes<'a>>, Problem>,
) -> Vec<Fault> {
    let mut seen = BTreeMap::<&str, usize>::new();
    let fault = |HashedFile { path, role, sha256: own, .. }: &'b HashedFile| {
        let (file, times) = (shown(path), seen.entry(path).or_default());
        *times += 1;
        let role = *role;
        let (kind, role) = match *times {
            1 if !is_plain_name(path) => (FileFault::NoPlainName { file }, None),
            1 => match bytes_of(path) {
                Err(Problem { message, .. }) => (FileFault::NotReadable { message }, None),
                Ok(None) => (FileFault::Missing { file }, role),
                Ok(Some((_, bytes))) if sha256(&bytes) == *own => return None,
                Ok(Some((known, _))) => (FileFault::Changed { file }, known.or(role)),
            },
            2 => (FileFault::ListedTwice { file }, None),
            _ => return None,
        };
        Some(Fault { kind, role })
    };
    listed.iter().filter_map(fault).collect()
}

/// A manifest lists files of its own directory and nothing else.
fn is_plain_name(name: &str) -> bool {
    std::path::Path::new(name).file_name() == Some(name.as_ref())
        && !name.contains(['/', '\\', ':'])
}

/// Serial number, name and chain of the machine of the kit against those of the job: another
/// serial number is another machine; another name or chain is one too, unless the serial numbers
/// are the same. Gives what is to be told.
fn check_machine(job: &Job, machine: Machine, problems: &mut Problems) -> Vec<Finding> {
    let own = &job.machine;
    let chain = own.chain.map(|chain| chain.to_string());
    let asked = [
        ("serial", "serial number", machine.serial, own.serial.clone()),
        ("name", "name", machine.name, Some(own.name.clone())),
        ("chain", "chain", machine.chain, chain),
    ];
    let (mut notes, mut same_serial) = (Vec::new(), false);
    for (key, what, kit, own) in asked {
        let (Some(kit), Some(own)) = (kit, own) else {
            continue;
        };
        if kit == own {
            same_serial |= key == "serial";
        } else if same_serial {
            notes.push(InControl::SameSerial { key, kit: shown(&kit), own }.into());
        } else {
            let is_serial = key == "serial";
            let help = if is_serial { refusals::LOADED } else { refusals::LOADED_OR_NAMED };
            problems.push(at_key(job, refusals::other_machine(what, shown(&kit), own, help)));
            if is_serial {
                break;
            }
        }
    }
    notes
}

/// The backlash parameters that the kit named; the axes of a gantry have the same one.
fn backlash(names: &PerAxis<Vec<String>>, state: Option<&State>) -> PerAxis<Option<f64>> {
    PerAxis::from_fn(|axis| names[axis].iter().find_map(|name| state?.axis(name))?.backlash_um)
}

/// Unit, axes, references and detection units of the kit against those of the job.
fn check_state(job: &Job, own: &ControlState, state: &State, problems: &mut Problems) {
    if state.unit != own.unit {
        problems.push(at_key(job, refusals::other_unit(state.unit.word(), own.unit.word())));
    }
    for entry in &state.axes {
        let name = &entry.name;
        let Some(axis) = own.axis(name) else {
            problems.push(at_key(job, refusals::no_such_axis(shown(name))));
            continue;
        };
        for words in differences(axis, entry) {
            problems.push(at_key(job, refusals::other_axis(name, words)));
        }
    }
}

fn differences(own: &AxisState, entry: &AxisOfState) -> Vec<String> {
    let mut words = Vec::new();
    let (reference, expected) = (entry.reference_mm.mm(), own.reference.mm());
    if (reference - expected).abs() > SAME {
        words.push(format!(
            "the active tables have their reference at {reference} mm, the job has it at {expected} mm"
        ));
    }
    let (direction, homing) = (entry.reference_direction, own.reference_direction);
    if direction != homing {
        words.push(format!(
            "the active tables are for a reference return in {direction}, the job for {homing}"
        ));
    }
    if let (Some(old), Some(new)) = (entry.detection_unit_um, own.detection_unit_um)
        && (old - new).abs() > SAME
    {
        words
            .push(format!("the active tables count detection units of {old} µm, the job {new} µm"));
    }
    words
}

/// The switches that no file of the kit writes.
fn take_switches(own: &mut ControlState, state: &State) {
    for axis in &mut own.axes {
        if let Some(entry) = state.axis(&axis.name) {
            axis.bidirectional = entry.bidirectional;
            axis.interpolated = entry.interpolated;
        }
    }
}
