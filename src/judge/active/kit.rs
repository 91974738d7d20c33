//! A kit of this program as the tables that were active.
//!
//! The files that the manifest lists as `table`, `parameters` and `enable` were loaded; every
//! listed file has to be the one that was made. The manifest's `state` says for which reference,
//! unit and axes, and which backlash parameter was named; its `machine` for which machine.

use super::{ActiveControl, Origin, Others, backlash_of, problem, stated};
use crate::control::claims::Assumption;
use crate::control::control_state::ControlState;
use crate::control::controller::{Profile, Role};
use crate::inputs::job::Job;
use crate::quantity::axis::{Axis, PerAxis};
use crate::read::{KitFile, read};
use crate::text::document::{json_page, sha256};
use crate::text::problem::{Problem, Problems, shown};
use crate::write::plan::axis_names;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

const SAME: f64 = 1e-6; // mm, µm

/// Reads a kit from the bytes of its manifest and its files.
pub fn from_kit(
    job: &Job,
    profile: &Profile,
    path: &str,
    manifest: &[u8],
    files: Vec<(String, Vec<u8>)>,
) -> Result<ActiveControl, Problems> {
    let document: Value = json_page(manifest).map_err(|error| {
        problem(
            job,
            format!("`{path}/manifest.json` is damaged: {error}"),
            "name the kit as it was made, or the files read out of the control",
        )
    })?;
    let files = listed(job, path, &document, files)?;
    let mut problems = Problems::none();
    check_controller(job, profile, &document, &mut problems);
    let notes = check_machine(job, &document["machine"], &mut problems);
    let state = &document["state"];
    let found = backlash(job, profile, state)?;
    let backlash_um = backlash_of(job, &found, &mut problems);
    let mut own = stated(job, profile, &backlash_um)?;
    check_state(job, &own, state, &mut problems);
    take_switches(&mut own, &document);
    problems.or_ok(())?;
    let kit_files: Vec<KitFile<'_>> = files
        .iter()
        .map(|(role, name, bytes)| KitFile {
            path: name,
            role: *role,
            bytes,
        })
        .collect();
    let read = read(profile, &kit_files)?;
    Ok(ActiveControl {
        tables: read.tables,
        files: files
            .into_iter()
            .map(|(_, name, bytes)| (name, bytes))
            .collect(),
        state: own,
        path: path.to_string(),
        origin: Origin::Kit {
            manifest: manifest.to_vec(),
            tool: document["tool"].as_str().unwrap_or_default().to_string(),
        },
        backlash_um,
        others: Others::default(),
        assumptions: vec![Assumption::of_job(
            "active_tables",
            format!("the kit `{path}` was loaded and switched on as it was made"),
            "the new tables would hold corrections that were not active: read the tables out of the control and name them instead",
        )],
        notes,
        held_backlash: Vec::new(),
        disagreements: Vec::new(),
        beside: Vec::new(),
    })
}

type RoleFile = (Role, String, Vec<u8>);

/// The files that act, after every listed one was compared with its hash.
fn listed(
    job: &Job,
    path: &str,
    document: &Value,
    files: Vec<(String, Vec<u8>)>,
) -> Result<Vec<RoleFile>, Problems> {
    let mut problems = Problems::none();
    let mut acting = Vec::new();
    let files: BTreeMap<&str, &[u8]> = files
        .iter()
        .map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
        .collect();
    let mut seen = BTreeSet::new();
    for entry in document["files"].as_array().into_iter().flatten() {
        let name = entry["path"].as_str().unwrap_or_default();
        let role = entry["role"].as_str().and_then(Role::of_word);
        if !seen.insert(name) {
            problems.push_with(|| changed(job, path, name, "is listed twice"));
            continue;
        }
        match files.get(name) {
            None => problems.push_with(|| changed(job, path, name, "is missing")),
            Some(_) if role.is_some_and(Role::is_written_into) => {}
            Some(bytes) if Some(sha256(bytes).as_str()) != entry["sha256"].as_str() => {
                problems.push(changed(job, path, name, "was changed after it was made"));
            }
            Some(bytes) => {
                let acts =
                    |role: &Role| matches!(role, Role::Table | Role::Parameters | Role::Enable);
                let role = role.filter(acts);
                acting.extend(role.map(|role| (role, name.to_string(), bytes.to_vec())))
            }
        }
    }
    problems.or_ok(acting)
}

fn changed(job: &Job, path: &str, name: &str, what: &str) -> Problem {
    problem(
        job,
        format!(
            "`{}` of the kit `{path}` {what}, so what was active is not known",
            shown(name)
        ),
        "name the kit as it was loaded, or the files read out of the control",
    )
}

fn check_controller(job: &Job, profile: &Profile, document: &Value, problems: &mut Problems) {
    let other = document["controller"].as_str().unwrap_or_default();
    if other != profile.id {
        problems.push(problem(
            job,
            format!(
                "the active tables were made for the control `{}`, the job is for `{}`",
                shown(other),
                profile.id
            ),
            "name the kit that was loaded into this control",
        ));
    }
}

