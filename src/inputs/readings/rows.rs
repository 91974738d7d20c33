//! The columns and rows of a file of readings, and the walks that the rows belong to.

use crate::inputs::table::{Column, Content, LENGTHS, Row as Cells, Table, count, named};
use crate::inputs::target_runs::Values;
use crate::quantity::{Axis, Diagonal, Pass, PerAxis};
use crate::text::{Line, Notes, Problems, Source};
use std::fmt;

const WORDS: [&str; 3] = [
    "readings, expected a header and a row for each node",
    "first line: diagonal,run,direction,node,moved,deviation_um",
    "columns: diagonal, run, direction, node, moved, deviation_um or displacement_mm, t_x_c …",
];

fn known_columns() -> Vec<Column> {
    let mut known = named(&[
        ("diagonal", Content::Diagonal, &[]),
        ("run", Content::Run, &[]),
        ("direction", Content::Direction, &[]),
        ("node", Content::Node, &[]),
        ("moved", Content::Moved, &[]),
        ("deviation", Content::reading(Values::Deviations), &LENGTHS),
        ("displacement", Content::reading(Values::Positions), &LENGTHS),
    ]);
    for axis in Axis::ALL {
        let name = format!("t_{}_c", axis.key());
        known.extend(named(&[(&name, Content::Temperature(axis), &[])]));
    }
    known
}

/// The table of a file of readings, and whether they are displacements as the instrument showed them
/// (`Positions`) or measured − nominal ones.
pub(super) fn table<'a>(
    source: &'a Source,
    notes: &'a Notes,
) -> Result<(Table<'a>, Values), Problems> {
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
pub(super) struct Walk {
    pub(super) diagonal: Diagonal,
    pub(super) run: u32,
    /// `Reverse` where the name is that of the reverse run (`NNN` …).
    pub(super) named: Pass,
    /// The column `direction`.
    pub(super) direction: Pass,
}

impl Walk {
    /// The way along the diagonal that carries the forward name.
    pub(super) fn pass(self) -> Pass {
        match self.named {
            Pass::Forward => self.direction,
            Pass::Reverse => Pass::Reverse,
        }
    }

    /// Whether nodes, sign and zero are those of its own travel, from the far corner (`NNN` …).
    pub(super) fn is_own(self) -> bool {
        self.named == Pass::Reverse
    }

    pub(super) fn name(self) -> &'static str {
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
pub(super) struct Row<'a> {
    pub(super) line: Line<'a>,
    pub(super) walk: Walk,
    /// As in the file.
    pub(super) node: usize,
    pub(super) moved: Option<Axis>,
    /// The reading as in the file, µm.
    pub(super) um: f64,
    pub(super) temperatures_c: PerAxis<Option<f64>>,
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
pub(super) fn rows<'a>(table: &Table<'a>) -> Vec<Row<'a>> {
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
        Some(Row { line, walk: walk?, node: node?, moved: moved?, um: um?, temperatures_c })
    })
}

/// The walk that a row names by its diagonal, run and direction.
fn walk(cells: &Cells<'_, '_>) -> Option<Walk> {
    let pass = |text: &str| Pass::BOTH.into_iter().find(|pass| pass.word() == text);
    let name = |text: &str| Diagonal::from_name(&text.to_ascii_uppercase());
    let name = cells.parsed(Content::Diagonal, None, name, DIAGONAL);
    let run = cells.parsed(Content::Run, Some(1), count, RUN);
    let direction = cells.parsed(Content::Direction, Some(Pass::Forward), pass, DIRECTION);
    let (diagonal, named) = name?;
    Some(Walk { diagonal, run: run?, named, direction: direction? })
}
