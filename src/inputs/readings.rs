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
use crate::inputs::job::{DiagonalMeasurement, Material};
use crate::inputs::readings::rows::{Row, Walk};
use crate::inputs::refusals;
use crate::inputs::table::{Content, Table};
use crate::inputs::target_runs::Values;
use crate::quantity::{
    Axis, Diagonal, Direction, Millimetres, Pass, PathKind, PerAxis, Run, Volume,
};
use crate::text::{Finding, Notes, Problems, Source};
use std::collections::BTreeMap;

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
        let path = |_: &Table<'_>, _: &[Row<'_>]| Ok(Path::of(measurement));
        let ((runs, own_zero, zeros_um), _) = runs_of(&source, path)?;
        Ok(Readings { source, runs, own_zero, zeros_um })
    }

    /// Whether every cell of a file can be read, whatever was measured.
    pub(crate) fn look_at_cells(source: &Source) -> Result<(), Problems> {
        let notes = Notes::default();
        let (table, _) = rows::table(source, &notes)?;
        rows::rows(&table);
        notes.end(())
    }

    /// Reads a file by itself, in a box of unit cells.
    pub(crate) fn without_job(source: Source) -> Result<(Readings, Volume, PathKind), Problems> {
        let ((runs, own_zero, zeros_um), path) = runs_of(&source, shown_path)?;
        Ok((Readings { source, runs, own_zero, zeros_um }, path.volume, path.kind))
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

/// The rows of each walk, by ascending node.
type Walks<'r, 'a> = BTreeMap<Walk, Vec<&'r Row<'a>>>;

/// How the readings were measured, and what they hold beside the errors.
struct Path {
    kind: PathKind,
    volume: Volume,
    laser_sign: Direction,
    material: Option<Material>,
}

impl Path {
    fn of(measured: &DiagonalMeasurement) -> Path {
        let DiagonalMeasurement { kind, laser_sign, material, .. } = *measured;
        Path { kind, volume: measured.volume.clone(), laser_sign, material }
    }
}

/// The walks of a file, beside the path that they shall be.
struct Walked<'r, 'a> {
    table: &'r Table<'a>,
    walks: Walks<'r, 'a>,
    path: &'r Path,
    /// Displacements as they were read (`Positions`), or measured − nominal ones.
    values: Values,
    /// The last node of the path.
    last: usize,
}

type Found = (Vec<Run>, Vec<(Diagonal, u32)>, Vec<(Diagonal, f64)>);

/// The runs of a file, checked against the path that `measured` says of it.
fn runs_of(
    source: &Source,
    measured: impl FnOnce(&Table<'_>, &[Row<'_>]) -> Result<Path, Problems>,
) -> Result<(Found, Path), Problems> {
    let notes = Notes::default();
    let (table, values) = rows::table(source, &notes)?;
    let rows = rows::rows(&table);
    let path = measured(&table, &rows)?;
    notes.end(())?;
    let mut walks = Walks::new();
    for row in &rows {
        walks.entry(row.walk).or_default().push(row);
    }
    walks.values_mut().for_each(|rows| rows.sort_by_key(|row| row.node));
    let last = path.volume.last_node(path.kind);
    let walked = Walked { table: &table, walks, path: &path, values, last };
    walked.check_set();
    if walked.check_nodes() {
        walked.check_moves();
        walked.check_readings();
    }
    walked.check_temperatures();
    notes.end(())?;
    let runs = walked.walks.iter().map(|(walk, rows)| walked.run(*walk, rows));
    let mut runs: Vec<Run> = runs.collect();
    runs.sort_by_key(|run| (run.diagonal, run.number, run.pass));
    let walks = || walked.walks.keys();
    let zeros_um = walks().filter_map(|walk| Some((walk.diagonal, walked.zero_um(*walk)?)));
    let mut zeros_um: Vec<(Diagonal, f64)> = zeros_um.collect();
    zeros_um.dedup();
    let own = walks().filter(|walk| walk.is_own());
    let own_zero = own.map(|walk| (walk.diagonal, walk.run)).collect();
    Ok(((runs, own_zero, zeros_um), path))
}

/// How the readings of a file were measured, as far as they show it. The box is not among it, so a box of
/// unit cells takes its place: no figure that depends on it may be made.
fn shown_path(table: &Table<'_>, rows: &[Row<'_>]) -> Result<Path, Problems> {
    if let Some(column) = table.column(Content::reading(Values::Positions)) {
        return Err(table.at(column, refusals::displacements_alone()).into());
    }
    let last = rows.iter().map(|row| row.node).max().unwrap_or(0);
    let is_step = rows.iter().any(|row| row.moved.is_some());
    let moved_to = |wanted: usize| rows.iter().find(|row| row.node == wanted)?.moved;
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
    Ok(Path { kind, volume, laser_sign: Direction::Plus, material: None })
}
