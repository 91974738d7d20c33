//! Klipper: facts of its skew correction (docs/klipper.md).

use super::fact::{Fact, Facts, Mechanism, Outside, TableSign};
use super::family::{Family, Proof};
use crate::control::table::Tables;
use crate::control::table::klipper::KlipperTables;
use crate::text::document::section;

pub(super) static FAMILY: Family = Family {
    word: "klipper",
    backlash_parameter: "backlash parameter (Klipper has none)",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Klipper(KlipperTables { skew: None }),
    off: "removed",
    restarts: true,
    off_by_hand: ": `SET_SKEW CLEAR=1`",
    page: Some("docs/klipper.md §3"),
    proofs: &[Proof {
        mechanism: Mechanism::Skew,
        name: "skew correction",
        sign_fact: "skew_sign",
        beside: None,
    }],
};

section! {
    /// Facts of the Klipper dialect.
    #[derive(Clone, Debug, PartialEq)]
    pub struct KlipperFacts(facts: &Facts<'_>) {
        /// Sense of a factor: `as_error` = how far the machine leans.
        pub skew_sign: Fact<TableSign> = stated(), must;
        /// Decimals of a factor.
        pub value_decimals: Fact<u32> = decimals(), must;
    }
}
