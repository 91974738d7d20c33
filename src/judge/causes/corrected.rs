//! A slip in the records of the first measurement, and what it was corrected to.

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
