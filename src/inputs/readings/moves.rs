//! Whether the axes moved in the order that the job states.
//!
//! On a step run the nodes off the diagonal depend on that order. A run named `NNN`, numbered
//! from the far corner, meets the nodes of `PPP` only if it takes the axes in the opposite order.

use crate::inputs::job::DiagonalMeasurement;
use crate::inputs::readings::columns::{Column, Columns};
use crate::inputs::readings::rows::{Row, Walk};
use crate::inputs::readings::walks::Walks;
use crate::quantity::axis::Axis;
use crate::quantity::diagonal::{Pass, PathKind, Volume};
use crate::text::problem::{Problem, Problems};

pub(super) fn check(
    walks: &Walks<'_, '_>,
    columns: &Columns<'_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    let column = columns.index_of(Column::Moved);
    match (measurement.kind, column) {
        (PathKind::Straight, Some(index)) => problems.push(
            Problem::new("straight runs have no column `moved`: all axes move together")
                .at(columns.header.cell_place(index))
                .help("remove the column, or write `kind = \"step\"` in the job"),
        ),
        (PathKind::Step, None) => problems.push(
            Problem::new("there is no column `moved`, which runs of single-axis steps need")
                .at(columns.header.whole())
                .help("name the axis of the forward step that ends at each node, or write `kind = \"straight\"` in the job"),
        ),
        (PathKind::Step, Some(index)) => {
            let once_named = |walk: &Walk| !(walk.is_own() && walk.direction == Pass::Reverse);
            for (walk, rows) in walks.iter().filter(|(walk, _)| once_named(walk)) {
                check_walk(*walk, rows, index, &measurement.volume, problems);
            }
        }
        (PathKind::Straight, None) => {}
    }
}

/// The axis that moves to a node as it is numbered in the file.
fn expected(volume: &Volume, walk: Walk, node: usize) -> Option<Axis> {
    let last = volume.last_node(PathKind::Step);
    match (node, walk.is_own()) {
        (0, _) => None,
        (_, true) => Some(volume.moved(last + 1 - node.min(last))),
        (_, false) => Some(volume.moved(node)),
    }
}

fn check_walk(
    walk: Walk,
    rows: &[&Row<'_>],
    index: usize,
    volume: &Volume,
    problems: &mut Problems,
) {
    let last = volume.last_node(PathKind::Step);
    let wrong = |row: &&&Row<'_>| row.node <= last && row.moved != expected(volume, walk, row.node);
    let Some(row) = rows.iter().find(wrong) else {
        return;
    };
    let problem = if walk.is_own() && follows(rows, |node| Some(volume.moved(node))) {
        other_nodes(walk, volume)
    } else {
        let found = in_words(row.moved);
        let wanted = match expected(volume, walk, row.node) {
            Some(axis) => format!("{axis} by the order {}", Axis::letters(&volume.order)),
            None => "no axis".to_string(),
        };
        Problem::new(format!(
            "{walk}, node {}: {found} moved, expected {wanted}",
            row.node
        ))
        .help(next_step(walk, rows, volume))
    };
    problems.push(problem.at(row.line.cell_place(index)));
}

/// A run from the far corner that takes the axes in the order of the forward run.
fn other_nodes(walk: Walk, volume: &Volume) -> Problem {
    let [first, second, third] = volume.order;
    Problem::new(format!(
        "{walk} takes the axes in the order {}, as the forward run does, so its nodes are not those of {}: walked backwards, the order is {}",
        Axis::letters(&volume.order),
        walk.diagonal,
        Axis::letters(&[third, second, first])
    ))
    .help(format!(
        "measure the way back over the same nodes; if these are such rows with the numbers of the forward run, write `{}` and `reverse`",
        walk.diagonal
    ))
}

/// Whether every row of a walk names the axis that `by` gives for its node.
fn follows(rows: &[&Row<'_>], by: impl Fn(usize) -> Option<Axis>) -> bool {
    rows.iter()
        .filter(|row| row.node > 0)
        .all(|row| row.moved == by(row.node))
}

fn next_step(walk: Walk, rows: &[&Row<'_>], volume: &Volume) -> String {
    let last = volume.last_node(PathKind::Step);
    let walked = |node: usize| (node < last).then(|| volume.moved(node + 1));
    if !walk.is_own() && rows.iter().all(|row| row.moved == walked(row.node)) {
        return "in reverse rows too, `moved` names the axis of the forward step that ends at the node".to_string();
    }
    let named = |node: usize| rows.iter().find(|row| row.node == node)?.moved;
    if let (Some(first), Some(second), Some(third)) = (named(1), named(2), named(3))
        && first != second
        && second != third
        && first != third
        && !walk.is_own()
        && [first, second, third] != volume.order
        && follows(rows, |node| [third, first, second].get(node % 3).copied())
    {
        let order = Axis::letters(&[first, second, third]);
        return format!(
            "the whole run follows the order {order}: write `order = \"{order}\"` in the job"
        );
    }
    "`moved` names the axis of the forward step that ends at the node, and is empty at node 0"
        .to_string()
}

fn in_words(axis: Option<Axis>) -> String {
    axis.map_or_else(|| "no axis".to_string(), |axis| axis.to_string())
}
