//! SINUMERIK: facts of ENC_COMP and CEC tables (docs/siemens.md).

use super::fact::{Fact, Facts, Mechanism, Outside, TableForm, TableSign};
use super::family::{Family, LanguageFacts, Proof};
use crate::control::table::Tables;
use crate::control::table::siemens::{Place, SiemensTables};
use crate::text::{section, words};

pub(super) static FAMILY: Family = Family {
    word: "siemens",
    backlash_parameter: "backlash parameter (MD32450)",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Siemens(SiemensTables::NONE),
    off: "0",
    restarts: false,
    proofs: &[
        Proof::of(Mechanism::EncComp, "ENC_COMP (LEC)", "lec_sign"),
        Proof {
            beside: Some(
                "MD32710 switches every CEC table of an axis, also those that are not of this kit (K3 p. 245): note their SD41300, set it to 0 while the proof lasts, and put it back",
            ),
            ..Proof::of(Mechanism::Cec, "CEC", "cec_sign")
        },
    ],
};

pub(super) static LANGUAGE: LanguageFacts = LanguageFacts {
    metric: "G710",
    inch: "G700",
    dwell: (&['F'], "`G4 F`"),
    numbered: None,
    preconditions: &[[
        "basic frames and DRF offset",
        "no rotation, scaling or mirroring; DRF off",
        "increments follow a rotated, scaled or mirrored frame",
        "docs/measuring.md §3",
    ]],
};

words! {
    /// How a table t that names a factor table m contributes (docs/siemens.md §2.4).
    pub enum MultiplyMode {
        /// `f_t · f_m` instead of `f_t`.
        Product = "product",
        /// `f_t + f_t · f_m`.
        Additive = "additive",
    }
}

section! {
    /// Facts of the Siemens dialect: ENC_COMP and CEC tables (docs/siemens.md).
    #[derive(Clone, Debug, PartialEq)]
    pub struct SiemensFacts(facts: &Facts<'_>) {
        /// Sense of `$AA_ENC_COMP` values.
        pub lec_sign: Fact<TableSign> = stated(), must;
        /// Sense of `$AN_CEC` values.
        pub cec_sign: Fact<TableSign> = stated(), must;
        /// Program or data form.
        pub table_form: Fact<TableForm> = stated(), must;
        /// Most points of one ENC_COMP table.
        pub lec_points: Fact<u32> = stated(), must;
        /// Number of CEC tables of the control.
        pub cec_tables: Fact<u32> = stated(), must;
        /// Most points of one CEC table.
        pub cec_points: Fact<u32> = stated(), must;
        /// Whether the points of a CEC table are fixed by the option (no MD18342 to set).
        pub cec_memory_fixed: Fact<bool> = stated(), must;
        /// Decimals of table values in the control's unit; one count is the last decimal.
        pub value_decimals: Fact<u32> = decimals(), must;
        /// Decimals of MIN, STEP and MAX in the control's unit.
        pub position_decimals: Fact<u32> = decimals(), must;
        /// Clamp of the CEC total (MD32720), µm.
        pub cec_max_sum_um: Fact<f64> = stated(), must;
        /// Contribution of a table that names a factor table.
        pub multiply_mode: Fact<MultiplyMode> = stated(), must;
        /// Whether a table used as a factor also contributes by itself.
        pub factor_contributes: Fact<bool> = stated(), must;
    }
}

impl SiemensFacts {
    /// Sense of the values of a table, and how many points it has at most.
    pub(crate) fn of_place(&self, place: &Place) -> (TableSign, u32) {
        match place {
            Place::Lec { .. } => (self.lec_sign.value, self.lec_points.value),
            Place::Cec(_) => (self.cec_sign.value, self.cec_points.value),
        }
    }
}
