//! SINUMERIK: facts of ENC_COMP and CEC tables (docs/siemens.md).

use super::fact::{Facts, Mechanism, Outside, TableForm, TableSign, facts};
use super::family::{Family, LanguageFacts, Proof};
use crate::control::table::Tables;
use crate::control::table::siemens::SiemensTables;
use crate::text::words::words;

pub(super) static FAMILY: Family = Family {
    word: "siemens",
    backlash_parameter: "backlash parameter (MD32450)",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Siemens(SiemensTables { lec: Vec::new(), cec: Vec::new() }),
    off: "0",
    restarts: false,
    off_by_hand: ", see to it by hand",
    page: Some("docs/siemens.md §4.2"),
    proofs: &[
        Proof {
            mechanism: Mechanism::EncComp,
            name: "ENC_COMP (LEC)",
            sign_fact: "lec_sign",
            beside: None,
        },
        Proof {
            mechanism: Mechanism::Cec,
            name: "CEC",
            sign_fact: "cec_sign",
            beside: Some(
                "MD32710 switches every CEC table of an axis, also those that are not of this kit (K3 p. 245): note their SD41300, set it to 0 while the proof lasts, and put it back",
            ),
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
        "docs/program.md §3",
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

facts! {
    /// Facts of the Siemens dialect: ENC_COMP and CEC tables (docs/siemens.md).
    SiemensFacts {
        /// Sense of `$AA_ENC_COMP` values.
        lec_sign: TableSign,
        /// Sense of `$AN_CEC` values.
        cec_sign: TableSign,
        /// Program or data form.
        table_form: TableForm,
        /// Most points of one ENC_COMP table.
        lec_points: u32,
        /// Number of CEC tables of the control.
        cec_tables: u32,
        /// Most points of one CEC table.
        cec_points: u32,
        /// Whether the points of a CEC table are fixed by the option (no MD18342 to set).
        cec_memory_fixed: bool,
        /// Decimals of table values in the control's unit; one count is the last decimal.
        value_decimals: u32,
        /// Decimals of MIN, STEP and MAX in the control's unit.
        position_decimals: u32,
        /// Clamp of the CEC total (MD32720), µm.
        cec_max_sum_um: f64,
        /// Contribution of a table that names a factor table.
        multiply_mode: MultiplyMode,
        /// Whether a table used as a factor also contributes by itself.
        factor_contributes: bool,
    }
}

impl SiemensFacts {
    /// Reads and checks them.
    pub(super) fn checked(facts: &Facts<'_>) -> Option<SiemensFacts> {
        let own = SiemensFacts::read(facts)?;
        facts.expect_decimals("value_decimals", &own.value_decimals);
        facts.expect_decimals("position_decimals", &own.position_decimals);
        Some(own)
    }
}
