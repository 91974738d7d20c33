//! Positioning figures by standard, from the runs of an axis or of the body diagonals.
//!
//! [`iso_230_2`] and [`vdi_3441`] take the [`Runs`] of one axis; [`diagonal`] takes those of the
//! body diagonals. A figure that the data cannot give is absent (`None`), never estimated. The
//! conditions of a standard that a file can show are tested, the others are named as not tested:
//! docs/standards.md lists formulas, editions and how surely they are known.

pub mod iso_230_2;
pub mod vdi_3441;

use crate::standards::iso_230_2::AxisFigures;
use crate::target_runs::Runs;

/// How surely a formula or a condition is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confidence {
    /// The same in all sources, and recomputed on measured data.
    Sure,
    /// From secondary sources; not compared with the text of the standard.
    Likely,
}

impl Confidence {
    /// `sure` or `likely`.
    pub const fn word(self) -> &'static str {
        match self {
            Confidence::Sure => "sure",
            Confidence::Likely => "likely",
        }
    }
}

/// How surely the formulas of VDI/DGQ 3441 are known.
pub const VDI_3441: Confidence = Confidence::Likely;
/// How surely the formulas of ISO 230-2 are known.
pub const ISO_230_2: Confidence = Confidence::Sure;
/// How surely the conditions of ISO 230-2 (targets, runs, 2 m) are known.
pub const ISO_230_2_CONDITIONS: Confidence = Confidence::Likely;
/// How surely the figures of ISO 230-6 and ASME B5.54 are known.
pub const DIAGONALS: Confidence = Confidence::Likely;

/// Whether a condition of a standard is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// The data meet it.
    Yes,
    /// The data do not meet it; figures are not according to the standard.
    No,
    /// The data cannot show it.
    NotTested,
}

impl Met {
    /// `met`, `not met` or `not tested`.
    pub const fn word(self) -> &'static str {
        match self {
            Met::Yes => "met",
            Met::No => "not met",
            Met::NotTested => "not tested",
        }
    }
}

/// A condition of a standard.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// What the standard asks for.
    pub asked: String,
    /// What the data show; empty where they cannot show it.
    pub found: String,
    /// The outcome.
    pub met: Met,
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

/// Largest of some values; `None` of none.
fn largest(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().reduce(f64::max)
}

/// Largest minus smallest of some values; `None` of none.
fn range(values: impl IntoIterator<Item = f64> + Clone) -> Option<f64> {
    let smallest = values.clone().into_iter().reduce(f64::min)?;
    Some(largest(values)? - smallest)
}

/// How the runs along a diagonal were made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiagonalMotion {
    /// All three axes moved at once, along the diagonal.
    StraightRuns,
    /// One axis after the other; the runs hold the ends of the cells.
    StepDiagonalCellEnds,
}

impl DiagonalMotion {
    /// How the figures have to be labelled.
    pub const fn label(self) -> &'static str {
        match self {
            DiagonalMotion::StraightRuns => "after ISO 230-6 (likely)",
            DiagonalMotion::StepDiagonalCellEnds => "from step-diagonal cell ends, not ISO 230-6",
        }
    }
}

/// Figures of one body diagonal.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagonalFigures {
    /// Its name, e.g. `PPN`.
    pub name: String,
    /// E, M, B, B̄, R and A as for an axis, on the coordinate along the diagonal.
    pub figures: AxisFigures,
    /// Largest minus smallest mean deviation over all directions that were measured, µm: E where
    /// both were, E↑ or E↓ where one was.
    pub range_um: Option<f64>,
}

/// Figures of the body diagonals and of the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagonals {
    /// How they have to be labelled.
    pub label: &'static str,
    /// Each diagonal, in the order given.
    pub diagonals: Vec<DiagonalFigures>,
    /// E_d of ISO 230-6; absent unless there are four diagonals in both directions.
    pub e_d_um: Option<f64>,
    /// B_d of ISO 230-6; absent unless there are four diagonals in both directions.
    pub b_d_um: Option<f64>,
    /// Largest range of a single diagonal, in the style of ASME B5.54; absent unless there are four.
    pub largest_range_um: Option<f64>,
    /// Range over all diagonals together, in the style of ASME B5.54; absent unless there are four.
    pub range_over_all_um: Option<f64>,
}

/// Body diagonals of a machine.
const BODY_DIAGONALS: usize = 4;

/// Figures of the body diagonals, in the style of ISO 230-6 and ASME B5.54.
///
///   per diagonal   E↑ E↓ E M B B̄ R A as in [`iso_230_2::figures`], on the diagonal's coordinate
///   E_d = max E     B_d = max B                                 over the four body diagonals
///   largest range = max over the diagonals of (largest − smallest mean deviation)
///   range over all = largest − smallest mean deviation of all four together
///
/// shape  one name and one [`Runs`] for each diagonal; up = the forward run
/// unit   targets: mm along the diagonal from its start; deviations: µm along the diagonal
/// source ISO 230-6:2002 and ASME B5.54, both likely: from secondary sources. Whether R and A are
///        reported, and how many runs are asked for, has to be looked up before conformity is claimed
/// limits ISO 230-6 asks for straight motion; cell ends of a step-diagonal run lie on the same
///        line but were reached by another motion, see [`DiagonalMotion::label`]. The range over
///        all depends on the zero of each diagonal: here its first target, as the readings have it
pub fn diagonal(diagonals: &[(&str, &Runs)], motion: DiagonalMotion) -> Diagonals {
    let figures: Vec<DiagonalFigures> = diagonals
        .iter()
        .map(|(name, runs)| DiagonalFigures {
            name: (*name).to_string(),
            figures: iso_230_2::figures(runs).axis,
            range_um: range(means_um(runs)),
        })
        .collect();
    let means: Vec<f64> = diagonals
        .iter()
        .flat_map(|(_, runs)| means_um(runs))
        .collect();
    let complete = figures.len() == BODY_DIAGONALS;
    let of_machine = |figure: &dyn Fn(&DiagonalFigures) -> Option<f64>| {
        let all: Option<Vec<f64>> = figures.iter().map(figure).collect();
        largest(all.filter(|_| complete)?)
    };
    Diagonals {
        label: motion.label(),
        e_d_um: of_machine(&|of| of.figures.e.both_um),
        b_d_um: of_machine(&|of| of.figures.b_um),
        largest_range_um: of_machine(&|of| of.range_um),
        range_over_all_um: range(means).filter(|_| complete),
        diagonals: figures,
    }
}

/// Mean deviations x̄_i↑ and x̄_i↓ of all targets, µm.
fn means_um(runs: &Runs) -> Vec<f64> {
    let targets = iso_230_2::figures(runs).targets;
    targets
        .iter()
        .flat_map(|target| [target.mean.up_um, target.mean.down_um])
        .flatten()
        .collect()
}
