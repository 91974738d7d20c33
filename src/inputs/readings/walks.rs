//! Whether every walk has each of its nodes once, and which walks there are.

use crate::inputs::job::DiagonalMeasurement;
use crate::inputs::readings::columns::Columns;
use crate::inputs::readings::rows::{Row, Walk};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind};
use crate::text::problem::{Problem, Problems};
use std::collections::BTreeMap;

/// The rows of each walk, by ascending node.
pub(super) type Walks<'r, 'a> = BTreeMap<Walk, Vec<&'r Row<'a>>>;

pub(super) fn of<'r, 'a>(rows: &'r [Row<'a>]) -> Walks<'r, 'a> {
    let mut walks = Walks::new();
    for row in rows {
        walks.entry(row.walk).or_default().push(row);
    }
    for rows in walks.values_mut() {
        rows.sort_by_key(|row| row.node);
    }
    walks
}

/// Notes nodes that are missing, stand twice or do not exist; `false` if all runs are of another
/// number of nodes, so that nothing else can be said of them.
pub(super) fn check_nodes(
    walks: &Walks<'_, '_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) -> bool {
    let last = measurement.volume.last_node(measurement.kind);
    for (walk, rows) in walks {
        refuse_repeated(*walk, rows, problems);
    }
    if let Some(problem) = other_number_of_nodes(walks, measurement) {
        problems.push(problem);
        return false;
    }
    for (walk, rows) in walks {
        refuse_beyond(*walk, rows, last, problems);
        refuse_missing(*walk, rows, last, problems);
    }
    true
}

fn refuse_repeated(walk: Walk, rows: &[&Row<'_>], problems: &mut Problems) {
    let twins = || rows.windows(2).filter(|pair| pair[0].node == pair[1].node);
    let mut repeated: Vec<usize> = twins().map(|pair| pair[1].node).collect();
    repeated.dedup();
    let Some(second) = twins().map(|pair| pair[1]).next() else {
        return;
    };
    let verb = if repeated.len() == 1 {
        "stands"
    } else {
        "stand"
    };
    problems.push(
        Problem::new(format!(
            "{walk}: {} {verb} more than once",
            in_words(&ranges(&repeated))
        ))
        .at(second.line.whole())
        .help("number repeated runs in the column `run`, and mark the way back in the column `direction`"),
    );
}

/// All walks are complete, but to another last node than the job's: one mistake, said once.
fn other_number_of_nodes(
    walks: &Walks<'_, '_>,
    measurement: &DiagonalMeasurement,
) -> Option<Problem> {
    let volume = &measurement.volume;
    let (kind, steps) = (measurement.kind, volume.steps);
    let expected = volume.last_node(kind);
    let end = walks.values().next()?.last()?;
    let found = end.node;
    let complete = |rows: &Vec<&Row<'_>>| {
        rows.last().is_some_and(|row| row.node == found) && missing(rows, found).is_empty()
    };
    if found == expected || found == 0 || !walks.values().all(complete) {
        return None;
    }
    let (word, other) = match kind {
        PathKind::Step => ("single-axis", PathKind::Straight),
        PathKind::Straight => ("straight", PathKind::Step),
    };
    let help = if found == volume.last_node(other) {
        match other {
            PathKind::Step => {
                "these look like runs of single-axis steps: write `kind = \"step\"`".to_string()
            }
            PathKind::Straight => {
                "these look like straight runs: write `kind = \"straight\"`".to_string()
            }
        }
    } else {
        match kind {
            PathKind::Step if found % 3 == 0 => {
                format!("the readings look like `steps = {}`", found / 3)
            }
            PathKind::Step => {
                "runs of single-axis steps have three nodes for each step of `steps`, and node 0"
                    .to_string()
            }
            PathKind::Straight => format!("the readings look like `steps = {found}`"),
        }
    };
    Some(
        Problem::new(format!(
            "the runs end at node {found}, but {word} runs with `steps = {steps}` end at node {expected}"
        ))
        .at(end.line.whole())
        .help(help),
    )
}

