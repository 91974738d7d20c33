//! Corrected readings: means over runs, their repeatability, and their increments, filed under the
//! machine interval that a step crosses.

use super::curves::{mean, range};
use crate::inputs::target_runs::Runs;
use crate::machine::standards::iso_230_2;
use crate::quantity::axis::{Axis, Direction};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run, Volume};
use crate::text::problem::Problem;

/// One corrected run, µm, by node.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrectedRun {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Number of the run, as in the file.
    pub number: u32,
    /// Forward or reverse.
    pub pass: Pass,
    /// Reading errors, µm.
    pub readings_um: Vec<f64>,
}

impl From<&Run> for CorrectedRun {
    /// The readings as they stand.
    fn from(run: &Run) -> CorrectedRun {
        let readings_um = run.deviations.iter().map(|of| of.um()).collect();
        CorrectedRun { diagonal: run.diagonal, number: run.number, pass: run.pass, readings_um }
    }
}

/// Mean reading errors of one pass along each diagonal, µm, by node of the forward path.
pub type PassMeans = PerDiagonal<Vec<f64>>;

/// How many runs stand behind the means of each pass: forward, reverse.
pub type RunCounts = PerDiagonal<[f64; 2]>;

/// Which readings stand for a curve: of every axis moving in this direction, forward passes of the diagonals that travel
/// so and reverse passes of the others; or the forward pass of all, with axes that a diagonal walks in − mixed in.
pub type Group = Option<Direction>;

/// The pass along a diagonal on which a group finds the steps of an axis.
pub(super) fn pass_of(group: Group, diagonal: Diagonal, axis: Axis) -> Pass {
    let is_forward = group.is_none_or(|direction| direction == diagonal.forward(axis));
    if is_forward { Pass::Forward } else { Pass::Reverse }
}

/// Mean reading errors of all passes that were walked.
#[derive(Clone, Debug, PartialEq)]
pub struct Means {
    /// Forward.
    pub forward: PassMeans,
    /// Reverse, if every diagonal was walked back.
    pub reverse: Option<PassMeans>,
}

impl Means {
    /// The readings of a pass; those of the forward pass where there is no other.
    pub fn of(&self, pass: Pass) -> &PassMeans {
        match (pass, &self.reverse) {
            (Pass::Reverse, Some(reverse)) => reverse,
            _ => &self.forward,
        }
    }
}

/// Mean of the runs of each pass. The reverse pass counts only if every diagonal has it.
pub fn means(runs: &[CorrectedRun]) -> Means {
    let walked_back = |diagonal| of(runs, diagonal, Pass::Reverse).next().is_some();
    let walked_back = Diagonal::ALL.into_iter().all(walked_back);
    Means {
        forward: pass_means(runs, Pass::Forward),
        reverse: walked_back.then(|| pass_means(runs, Pass::Reverse)),
    }
}

/// How many runs each pass along each diagonal has.
pub fn run_counts(runs: &[CorrectedRun]) -> RunCounts {
    PerDiagonal::from_fn(|diagonal| {
        Pass::BOTH.map(|pass| of(runs, diagonal, pass).map(|_| 1.0).sum())
    })
}

/// The runs of one pass along a diagonal.
pub(super) fn of(
    runs: &[CorrectedRun],
    diagonal: Diagonal,
    pass: Pass,
) -> impl Iterator<Item = &CorrectedRun> + Clone {
    runs.iter().filter(move |run| run.diagonal == diagonal && run.pass == pass)
}

/// The readings of all runs of a pass along a diagonal at some of its nodes; `None` where it was not walked.
fn by_node(
    runs: &[CorrectedRun],
    (diagonal, pass): (Diagonal, Pass),
    spacing: usize,
) -> Option<Vec<Vec<f64>>> {
    let walks = of(runs, diagonal, pass);
    let nodes = (0..walks.clone().next()?.readings_um.len()).step_by(spacing);
    let at = |node: usize| walks.clone().map(|run| run.readings_um[node]).collect();
    Some(nodes.map(at).collect())
}

fn pass_means(runs: &[CorrectedRun], pass: Pass) -> PassMeans {
    PerDiagonal::from_fn(|diagonal| {
        let nodes = by_node(runs, (diagonal, pass), 1).unwrap_or_default();
        nodes.into_iter().map(|readings| mean(readings.into_iter())).collect()
    })
}

/// Repeatability of a pass along a diagonal as in ISO 230-2: R = 4 s, the largest over its nodes,
/// µm; `None` with fewer than two runs. Each run counts from its own zero, as it was read.
pub(crate) fn repeatability_um(
    runs: &[CorrectedRun],
    diagonal: Diagonal,
    pass: Pass,
) -> Option<f64> {
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
    runs: &[CorrectedRun],
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
pub fn figures(runs: &[CorrectedRun], kind: PathKind) -> (PerDiagonal<DiagonalFigures>, f64) {
    let passes = Pass::BOTH.map(|pass| pass_means(runs, pass));
    let on_diagonal = |d| passes.iter().map(move |pass| pass[d].iter().step_by(spacing(kind)));
    let figures = PerDiagonal::from_fn(|d| {
        // Far end less start of a pass, so that an offset between the passes does not count.
        let total = |pass: &PassMeans| Some(pass[d].last()? - pass[d].first()?);
        DiagonalFigures {
            end_um: mean(passes.iter().filter_map(total)),
            range_um: range(on_diagonal(d).flatten().copied()),
        }
    });
    let all = Diagonal::ALL.into_iter().flat_map(on_diagonal).flatten();
    (figures, range(all.copied()))
}
