//! Whether the walks of a file are complete: each diagonal walked, each node once, the axes in the job's
//! order.
//!
//! On a step run the nodes off the diagonal depend on that order. A run named `NNN`, numbered
//! from the far corner, meets the nodes of `PPP` only if it takes the axes in the opposite order.

use crate::inputs::job::DiagonalMeasurement;
use crate::inputs::readings::rows::{Column, Columns, Row, Walk};
use crate::quantity::axis::Axis;
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, Volume};
use crate::text::problem::{Problem, Problems};
use std::collections::BTreeMap;

/// The rows of each walk, by ascending node.
pub(super) type Walks<'r, 'a> = BTreeMap<Walk, Vec<&'r Row<'a>>>;

pub(super) fn walks<'r, 'a>(rows: &'r [Row<'a>]) -> Walks<'r, 'a> {
    let mut walks = Walks::new();
    for row in rows {
        walks.entry(row.walk).or_default().push(row);
    }
    for rows in walks.values_mut() {
        rows.sort_by_key(|row| row.node);
    }
    walks
}

/// A problem of a row as a whole.
pub(super) fn at_row(row: &Row<'_>, message: String, help: impl Into<String>) -> Problem {
    Problem::new(message).at(row.line.whole()).help(help)
}

/// Notes diagonals without the walks that the separation needs.
pub(super) fn check_set(walks: &Walks<'_, '_>, table: &Columns<'_>, problems: &mut Problems) {
    let back = "the separation of the two directions needs the return pass on all four body diagonals; measure it, or leave its rows out";
    require_all(
        walks,
        table,
        (Pass::Forward, "the separation needs all four body diagonals"),
        problems,
    );
    if walks.keys().any(|walk| walk.pass() == Pass::Reverse) {
        require_all(walks, table, (Pass::Reverse, back), problems);
    }
    for (walk, rows) in walks.iter().filter(|(walk, _)| walk.direction == Pass::Reverse) {
        if let Some(row) = rows.first() {
            check_back(*walk, row, walks, problems);
        }
    }
}

/// Whether rows of a way back belong to forward rows, and to nothing else.
fn check_back(walk: Walk, row: &Row<'_>, walks: &Walks<'_, '_>, problems: &mut Problems) {
    let (name, diagonal) = (walk.name(), walk.diagonal);
    if walk.is_own() {
        let message = format!("{walk}: `{name}` already names the return pass of {diagonal}");
        let help = format!("write `{diagonal}` and `reverse`");
        problems.push(at_row(row, message, help));
        return;
    }
    let forward = Walk { direction: Pass::Forward, ..walk };
    let twin = Walk { named: Pass::Reverse, ..forward };
    if walks.contains_key(&twin) {
        let message = format!("{walk} stands a second time as {twin}");
        let help = "keep one of the two, or give them different runs";
        problems.push(at_row(row, message, help));
    }
    if !walks.contains_key(&forward) {
        let message =
            format!("{walk} has no forward rows of the same run, whose start is its zero");
        problems.push(at_row(row, message, "give both ways of a run the same number"));
    }
}

fn require_all(
    walks: &Walks<'_, '_>,
    table: &Columns<'_>,
    (pass, help): (Pass, &str),
    problems: &mut Problems,
) {
    let is_walked = |diagonal: Diagonal| {
        let mut walks = walks.keys();
        walks.any(|walk| walk.diagonal == diagonal && walk.pass() == pass)
    };
    let missing = Diagonal::ALL.into_iter().filter(|diagonal| !is_walked(*diagonal));
    let missing: Vec<String> = missing.map(|diagonal| diagonal.to_string()).collect();
    if !missing.is_empty() {
        let message = format!("there is no {} run of {}", pass.word(), listed(&missing));
        problems.push(table.at_header(message, help));
    }
}

