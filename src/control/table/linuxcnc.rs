//! LinuxCNC: one table for each joint, the file that `COMP_FILE` names (docs/linuxcnc.md §1), and the curves
//! of a HAL file by which one joint corrects another (§6).
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

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position of the joint that is looked up.
    pub position: f64,
    /// What is added there.
    pub value: f64,
}

/// What one joint gets because another one stands somewhere: curves that add up, each straight between its
/// points and held outside.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossTable {
    /// The joint that is looked up.
    pub base: u32,
    /// The joint that is corrected.
    pub output: u32,
    /// The curves, points ascending.
    pub pieces: Vec<Vec<Point>>,
}

impl CrossTable {
    /// `joint 1 by joint 0`.
    pub(crate) fn name(&self) -> String {
        format!("joint {} by joint {}", self.output, self.base)
    }
}

/// All tables, ascending by joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinuxcncTables {
    /// The tables of joints for themselves.
    pub joints: Vec<CompTable>,
    /// What a HAL file adds, ascending by output and base.
    pub cross: Vec<CrossTable>,
}

impl LinuxcncTables {
    /// The table of a joint.
    pub(crate) fn of_joint(&self, joint: u32) -> Option<&CompTable> {
        self.joints.iter().find(|table| table.joint == joint)
    }
}
