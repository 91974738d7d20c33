//! FANUC: facts of the stored pitch error compensation and of straightness (docs/fanuc.md).

use super::fact::{Facts, Mechanism, NumberRange, Outside, TableSign, facts};
use super::family::{Family, LanguageFacts, Proof};
use crate::control::table::Tables;
use crate::control::table::fanuc::FanucMemory;
use crate::text::words::words;
use std::collections::BTreeMap;

pub(super) static FAMILY: Family = Family {
    word: "fanuc",
    backlash_parameter: "backlash parameter (1851)",
    between: "step",
    outside: &[Outside::Hold],
    no_tables: Tables::Fanuc(FanucMemory { parameters: BTreeMap::new(), points: BTreeMap::new() }),
    off: "0",
    restarts: true,
    off_by_hand: ": 3623 = 0 stops the pitch points of an axis (assumed)",
    page: Some("docs/fanuc.md §4.2"),
    proofs: &[
        Proof {
            mechanism: Mechanism::Pitch,
            name: "pitch error compensation",
            sign_fact: "pitch_sign",
            beside: None,
        },
        Proof {
            mechanism: Mechanism::FourPoint,
            name: "straightness compensation",
            sign_fact: "straightness_sign",
            beside: Some(
                "alarm PW5046 instead: the control refuses the set; where axes and points are right, the slope of the bump (from memory, its limit is not known): lower `limits.max_bump_um`",
            ),
        },
        Proof {
            mechanism: Mechanism::PerPoint,
            name: "straightness compensation",
            sign_fact: "straightness_sign",
            beside: None,
        },
    ],
};

/// Evidence of what no available manual was read for.
const FROM_MEMORY: &str = "assumed: from memory, not in the manuals read";

pub(super) static LANGUAGE: LanguageFacts = LanguageFacts {
    metric: "G21",
    inch: "G20",
    dwell: (&['X', 'U'], "`G04 X` or `G04 U`"),
    numbered: Some((8000, "parameter 3202, NE8 and NE9")),
    preconditions: &[
        [
            "mirror image of the machine",
            "off for every axis, by setting (0012#0) and by signal",
            "G50.1 cancels the programmed mirror image only; under another one increments go the wrong way",
            FROM_MEMORY,
        ],
        [
            "manual handle interruption",
            "none, or cancelled (reference return) before cycle start",
            "G91 counts from the commanded position: what the handle added shifts every node",
            FROM_MEMORY,
        ],
    ],
};

words! {
    /// Form of the straightness compensation (docs/fanuc.md §2.1, §2.2).
    pub enum StraightnessForm {
        /// Three straight pieces through four points.
        FourPoint = "four-point",
        /// One increment for each pitch point of the moving axis, up to 128.
        PerPoint = "per-point",
    }
}

words! {
    /// How parameter 3624 (interval) is written.
    pub enum IntervalForm {
        /// A real number in mm or inch, with a decimal point.
        Real = "real",
        /// An integer in least input increments.
        Integer = "integer",
    }
}

facts! {
    /// Facts of the Fanuc dialect: stored pitch error compensation (docs/fanuc.md).
    FanucFacts {
        /// Sense of pitch data.
        pitch_sign: TableSign,
        /// Sense of straightness data.
        straightness_sign: TableSign,
        /// Digits of a number below 10000 (`N03620` or `N3620`).
        number_digits: u32,
        /// Whether blocks carry `Q1` (parameter) and `Q0` (pitch data), and `L1` before a parameter of the path.
        q_identifier: bool,
        /// What is added to a point number in a file.
        point_offset: u32,
        /// Numbers that pitch points may have.
        pitch_points: Vec<NumberRange>,
        /// Numbers that the second run of a bidirectional table may have.
        minus_points: Vec<NumberRange>,
        /// Largest increment of one point.
        increment_max: u32,
        /// Largest magnification (3623).
        magnification_max: u32,
        /// How 3624 is written.
        interval_form: IntervalForm,
        /// Decimals of 3624 on a metric control (with `Integer`: of the least input increment).
        interval_decimals_mm: u32,
        /// Decimals of 3624 on an inch control.
        interval_decimals_inch: u32,
        /// The interval must be at least the largest feed (per minute) divided by this.
        interval_feed_divisor: f64,
        /// Where inside its section a pulse comes out, 0 = lower end, 1 = upper end.
        output_fraction: f64,
        /// Whether 3627 is multiplied by the magnification.
        reversal_magnified: bool,
        /// Form of the straightness compensation.
        straightness_form: StraightnessForm,
        /// Number of straightness sets.
        straightness_sets: u32,
        /// Most pitch points of a moving axis that has straightness compensation.
        straightness_axis_points: u32,
        /// Numbers of straightness data (per-point form).
        straightness_points: Vec<NumberRange>,
        /// First parameter of the magnifications (per-point form), set 1.
        straightness_magnification_parameter: u32,
        /// First parameter of the first data numbers (per-point form), set 1.
        straightness_start_parameter: u32,
        /// Largest amount of the four-point form, detection units.
        straightness_amount_max: u32,
    }
}

impl FanucFacts {
    /// Reads and checks them.
    pub(super) fn checked(facts: &Facts<'_>) -> Option<FanucFacts> {
        let own = FanucFacts::read(facts)?;
        facts.expect_decimals("interval_decimals_mm", &own.interval_decimals_mm);
        facts.expect_decimals("interval_decimals_inch", &own.interval_decimals_inch);
        let fraction = own.output_fraction.value;
        facts.expect("output_fraction", fraction < 1.0, "between 0 and 1");
        let at_least_1 =
            [("increment_max", &own.increment_max), ("magnification_max", &own.magnification_max)];
        for (name, fact) in at_least_1 {
            facts.expect(name, fact.value > 0, "at least 1");
        }
        Some(own)
    }

    /// Whether a parameter holds the magnification or the first data number of a per-point set.
    pub(crate) fn is_of_per_point_set(&self, number: u32) -> bool {
        let firsts =
            [&self.straightness_magnification_parameter, &self.straightness_start_parameter];
        let sets = self.straightness_sets.value;
        let mut firsts = firsts.iter().map(|first| first.value);
        firsts.any(|first| (first..first + sets).contains(&number))
    }
}
