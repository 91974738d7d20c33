//! The machine data that files set: switches and memory of the job's tables, and nothing else.

use super::data::{CEC_ON, CEC_POINTS, Datum, LEC_ON, LEC_POINTS, TABLE_ON};
use crate::control::controller::{Role, SiemensFacts};
use crate::control::table::siemens::SiemensTables;
use crate::judge::findings::{Difference, InControl};
use crate::read::FileData;
use crate::read::siemens::{MachineDatum, MachineValue};
use crate::text::finding::Finding;

/// A machine or setting datum of the job.
struct Owned {
    datum: Datum,
    indices: Vec<String>,
    /// What it belongs to.
    of: String,
    /// Points to reserve; a switch needs none.
    points: usize,
}

impl Owned {
    fn is(&self, datum: &MachineDatum) -> bool {
        self.datum.1 == datum.name && self.indices == datum.indices
    }
}

/// What a file of a role sets, and what is said where no file does, or another value is set.
const TASKS: [(Role, &str, &str, &str); 3] = [
    (Role::Enable, "switches the tables on", " = 1", "the enable file does not switch on"),
    (Role::Disable, "switches the tables off", " = 0", "the disable file does not switch off"),
    (Role::Parameters, "reserves their memory", "", "the memory file does not reserve enough for"),
];

/// MD32700, SD41300 and MD32710 of the job's tables in the files that switch them; MD38000 and, where
/// it is not fixed, MD18342 in the one that reserves their memory.
fn owned(role: Role, wanted: &SiemensTables, facts: &SiemensFacts) -> Vec<Owned> {
    let (of_lec, of_cec) = match role {
        Role::Enable | Role::Disable => (LEC_ON, TABLE_ON),
        Role::Parameters => (LEC_POINTS, CEC_POINTS),
        Role::Table | Role::Rollback | Role::SignProof | Role::Checklist | Role::Report => {
            return Vec::new();
        }
    };
    let lec = wanted.lec.iter().map(|table| Owned {
        datum: of_lec,
        indices: vec![table.encoder.to_string(), table.axis.clone()],
        of: table.name(),
        points: table.values.len(),
    });
    let cec = wanted.cec.iter().map(|table| Owned {
        datum: of_cec,
        indices: vec![table.number.to_string()],
        of: table.name(),
        points: table.values.len(),
    });
    let reserves = role == Role::Parameters;
    let cec = cec.filter(|_| !reserves || !facts.cec_memory_fixed.value);
    let outputs = wanted.cec_outputs().into_iter().filter(|_| !reserves);
    let axes = outputs.map(|axis| Owned {
        datum: CEC_ON,
        of: format!("CEC of axis {axis}"),
        indices: vec![axis],
        points: 0,
    });
    lec.chain(cec).chain(axes).collect()
}

/// What files set that the job does not own, and what they do not set though they should.
pub(super) fn differences(
    wanted: &SiemensTables,
    stale: &[String],
    files: &[FileData],
    facts: &SiemensFacts,
) -> Vec<Difference> {
    let switches_off = |datum: &MachineDatum| {
        let (variable, off) = (datum.variable(), datum.value == MachineValue::Number(0.0));
        off && stale.iter().any(|switch| switch.ends_with(&format!(" {variable}")))
    };
    let foreign = files.iter().filter_map(|file| {
        let owned = owned(file.role, wanted, facts);
        let is_foreign = |datum: &&MachineDatum| {
            let is_old = file.role == Role::Disable && switches_off(datum);
            !is_old && !owned.iter().any(|own| own.is(datum))
        };
        let foreign = file.data.iter().filter(is_foreign);
        let foreign = foreign.map(|datum| format!("{} = {}", datum.variable(), text(&datum.value)));
        let data: Vec<String> = foreign.collect();
        let file = file.path.clone();
        (!data.is_empty()).then_some(Difference::SetsMore { file, data })
    });
    let mut found: Vec<Difference> = foreign.collect();
    for (role, _, _, not) in TASKS {
        let of_role: Vec<&FileData> = files.iter().filter(|file| file.role == role).collect();
        if !of_role.is_empty() {
            let data: Vec<&MachineDatum> = of_role.iter().flat_map(|file| &file.data).collect();
            found.extend(wrong(role, not, &owned(role, wanted, facts), &data));
        }
    }
    found
}

/// Once for all data that stand alike.
fn wrong(
    role: Role,
    task: &'static str,
    owned: &[Owned],
    data: &[&MachineDatum],
) -> Vec<Difference> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for own in owned {
        let value = data.iter().rev().find(|datum| own.is(datum)).map(|d| &d.value);
        let (is_right, expected) = match (role, value) {
            (Role::Parameters, Some(MachineValue::Number(points))) => {
                (*points >= own.points as f64, format!("at least {}", own.points))
            }
            (Role::Parameters, _) => (false, format!("at least {}", own.points)),
            (Role::Enable, _) => (value == Some(&MachineValue::Number(1.0)), "1".to_string()),
            _ => (value == Some(&MachineValue::Number(0.0)), "0".to_string()),
        };
        if is_right {
            continue;
        }
        let set = value.map(|value| format!("set to {}", text(value)));
        let stands = format!("{}, expected {expected}", set.unwrap_or("not written".to_string()));
        let of = format!("{} ({})", own.of, own.datum.0);
        match groups.iter_mut().find(|(known, _)| *known == stands) {
            Some((_, names)) => names.push(of),
            None => groups.push((stands, vec![of])),
        }
    }
    let groups = groups.into_iter();
    let not_set = |(stands, data)| Difference::NotSet { task, data, stands };
    groups.map(not_set).collect()
}

fn text(value: &MachineValue) -> String {
    match value {
        MachineValue::Number(number) => number.to_string(),
        MachineValue::Text(text) => text.clone(),
    }
}

/// Files that are not there (or that a profile of one's own leaves out), and the data to see to
/// by hand.
pub(super) fn absent(
    wanted: &SiemensTables,
    files: &[FileData],
    facts: &SiemensFacts,
) -> Vec<Finding> {
    let found = |(role, does, value, _): (Role, &'static str, &str, &str)| {
        if files.iter().any(|file| file.role == role) {
            return None;
        }
        let data = owned(role, wanted, facts);
        let data =
            data.iter().map(|Owned { datum, .. }| format!("{} ${}{value}", datum.0, datum.1));
        let mut data: Vec<String> = data.collect();
        data.dedup();
        (!data.is_empty()).then(|| InControl::NoFile { does, data }.into())
    };
    TASKS.into_iter().filter_map(found).collect()
}
