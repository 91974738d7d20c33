//! LinuxCNC: one table for each joint, the file that `COMP_FILE` names (docs/linuxcnc.md §1).
//!
//! Positions and values are in the machine unit of the joint (mm or inch), as in the file.

/// Most joints of a machine (`EMCMOT_MAX_JOINTS` of 2.9); they are numbered from 0.
pub const MOST_JOINTS: u32 = 16;

/// What the second and the third number of a row hold (`COMP_FILE_TYPE`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// 0: the position that is reached; the trim is nominal − column.
    Reached,
    /// 1: the trim, which the control adds.
    Trims,
}

impl Columns {
    /// The number of `COMP_FILE_TYPE`.
    pub const fn number(self) -> u32 {
        match self {
            Columns::Reached => 0,
            Columns::Trims => 1,
        }
    }
}

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Position of the joint.
    pub nominal: f64,
    /// Column 2, used while the joint moves up.
    pub forward: f64,
    /// Column 3, used while it moves down.
    pub reverse: f64,
}

/// The table of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct CompTable {
    /// The joint, n of `[JOINT_n]`.
    pub joint: u32,
    /// What the columns hold.
    pub columns: Columns,
    /// The rows, ascending.
    pub rows: Vec<Row>,
}

impl CompTable {
    /// The section of the ini file that names it: `JOINT_0`.
    pub(crate) fn name(&self) -> String {
        format!("JOINT_{}", self.joint)
    }
}

/// All tables, ascending by joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinuxcncTables {
    /// The tables.
    pub joints: Vec<CompTable>,
}

impl LinuxcncTables {
    /// The table of a joint.
    pub(crate) fn of_joint(&self, joint: u32) -> Option<&CompTable> {
        self.joints.iter().find(|table| table.joint == joint)
    }
}
