//! ISG kernel, TwinCAT CNC: facts of the volumetric compensation (docs/isg.md).

use super::fact::{Facts, Mechanism, Outside, TableSign, facts};
use super::family::{Family, Proof};
use crate::control::table::Tables;
use crate::control::table::isg::IsgTables;
use crate::text::words::words;

pub(super) static FAMILY: Family = Family {
    word: "isg",
    backlash_parameter: "backlash compensation of the axis list",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Isg(IsgTables::NONE),
    off: "removed",
    restarts: false,
    off_by_hand: ": `#VOLCOMP OFF`",
    page: Some("docs/isg.md §3"),
    proofs: &[Proof {
        mechanism: Mechanism::Volcomp,
        name: "volumetric compensation",
        sign_fact: "error_sign",
        beside: None,
    }],
};

words! {
    /// Where the control counts levers from.
    pub enum LeverOrigin {
        /// Position 0 of each axis.
        MachineZero = "machine_zero",
        /// The reference point.
        Reference = "reference",
    }
}

facts! {
    /// Facts of the ISG dialect.
    IsgFacts {
        /// Sense of the deviations.
        error_sign: TableSign,
        /// Sense of the angles: `as_error` = right-handed, as ISO 230-1 has them.
        angle_sign: TableSign,
        /// Where levers count from.
        lever_origin: LeverOrigin,
        /// Most records of a compensation (`max_records` as it is set).
        records: u32,
        /// Decimals of deviations in mm; one count is the last decimal.
        value_decimals: u32,
        /// Decimals of angles in rad.
        angle_decimals: u32,
        /// Decimals of positions in mm.
        position_decimals: u32,
    }
}

impl IsgFacts {
    /// Reads and checks them.
    pub(super) fn checked(facts: &Facts<'_>) -> Option<IsgFacts> {
        let own = IsgFacts::read(facts)?;
        facts.expect_decimals("value_decimals", &own.value_decimals);
        facts.expect_decimals("angle_decimals", &own.angle_decimals);
        facts.expect_decimals("position_decimals", &own.position_decimals);
        facts.expect("records", own.records.value > 1, "at least 2");
        Some(own)
    }
}
