//! The way back: exactly what was read out of the control, for what the kit overwrites.
//!
//! Nothing is invented: where the read-out does not hold everything that the kit overwrites, there
//! is no rollback file, and what is missing is named. Zeros are not a rollback.

use super::Inputs;
use super::field::{Made, as_kit_file};
use crate::active::{ActiveControl, Origin};
use crate::compensation::Compiled;
use crate::controller::{Profile, Role};
use crate::emit::{self, Instead, RenderedFile, Switch};
use crate::plan::Plan;
use crate::problem::{Problem, Problems};
use crate::readback::kit::{KitFile, ReadBack, read, read_apart};
use crate::readback::siemens::{MachineDatum, MachineValue};
use crate::table::Tables;
use crate::table::fanuc::{FanucMemory, ParameterKey};
use crate::table::siemens::SiemensTables;

/// What the kit overwrites, as it was.
struct Old {
    tables: Tables,
    /// Switches and backlash (Siemens).
    data: Vec<MachineDatum>,
}

/// The rollback files; `Err` = why there are none, in sentences for the checklist.
pub(super) fn files(made: &Made<'_>) -> Result<Result<Vec<RenderedFile>, Problems>, Vec<String>> {
    let wanted = |role: Role| made.inputs.profile.files.iter().any(|f| f.role == role);
    if !wanted(Role::Rollback) {
        return Err(Vec::new());
    }
    let Some(active) = &made.inputs.active else {
        return Err(vec![
            "no rollback file: `active_while_measuring` names no files that were read out of the control, and zeros are not a way back".to_string(),
        ]);
    };
    if active.origin != Origin::ReadOut {
        return Err(vec![format!(
            "no rollback file: `{}` is a kit, not files that were read out of the control; loading that kit again is the way back to it",
            active.path
        )]);
    }
    let old = old(&made.inputs.profile, active, made.plan, made.compiled)
        .map_err(|missing| vec![incomplete(&missing)])?;
    Ok(rendered(made, &old))
}

fn incomplete(missing: &[String]) -> String {
    const MOST: usize = 8;
    let shown = missing[..missing.len().min(MOST)].join(", ");
    let rest = missing.len().saturating_sub(MOST);
    let rest = if rest > 0 {
        format!(" and {rest} more")
    } else {
        String::new()
    };
    format!(
        "no rollback file: the files read out of the control do not hold all that this kit overwrites; missing: {shown}{rest}"
    )
}

fn rendered(made: &Made<'_>, old: &Old) -> Result<Vec<RenderedFile>, Problems> {
    let instead = Instead {
        notice: "ROLLBACK: values as read out of the control before this kit",
        names_terms: false,
        switches: old.data.iter().map(switch).collect(),
    };
    let files = emit::render_apart(
        made.inputs.task(),
        made.compiled,
        &old.tables,
        &instead,
        |file| file.role == Role::Rollback,
    )?;
    let read_files: Vec<KitFile<'_>> = files.iter().map(as_kit_file).collect();
    let read = read_apart(&made.inputs.profile, &read_files, Role::Rollback)?;
    if !is_same(old, &read) {
        return Err(Problem::new(
            "the rollback files do not read back to what was read out of the control, so nothing is written",
        )
        .help("the control may hold more digits than its profile writes; a template of your own has to keep to the format of the dialect")
        .into());
    }
    Ok(files)
}

