//! Machine data of the job's tables: what files set beside their switches and memory, and what a read-out holds.

use crate::control::controller::{ControlUnit, Role, SiemensFacts};
use crate::control::table::siemens::{
    MachineDatum, MachineValue, Place, SiemensTable, SiemensTables,
};
use crate::judge::findings::{Difference, InControl};
use crate::read::FileData;
use crate::text::{Finding, grouped};
use std::ops::RangeInclusive;

/// A machine or setting datum of the job.
struct Owned {
    datum: Datum,
    variable: String,
    /// What it belongs to.
    of: String,
    /// What a file has to set, and the same in words.
    right: RangeInclusive<f64>,
    expected: String,
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
    let switched = match role {
        Role::Enable => 1.0,
        Role::Disable => 0.0,
        Role::Parameters => return memory(wanted, facts),
        _ => return Vec::new(),
    };
    let own = |datum, index: &str, of| Owned {
        datum,
        variable: variable(datum, index),
        of,
        right: switched..=switched,
        expected: switched.to_string(),
    };
    let places = wanted.tables.iter().map(|table| &table.place);
    let tables = places.map(|place| own(of_place(place)[0], &place.index(), place.name()));
    let outputs = wanted.cec_outputs().into_iter();
    let axes = outputs.map(|axis| own(CEC_ON, &axis, format!("CEC of axis {axis}")));
    tables.chain(axes).collect()
}

fn memory(wanted: &SiemensTables, facts: &SiemensFacts) -> Vec<Owned> {
    let is_set =
        |table: &&SiemensTable| table.place.cec().is_none() || !facts.cec_memory_fixed.value;
    let own = |table: &SiemensTable| Owned {
        datum: of_place(&table.place)[1],
        variable: variable(of_place(&table.place)[1], &table.place.index()),
        of: table.place.name(),
        right: table.values.len() as f64..=f64::INFINITY,
        expected: format!("at least {}", table.values.len()),
    };
    wanted.tables.iter().filter(is_set).map(own).collect()
}

/// What files set that the job does not own, and what they do not set though they should; where a file is not there (or
/// a profile of one's own leaves it out), the data to see to by hand.
pub(super) fn beside(
    wanted: &SiemensTables,
    stale: &[String],
    files: &[FileData],
    facts: &SiemensFacts,
) -> Vec<Finding> {
    let switches_off = |datum: &MachineDatum| {
        let ends = format!(" {}", datum.variable);
        datum.value == MachineValue::Number(0.0) && stale.iter().any(|own| own.ends_with(&ends))
    };
    let foreign = files.iter().filter_map(|file| {
        let owned = owned(file.role, wanted, facts);
        let is_foreign = |datum: &&MachineDatum| {
            let is_old = file.role == Role::Disable && switches_off(datum);
            !is_old && !owned.iter().any(|own| own.variable == datum.variable)
        };
        let foreign = file.data.iter().filter(is_foreign);
        let foreign =
            foreign.map(|MachineDatum { variable, value }| format!("{variable} = {value}"));
        let data: Vec<String> = foreign.collect();
        (!data.is_empty()).then(|| Difference::SetsMore { file: file.path.clone(), data }.into())
    });
    let (mut found, mut absent): (Vec<Finding>, _) = (foreign.collect(), Vec::new());
    for (role, does, value, not) in TASKS {
        let owned = owned(role, wanted, facts);
        let of_role: Vec<&FileData> = files.iter().filter(|file| file.role == role).collect();
        if of_role.is_empty() {
            let data = owned.iter().map(|own| format!("{} ${}{value}", own.datum.0, own.datum.1));
            let mut data: Vec<String> = data.collect();
            data.dedup();
            absent.extend((!data.is_empty()).then(|| InControl::NoFile { does, data }.into()));
        } else {
            let data: Vec<&MachineDatum> = of_role.iter().flat_map(|file| &file.data).collect();
            found.extend(wrong(not, &owned, &data).into_iter().map(Finding::from));
        }
    }
    found.into_iter().chain(absent).collect()
}

/// Once for all data that stand alike.
fn wrong(task: &'static str, owned: &[Owned], data: &[&MachineDatum]) -> Vec<Difference> {
    let groups = grouped(owned.iter().filter_map(|own| {
        let value = data.iter().rev().find(|datum| own.variable == datum.variable);
        let value = value.map(|datum| &datum.value);
        let number = value.and_then(MachineValue::number);
        let is_right = number.is_some_and(|number| own.right.contains(&number));
        let set = value.map_or("not written".to_string(), |value| format!("set to {value}"));
        let stands = format!("{set}, expected {}", own.expected);
        (!is_right).then(|| (stands, format!("{} ({})", own.of, own.datum.0)))
    }));
    groups.into_iter().map(|(stands, data)| Difference::NotSet { task, data, stands }).collect()
}

// Machine and setting data of the compensation: number and name of each, and which of them switch a table.