fn refuse_beyond(walk: Walk, rows: &[&Row<'_>], last: usize, problems: &mut Problems) {
    let Some(row) = rows.iter().find(|row| row.node > last) else {
        return;
    };
    problems.push(
        Problem::new(format!(
            "{walk} reaches node {}, but the last node of this path is {last}",
            row.node
        ))
        .at(row.line.whole())
        .help("nodes count from 0 at the start of the forward run; check `steps` and `kind` of the job"),
    );
}

fn refuse_missing(walk: Walk, rows: &[&Row<'_>], last: usize, problems: &mut Problems) {
    let missing = missing(rows, last);
    let Some((first, _)) = missing.first() else {
        return;
    };
    let before = rows.iter().rfind(|row| row.node < *first).or(rows.first());
    let verb = match missing[..] {
        [(from, to)] if from == to => "is",
        _ => "are",
    };
    let problem = Problem::new(format!("{walk}: {} {verb} missing", in_words(&missing)))
        .help("measure it again: a missing reading is never filled in");
    problems.push(match before {
        Some(row) => problem.at(row.line.whole()),
        None => problem,
    });
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

fn ranges(nodes: &[usize]) -> Vec<(usize, usize)> {
    let mut ranges: Vec<(usize, usize)> = Vec::new();
    for node in nodes {
        match ranges.last_mut() {
            Some((_, to)) if *to + 1 == *node => *to = *node,
            _ => ranges.push((*node, *node)),
        }
    }
    ranges
}

/// How many ranges a sentence names.
const MOST_RANGES: usize = 6;

/// `node 3`, `nodes 12 and 31 to 33`.
fn in_words(ranges: &[(usize, usize)]) -> String {
    let mut parts: Vec<String> = ranges
        .iter()
        .take(MOST_RANGES)
        .map(|(from, to)| match to - from {
            0 => from.to_string(),
            1 => format!("{from}, {to}"),
            _ => format!("{from} to {to}"),
        })
        .collect();
    let more: usize = ranges
        .iter()
        .skip(MOST_RANGES)
        .map(|(a, b)| b - a + 1)
        .sum();
    if more > 0 {
        parts.push(format!("{more} more"));
    }
    let word = match ranges {
        [(from, to)] if from == to => "node",
        _ => "nodes",
    };
    format!("{word} {}", listed(&parts))
}

fn listed(parts: &[String]) -> String {
    match parts {
        [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => parts.concat(),
    }
}

/// Notes diagonals without the walks that the separation needs.
pub(super) fn check_set(walks: &Walks<'_, '_>, columns: &Columns<'_>, problems: &mut Problems) {
    require_all(walks, columns, Pass::Forward, problems);
    if walks.keys().any(|walk| walk.pass() == Pass::Reverse) {
        require_all(walks, columns, Pass::Reverse, problems);
    }
    for (walk, rows) in walks {
        let Some(row) = rows.first() else { continue };
        let twin = Walk {
            named: Pass::Reverse,
            direction: Pass::Forward,
            ..*walk
        };
        if walk.named == Pass::Reverse && walk.direction == Pass::Reverse {
            problems.push(
                Problem::new(format!(
                    "{walk}: `{}` already names the way back of {}",
                    walk.name(),
                    walk.diagonal
                ))
                .at(row.line.whole())
                .help(format!("write `{}` and `reverse`", walk.diagonal)),
            );
        } else if walk.pass() == Pass::Reverse && !walk.is_own() {
            if walks.contains_key(&twin) {
                problems.push(
                    Problem::new(format!("{walk} stands a second time as {twin}"))
                        .at(row.line.whole())
                        .help("keep one of the two, or give them different runs"),
                );
            }
            let forward = Walk {
                direction: Pass::Forward,
                ..*walk
            };
            if !walks.contains_key(&forward) {
                problems.push(
                    Problem::new(format!(
                        "{walk} has no forward rows of the same run, whose start is its zero"
                    ))
                    .at(row.line.whole())
                    .help("give both ways of a run the same number"),
                );
            }
        }
    }
}

fn require_all(walks: &Walks<'_, '_>, columns: &Columns<'_>, pass: Pass, problems: &mut Problems) {
    let missing: Vec<String> = Diagonal::ALL
        .into_iter()
        .filter(|diagonal| {
            !walks
                .keys()
                .any(|walk| walk.diagonal == *diagonal && walk.pass() == pass)
        })
        .map(|diagonal| diagonal.to_string())
        .collect();
    if missing.is_empty() {
        return;
    }
    let help = match pass {
        Pass::Forward => "the separation needs all four body diagonals",
        Pass::Reverse => {
            "the separation of the two directions needs the way back on all four body diagonals; measure it, or leave its rows out"
        }
    };
    problems.push(
        Problem::new(format!(
            "there is no {} run of {}",
            pass.word(),
            listed(&missing)
        ))
        .at(columns.header.whole())
        .help(help),
    );
}
