//! Corrected readings: means over runs, their repeatability, and their increments, filed under the
//! machine interval that a step crosses.

use super::curves::{mean, range};
use crate::inputs::target_runs::Runs;
use crate::machine::standards::iso_230_2;
use crate::quantity::{Axis, Diagonal, Direction, Pass, PathKind, PerDiagonal, Run, Volume};
use crate::text::Problem;

/// The mean of the runs of a pass along a diagonal.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Forward or reverse.
    pub pass: Pass,
    /// How many runs it is the mean of.
    pub runs: f64,
    /// Mean reading errors, µm, by node of the forward path.
    pub um: Vec<f64>,
}

/// Which readings stand for a curve: of every axis moving in this direction, forward passes of the diagonals that travel
/// so and reverse passes of the others; or the forward pass of all, with axes that a diagonal walks in − mixed in.
pub type Group = Option<Direction>;

/// The pass along a diagonal on which a group finds the steps of an axis.
pub(super) fn pass_of(group: Group, diagonal: Diagonal, axis: Axis) -> Pass {
    let is_forward = group.is_none_or(|direction| direction == diagonal.forward(axis));
    if is_forward { Pass::Forward } else { Pass::Reverse }
}

/// The passes that were walked: forward, then reverse, each by diagonal.
pub fn walks(runs: &[Run]) -> Vec<Walk> {
    let all = Pass::BOTH.into_iter().flat_map(|pass| Diagonal::ALL.map(|d| (d, pass)));
    let walk = |(diagonal, pass)| {
        let own: Vec<&Run> = of(runs, diagonal, pass).collect();
        let of_node = |node: usize| mean(own.iter().map(|run| run.deviations[node].um()));
        let um = (0..own.first()?.deviations.len()).map(of_node).collect();
        Some(Walk { diagonal, pass, runs: own.len() as f64, um })
    };
    all.filter_map(walk).collect()
}

/// The runs of one pass along a diagonal.
pub(super) fn of(
    runs: &[Run],
    diagonal: Diagonal,
    pass: Pass,
) -> impl Iterator<Item = &Run> + Clone {
    runs.iter().filter(move |run| run.diagonal == diagonal && run.pass == pass)
}

/// The readings of all runs of a pass along a diagonal at some of its nodes; `None` where it was not walked.
fn by_node(
    runs: &[Run],
    (diagonal, pass): (Diagonal, Pass),
    spacing: usize,
) -> Option<Vec<Vec<f64>>> {
    let walks = of(runs, diagonal, pass);
    let nodes = (0..walks.clone().next()?.deviations.len()).step_by(spacing);
    let at = |node: usize| walks.clone().map(|run| run.deviations[node].um()).collect();
    Some(nodes.map(at).collect())
}

/// Repeatability of a pass along a diagonal as in ISO 230-2: R = 4 s, the largest over its nodes,
/// µm; `None` with fewer than two runs. Each run counts from its own zero, as it was read.
pub(crate) fn repeatability_um(runs: &[Run], diagonal: Diagonal, pass: Pass) -> Option<f64> {
    let nodes = by_node(runs, (diagonal, pass), 1)?;
    let places = (0..nodes.len()).map(|node| node as f64);
    let runs = Runs::new(places.collect(), Some(nodes), None);
    iso_230_2::figures(&runs.ok()?).axis.r.up_um
}

/// Every how many nodes the target is on the diagonal: between the cell ends of a step run it is
/// beside it.
fn spacing(kind: PathKind) -> usize {
    if kind == PathKind::Step { 3 } else { 1 }
}

/// Runs of one diagonal over its cell ends (step) or nodes (straight) as runs of a standard's test; up =
/// forward.
pub(crate) fn diagonal_runs(
    volume: &Volume,
    kind: PathKind,
    diagonal: Diagonal,
    runs: &[Run],
) -> Result<Runs, Problem> {
    let nodes = (0..=volume.last_node(kind)).step_by(spacing(kind));
    let targets = nodes.map(|node| volume.nominal_mm(diagonal, kind, node));
    let [up, down] = Pass::BOTH.map(|pass| by_node(runs, (diagonal, pass), spacing(kind)));
    Runs::new(targets.collect(), up, down)
}

/// Figures of one diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalFigures {
    /// Reading error at the far end less that at the start, mean of all runs, µm.
    pub end_um: f64,
    /// Max − min over the nodes that lie on the diagonal, both passes, µm.
    pub range_um: f64,
}

/// Figures of every diagonal, and max − min over all of them, µm.
pub fn figures(runs: &[Run], kind: PathKind) -> (PerDiagonal<DiagonalFigures>, f64) {
    let walks = walks(runs);
    let of = |d: Diagonal| walks.iter().filter(move |walk| walk.diagonal == d);
    let on_diagonal = |d| of(d).flat_map(|walk| walk.um.iter().step_by(spacing(kind)));
    let figures = PerDiagonal::from_fn(|d| {
        // Far end less start of a pass, so that an offset between the passes does not count.
        let total = |walk: &Walk| Some(walk.um.last()? - walk.um.first()?);
        DiagonalFigures {
            end_um: mean(of(d).filter_map(total)),
            range_um: range(on_diagonal(d).copied()),
        }
    });
    let all = Diagonal::ALL.into_iter().flat_map(on_diagonal);
    (figures, range(all.copied()))
}
