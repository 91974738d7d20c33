//! FANUC: facts of the stored pitch error compensation and of straightness (docs/fanuc.md).

use super::fact::{ControlUnit, Fact, Facts, Mechanism, NumberRange, Outside, TableSign};
use super::family::{Family, LanguageFacts, Proof};
use crate::control::table::Tables;
use crate::control::table::fanuc::FanucMemory;
use crate::text::{section, words};

pub(super) static FAMILY: Family = Family {
    word: "fanuc",
    backlash_parameter: "backlash parameter (1851)",
    between: "step",
    outside: &[Outside::Hold],
    no_tables: Tables::Fanuc(FanucMemory::NONE),
    off: "0",
    restarts: true,
    proofs: &[
        Proof::of(Mechanism::Pitch, "pitch error compensation", "pitch_sign"),
        Proof {
            beside: Some(
                "alarm PW5046 instead: the control refuses the set; where axes and points are right, the slope of the bump (from memory, its limit is not known): lower `limits.max_bump_um`",
            ),
            ..Proof::of(Mechanism::FourPoint, "straightness compensation", "straightness_sign")
        },
        Proof::of(Mechanism::PerPoint, "straightness compensation", "straightness_sign"),
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
    /// Form of the straightness compensation (docs/fanuc.md §2.4, §2.5).
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

section! {
    /// Facts of the Fanuc dialect: stored pitch error compensation (docs/fanuc.md).
    #[derive(Clone, Debug, PartialEq)]
    pub struct FanucFacts(facts: &Facts<'_>) {
        /// Sense of pitch data.
        pub pitch_sign: Fact<TableSign> = stated(), must;
        /// Sense of straightness data.
        pub straightness_sign: Fact<TableSign> = stated(), must;
        /// Digits of a number below 10000 (`N03620` or `N3620`).
        pub number_digits: Fact<u32> = stated(), must;
        /// Whether blocks carry `Q1` (parameter) and `Q0` (pitch data), and `L1` before a parameter of the path.
        pub q_identifier: Fact<bool> = stated(), must;
        /// What is added to a point number in a file.
        pub point_offset: Fact<u32> = stated(), must;
        /// Numbers that pitch points may have.
        pub pitch_points: Fact<Vec<NumberRange>> = stated(), must;
        /// Numbers that the second run of a bidirectional table may have.
        pub minus_points: Fact<Vec<NumberRange>> = stated(), must;
        /// Largest increment of one point.
        pub increment_max: Fact<u32> = within(1.., "at least 1"), must;
        /// Largest magnification (3623).
        pub magnification_max: Fact<u32> = within(1.., "at least 1"), must;
        /// How 3624 is written.
        pub interval_form: Fact<IntervalForm> = stated(), must;
        /// Decimals of 3624 on a metric control (with `Integer`: of the least input increment).
        pub interval_decimals_mm: Fact<u32> = decimals(), must;
        /// Decimals of 3624 on an inch control.
        pub interval_decimals_inch: Fact<u32> = decimals(), must;
        /// The interval must be at least the largest feed (per minute) divided by this.
        pub interval_feed_divisor: Fact<f64> = stated(), must;
        /// Where inside its section a pulse comes out, 0 = lower end, 1 = upper end.
        pub output_fraction: Fact<f64> = within(0.0..1.0, "between 0 and 1"), must;
        /// Whether 3627 is multiplied by the magnification.
        pub reversal_magnified: Fact<bool> = stated(), must;
        /// Form of the straightness compensation.
        pub straightness_form: Fact<StraightnessForm> = stated(), must;
        /// Number of straightness sets.
        pub straightness_sets: Fact<u32> = stated(), must;
        /// Most pitch points of a moving axis that has straightness compensation.
        pub straightness_axis_points: Fact<u32> = stated(), must;
        /// Numbers of straightness data (per-point form).
        pub straightness_points: Fact<Vec<NumberRange>> = stated(), must;
        /// First parameter of the magnifications (per-point form), set 1.
        pub straightness_magnification_parameter: Fact<u32> = stated(), must;
        /// First parameter of the first data numbers (per-point form), set 1.
        pub straightness_start_parameter: Fact<u32> = stated(), must;
        /// Largest amount of the four-point form, detection units.
        pub straightness_amount_max: Fact<u32> = stated(), must;
    }
}

impl FanucFacts {
    /// Decimals of 3624 on a control with this basic system.
    pub(crate) const fn interval_decimals(&self, unit: ControlUnit) -> u32 {
        match unit {
            ControlUnit::Millimetre => self.interval_decimals_mm.value,
            ControlUnit::Inch => self.interval_decimals_inch.value,
        }
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
