//! LinuxCNC: facts of the tables that `COMP_FILE` names (docs/linuxcnc.md).

use super::fact::{Facts, Mechanism, TableSign, Word, facts};
use super::family::{Family, LanguageFacts, Proof};
use crate::control::table::Tables;
use crate::control::table::linuxcnc::{Columns, LinuxcncTables};

pub(super) static FAMILY: Family = Family {
    word: "linuxcnc",
    backlash_parameter: "BACKLASH of the ini file",
    replaces_backlash: true,
    between: "linear",
    no_tables: Tables::Linuxcnc(LinuxcncTables { joints: Vec::new() }),
    off: "removed",
    restarts: true,
    off_by_hand: ": take COMP_FILE and COMP_FILE_TYPE out of their sections",
    page: Some("docs/linuxcnc.md §3"),
    proofs: &[Proof {
        mechanism: Mechanism::Comp,
        name: "COMP_FILE",
        sign_fact: "trim_sign",
        beside: None,
    }],
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
    }
}

impl LinuxcncFacts {
    /// Reads and checks them.
    pub(super) fn checked(facts: &Facts<'_>) -> Option<LinuxcncFacts> {
        let own = LinuxcncFacts::read(facts)?;
        facts.expect_decimals("value_decimals", &own.value_decimals);
        facts.expect_decimals("position_decimals", &own.position_decimals);
        facts.expect("rows", own.rows.value > 1, "at least 2");
        Some(own)
    }
}