/// A machine or setting datum: its number, and its name without `$`.
pub(super) type Datum = (&'static str, &'static str);

pub(super) const BACKLASH: Datum = ("MD32450", "MA_BACKLASH");
pub(super) const LEC_ON: Datum = ("MD32700", "MA_ENC_COMP_ENABLE");
pub(super) const LEC_POINTS: Datum = ("MD38000", "MA_MM_ENC_COMP_MAX_POINTS");
pub(super) const CEC_ON: Datum = ("MD32710", "MA_CEC_ENABLE");
pub(super) const CEC_UNIT: Datum = ("MD32711", "MA_CEC_SCALING_SYSTEM_METRIC");
pub(super) const CEC_LIMIT: Datum = ("MD32720", "MA_CEC_MAX_SUM");
pub(super) const CEC_POINTS: Datum = ("MD18342", "MN_MM_CEC_MAX_POINTS");
pub(super) const TABLE_ON: Datum = ("SD41300", "SN_CEC_TABLE_ENABLE");
pub(super) const WEIGHT: Datum = ("SD41310", "SN_CEC_TABLE_WEIGHT");
pub(super) const REFERENCE: Datum = ("MD34100", "MA_REFP_SET_POS");
pub(super) const REFERENCE_MODE: Datum = ("MD34200", "MA_ENC_REFP_MODE");
pub(super) const UNIT: Datum = ("MD10240", "MN_SCALING_SYSTEM_IS_METRIC");
pub(super) const UNIT_CHANGES: Datum = ("MD10260", "MN_CONVERT_SCALING_SYSTEM");

/// A datum as files write it: `$MA_BACKLASH[0,AX1]`.
pub(super) fn variable((_, name): Datum, index: &str) -> String {
    match index {
        "" => format!("${name}"),
        index => format!("${name}[{index}]"),
    }
}

/// The same behind its number.
pub(super) fn numbered(datum: Datum, index: &str) -> String {
    format!("{} {}", datum.0, variable(datum, index))
}

impl SiemensTables {
    /// The number that is held of a datum.
    pub(super) fn number(&self, of: Datum, index: &str) -> Option<f64> {
        self.datum(&variable(of, index))?.value.number()
    }
}

/// The switch of a table, and what reserves its memory.
pub(super) fn of_place(place: &Place) -> [Datum; 2] {
    match place {
        Place::Lec { .. } => [LEC_ON, LEC_POINTS],
        Place::Cec(_) => [TABLE_ON, CEC_POINTS],
    }
}

/// What switches a table on: its own switch first, then that of all CEC tables of an axis.
pub(super) fn switches(table: &SiemensTable) -> Vec<(Datum, String)> {
    let own = (of_place(&table.place)[0], table.place.index());
    let of_axis = table.place.cec().map(|_| (CEC_ON, table.output_axis.clone()));
    std::iter::once(own).chain(of_axis).collect()
}

// What a read-out holds around the tables: limit and unit of CEC.

/// The last digit of a value in a table; sums are not exact in binary.
const LAST_DIGIT: f64 = 1e-6;

/// Preconditions on machine data that no file holds.
pub(super) fn not_held(tables: &SiemensTables, held: &SiemensTables) -> Vec<String> {
    let lacks = |datum, index: &str| held.number(datum, index).is_none();
    let mut absent = Vec::new();
    absent.extend(lacks(UNIT, "").then(|| UNIT.0.to_string()));
    for output in tables.cec_outputs() {
        let lacking = [CEC_LIMIT, CEC_UNIT].into_iter().filter(|datum| lacks(*datum, &output));
        absent.extend(lacking.map(|(number, _)| format!("{number} of {output}")));
    }
    absent
}

/// What else decides how far CEC tables act on an axis: MD32720 cuts their sum, MD32711 (where
/// MD10260 = 1) says their unit.
pub(super) fn cec_limits(
    held: &SiemensTables,
    tables: &SiemensTables,
    unit: ControlUnit,
) -> Vec<InControl> {
    let mut findings = Vec::new();
    for axis in tables.cec_outputs() {
        let sum = tables.largest_cec_sum(&axis);
        let limit = held.number(CEC_LIMIT, &axis);
        if let Some(limit) = limit.filter(|limit| *limit < sum - LAST_DIGIT / 2.0) {
            let sum = (sum / LAST_DIGIT).round() * LAST_DIGIT;
            let (axis, unit) = (axis.clone(), unit.word());
            findings.push(InControl::CutOff { axis, limit, sum, unit });
        }
        let metric = held.number(CEC_UNIT, &axis);
        let converts = held.number(UNIT_CHANGES, "");
        let Some(metric) = metric.filter(|metric| ControlUnit::of_metric(*metric) != unit) else {
            continue;
        };
        let unit = unit.word();
        findings.extend(match converts {
            None => Some(InControl::MayBeCecUnit { axis, metric, unit }),
            Some(on) => (on > 0.0).then_some(InControl::CecUnit { axis, metric, unit }),
        });
    }
    findings
}
