//! Readings without a job: what they say themselves of how they were measured.

use crate::inputs::job::{DiagonalMeasurement, Frame, Reflector, SetUp};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{PathKind, Volume};
use crate::quantity::units::Millimetres;
use crate::text::delimited::header_and_rows;
use crate::text::document::Source;
use crate::text::problem::Problem;

/// How the readings of a file were measured, as far as they show it. The box is not among it, so a box of
/// unit cells takes its place: no figure that depends on it may be made.
pub(super) fn measurement(source: &Source) -> Result<DiagonalMeasurement, Problem> {
    let nodes = nodes(source)?;
    let last = nodes.iter().map(|(node, _)| *node).max().unwrap_or(0);
    let is_step = nodes.iter().any(|(_, moved)| moved.is_some());
    let moved_to = |wanted: usize| nodes.iter().find(|(node, _)| *node == wanted)?.1;
    let (kind, steps) = match is_step {
        true => (PathKind::Step, last.div_ceil(3)),
        false => (PathKind::Straight, last),
    };
    let edges = |mm: f64| PerAxis::from_fn(|_| Millimetres::new(mm));
    let mut volume = Volume {
        start: edges(0.0),
        size: edges(1.0),
        steps: steps.max(1),
        order: match [1, 2, 3].map(moved_to) {
            [Some(first), Some(second), Some(third)] => [first, second, third],
            _ => Axis::ALL,
        },
    };
    volume.size = edges(volume.steps_f64());
    Ok(DiagonalMeasurement {
        readings: source.name.clone(),
        kind,
        volume,
        laser_sign: Direction::Plus,
        setup: SetUp::Solve,
        frame: Frame::XPrimary,
        target: Reflector::FlatMirror,
        overrun: None,
        linear: Vec::new(),
        beams: Vec::new(),
        material: None,
        closure_errors: None,
    })
}

/// The number of each node, and the axis that moved to it.
fn nodes(source: &Source) -> Result<Vec<(usize, Option<Axis>)>, Problem> {
    let (header, lines) = header_and_rows(source).ok_or_else(|| {
        Problem::new(format!("`{}` holds no readings", source.name))
            .help("first line: diagonal,run,direction,node,moved,deviation_um")
    })?;
    let cells = header.cells();
    if let Some(index) = cells.iter().position(|c| c.starts_with("displacement_")) {
        return Err(Problem::new(
            "the readings are displacements: their deviations need the box, which stands in the job",
        )
        .at(header.cell_place(index))
        .help("give the job instead: `nonius standards job.toml`"));
    }
    let at = |name: &str| cells.iter().position(|cell| cell == name);
    let (node, moved) = (at("node"), at("moved"));
    let nodes = lines.iter().filter_map(|line| {
        let cells = line.cells();
        let node = cells.get(node?)?.parse().ok()?;
        let moved = moved.and_then(|at| cells.get(at));
        Some((node, moved.and_then(|cell| Axis::from_letter(cell))))
    });
    Ok(nodes.collect())
}
