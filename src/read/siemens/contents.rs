//! What the files of a control hold, and the files of a kit put together.

use crate::control::controller::ControlUnit;
use crate::control::table::siemens::{SiemensTable, SiemensTables};
use crate::text::{Finding, Problem, Problems};
use std::collections::BTreeSet;
use std::fmt;

/// What one file, or all files of a kit together, write into a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiemensContents {
    /// The tables.
    pub tables: SiemensTables,
    /// Machine and setting data, in the order of their first assignment, with their last value.
    pub machine_data: Vec<MachineDatum>,
    /// Remarks for the user that are no problem.
    pub notes: Vec<Finding>,
    /// Parameters of tables that the file does not write, such as `IS_MODULO of $AN_CEC[0]`: the control
    /// keeps an older one. They are read as 0, the value of a table that was never written.
    pub unwritten: Vec<String>,
    /// Tables of a control that hold zeros and no usable grid, such as `AN_CEC[3]`.
    pub idle: Vec<String>,
    /// Of files that a control wrote, how many data were ignored, as they are of no concern.
    pub passed_over: usize,
    /// Tables that are reserved but hold no grid (STEP 0), such as `AN_CEC[3]`.
    pub without_grid: Vec<String>,
    /// Names of its part programs, such as `NONIUS_EEC_MPF`.
    pub programs: Vec<String>,
    /// Whether they write tables.
    pub programs_write_tables: bool,
    /// Variables of concern that are held with two values, switches also those of several files.
    pub twice: BTreeSet<String>,
    /// The units that its data are in, where it says so (`METRIC`, `INCH`).
    pub units: Vec<ControlUnit>,
}

/// One `$MA_`, `$MN_` or `$SN_` assignment.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineDatum {
    /// As files write it: `$MA_BACKLASH[0,AX1]`; whole numbers without leading zeros, names in upper case.
    pub variable: String,
    /// The value.
    pub value: MachineValue,
}

/// Value of a machine or setting datum, in the control's own unit.
#[derive(Clone, Debug, PartialEq)]
pub enum MachineValue {
    /// A number; `TRUE` is 1 and `FALSE` is 0.
    Number(f64),
    /// A name in parentheses or quotes, upper case.
    Text(String),
}

impl MachineValue {
    /// The number.
    pub(crate) fn number(&self) -> Option<f64> {
        match self {
            MachineValue::Number(number) => Some(*number),
            MachineValue::Text(_) => None,
        }
    }
}

impl fmt::Display for MachineValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MachineValue::Number(number) => write!(f, "{number}"),
            MachineValue::Text(text) => f.write_str(text),
        }
    }
}

/// What data hold of a variable.
pub(crate) fn datum<'a>(data: &'a [MachineDatum], variable: &str) -> Option<&'a MachineDatum> {
    data.iter().find(|datum| datum.variable == variable)
}

/// Whether a machine or setting datum switches tables on and off, and so is made for being changed.
pub(crate) fn is_switch(variable: &str) -> bool {
    let name = variable.split('[').next();
    matches!(name, Some("$MA_ENC_COMP_ENABLE" | "$MA_CEC_ENABLE" | "$SN_CEC_TABLE_ENABLE"))
}

/// Puts the files of a kit into one memory, in the order in which they are loaded.
///
/// A point or parameter that two files write with different values is a problem, because the
/// result would depend on the order of loading. The switches `ENC_COMP_ENABLE`, `CEC_ENABLE` and
/// `CEC_TABLE_ENABLE` are made for being changed: of these the last one counts.
pub fn merge(contents: Vec<SiemensContents>) -> Result<SiemensContents, Problems> {
    let mut problems = Problems::none();
    let mut all = SiemensContents::default();
    let mut tables: Vec<SiemensTable> = Vec::new();
    for file in contents {
        for mut table in file.tables.tables {
            match tables.iter_mut().find(|known| known.place == table.place) {
                Some(known) => merge_table(known, &mut table, &mut problems),
                None => tables.push(table),
            }
        }
        for datum in file.machine_data {
            match all.machine_data.iter_mut().find(|known| known.variable == datum.variable) {
                None => all.machine_data.push(datum),
                Some(known) if known.value == datum.value => {}
                Some(known) if is_switch(&datum.variable) => {
                    known.value = datum.value;
                    all.twice.insert(datum.variable);
                }
                Some(_) => problems.push(conflict(&datum.variable)),
            }
        }
        all.notes.extend(file.notes);
        all.unwritten.extend(file.unwritten);
        all.idle.extend(file.idle);
        all.passed_over += file.passed_over;
        all.without_grid.extend(file.without_grid);
        all.programs.extend(file.programs);
        all.programs_write_tables |= file.programs_write_tables;
        all.twice.extend(file.twice);
        all.units.extend(file.units);
    }
    all.tables = SiemensTables::of(tables);
    problems.or_ok(all)
}

/// Makes the points of both the same; exact, as all were read from decimal digits. What is left
/// different are parameters.
fn merge_table(known: &mut SiemensTable, table: &mut SiemensTable, problems: &mut Problems) {
    let place = &table.place;
    for (point, (known, value)) in known.values.iter_mut().zip(&mut table.values).enumerate() {
        if let (Some(a), Some(b)) = (*known, *value)
            && (a - b).abs() > 0.0
        {
            problems.push(conflict(&format!("point {point} of ${place} ({a} and {b})")));
        }
        *known = known.or(*value);
        *value = *known;
    }
    if known != table {
        problems.push(conflict(&format!("the parameters of ${place}")));
    }
}

fn conflict(what: &str) -> Problem {
    Problem::new(format!("two files write {what} with different values"))
        .help("what the control holds would depend on the order of loading; remove one of the two")
}
