//! LinuxCNC: facts of the tables that `COMP_FILE` names, and of the HAL file for cross terms (docs/linuxcnc.md).

use super::fact::{ControlUnit, Fact, Facts, Mechanism, Outside, TableSign};
use super::family::{Family, LanguageFacts, Proof};
use super::form::{Form, Order, PointLists, Rounding, ValueForm};
use crate::control::table::{ListedTable, ListedTables, Tables};
use crate::quantity::UM_PER_MM;
use crate::text::{section, words};

/// Most joints of a machine (`EMCMOT_MAX_JOINTS` of 2.9); they are numbered from 0.
pub(crate) const MOST_JOINTS: u32 = 16;

pub(super) static FAMILY: Family = Family {
    word: "linuxcnc",
    backlash_parameter: "BACKLASH of the ini file",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Listed(ListedTables::NONE),
    off: "removed",
    restarts: true,
    proofs: &[
        Proof::of(Mechanism::Comp, "COMP_FILE", "trim_sign"),
        Proof::of(Mechanism::Hal, "HAL file", "sum_sign"),
    ],
};

pub(super) static LANGUAGE: LanguageFacts = LanguageFacts {
    metric: "G21",
    inch: "G20",
    dwell: (&['P'], "`G4 P`"),
    numbered: None,
    preconditions: &[[
        "rotation of the active coordinate system (R of G10 L2) and external offsets",
        "0",
        "increments follow a rotated system, and no word of a program takes the rotation off without writing it",
        "LinuxCNC documentation, G-Code, G10 L2; from memory",
    ]],
};

words! {
    /// What the second and the third number of a row hold (`COMP_FILE_TYPE`).
    pub enum Columns {
        /// 0: the position that is reached; the trim is nominal − column.
        Reached = "reached",
        /// 1: the trim, which the control adds.
        Trims = "trims",
    }
}

impl Columns {
    /// The number of `COMP_FILE_TYPE`.
    pub(crate) const fn number(self) -> u32 {
        match self {
            Columns::Reached => 0,
            Columns::Trims => 1,
        }
    }
}

words! {
    /// What corrects one joint by the position of another.
    pub enum CrossTerms {
        /// Nothing.
        None = "none",
        /// Components in a HAL file.
        Hal = "hal",
    }
}

section! {
    /// Facts of the LinuxCNC dialect.
    #[derive(Clone, Debug, PartialEq)]
    pub struct LinuxcncFacts(facts: &Facts<'_>) {
        /// Sense of a trim, what the control does with it.
        pub trim_sign: Fact<TableSign> = stated(), must;
        /// What the columns hold that are written.
        pub columns: Fact<Columns> = stated(), must;
        /// Most rows of a table.
        pub rows: Fact<u32> = within(2.., "at least 2"), must;
        /// Decimals of trims in the machine unit; one count is the last decimal.
        pub value_decimals: Fact<u32> = decimals(), must;
        /// Decimals of positions in the machine unit.
        pub position_decimals: Fact<u32> = decimals(), must;
        /// Where cross terms go.
        pub cross_terms: Fact<CrossTerms> = stated(), must;
        /// Sense of what a HAL file adds to the command of a joint.
        pub sum_sign: Fact<TableSign> = stated(), must;
        /// Most points of a curve (`lincurve`).
        pub curve_points: Fact<u32> = within(2.., "at least 2"), must;
        /// Most numbers of points that are stated when curves are loaded; they repeat.
        pub personalities: Fact<u32> = within(2.., "at least 2"), must;
        /// Most curves of a HAL file.
        pub curves: Fact<u32> = stated(), must;
    }
}

impl PointLists for LinuxcncFacts {
    fn form(&self, is_own: bool, unit: ControlUnit) -> Form {
        let um = unit.in_mm() * UM_PER_MM;
        let (sign, value) = match (is_own, self.columns.value) {
            (false, _) => (self.sum_sign.value, ValueForm::Amount),
            (true, Columns::Trims) => (self.trim_sign.value, ValueForm::Amount),
            (true, Columns::Reached) => (self.trim_sign.value.turned(), ValueForm::Position),
        };
        Form {
            sign,
            value,
            value_um: um,
            is_of_axis: false,
            value_decimals: self.value_decimals.value,
            rounding: Rounding::LastDecimal,
            largest: f64::INFINITY,
            position_um: um,
            position_decimals: self.position_decimals.value,
            order: Order::Ascending,
            has_two: is_own,
            outside: Outside::Hold,
            beyond_travel: true,
            zero_reverse_is_forward: false,
            is_float: is_own,
            is_factor: false,
            names_terms: false,
        }
    }

    fn replaces_parameter(&self) -> bool {
        true
    }

    /// A joint for itself by its section of the ini file.
    fn table_name(&self, table: &ListedTable) -> String {
        let ListedTable { base, output, .. } = table;
        match base == output {
            true => format!("table of JOINT_{output}"),
            false => format!("correction of joint {output} by joint {base}"),
        }
    }
}
