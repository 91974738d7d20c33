//! Readings of the four body diagonals: the file of contract §2.2, checked against its job.
//!
//! ```text
//!  readings.csv ─→ rows ─→ nodes: every node of every run once, the axes in the job's order
//!                                           ─→ values: measured − nominal, along the forward path
//! ```
//! Readings that exist are complete: all four diagonals, every node of every run. A reading that
//! is missing is never filled in.

mod walks;

use crate::inputs::error_table::Remarks;
use crate::inputs::findings::Remark;
use crate::inputs::job::DiagonalMeasurement;
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content, LENGTHS, Table, TableRow, count, named};
use crate::inputs::target_runs::Values;
use crate::quantity::{Axis, Diagonal, Millimetres, Pass, PathKind, PerAxis, Run, Volume};
use crate::text::{Finding, Line, Notes, Problems, Source};
use std::collections::BTreeMap;
use std::fmt;

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
        Ok(Readings::along(source, |_, _| Ok(measurement.clone()))?.0)
    }

    /// Whether every cell of a file can be read, whatever was measured.
    pub(crate) fn look_at_cells(source: &Source) -> Result<(), Problems> {
        let notes = Notes::default();
        let (table, _) = table(source, &notes)?;
        rows(&table);
        notes.end(())
    }

    /// Reads a file by itself, in a box of unit cells.
    pub(crate) fn without_job(source: Source) -> Result<(Readings, Volume, PathKind), Problems> {
        let (readings, path) = Readings::along(source, shown_path)?;
        Ok((readings, path.volume, path.kind))
    }

    /// Reads a file and checks it against the path that `measured` says of it.
    fn along(
        source: Source,
        measured: impl FnOnce(&Table<'_>, &[ReadingRow<'_>]) -> Result<DiagonalMeasurement, Problems>,
    ) -> Result<(Readings, DiagonalMeasurement), Problems> {
        let notes = Notes::default();
        let (table, values) = table(&source, &notes)?;
        let rows = rows(&table);
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
        Ok((Readings { source, runs, own_zero, zeros_um }, path))
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
type Walks<'r, 'a> = BTreeMap<Walk, Vec<&'r ReadingRow<'a>>>;

/// The walks of a file, beside the path that they shall be.
struct Walked<'r, 'a> {
    table: &'r Table<'a>,
    walks: Walks<'r, 'a>,
    path: &'r DiagonalMeasurement,
    /// Displacements as they were read (`Positions`), or measured − nominal ones.
    values: Values,
    /// The last node of the path.
    last: usize,
}

/// How the readings of a file were measured, as far as they show it. The box is not among it, so a box of
/// unit cells takes its place: no figure that depends on it may be made.
fn shown_path(table: &Table<'_>, rows: &[ReadingRow<'_>]) -> Result<DiagonalMeasurement, Problems> {
    if let Some(column) = table.column(Content::reading(Values::Positions)) {
        return Err(table.at(column, refusals::displacements_alone()).into());
    }
    let last = rows.iter().map(|row| row.node).max().unwrap_or(0);
    let moved_to = |wanted: usize| rows.iter().find(|row| row.node == wanted)?.moved;
    let (kind, steps) = match rows.iter().any(|row| row.moved.is_some()) {
        true => (PathKind::Step, last.div_ceil(3).max(1)),
        false => (PathKind::Straight, last.max(1)),
    };
    let edges = |mm: f64| PerAxis::from_fn(|_| Millimetres::new(mm));
    let order = match [1, 2, 3].map(moved_to) {
        [Some(first), Some(second), Some(third)] => [first, second, third],
        _ => Axis::ALL,
    };
    let volume = Volume { start: edges(0.0), size: edges(steps as f64), steps, order };
    Ok(DiagonalMeasurement::along(kind, volume))
}

// The columns and rows of a file of readings, and the walks that the rows belong to.

const WORDS: [&str; 3] = [
    "readings, expected a header and a row for each node",
    "first line: diagonal,run,direction,node,moved,deviation_um",
    "columns: diagonal, run, direction, node, moved, deviation_um or displacement_mm, t_x_c …",
];

fn known_columns() -> Vec<Column> {
    named(&[
        ("diagonal", Content::Diagonal, &[]),
        ("run", Content::Run, &[]),
        ("direction", Content::Direction, &[]),
        ("node", Content::Node, &[]),
        ("moved", Content::Moved, &[]),
        ("deviation", Content::reading(Values::Deviations), &LENGTHS),
        ("displacement", Content::reading(Values::Positions), &LENGTHS),
        ("t_x_c", Content::Temperature(Axis::X), &[]),
        ("t_y_c", Content::Temperature(Axis::Y), &[]),
        ("t_z_c", Content::Temperature(Axis::Z), &[]),
    ])
}

