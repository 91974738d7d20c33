//! ISO 230-6 and ASME B5.54: figures of the body diagonals.

use super::iso_230_2::{self, Travel};
use super::{Condition, Conditions, Counts, Met, largest, range};
use crate::inputs::target_runs::Runs;
use crate::machine::separation::readings::{by_node, spacing};
use crate::quantity::{Diagonal, Pass, PathKind, Run, Volume};
use crate::text::{NamedEntries, Problem};
use serde::Serialize;

/// Repeatability of a pass along a diagonal as in ISO 230-2: R = 4 s, the largest over its nodes,
/// µm; `None` with fewer than two runs. Each run counts from its own zero, as it was read.
pub(crate) fn repeatability_um(runs: &[Run], diagonal: Diagonal, pass: Pass) -> Option<f64> {
    let nodes = by_node(runs, diagonal, pass)?;
    let runs = Runs::new((0..nodes.len()).map(|node| node as f64).collect(), Some(nodes), None);
    iso_230_2::figures(&runs.ok()?).axis.r.up_um
}

/// Figures of the body diagonals by standard, over cell ends (step) or nodes (straight); up = forward. `runs`: only those that count from the start of the forward run, or the two directions
/// cannot be compared; `length_is_known`: whether somebody knows the size of the box.
pub(crate) fn by_standard(
    volume: &Volume,
    kind: PathKind,
    runs: &[Run],
    length_is_known: bool,
) -> Result<Diagonals, Problem> {
    let of = |d: Diagonal| {
        let nodes = (0..=volume.last_node(kind)).step_by(spacing(kind));
        let targets = nodes.map(|node| volume.nominal_mm(d, kind, node));
        let [up, down] = Pass::BOTH
            .map(|pass| Some(by_node(runs, d, pass)?.into_iter().step_by(spacing(kind)).collect()));
        Ok((d.name(), Runs::new(targets.collect(), up, down)?))
    };
    let runs = Diagonal::ALL.into_iter().map(of).collect::<Result<Vec<_>, Problem>>()?;
    let named: Vec<(&str, &Runs)> = runs.iter().map(|(name, runs)| (*name, runs)).collect();
    Ok(diagonal(&named, kind, length_is_known))
}

/// Edition of ISO 230-6 that is meant.
const EDITION: [u16; 1] = [2002];

/// Figures of one body diagonal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiagonalFigures {
    /// Number of its targets.
    pub targets: usize,
    /// Its runs up and down.
    pub runs: Counts,
    /// E, M, B, B̄, R and A as for an axis, on the coordinate along the diagonal.
    #[serde(flatten)]
    pub figures: iso_230_2::Figures,
    /// Largest minus smallest mean deviation over all directions that were measured, µm: E where
    /// both were, E↑ or E↓ where one was.
    pub range_um: Option<f64>,
}

