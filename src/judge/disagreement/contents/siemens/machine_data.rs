//! The machine data that files set: switches and memory of the job's tables, and nothing else.

use super::lec_name;
use crate::control::controller::{Role, SiemensFacts};
use crate::control::table::siemens::SiemensTables;
use crate::judge::disagreement::contents::words::{it, listed};
use crate::read::FileData;
use crate::read::siemens::{MachineDatum, MachineValue};

/// A machine or setting datum of the job.
struct Owned {
    name: &'static str,
    indices: Vec<String>,
    number: &'static str,
    /// What it belongs to.
    of: String,
    /// Points to reserve; a switch needs none.
    points: usize,
}

impl Owned {
    fn is(&self, datum: &MachineDatum) -> bool {
        self.name == datum.name && self.indices == datum.indices
    }

    fn value(&self, data: &[&MachineDatum]) -> Option<MachineValue> {
        let last = data.iter().rev().find(|datum| self.is(datum));
        last.map(|datum| datum.value.clone())
    }
}

/// MD32700, SD41300 and MD32710 of the job's tables.
fn switches(wanted: &SiemensTables) -> Vec<Owned> {
    let lec = wanted.lec.iter().map(|table| Owned {
        name: "MA_ENC_COMP_ENABLE",
        indices: vec![table.encoder.to_string(), table.axis.clone()],
        number: "MD32700",
        of: lec_name(table),
        points: 0,
    });
    let cec = wanted.cec.iter().map(|table| Owned {
        name: "SN_CEC_TABLE_ENABLE",
        indices: vec![table.number.to_string()],
        number: "SD41300",
        of: format!("CEC table {}", table.number),
        points: 0,
    });
    let mut outputs: Vec<&String> = wanted.cec.iter().map(|t| &t.output_axis).collect();
    outputs.sort_unstable();
    outputs.dedup();
    let axes = outputs.into_iter().map(|axis| Owned {
        name: "MA_CEC_ENABLE",
        indices: vec![axis.clone()],
        number: "MD32710",
        of: format!("CEC of axis {axis}"),
        points: 0,
    });
    lec.chain(cec).chain(axes).collect()
}

/// MD38000 and, where it is not fixed, MD18342 of the job's tables.
fn reservations(wanted: &SiemensTables, facts: &SiemensFacts) -> Vec<Owned> {
    let lec = wanted.lec.iter().map(|table| Owned {
        name: "MA_MM_ENC_COMP_MAX_POINTS",
        indices: vec![table.encoder.to_string(), table.axis.clone()],
        number: "MD38000",
        of: lec_name(table),
        points: table.values.len(),
    });
    let cec = wanted.cec.iter().map(|table| Owned {
        name: "MN_MM_CEC_MAX_POINTS",
        indices: vec![table.number.to_string()],
        number: "MD18342",
        of: format!("CEC table {}", table.number),
        points: table.values.len(),
    });
    let fixed = facts.cec_memory_fixed.value;
    lec.chain(cec.filter(|_| !fixed)).collect()
}

fn owned(role: Role, wanted: &SiemensTables, facts: &SiemensFacts) -> Vec<Owned> {
    match role {
        Role::Enable | Role::Disable => switches(wanted),
        Role::Parameters => reservations(wanted, facts),
        Role::Table | Role::Rollback | Role::SignProof | Role::Checklist | Role::Report => {
            Vec::new()
        }
    }
}

/// What files set that the job does not own, and what they do not set though they should.
pub(in super::super) fn differences(
    wanted: &SiemensTables,
    files: &[FileData],
    facts: &SiemensFacts,
) -> Vec<String> {
    let mut words: Vec<String> = files
        .iter()
        .filter_map(|file| foreign(file, &owned(file.role, wanted, facts)))
        .collect();
    if let Some(data) = of_role(files, Role::Enable) {
        let not = "the enable file does not switch on";
        words.extend(wrong_switches(&switches(wanted), &data, 1.0, not));
    }
    if let Some(data) = of_role(files, Role::Disable) {
        let not = "the disable file does not switch off";
        words.extend(wrong_switches(&switches(wanted), &data, 0.0, not));
    }
    if let Some(data) = of_role(files, Role::Parameters) {
        words.extend(short_reservations(&reservations(wanted, facts), &data));
    }
    words
}