/// The table of a file of readings, and whether they are displacements as the instrument showed them
/// (`Positions`) or measured − nominal ones.
fn table<'a>(source: &'a Source, notes: &'a Notes) -> Result<(Table<'a>, Values), Problems> {
    let table = Table::read(source, notes, WORDS, |_| Ok(known_columns()))?;
    table.require(table.column(Content::Diagonal), "the diagonal", "`diagonal`");
    table.require(table.column(Content::Node), "the node", "`node`");
    let reading = table.find(Content::is_reading);
    let example = "`deviation_um`, or `displacement_mm` for the displacement itself";
    table.require(reading, "the reading", example);
    let values = reading.and_then(|column| column.content.as_reading()?.values);
    notes.end((table, values.unwrap_or(Values::Deviations)))
}

/// One walk along a diagonal, as the file names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Walk {
    diagonal: Diagonal,
    run: u32,
    /// `Reverse` where the name is that of the reverse run (`NNN` …).
    named: Pass,
    /// The column `direction`.
    direction: Pass,
}

impl Walk {
    /// The way along the diagonal that carries the forward name.
    fn pass(self) -> Pass {
        match self.named {
            Pass::Forward => self.direction,
            Pass::Reverse => Pass::Reverse,
        }
    }

    /// Whether nodes, sign and zero are those of its own travel, from the far corner (`NNN` …).
    fn is_own(self) -> bool {
        self.named == Pass::Reverse
    }

    fn name(self) -> &'static str {
        match self.named {
            Pass::Forward => self.diagonal.name(),
            Pass::Reverse => self.diagonal.reverse_name(),
        }
    }
}

impl fmt::Display for Walk {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, word) = (self.name(), self.direction.word());
        write!(out, "{name} run {} {word}", self.run)
    }
}

/// A row whose cells could all be read.
struct ReadingRow<'a> {
    line: Line<'a>,
    walk: Walk,
    /// As in the file.
    node: usize,
    moved: Option<Axis>,
    /// The reading as in the file, µm.
    um: f64,
    temperatures_c: PerAxis<Option<f64>>,
}

/// More nodes than any file of readings can hold rows for.
const MOST_NODES: usize = 100_000_000;

// What is expected in a column, and the next step where it is something else.
const DIAGONAL: (&str, &str) = (
    "`PPP`, `NPP`, `PNP` or `PPN`",
    "P and N: this axis travels positive or negative on the forward run",
);
const RUN: (&str, &str) =
    ("a whole number from 1", "number the repeated runs of a diagonal 1, 2, 3 …");
const DIRECTION: (&str, &str) = ("`forward` or `reverse`", "`reverse` = back over the same nodes");
const NODE: (&str, &str) =
    ("a whole number from 0", "nodes count from 0 at the start of the forward run");
const MOVED: (&str, &str) = (
    "`x`, `y`, `z` or, at node 0, an empty cell",
    "name the axis of the forward step that ends at this node",
);
const NEVER_FILLED_IN: &str = "a missing reading is never filled in: measure it again";

/// The rows that can be read.
fn rows<'a>(table: &Table<'a>) -> Vec<ReadingRow<'a>> {
    let reading = table.find(Content::is_reading);
    let temperatures = PerAxis::from_fn(|of| table.column(Content::Temperature(of)));
    table.rows(|cells| {
        let axis = |text: &str| match text {
            "" => Some(None),
            letter => Axis::from_letter(letter).map(Some),
        };
        let walk = walk(cells);
        let is_node = |node: &usize| *node <= MOST_NODES;
        let node = cells.parsed(Content::Node, None, |t| t.parse().ok().filter(is_node), NODE);
        let moved = cells.parsed(Content::Moved, Some(None), axis, MOVED);
        let um = reading.and_then(|column| {
            Some(cells.cell(column).reading(NEVER_FILLED_IN)? * column.factor())
        });
        let temperatures_c = PerAxis::from_fn(|axis| {
            let cell = cells.cell(temperatures[axis]?);
            if cell.text.is_empty() { None } else { cell.reading("") }
        });
        let line = cells.line;
        Some(ReadingRow { line, walk: walk?, node: node?, moved: moved?, um: um?, temperatures_c })
    })
}

/// The walk that a row names by its diagonal, run and direction.
fn walk(cells: &TableRow<'_, '_>) -> Option<Walk> {
    let pass = |text: &str| Pass::BOTH.into_iter().find(|pass| pass.word() == text);
    let name = |text: &str| Diagonal::from_name(&text.to_ascii_uppercase());
    let name = cells.parsed(Content::Diagonal, None, name, DIAGONAL);
    let run = cells.parsed(Content::Run, Some(1), count, RUN);
    let direction = cells.parsed(Content::Direction, Some(Pass::Forward), pass, DIRECTION);
    let (diagonal, named) = name?;
    Some(Walk { diagonal, run: run?, named, direction: direction? })
}