/// Figures of the body diagonals and of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagonals {
    /// How they have to be labelled: by the motion, and by the conditions that are missed.
    pub label: String,
    /// Each diagonal by its name, e.g. `PPN`, in the order given.
    pub(crate) diagonals: NamedEntries<String, DiagonalFigures>,
    /// E_d of ISO 230-6; absent unless there are four diagonals in both directions.
    #[serde(rename = "E_d_um")]
    pub e_d_um: Option<f64>,
    /// B_d of ISO 230-6; absent unless there are four diagonals in both directions.
    #[serde(rename = "B_d_um")]
    pub b_d_um: Option<f64>,
    /// Largest range of a single diagonal, in the style of ASME B5.54; absent unless there are four.
    pub largest_range_um: Option<f64>,
    /// Range over all diagonals together, in the style of ASME B5.54; absent unless there are four.
    pub range_over_all_um: Option<f64>,
    /// Conditions of ISO 230-6.
    pub conditions: Conditions,
}

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
///        line but were reached by another motion, and the label says so. The range over
///        all depends on the zero of each diagonal: here its first target, as the readings have it
///        Where nobody knows the size of the box (`length_is_known`), no figure depends on the targets'
///        places along the diagonal, but whether they are enough cannot be determined
pub fn diagonal(diagonals: &[(&str, &Runs)], kind: PathKind, length_is_known: bool) -> Diagonals {
    let mut means = Vec::new();
    let figures = diagonals.iter().map(|(name, runs)| {
        let figures = iso_230_2::figures(runs);
        // Mean deviations x̄_i↑ and x̄_i↓ of all targets, µm.
        let own = figures.targets.iter().flat_map(|of| [of.mean.up_um, of.mean.down_um]);
        let own: Vec<f64> = own.flatten().collect();
        means.extend_from_slice(&own);
        let (targets, runs) = (figures.targets.len(), Counts::of(runs));
        ((*name).to_string(), DiagonalFigures { targets, runs, figures, range_um: range(own) })
    });
    let figures: NamedEntries<String, DiagonalFigures> = figures.collect();
    let complete = diagonals.len() == Diagonal::ALL.len();
    let of_machine = |figure: fn(&DiagonalFigures) -> Option<f64>| {
        let all: Option<Vec<f64>> = figures.iter().map(|(_, of)| figure(of)).collect();
        largest(all.filter(|_| complete)?)
    };
    let conditions = conditions(diagonals, kind, length_is_known);
    let missed = Condition::missed(&conditions);
    let label = match kind {
        PathKind::Straight if !missed.is_empty() => {
            format!("NOT after ISO 230-6: {}", missed.join("; "))
        }
        PathKind::Straight => "after ISO 230-6 (likely)".to_string(),
        PathKind::Step => "from step-diagonal cell ends, not ISO 230-6".to_string(),
    };
    Diagonals {
        label,
        e_d_um: of_machine(|of| of.figures.axis.e.both_um),
        b_d_um: of_machine(|of| of.figures.axis.b_um),
        largest_range_um: of_machine(|of| of.range_um),
        range_over_all_um: range(means).filter(|_| complete),
        diagonals: figures,
        conditions: Conditions { list: conditions },
    }
}

/// Conditions of ISO 230-6: motion, the four diagonals, and targets and approaches as in ISO 230-2.
fn conditions(
    diagonals: &[(&str, &Runs)],
    kind: PathKind,
    length_is_known: bool,
) -> Vec<Condition> {
    let targets = diagonals.iter().filter_map(|(name, runs)| {
        let travel = Travel::of(runs, None).ok().filter(|_| length_is_known)?;
        Some((*name, iso_230_2::number_of_targets(runs, travel)))
    });
    let likely = |asked: &str, found: &str, met| Condition::likely(&EDITION, asked, found, met);
    // A condition that every diagonal has to meet; what is said is that of the first that does not.
    let of_all = |asked: &str, unknown: &str, each: Vec<(&str, Condition)>| match (
        each.iter().find(|(_, of)| of.met == Met::No),
        each.first(),
    ) {
        (Some((name, of)), _) => likely(asked, &format!("{name}: {}", of.found), Met::No),
        (None, Some((_, of))) => likely(asked, &of.found, Met::Yes),
        (None, None) => likely(asked, unknown, Met::NotTested),
    };
    let straight = kind == PathKind::Straight;
    let names: Vec<&str> = diagonals.iter().map(|(name, _)| *name).collect();
    let directions = diagonals.iter().map(|(name, runs)| (*name, iso_230_2::directions(runs)));
    let runs = diagonals.first().map_or_else(String::new, |(_, runs)| iso_230_2::runs_words(runs));
    vec![
        likely(
            "all three axes move at once, straight along the diagonal",
            if straight { "straight runs" } else { "single-axis steps" },
            Met::of(straight),
        ),
        likely(
            "the four body diagonals",
            &names.join(", "),
            Met::of(diagonals.len() == Diagonal::ALL.len()),
        ),
        of_all(
            "targets as in ISO 230-2: five per metre and at least five",
            "the length of the diagonals is not known",
            targets.collect(),
        ),
        of_all("approach in both directions", "", directions.collect()),
        likely(
            "number of runs, whether R and A are reported: to be looked up in the standard",
            &runs,
            Met::NotTested,
        ),
    ]
}
