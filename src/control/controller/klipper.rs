//! Klipper: facts of its skew correction (docs/klipper.md).

use super::fact::{Facts, Mechanism, Outside, TableSign, facts};
use super::family::{Family, Proof};
use crate::control::table::Tables;
use crate::control::table::klipper::KlipperTables;

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

facts! {
    /// Facts of the Klipper dialect.
    KlipperFacts {
        /// Sense of a factor: `as_error` = how far the machine leans.
        skew_sign: TableSign,
        /// Decimals of a factor.
        value_decimals: u32,
    }
}

impl KlipperFacts {
    /// Reads and checks them.
    pub(super) fn checked(facts: &Facts<'_>) -> Option<KlipperFacts> {
        let own = KlipperFacts::read(facts)?;
        facts.expect_decimals("value_decimals", &own.value_decimals);
        Some(own)
    }
}