/// Notes nodes that are missing, are given twice or do not exist; `false` if all runs are of another
/// number of nodes, so that nothing else can be said of them.
pub(super) fn check_nodes(
    walks: &Walks<'_, '_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) -> bool {
    let last = measurement.volume.last_node(measurement.kind);
    for (walk, rows) in walks {
        let mut pairs = rows.windows(2);
        if let Some(twins) = pairs.find(|pair| pair[0].node == pair[1].node) {
            let message = format!("{walk}: node {} stands more than once", twins[1].node);
            let help = "number repeated runs in the column `run`, and mark the return pass in the column `direction`";
            problems.push(at_row(twins[1], message, help));
        }
    }
    if let Some(problem) = other_number_of_nodes(walks, measurement) {
        problems.push(problem);
        return false;
    }
    for (walk, rows) in walks {
        if let Some(row) = rows.iter().find(|row| row.node > last) {
            let node = row.node;
            let message =
                format!("{walk} reaches node {node}, but the last node of this path is {last}");
            let help = "nodes count from 0 at the start of the forward run; check `steps` and `kind` of the job";
            problems.push(at_row(row, message, help));
        }
        refuse_missing(*walk, rows, last, problems);
    }
    true
}

/// All walks are complete, but to another last node than the job's: one mistake, said once.
fn other_number_of_nodes(
    walks: &Walks<'_, '_>,
    measurement: &DiagonalMeasurement,
) -> Option<Problem> {
    let (volume, kind) = (&measurement.volume, measurement.kind);
    let (steps, expected) = (volume.steps, volume.last_node(kind));
    let end = walks.values().next()?.last()?;
    let found = end.node;
    let is_complete = |rows: &Vec<&Row<'_>>| {
        rows.last().is_some_and(|row| row.node == found) && missing(rows, found).is_empty()
    };
    if found == expected || found == 0 || !walks.values().all(is_complete) {
        return None;
    }
    let (word, nodes, other, other_word) = match kind {
        PathKind::Step => ("single-axis", 3, PathKind::Straight, "straight"),
        PathKind::Straight => ("straight", 1, PathKind::Step, "step"),
    };
    let help = if found == volume.last_node(other) {
        format!("these look like runs of the other kind: write `kind = \"{other_word}\"`")
    } else if found % nodes == 0 {
        format!("the readings look like `steps = {}`", found / nodes)
    } else {
        "runs of single-axis steps have three nodes for each step of `steps`, and node 0"
            .to_string()
    };
    let message = format!(
        "the runs end at node {found}, but {word} runs with `steps = {steps}` end at node {expected}"
    );
    Some(at_row(end, message, help))
}

