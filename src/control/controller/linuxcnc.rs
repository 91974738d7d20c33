//! LinuxCNC: facts of the tables that `COMP_FILE` names, and of the HAL file for cross terms (docs/linuxcnc.md).

use super::fact::{Fact, Facts, Mechanism, Outside, TableSign};
use super::family::{Family, LanguageFacts, Proof};
use crate::control::table::Tables;
use crate::control::table::linuxcnc::{Columns, LinuxcncTables};
use crate::text::document::section;
use crate::text::words::{Word, words};

pub(super) static FAMILY: Family = Family {
    word: "linuxcnc",
    backlash_parameter: "BACKLASH of the ini file",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Linuxcnc(LinuxcncTables { joints: Vec::new(), cross: Vec::new() }),
    off: "removed",
    restarts: true,
    off_by_hand: ": take COMP_FILE and COMP_FILE_TYPE out of their sections",
    page: Some("docs/linuxcnc.md §3"),
    proofs: &[
        Proof {
            mechanism: Mechanism::Comp,
            name: "COMP_FILE",
            sign_fact: "trim_sign",
            beside: None,
        },
        Proof { mechanism: Mechanism::Hal, name: "HAL file", sign_fact: "sum_sign", beside: None },
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

impl Word for Columns {
    const WORDS: &'static [(&'static str, Columns)] =
        &[("reached", Columns::Reached), ("trims", Columns::Trims)];
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