fn is_same(old: &Old, read: &ReadBack) -> bool {
    let data: Vec<&MachineDatum> = read.machine_data.iter().flat_map(|f| &f.data).collect();
    read.tables == old.tables && data.iter().copied().eq(&old.data)
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

/// What the read-out holds of what the kit overwrites; `Err` = what it lacks.
fn old(
    profile: &Profile,
    active: &ActiveControl,
    plan: &Plan,
    compiled: &Compiled,
) -> Result<Old, Vec<String>> {
    match (&compiled.tables, &active.tables) {
        (Tables::Siemens(kit), Tables::Siemens(held)) => {
            let tables = siemens(kit, held)?;
            let data = switches(profile, active, kit, plan);
            Ok(Old {
                tables: Tables::Siemens(tables),
                data,
            })
        }
        (Tables::Fanuc(kit), Tables::Fanuc(held)) => Ok(Old {
            tables: Tables::Fanuc(fanuc(kit, held)?),
            data: Vec::new(),
        }),
        _ => Err(vec!["tables of this format".to_string()]),
    }
}

fn siemens(kit: &SiemensTables, held: &SiemensTables) -> Result<SiemensTables, Vec<String>> {
    let mut old = SiemensTables::default();
    let mut missing = Vec::new();
    let is_whole = |values: &[Option<f64>]| values.iter().all(Option::is_some);
    for table in &kit.lec {
        let found = held
            .lec
            .iter()
            .find(|t| t.axis == table.axis && t.encoder == table.encoder && is_whole(&t.values));
        match found {
            Some(found) => old.lec.push(found.clone()),
            None => missing.push(format!("ENC_COMP[{},{}]", table.encoder, table.axis)),
        }
    }
    for table in &kit.cec {
        let found = held.cec.iter();
        match found
            .clone()
            .find(|t| t.number == table.number && is_whole(&t.values))
        {
            Some(found) => old.cec.push(found.clone()),
            None => missing.push(format!("CEC table {}", table.number)),
        }
    }
    if missing.is_empty() {
        Ok(old)
    } else {
        Err(missing)
    }
}

/// Switches and backlash of the kit's axes, where the read-out holds them in one way only.
fn switches(
    profile: &Profile,
    active: &ActiveControl,
    kit: &SiemensTables,
    plan: &Plan,
) -> Vec<MachineDatum> {
    let held: Vec<MachineDatum> = active
        .files
        .iter()
        .filter_map(|(path, bytes)| {
            let file = KitFile {
                path,
                role: Role::Table,
                bytes,
            };
            read(profile, &[file]).ok()
        })
        .flat_map(|read| read.machine_data)
        .flat_map(|file| file.data)
        .collect();
    let is_owned = |datum: &&MachineDatum| {
        let index = |at: usize| {
            datum
                .indices
                .get(at)
                .map(String::as_str)
                .unwrap_or_default()
        };
        match datum.name.as_str() {
            "MA_ENC_COMP_ENABLE" => kit
                .lec
                .iter()
                .any(|t| t.encoder.to_string() == index(0) && t.axis == index(1)),
            "SN_CEC_TABLE_ENABLE" => kit.cec.iter().any(|t| t.number.to_string() == index(0)),
            "MA_CEC_ENABLE" => kit.cec.iter().any(|t| t.output_axis == index(0)),
            "MA_BACKLASH" => plan.tables.iter().any(|t| {
                t.term.is_positioning() && plan.names[t.term.of].iter().any(|n| n == index(1))
            }),
            _ => false,
        }
    };
    let mut old: Vec<MachineDatum> = Vec::new();
    for datum in held.iter().filter(is_owned) {
        let of_name = |d: &&MachineDatum| d.name == datum.name && d.indices == datum.indices;
        let in_one_way = held.iter().filter(of_name).all(|d| d.value == datum.value);
        if in_one_way && !old.contains(datum) {
            old.push(datum.clone());
        }
    }
    old
}

/// 3605, 1851 and 1852 of the kit's axes come along where they were read out: the preconditions of
/// a kit may change them.
fn fanuc(kit: &FanucMemory, held: &FanucMemory) -> Result<FanucMemory, Vec<String>> {
    let mut old = FanucMemory::default();
    let mut missing = Vec::new();
    for key in kit.parameters.keys() {
        match held.parameters.get(key) {
            Some(value) => {
                old.parameters.insert(*key, *value);
            }
            None => missing.push(parameter_name(*key)),
        }
    }
    for point in kit.points.keys() {
        match held.points.get(point) {
            Some(value) => {
                old.points.insert(*point, *value);
            }
            None => missing.push(format!("point {point}")),
        }
    }
    let has_axis = |key: &ParameterKey| {
        let axes = kit.parameters.keys().filter_map(|known| known.axis);
        key.axis
            .is_some_and(|axis| axes.into_iter().any(|a| a == axis))
    };
    let beside = held
        .parameters
        .iter()
        .filter(|(key, _)| [1851, 1852, 3605].contains(&key.number) && has_axis(key));
    old.parameters
        .extend(beside.map(|(key, value)| (*key, *value)));
    if missing.is_empty() {
        Ok(old)
    } else {
        Err(missing)
    }
}

fn parameter_name(key: ParameterKey) -> String {
    let axis = key.axis.map(|axis| format!(" of axis {axis}"));
    format!("parameter {}{}", key.number, axis.unwrap_or_default())
}

/// Rollback files of a directory against what the job's read-out holds, one sentence.
pub(super) fn differences(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    files: &[KitFile<'_>],
) -> Result<Option<String>, Problems> {
    if !files.iter().any(|file| file.role == Role::Rollback) {
        return Ok(None);
    }
    let read = read_apart(&inputs.profile, files, Role::Rollback)?;
    let old = inputs
        .active
        .as_ref()
        .and_then(|active| old(&inputs.profile, active, plan, compiled).ok());
    let same = old.is_some_and(|old| is_same(&old, &read));
    Ok((!same).then(|| {
        "the rollback files do not hold what `active_while_measuring` names as read out of the control".to_string()
    }))
}
