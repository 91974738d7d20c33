//! Positioning figures by standard, from the runs of an axis or of the body diagonals.
//!
//! [`iso_230_2`] and [`vdi_3441`] take the [`crate::inputs::target_runs::Runs`] of one axis; [`diagonal`]
//! takes those of the body diagonals. A figure that the data cannot give is absent (`None`), never estimated. The
//! conditions of a standard that a file can show are tested, the others are named as not tested:
//! docs/standards.md lists formulas, editions and how surely they are known.

use crate::inputs::target_runs::Runs;
use crate::quantity::{Direction, Figure, ends};
use crate::text::words;
use serde::{Serialize, Serializer};

mod diagonals;
pub mod iso_230_2;
pub mod vdi_3441;

pub use self::diagonals::{DiagonalFigures, Diagonals, diagonal};
pub(crate) use self::diagonals::{by_standard, repeatability_um};

/// How surely a formula or a condition is known: the same in all sources, and recomputed on measured data.
pub const SURE: &str = "sure";
/// From secondary sources; not compared with the text of the standard.
pub const LIKELY: &str = "likely";
/// How surely the formulas of VDI/DGQ 3441 are known.
pub const VDI_3441: &str = LIKELY;
/// How surely the formulas of ISO 230-2 are known.
pub const ISO_230_2: &str = SURE;
/// How surely the figures of ISO 230-6 and ASME B5.54 are known.
pub const DIAGONALS: &str = LIKELY;

words! {
    /// Whether a condition of a standard is met.
    pub enum Met {
        /// The data meet it.
        Yes = "met",
        /// The data do not meet it; figures are not according to the standard.
        No = "not met",
        /// The data cannot show it.
        NotTested = "not tested",
    }
}

impl Met {
    const fn of(yes: bool) -> Met {
        if yes { Met::Yes } else { Met::No }
    }
}

/// A condition of a standard.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// What the standard asks for.
    pub asked: String,
    /// What the data show; empty where they cannot show it.
    #[serde(serialize_with = "null_if_empty")]
    pub found: String,
    /// The outcome.
    #[serde(rename = "outcome")]
    pub met: Met,
    /// Editions that ask for it, by their year.
    pub editions: &'static [u16],
    /// How surely it is known that they do.
    pub confidence: &'static str,
}

fn null_if_empty<S: Serializer>(found: &str, to: S) -> Result<S::Ok, S::Error> {
    (!found.is_empty()).then_some(found).serialize(to)
}

impl Condition {
    /// One that is likely asked for.
    fn likely(
        editions: &'static [u16],
        asked: impl Into<String>,
        found: impl Into<String>,
        met: Met,
    ) -> Condition {
        Condition { asked: asked.into(), found: found.into(), met, editions, confidence: LIKELY }
    }

    /// What was found where a condition is not met.
    pub fn missed(conditions: &[Condition]) -> Vec<String> {
        conditions.iter().filter(|of| of.met == Met::No).map(|of| of.found.clone()).collect()
    }
}

/// All conditions of a standard.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conditions {
    /// One by one.
    pub list: Vec<Condition>,
}

/// Numbers of runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// ↑, in the + direction.
    pub up: usize,
    /// ↓, in the - direction.
    pub down: usize,
}

impl Counts {
    /// How many runs there are of each direction.
    pub(crate) fn of(runs: &Runs) -> Counts {
        let [up, down] = Direction::BOTH.map(|way| runs.count(way));
        Counts { up, down }
    }
}

/// A figure moving up, moving down and of both; `None` where the data cannot give it. µm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByDirection {
    /// ↑, approached in the + direction.
    pub up_um: Option<f64>,
    /// ↓, approached in the - direction.
    pub down_um: Option<f64>,
    /// Of both directions.
    pub both_um: Option<f64>,
}

impl ByDirection {
    const fn of([up_um, down_um]: [Option<f64>; 2], both_um: Option<f64>) -> ByDirection {
        ByDirection { up_um, down_um, both_um }
    }
}

/// Largest of some values; `None` of none.
fn largest(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().reduce(f64::max)
}

/// Largest minus smallest of some values; `None` of none.
fn range(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (low, high) = ends(values.into_iter());
    (low <= high).then_some(high - low)
}

/// A length in mm without zeros at its end.
pub(crate) fn in_words(mm: f64) -> String {
    Figure(mm).trimmed(4)
}