fn refuse_missing(walk: Walk, rows: &[&Row<'_>], last: usize, problems: &mut Problems) {
    let missing = missing(rows, last);
    let Some((first, _)) = missing.first() else {
        return;
    };
    let before = rows.iter().rfind(|row| row.node < *first);
    if let Some(row) = before.or(rows.first()) {
        let message = format!("{walk}: {} missing", in_words(&missing));
        let help = "measure it again: a missing reading is never filled in";
        problems.push(at_row(row, message, help));
    }
}

/// Ranges of nodes from 0 to `last` that no row has.
fn missing(rows: &[&Row<'_>], last: usize) -> Vec<(usize, usize)> {
    let mut missing = Vec::new();
    let mut next = 0;
    for row in rows.iter().filter(|row| row.node <= last) {
        if row.node > next {
            missing.push((next, row.node - 1));
        }
        next = row.node + 1;
    }
    if next <= last {
        missing.push((next, last));
    }
    missing
}

/// How many ranges a sentence names.
const MOST_RANGES: usize = 6;

/// `node 3 is`, `nodes 12 and 31 to 33 are`.
fn in_words(ranges: &[(usize, usize)]) -> String {
    let named = ranges.iter().take(MOST_RANGES);
    let range = |(from, to): &(usize, usize)| match to - from {
        0 => from.to_string(),
        1 => format!("{from}, {to}"),
        _ => format!("{from} to {to}"),
    };
    let mut parts: Vec<String> = named.map(range).collect();
    let more: usize = ranges.iter().skip(MOST_RANGES).map(|(a, b)| b - a + 1).sum();
    if more > 0 {
        parts.push(format!("{more} more"));
    }
    let list = listed(&parts);
    match ranges {
        [(from, to)] if from == to => format!("node {list} is"),
        _ => format!("nodes {list} are"),
    }
}

fn listed(parts: &[String]) -> String {
    match parts {
        [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => parts.concat(),
    }
}

/// Notes axes that moved in another order than that of the job.
pub(super) fn check_moves(
    walks: &Walks<'_, '_>,
    table: &Columns<'_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    let column = table.find(|column| column == Column::Moved);
    match (measurement.kind, column) {
        (PathKind::Straight, Some(index)) => problems.push(table.at_column(
            index,
            "straight runs have no column `moved`: all axes move together".to_string(),
            "remove the column, or write `kind = \"step\"` in the job",
        )),
        (PathKind::Step, None) => problems.push(table.at_header(
            "there is no column `moved`, which runs of single-axis steps need",
            "name the axis of the forward step that ends at each node, or write `kind = \"straight\"` in the job",
        )),
        (PathKind::Step, Some(index)) => {
            let once_named = |walk: &Walk| !(walk.is_own() && walk.direction == Pass::Reverse);
            for (walk, rows) in walks.iter().filter(|(walk, _)| once_named(walk)) {
                let wrong = wrong_move(*walk, rows, &measurement.volume);
                if let Some((row, problem)) = wrong {
                    problems.push(problem.at(row.line.cell_place(index)));
                }
            }
        }
        (PathKind::Straight, None) => {}
    }
}

/// The first row of a walk that names another axis than the job's order does.
fn wrong_move<'r, 'a>(
    walk: Walk,
    rows: &[&'r Row<'a>],
    volume: &Volume,
) -> Option<(&'r Row<'a>, Problem)> {
    let last = volume.last_node(PathKind::Step);
    let forward = |node: usize| (node > 0).then(|| volume.moved(node));
    let expected = |node: usize| match walk.is_own() && node > 0 {
        true => Some(volume.moved(last + 1 - node.min(last))),
        false => forward(node),
    };
    let wrong = |row: &&&Row<'_>| row.node <= last && row.moved != expected(row.node);
    let row = *rows.iter().find(wrong)?;
    let order = Axis::letters(&volume.order);
    let mut moves = rows.iter().filter(|row| row.node > 0);
    if walk.is_own() && moves.all(|row| row.moved == forward(row.node)) {
        // It takes the axes in the order of the forward run.
        let (diagonal, [first, second, third]) = (walk.diagonal, volume.order);
        let back = Axis::letters(&[third, second, first]);
        let message = format!(
            "{walk} takes the axes in the order {order}, as the forward run does, so its nodes are not those of {diagonal}: walked backwards, the order is {back}"
        );
        let help = format!(
            "measure the return pass over the same nodes; if these are such rows with the numbers of the forward run, write `{diagonal}` and `reverse`"
        );
        return Some((row, Problem::new(message).help(help)));
    }
    let in_words = |axis: Option<Axis>| axis.map_or("no axis".to_string(), |axis| axis.to_string());
    let by = expected(row.node).map_or(String::new(), |_| format!(" by the order {order}"));
    let (found, wanted) = (in_words(row.moved), in_words(expected(row.node)));
    let message = format!("{walk}, node {}: {found} moved, expected {wanted}{by}", row.node);
    Some((row, Problem::new(message).help(next_step(walk, rows, volume))))
}

/// What may have been meant by other axes than those of the job's order.
fn next_step(walk: Walk, rows: &[&Row<'_>], volume: &Volume) -> String {
    let usual =
        "`moved` names the axis of the forward step that ends at the node, and is empty at node 0";
    if walk.is_own() {
        return usual.to_string();
    }
    let last = volume.last_node(PathKind::Step);
    if rows.iter().all(|row| row.moved == (row.node < last).then(|| volume.moved(row.node + 1))) {
        return "in reverse rows too, `moved` names the axis of the forward step that ends at the node".to_string();
    }
    let follows = |order: &[Axis; 3]| {
        let mut moves = rows.iter().filter(|row| row.node > 0);
        *order != volume.order && moves.all(|row| row.moved == Some(order[(row.node + 2) % 3]))
    };
    match Axis::ORDERS.into_iter().find(follows) {
        Some(order) => format!(
            "the whole run follows another order: write `order = \"{}\"` in the job",
            Axis::letters(&order)
        ),
        None => usual.to_string(),
    }
}
