//! ISG kernel, TwinCAT CNC: facts of the volumetric compensation (docs/isg.md).

use super::fact::{Fact, Facts, Mechanism, Outside, TableSign};
use super::family::{Family, Proof};
use crate::control::table::Tables;
use crate::control::table::isg::IsgTables;
use crate::text::{section, words};

pub(super) static FAMILY: Family = Family {
    word: "isg",
    backlash_parameter: "backlash compensation of the axis list",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Isg(IsgTables::NONE),
    off: "removed",
    restarts: false,
    proofs: &[Proof::of(Mechanism::Volcomp, "volumetric compensation", "error_sign")],
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

section! {
    /// Facts of the ISG dialect.
    #[derive(Clone, Debug, PartialEq)]
    pub struct IsgFacts(facts: &Facts<'_>) {
        /// Sense of the deviations.
        pub error_sign: Fact<TableSign> = stated(), must;
        /// Sense of the angles: `as_error` = right-handed, as ISO 230-1 has them.
        pub angle_sign: Fact<TableSign> = stated(), must;
        /// Where levers count from.
        pub lever_origin: Fact<LeverOrigin> = stated(), must;
        /// Most records of a compensation (`max_records` as it is set).
        pub records: Fact<u32> = within(2.., "at least 2"), must;
        /// Decimals of deviations in mm; one count is the last decimal.
        pub value_decimals: Fact<u32> = decimals(), must;
        /// Decimals of angles in rad.
        pub angle_decimals: Fact<u32> = decimals(), must;
        /// Decimals of positions in mm.
        pub position_decimals: Fact<u32> = decimals(), must;
    }
}
