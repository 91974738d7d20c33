//! Slips in the records of the first measurement: its readings belong to another machine than the
//! one that was separated from them.
//!
//! ```text
//!   readings, filed right ─→ separated again ─→ as found, truly
//!   as found, truly + what the loaded tables add  =  as left
//! ```
//! To the closure an order of the steps is the same as one way to share out the names (docs/method.md
//! §4). Separated they are not: the names put other readings to an axis, the order another axis to
//! the readings. So the second measurement tells them apart, and both are tried.

use super::question::{Question, deviation_um};
use crate::judge::after::Part;
use crate::machine::model::ErrorModel;
use crate::quantity::axis::Axis;
use crate::quantity::diagonal::Diagonal;

/// What may have been recorded wrongly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slip {
    /// The readings of two diagonals were saved under each other's name.
    Names(Diagonal, Diagonal),
    /// The steps went in this order, not in that of the job.
    Order([Axis; 3]),
}

impl Slip {
    /// The six exchanges of two names and the five orders other than the recorded one.
    pub fn all(recorded: [Axis; 3]) -> Vec<Slip> {
        let names = Diagonal::ALL.into_iter().enumerate();
        let pairs = names.flat_map(|(index, one)| {
            let others = Diagonal::ALL.into_iter().skip(index + 1);
            others.map(move |other| Slip::Names(one, other))
        });
        let others = Axis::ORDERS.into_iter().filter(|order| *order != recorded);
        pairs.chain(others.map(Slip::Order)).collect()
    }

    /// Its kind among the causes.
    pub(super) const fn kind(self) -> &'static str {
        match self {
            Slip::Names(..) => "names exchanged",
            Slip::Order(_) => "wrong order",
        }
    }

    pub(super) fn subject(self) -> String {
        match self {
            Slip::Names(one, other) => {
                format!("the readings of {one} and {other} of the first measurement")
            }
            Slip::Order(_) => "the steps of the first measurement".to_string(),
        }
    }

    pub(super) fn predicate(self) -> String {
        match self {
            Slip::Names(..) => {
                "were saved under each other's name, and the tables were made from that".to_string()
            }
            Slip::Order([first, second, third]) => format!(
                "went {first}, {second}, {third}, not as the job says, and the tables were made from that"
            ),
        }
    }

    /// What settles it.
    pub(super) const fn check(self) -> &'static str {
        match self {
            Slip::Names(..) => {
                "compare the names in the file of the first readings with the programs that were run, or run one of the two diagonals again"
            }
            Slip::Order(_) => {
                "compare the order in the job of the first measurement with the programs that were run"
            }
        }
    }
}

/// What the first readings are once a slip is taken back.
#[derive(Clone, Debug)]
pub struct Corrected {
    /// The slip.
    pub slip: Slip,
    /// The machine without tables, from the same readings, filed right.
    pub before: ErrorModel,
}

impl Corrected {
    /// What a part was as found beyond what the records say, µm; `None` = not measured there.
    fn beyond_um(&self, question: &Question<'_>, part: &Part) -> Option<f64> {
        Some(deviation_um(&self.before, part)? - deviation_um(question.before, part)?)
    }

    /// Whether it has an answer wherever the second measurement looked.
    pub(super) fn answers(&self, question: &Question<'_>) -> bool {
        let mut parts = question.seen.iter().flat_map(|o| &o.parts);
        parts.all(|part| self.beyond_um(question, part).is_some())
    }
}

/// What the machine was beyond the records if they hold this slip, µm.
pub(super) fn beyond_um(question: &Question<'_>, slip: Slip, part: &Part) -> f64 {
    let mut all = question.corrected.iter();
    let own = all.find(|corrected| corrected.slip == slip);
    // Only what answers everywhere is tried.
    own.and_then(|own| own.beyond_um(question, part))
        .unwrap_or(0.0)
}
