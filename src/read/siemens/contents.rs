//! What the files of a control hold, and the files of a kit put together.

use crate::control::controller::ControlUnit;
use crate::control::table::siemens::{CecTable, LecTable, SiemensTables};
use crate::text::finding::Finding;
use crate::text::problem::{Problem, Problems};

/// What one file, or all files of a kit together, write into a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiemensContents {
    /// The tables; `lec` in the order of axis and encoder, `cec` in the order of its number.
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
    /// What else there is to know of a file that a control wrote.
    pub read_out: ReadOut,
}

/// What there is to know of a file that a control wrote, beside its tables and data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOut {
    /// How many data were ignored, as they are of no concern.
    pub passed_over: usize,
    /// Tables that are reserved but hold no grid (STEP 0), such as `AN_CEC[3]`.
    pub without_grid: Vec<String>,
    /// Names of its part programs, such as `NONIUS_EEC_MPF`.
    pub programs: Vec<String>,
    /// Whether they write tables.
    pub programs_write_tables: bool,
    /// Variables of concern that the file holds with two values.
    pub twice: Vec<String>,
    /// The units that its data are in, where it says so (`METRIC`, `INCH`).
    pub units: Vec<ControlUnit>,
}

impl ReadOut {
    fn extend(&mut self, other: ReadOut) {
        self.passed_over += other.passed_over;
        self.without_grid.extend(other.without_grid);
        self.programs.extend(other.programs);
        self.programs_write_tables |= other.programs_write_tables;
        self.twice.extend(other.twice);
        self.units.extend(other.units);
    }
}

/// One `$MA_`, `$MN_` or `$SN_` assignment.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineDatum {
    /// Name without `$`, upper case, such as `MA_ENC_COMP_ENABLE`.
    pub name: String,
    /// What stood in brackets: whole numbers without leading zeros, axis names in upper case.
    pub indices: Vec<String>,
    /// The value.
    pub value: MachineValue,
}

impl MachineDatum {
    /// As files write it: `$MA_BACKLASH[0,AX1]`.
    pub fn variable(&self) -> String {
        variable_text(&self.name, &self.indices)
    }
}

/// A variable as files write it, with its indices where it has any.
pub(super) fn variable_text(name: &str, indices: &[String]) -> String {
    match indices.join(",") {
        none if none.is_empty() => format!("${name}"),
        indices => format!("${name}[{indices}]"),
    }
}

/// Value of a machine or setting datum, in the control's own unit.
#[derive(Clone, Debug, PartialEq)]
pub enum MachineValue {
    /// A number; `TRUE` is 1 and `FALSE` is 0.
    Number(f64),
    /// A name in parentheses or quotes, upper case.
    Text(String),
}

/// Whether a machine or setting datum switches tables on and off, and so is made for being changed.
pub(crate) fn is_switch(name: &str) -> bool {
    matches!(name, "MA_ENC_COMP_ENABLE" | "MA_CEC_ENABLE" | "SN_CEC_TABLE_ENABLE")
}

/// Puts the files of a kit into one memory, in the order in which they are loaded.
///
/// A point or parameter that two files write with different values is a problem, because the
/// result would depend on the order of loading. The switches `ENC_COMP_ENABLE`, `CEC_ENABLE` and
/// `CEC_TABLE_ENABLE` are made for being changed: of these the last one counts.
pub fn merge(contents: Vec<SiemensContents>) -> Result<SiemensContents, Problems> {
    let mut problems = Problems::none();
    let mut all = SiemensContents::default();
    for file in contents {
        for table in file.tables.lec {
            merge_lec(&mut all.tables.lec, table, &mut problems);
        }
        for table in file.tables.cec {
            merge_cec(&mut all.tables.cec, table, &mut problems);
        }
        for datum in file.machine_data {
            merge_datum(&mut all.machine_data, datum, &mut problems);
        }
        all.notes.extend(file.notes);
        all.unwritten.extend(file.unwritten);
        all.idle.extend(file.idle);
        all.read_out.extend(file.read_out);
    }
    let place = |table: &LecTable| (table.axis.clone(), table.encoder);
    all.tables.lec.sort_by_key(place);
    all.tables.cec.sort_by_key(|table| table.number);
    problems.or_ok(all)
}

fn merge_lec(all: &mut Vec<LecTable>, mut table: LecTable, problems: &mut Problems) {
    let same = |known: &&mut LecTable| known.axis == table.axis && known.encoder == table.encoder;
    let Some(known) = all.iter_mut().find(same) else {
        all.push(table);
        return;
    };
    let name = format!("$AA_ENC_COMP[{},{}]", table.encoder, table.axis);
    merge_values(&name, &mut known.values, &mut table.values, problems);
    if *known != table {
        problems.push(conflict(&format!("the parameters of {name}")));
    }
}

fn merge_cec(all: &mut Vec<CecTable>, mut table: CecTable, problems: &mut Problems) {
    let Some(known) = all.iter_mut().find(|known| known.number == table.number) else {
        all.push(table);
        return;
    };
    let name = format!("$AN_CEC[{}]", table.number);
    merge_values(&name, &mut known.values, &mut table.values, problems);
    if *known != table {
        problems.push(conflict(&format!("the parameters of {name}")));
    }
}

/// Makes the points of both the same; exact, as all were read from decimal digits. What is left
/// different are parameters.
fn merge_values(
    name: &str,
    known: &mut [Option<f64>],
    values: &mut [Option<f64>],
    problems: &mut Problems,
) {
    for (point, (known, value)) in known.iter_mut().zip(values).enumerate() {
        if let (Some(a), Some(b)) = (*known, *value)
            && (a - b).abs() > 0.0
        {
            problems.push(conflict(&format!("point {point} of {name} ({a} and {b})")));
        }
        *known = known.or(*value);
        *value = *known;
    }
}

fn merge_datum(all: &mut Vec<MachineDatum>, datum: MachineDatum, problems: &mut Problems) {
    let same =
        |known: &&mut MachineDatum| known.name == datum.name && known.indices == datum.indices;
    match all.iter_mut().find(same) {
        None => all.push(datum),
        Some(known) if is_switch(&datum.name) => known.value = datum.value,
        Some(known) if known.value == datum.value => {}
        Some(_) => problems.push(conflict(&datum.variable())),
    }
}

fn conflict(what: &str) -> Problem {
    Problem::new(format!("two files write {what} with different values"))
        .help("what the control holds would depend on the order of loading; remove one of the two")
}
