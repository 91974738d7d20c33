//! The nodes on the diagonals as runs of a standard's test.

use super::noise::CorrectedRun;
use crate::inputs::target_runs::Runs;
use crate::quantity::axis::Direction;
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, Volume};
use crate::text::problem::Problem;

/// Runs of one diagonal over its cell ends (step) or nodes (straight); up = forward.
pub(crate) fn diagonal_runs(
    volume: &Volume,
    kind: PathKind,
    diagonal: Diagonal,
    runs: &[CorrectedRun],
) -> Result<Runs, Problem> {
    let every = match kind {
        PathKind::Step => 3,
        PathKind::Straight => 1,
    };
    let nodes: Vec<usize> = (0..=volume.last_node(kind)).step_by(every).collect();
    let targets = nodes
        .iter()
        .map(|node| volume.nominal_mm(diagonal, kind, *node))
        .collect();
    let of = |direction: Direction| {
        let pass = match direction {
            Direction::Plus => Pass::Forward,
            Direction::Minus => Pass::Reverse,
        };
        let walks: Vec<&CorrectedRun> = runs
            .iter()
            .filter(|run| run.diagonal == diagonal && run.pass == pass)
            .collect();
        let at = |node: &usize| walks.iter().map(|run| run.readings_um[*node]).collect();
        (!walks.is_empty()).then(|| nodes.iter().map(at).collect())
    };
    Runs::new(targets, of(Direction::Plus), of(Direction::Minus))
}
