//! Readings of the four body diagonals: the file of contract §2.2, checked against its job.
//!
//! ```text
//!  readings.csv ─→ rows ─→ nodes: every node of every run once, the axes in the job's order
//!                                           ─→ values: measured − nominal, along the forward path
//! ```
//! Readings that exist are complete: all four diagonals, every node of every run. A reading that
//! is missing is never filled in.

mod nodes;
mod rows;
mod values;

use crate::inputs::error_table::Remarks;
use crate::inputs::findings::Remark;
use crate::inputs::job::{DiagonalMeasurement, Frame, Reflector, SetUp};
use crate::inputs::readings::rows::{Row, Walk};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, Run, Volume};
use crate::quantity::units::Millimetres;
use crate::text::delimited::header_and_rows;
use crate::text::document::Source;
use crate::text::finding::Finding;
use crate::text::problem::{Problem, Problems};

/// Checked readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The file.
    pub source: Source,
    /// Every run, by diagonal, number and pass.
    pub runs: Vec<Run>,
    /// Reverse runs that were zeroed at their own start.
    own_zero: Vec<(Diagonal, u32)>,
    /// What stood at the start of each diagonal and was subtracted, µm.
    zeros_um: Vec<(Diagonal, f64)>,
}

impl Readings {
    /// Reads a file and checks it against what the job says of the measurement; all problems of
    /// the file are given at once.
    pub fn read(source: Source, measurement: &DiagonalMeasurement) -> Result<Readings, Problems> {
        let (runs, own_zero, zeros_um) = runs_of(&source, measurement)?;
        Ok(Readings { source, runs, own_zero, zeros_um })
    }

    /// Whether every cell of a file can be read, whatever was measured.
    pub(crate) fn look_at_cells(source: &Source) -> Result<(), Problems> {
        let (table, _) = rows::columns(source)?;
        rows::rows(&table).map(|_| ())
    }

    /// Reads a file by itself, in a box of unit cells.
    pub(crate) fn without_job(source: Source) -> Result<(Readings, DiagonalMeasurement), Problems> {
        let measurement = shown_measurement(&source)?;
        Ok((Readings::read(source, &measurement)?, measurement))
    }

    /// What the file says of itself in comments `# note: …`, one sentence each, and what was subtracted.
    pub fn notes(&self) -> Vec<Finding> {
        Remarks::read(&self.source.text).notes.into_iter().chain(self.zeroed()).collect()
    }

    /// Which diagonals began at another reading than zero, which was subtracted.
    pub fn zeroed(&self) -> Option<Finding> {
        let zeros_um = self.zeros_um.clone();
        (!zeros_um.is_empty()).then(|| Remark::Zeroed { zeros_um }.into())
    }

    /// Whether the values of a run count from the start of the forward run.
    ///
    /// A run under the name of a reverse run (`NNN` …) is zero at its own start, the far corner.
    /// What the machine reads there on the way out belongs to another run, so the offset between
    /// the two ways is not known: its increments are what was measured, a reversal is not.
    pub fn offset_known(&self, run: &Run) -> bool {
        run.pass == Pass::Forward || !self.own_zero.contains(&(run.diagonal, run.number))
    }

    /// Gives the runs of two diagonals each other's name, both passes.
    pub fn exchange(&mut self, one: Diagonal, other: Diagonal) {
        let named = |diagonal: Diagonal| match diagonal {
            own if own == one => other,
            own if own == other => one,
            own => own,
        };
        for run in &mut self.runs {
            run.diagonal = named(run.diagonal);
        }
        for (diagonal, _) in &mut self.own_zero {
            *diagonal = named(*diagonal);
        }
    }
}

type Found = (Vec<Run>, Vec<(Diagonal, u32)>, Vec<(Diagonal, f64)>);

fn runs_of(source: &Source, measurement: &DiagonalMeasurement) -> Result<Found, Problems> {
    let (table, quantity) = rows::columns(source)?;
    let rows = rows::rows(&table)?;
    let walks = nodes::walks(&rows);
    let mut problems = Problems::none();
    nodes::check_set(&walks, &table, &mut problems);
    if nodes::check_nodes(&walks, measurement, &mut problems) {
        nodes::check_moves(&walks, &table, measurement, &mut problems);
        values::check(&walks, quantity, measurement, &mut problems);
    }
    values::check_temperatures(&walks, &table, measurement, &mut problems);
    problems.or_ok(())?;
    let zero_um = |walk: &Walk| values::zero_um(*walk, &walks, quantity, measurement);
    let run = |(walk, rows): (&Walk, &Vec<&Row<'_>>)| {
        values::run(*walk, rows, zero_um(walk).unwrap_or(0.0), quantity, measurement)
    };
    let mut runs: Vec<Run> = walks.iter().map(run).collect();
    let zeros_um = walks.keys().filter_map(|walk| Some((walk.diagonal, zero_um(walk)?)));
    let mut zeros_um: Vec<(Diagonal, f64)> = zeros_um.collect();
    zeros_um.dedup();
    runs.sort_by_key(|run| (run.diagonal, run.number, run.pass));
    let own = walks.keys().filter(|walk| walk.is_own());
    let own_zero = own.map(|walk| (walk.diagonal, walk.run)).collect();
    Ok((runs, own_zero, zeros_um))
}

/// How the readings of a file were measured, as far as they show it. The box is not among it, so a box of
/// unit cells takes its place: no figure that depends on it may be made.
fn shown_measurement(source: &Source) -> Result<DiagonalMeasurement, Problem> {
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
