//! What the files of a control hold.

use crate::control::table::siemens::SiemensTables;

/// What one file, or all files of a kit together, write into a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiemensContents {
    /// The tables; `lec` in the order of axis and encoder, `cec` in the order of its number.
    pub tables: SiemensTables,
    /// Machine and setting data, in the order of their first assignment, with their last value.
    pub machine_data: Vec<MachineDatum>,
    /// Remarks for the user that are no problem.
    pub notes: Vec<String>,
    /// Parameters of tables that the file does not write, such as `IS_MODULO of $AN_CEC[0]`: the control
    /// keeps an older one. They are read as 0, the value of a table that was never written.
    pub unwritten: Vec<String>,
    /// Tables of a control that hold zeros and no usable grid, such as `AN_CEC[3]`.
    pub idle: Vec<String>,
}

/// Statements of one file that concern the compensation, and points of its tables. The largest read-out
/// seen has 900; 31 axes with the 5000 points of the largest table have 155 000.
pub const MOST_STATEMENTS: usize = 200_000;

/// Tables of one file, and machine data: 62 and 31 tables and some 800 data are what a control has.
pub(super) const MOST_TABLES: usize = 1000;

pub(super) const MOST_DATA: usize = 10_000;

/// Who wrote a file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Writer {
    /// A program or a person, for a control to load.
    Kit,
    /// The control, which writes what it holds.
    Control,
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
pub(crate) fn variable_text(name: &str, indices: &[String]) -> String {
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
pub fn is_switch(name: &str) -> bool {
    matches!(
        name,
        "MA_ENC_COMP_ENABLE" | "MA_CEC_ENABLE" | "SN_CEC_TABLE_ENABLE"
    )
}