/// Serial number, name and chain of the machine of the kit against those of the job: another
/// serial number is another machine; another name or chain is one too, unless the serial numbers
/// are the same. Gives what is to be told.
fn check_machine(job: &Job, machine: &Value, problems: &mut Problems) -> Vec<String> {
    let own = &job.machine;
    let serials = (machine["serial"].as_str(), own.serial.as_deref());
    if let (Some(kit), Some(job_has)) = serials
        && kit != job_has
    {
        let help = "name the kit that was loaded into this machine";
        problems.push(other_machine(job, "serial number", kit, job_has, help));
        return Vec::new();
    }
    let is_same = serials.0.is_some() && serials.0 == serials.1;
    let chain = own.chain.map(|chain| chain.to_string());
    let asked = [("name", Some(own.name.clone())), ("chain", chain)];
    let mut notes = Vec::new();
    for (key, job_has) in asked {
        let (Some(kit), Some(job_has)) = (machine[key].as_str(), job_has) else {
            continue;
        };
        if kit == job_has {
            continue;
        }
        if is_same {
            notes.push(format!("the kit of the active tables has the machine {key} `{}`, the job `{job_has}`; the serial number is the same, so it counts as the same machine", shown(kit)));
        } else {
            let help = "name the kit that was loaded into this machine; if it is the same machine, write `name` and `chain` as the manifest of the kit has them (the same `serial` in both would tell, too)";
            problems.push(other_machine(job, key, kit, &job_has, help));
        }
    }
    notes
}

fn other_machine(job: &Job, what: &str, kit: &str, job_has: &str, help: &str) -> Problem {
    let message = format!(
        "the active tables were made for another machine: its {what} is `{}`, that of the job `{job_has}`",
        shown(kit)
    );
    problem(job, message, help)
}

/// The backlash parameters that the kit named; the axes of a gantry have the same one.
fn backlash(job: &Job, profile: &Profile, state: &Value) -> Result<PerAxis<Option<f64>>, Problems> {
    let names = axis_names(job, profile)?;
    let of = |axis: Axis| {
        let mut own = names[axis].iter();
        own.find_map(|name| named_axis(state, name))?["backlash_um"].as_f64()
    };
    Ok(PerAxis::from_fn(of))
}

/// What the `state` of a manifest says of an axis of the control.
pub fn named_axis<'a>(state: &'a Value, name: &str) -> Option<&'a Value> {
    let own = |entry: &&Value| {
        let named = entry["name"].as_str().unwrap_or_default();
        named.eq_ignore_ascii_case(name)
    };
    state["axes"].as_array()?.iter().find(own)
}

/// Unit, axes, references and detection units of the kit against those of the job.
fn check_state(job: &Job, own: &ControlState, state: &Value, problems: &mut Problems) {
    let Some(axes) = state["axes"].as_array() else {
        return; // a kit from before manifests held it
    };
    let unit = state["unit"].as_str().unwrap_or_default();
    if unit != own.unit.word() {
        problems.push(problem(
            job,
            format!(
                "the active tables are in {}, the job in {}",
                shown(unit),
                own.unit.word()
            ),
            "correct `control_unit`, or make the new tables in the unit of the old ones",
        ));
    }
    for entry in axes {
        let name = entry["name"].as_str().unwrap_or_default();
        match own.axis(name) {
            None => problems.push(problem(
                job,
                format!(
                    "the active tables are for an axis `{}`, which the job does not have",
                    shown(name)
                ),
                "compare `id` of [compensation.axes] with the kit",
            )),
            Some(axis) => {
                for words in differences(axis, entry) {
                    problems.push(problem(
                        job,
                        format!("axis {name}: {words}"),
                        "correct the job; tables of another reference or unit cannot be added",
                    ));
                }
            }
        }
    }
}

fn differences(own: &crate::control::control_state::AxisState, entry: &Value) -> Vec<String> {
    let mut words = Vec::new();
    let expected = own.reference.mm();
    match entry["reference_mm"].as_f64() {
        Some(reference) if (reference - expected).abs() <= SAME => {}
        Some(reference) => words.push(format!(
            "the active tables have their reference at {reference} mm, the job has it at {expected} mm"
        )),
        None => words.push(format!(
            "the manifest of the active tables lacks `reference_mm`, the job has the reference at {expected} mm"
        )),
    }
    let direction = entry["reference_direction"].as_str().unwrap_or_default();
    if direction != own.reference_direction.symbol() {
        words.push(format!(
            "the active tables are for a reference return in {}, the job for {}",
            shown(direction),
            own.reference_direction
        ));
    }
    let unit = entry["detection_unit_um"].as_f64();
    if let (Some(old), Some(new)) = (unit, own.detection_unit_um)
        && (old - new).abs() > SAME
    {
        words.push(format!(
            "the active tables count detection units of {old} µm, the job {new} µm"
        ));
    }
    words
}

/// The switches that no file of the kit writes.
fn take_switches(own: &mut ControlState, document: &Value) {
    for entry in document["state"]["axes"].as_array().into_iter().flatten() {
        let name = entry["name"].as_str().unwrap_or_default();
        if let Some(axis) = own
            .axes
            .iter_mut()
            .find(|a| a.name.eq_ignore_ascii_case(name))
        {
            axis.bidirectional = entry["bidirectional"]
                .as_bool()
                .unwrap_or(axis.bidirectional);
            axis.interpolated = entry["interpolated"].as_bool().unwrap_or(axis.interpolated);
        }
    }
}