/// All data of the files of a role; nothing if there is no such file.
fn of_role(files: &[FileData], role: Role) -> Option<Vec<&MachineDatum>> {
    let mut of_role = files.iter().filter(|file| file.role == role).peekable();
    of_role.peek()?;
    Some(of_role.flat_map(|file| &file.data).collect())
}

fn foreign(file: &FileData, owned: &[Owned]) -> Option<String> {
    let foreign: Vec<String> = file
        .data
        .iter()
        .filter(|datum| !owned.iter().any(|own| own.is(datum)))
        .map(|datum| format!("{} = {}", datum.variable(), text(&datum.value)))
        .collect();
    let (names, them) = (listed(&foreign), it(foreign.len()));
    (!foreign.is_empty()).then(|| {
        format!(
            "`{}` sets {names}: the job does not write {them} there",
            file.path
        )
    })
}

/// One sentence for all switches that stand alike.
fn wrong_switches(
    switches: &[Owned],
    data: &[&MachineDatum],
    expected: f64,
    not: &str,
) -> Vec<String> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for switch in switches {
        let value = switch.value(data);
        if value == Some(MachineValue::Number(expected)) {
            continue;
        }
        let stands = value.map_or_else(
            || "not written".to_string(),
            |value| format!("set to {}", text(&value)),
        );
        let of = format!("{} ({})", switch.of, switch.number);
        match groups.iter_mut().find(|(known, _)| *known == stands) {
            Some((_, names)) => names.push(of),
            None => groups.push((stands, vec![of])),
        }
    }
    groups
        .iter()
        .map(|(stands, names)| format!("{not} {}: {stands}, expected {expected}", listed(names)))
        .collect()
}

#[allow(
    clippy::cast_precision_loss,
    reason = "a table has few thousand points"
)]
fn short_reservations(reservations: &[Owned], data: &[&MachineDatum]) -> Vec<String> {
    let (mut missing, mut words) = (Vec::new(), Vec::new());
    for own in reservations {
        let (of, number, points) = (&own.of, own.number, own.points);
        match own.value(data) {
            None => missing.push(format!("{of} ({number}, {points} points)")),
            Some(MachineValue::Number(value)) if value >= points as f64 => {}
            Some(value) => words.push(format!(
                "{of}: {number} reserves {} points, the table has {points}",
                text(&value)
            )),
        }
    }
    if !missing.is_empty() {
        words.push(format!(
            "the memory file reserves nothing for {}",
            listed(&missing)
        ));
    }
    words
}

fn text(value: &MachineValue) -> String {
    match value {
        MachineValue::Number(number) => number.to_string(),
        MachineValue::Text(text) => text.clone(),
    }
}

/// Files that are not there (or that a profile of one's own leaves out), and the data to see to
/// by hand.
pub(in super::super) fn absent(
    wanted: &SiemensTables,
    files: &[FileData],
    facts: &SiemensFacts,
) -> Vec<String> {
    let tasks = [
        (Role::Enable, "switches the tables on", " = 1"),
        (Role::Disable, "switches the tables off", " = 0"),
        (Role::Parameters, "reserves their memory", ""),
    ];
    let sentence = |(role, does, value): (Role, &str, &str)| {
        if files.iter().any(|file| file.role == role) {
            return None;
        }
        let mut data: Vec<String> = owned(role, wanted, facts)
            .iter()
            .map(|own| format!("{} ${}{value}", own.number, own.name))
            .collect();
        data.dedup();
        (!data.is_empty())
            .then(|| format!("no file {does}; see to {} on the control", data.join(", ")))
    };
    tasks.into_iter().filter_map(sentence).collect()
}
