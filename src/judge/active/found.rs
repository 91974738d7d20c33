//! What was found in a read-out.

use crate::control::claims::Assumption;
use crate::control::controller::LengthUnit;
use crate::control::table::Tables;
use crate::judge::active::{Held, Others};
use crate::quantity::axis::PerAxis;

/// What files that were read out are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadOutFor {
    /// They were active while measuring, and the new tables build on them: what contradicts the
    /// job is refused.
    OldTables,
    /// They are judged as they are now: what contradicts the job is what is looked for, and
    /// nothing that was active while measuring stands in for what they do not hold.
    Judging,
}

impl ReadOutFor {
    /// What happens to what belongs to others.
    pub(super) const fn leaves(self) -> &'static str {
        match self {
            ReadOutFor::OldTables => "left as it is",
            ReadOutFor::Judging => "passed over",
        }
    }
}

/// Files against the job.
pub(super) struct Contrary {
    /// What they hold, and what the job has.
    pub(super) words: String,
    /// What to do.
    pub(super) help: String,
}

impl Contrary {
    pub(super) fn new(words: impl Into<String>, help: impl Into<String>) -> Contrary {
        Contrary {
            words: words.into(),
            help: help.into(),
        }
    }
}

/// `a, b, c and 4 more`
pub(super) fn listed(names: &[String]) -> String {
    const MOST_NAMES: usize = 6;
    let shown = names[..names.len().min(MOST_NAMES)].join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => shown,
        rest => format!("{shown} and {rest} more"),
    }
}

/// What the reader of a dialect found.
pub(super) struct Found {
    /// What acted on the job's axes.
    pub(super) tables: Tables,
    /// What the files hold.
    pub(super) held: Held,
    pub(super) backlash: PerAxis<NamedBacklash>,
    pub(super) others: Others,
    pub(super) assumptions: Vec<Assumption>,
    pub(super) notes: Vec<String>,
    /// Unit of the control, where a file holds it.
    pub(super) unit: Option<LengthUnit>,
    /// What contradicts the job.
    pub(super) contrary: Vec<Contrary>,
    /// What acts on the job's axes and is not emulated.
    pub(super) beside: Vec<String>,
}

/// The backlash parameters that axes of the control hold, µm, by the control's names.
pub(super) type NamedBacklash = Vec<(String, Option<f64>)>;

/// A correction of an axis of the job that follows an axis it does not have.
pub(super) fn beside_words(what: &str, moving: &str) -> String {
    format!(
        "{what} follows axis {moving}, which the job does not have: it is not in the forecast, and changes the error wherever {moving} stands elsewhere"
    )
}
