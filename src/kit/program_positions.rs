//! The expected positions of a measuring run, as read back, against the nodes of the job (contract §2.2).

use crate::inputs::job::{ProgramRequest, TargetGrid};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind};
use crate::read::program::positions::{Named, Position};

/// What differs between the rows and what the job asks for, one sentence each; empty = nothing.
/// Diagonals are compared with the nodes that `separate` will expect.
pub(super) fn differences(
    rows: &[Position],
    request: &ProgramRequest,
    digit_mm: f64,
) -> Vec<String> {
    let expected = order(request);
    let mut words = Vec::new();
    if expected.len() != rows.len() {
        words.push(format!(
            "positions.csv has {} readings, expected {}",
            rows.len(),
            expected.len()
        ));
    }
    for (row, (of, run, pass, node)) in rows.iter().zip(&expected) {
        let same = (row.of, row.run, row.pass, row.node) == (*of, *run, *pass, *node);
        if !same {
            words.push(format!(
                "reading {} of run {} should be node {node} of run {run}, {}",
                row.node,
                row.run,
                pass.word()
            ));
        } else if !is_at_node(row, request, digit_mm) {
            words.push(format!(
                "node {} of run {} is not where the job has it",
                row.node, row.run
            ));
        }
        if words.len() > 20 {
            break;
        }
    }
    words
}

type Key = (Named, u32, Pass, usize);

/// Diagonal, run, direction and node of every reading in the order of the files of readings.
fn order(request: &ProgramRequest) -> Vec<Key> {
    let (set_ups, last): (Vec<Named>, usize) = match request.what.path() {
        Some(kind) => (
            Diagonal::ALL.into_iter().map(Named::Diagonal).collect(),
            request.volume.last_node(kind),
        ),
        None => (
            request.axes.iter().map(|axis| Named::Axis(*axis)).collect(),
            request.volume.steps,
        ),
    };
    let mut keys = Vec::new();
    for of in set_ups {
        for run in 1..=request.runs {
            keys.extend((0..=last).map(|node| (of, run, Pass::Forward, node)));
            if request.bidirectional {
                keys.extend((0..=last).rev().map(|node| (of, run, Pass::Reverse, node)));
            }
        }
    }
    keys
}

fn is_at_node(row: &Position, request: &ProgramRequest, digit_mm: f64) -> bool {
    let close = |a: f64, b: f64, slack: f64| (a - b).abs() <= slack;
    match (row.of, request.what.path()) {
        (Named::Diagonal(diagonal), Some(kind)) => {
            let place = request.volume.place(diagonal, kind, row.node);
            let nominal = request.volume.nominal_mm(diagonal, kind, row.node);
            let moved =
                (kind == PathKind::Step && row.node > 0).then(|| request.volume.moved(row.node));
            moved == row.moved
                && close(row.nominal_mm, nominal, 1e-6)
                && place
                    .iter()
                    .all(|(axis, mm)| close(row.place[axis], mm.mm(), digit_mm / 100.0))
        }
        (Named::Axis(axis), None) => {
            let equal = request.volume.start[axis].mm() + request.volume.along_mm(axis, row.node);
            let step = request.volume.step_mm(axis);
            let slack = match request.targets {
                TargetGrid::Equal => digit_mm / 100.0,
                TargetGrid::Offset { shift } => shift.map_or(step / 4.0, |s| s.mm()) + digit_mm,
            };
            close(row.place[axis], equal, slack)
        }
        _ => false,
    }
}
