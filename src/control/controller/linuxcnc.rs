//! LinuxCNC: facts of the tables that `COMP_FILE` names, and of the HAL file for cross terms (docs/linuxcnc.md).

use super::fact::{Facts, Mechanism, Outside, TableSign, facts};
use super::family::{Family, LanguageFacts, Proof};
use crate::control::table::Tables;
use crate::control::table::linuxcnc::{Columns, LinuxcncTables};
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

facts! {
    /// Facts of the LinuxCNC dialect.
    LinuxcncFacts {
        /// Sense of a trim, what the control does with it.
        trim_sign: TableSign,
        /// What the columns hold that are written.
        columns: Columns,
        /// Most rows of a table.
        rows: u32,
        /// Decimals of trims in the machine unit; one count is the last decimal.
        value_decimals: u32,
        /// Decimals of positions in the machine unit.
        position_decimals: u32,
        /// Where cross terms go.
        cross_terms: CrossTerms,
        /// Sense of what a HAL file adds to the command of a joint.
        sum_sign: TableSign,
        /// Most points of a curve (`lincurve`).
        curve_points: u32,
        /// Most numbers of points that are stated when curves are loaded; they repeat.
        personalities: u32,
        /// Most curves of a HAL file.
        curves: u32,
    }
}

impl LinuxcncFacts {
    /// Reads and checks them.
    pub(super) fn checked(facts: &Facts<'_>) -> Option<LinuxcncFacts> {
        let own = LinuxcncFacts::read(facts)?;
        facts.expect_decimals("value_decimals", &own.value_decimals);
        facts.expect_decimals("position_decimals", &own.position_decimals);
        let at_least_2 = [
            ("rows", &own.rows),
            ("curve_points", &own.curve_points),
            ("personalities", &own.personalities),
        ];
        for (name, fact) in at_least_2 {
            facts.expect(name, fact.value > 1, "at least 2");
        }
        Some(own)
    }
}
