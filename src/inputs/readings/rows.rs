//! The columns and rows of a file of readings, and the walks that the rows belong to.

use crate::inputs::table::{self, Table};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass};
use crate::text::delimited::{Expected, LengthUnit, Line};
use crate::text::document::Source;
use crate::text::problem::Problems;
use std::fmt;

/// What the readings are counted from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Quantity {
    /// Measured − nominal displacement.
    Deviation,
    /// The displacement as the instrument showed it.
    Displacement,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Column {
    Diagonal,
    Run,
    Direction,
    Node,
    Moved,
    Value { quantity: Quantity, to_um: f64 },
    Temperature { of: Axis },
}

const FIRST_LINE: &str = "first line: diagonal,run,direction,node,moved,deviation_um";

fn known_columns() -> Vec<(String, Column)> {
    let plain = [
        ("diagonal", Column::Diagonal),
        ("run", Column::Run),
        ("direction", Column::Direction),
        ("node", Column::Node),
        ("moved", Column::Moved),
    ];
    let plain = plain.map(|(name, column)| (name.to_string(), column));
    let values = [("deviation", Quantity::Deviation), ("displacement", Quantity::Displacement)];
    let values = values.into_iter().flat_map(|(name, quantity)| {
        LengthUnit::ALL.map(|unit| {
            (format!("{name}_{}", unit.word()), Column::Value { quantity, to_um: unit.um() })
        })
    });
    let temperature = |of: Axis| (format!("t_{}_c", of.key()), Column::Temperature { of });
    let temperatures = Axis::ALL.map(temperature);
    plain.into_iter().chain(values).chain(temperatures).collect()
}

fn is_value(column: Column) -> bool {
    matches!(column, Column::Value { .. })
}

/// A file of readings whose header was read.
pub(super) type Columns<'a> = Table<'a, Column>;

/// The table of a file of readings, and what its readings are counted from.
pub(super) fn columns(source: &Source) -> Result<(Columns<'_>, Quantity), Problems> {
    let what = "readings, expected a header and a row for each node";
    let table = Table::read(source, what, FIRST_LINE, |_| {
        Ok(Expected {
            known: known_columns(),
            same: |a, b| is_value(*a) && is_value(*b) || a == b,
            first_line: FIRST_LINE,
            columns: "columns: diagonal, run, direction, node, moved, deviation_um or displacement_mm, t_x_c …",
        })
    })?;
    let mut problems = Problems::none();
    let find = |column| table.find(|kind| kind == column);
    let mut require = |found, what, example| table.require(found, what, example, &mut problems);
    require(find(Column::Diagonal), "the diagonal", "`diagonal`");
    require(find(Column::Node), "the node", "`node`");
    let example = "`deviation_um`, or `displacement_mm` for the displacement itself";
    let value = require(table.find(is_value), "the reading", example);
    let quantity = match table.kinds.get(value) {
        Some(Column::Value { quantity, .. }) => *quantity,
        _ => Quantity::Deviation,
    };
    problems.or_ok((table, quantity))
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

pub(super) fn rows<'a>(table: &Columns<'a>) -> Result<Vec<Row<'a>>, Problems> {
    let temperatures = PerAxis::from_fn(|of| table.find(|c| c == Column::Temperature { of }));
    let find = |column| table.find(|kind| kind == column);
    let named = [Column::Diagonal, Column::Run, Column::Direction].map(find);
    let (node, moved) = (find(Column::Node), find(Column::Moved));
    table.rows(|cells| {
        let axis = |text: &str| match text {
            "" => Some(None),
            letter => Axis::from_letter(letter).map(Some),
        };
        let walk = walk(cells, named);
        let is_node = |node: &usize| *node <= MOST_NODES;
        let node = cells.parsed(node, None, |t| t.parse().ok().filter(is_node), NODE);
        let moved = cells.parsed(moved, Some(None), axis, MOVED);
        let um = reading(table, cells);
        let temperatures_c = PerAxis::from_fn(|axis| {
            let index = temperatures[axis].filter(|index| !cells.cell(*index).is_empty());
            cells.number(index?, "") // a problem where it is no number
        });
        Some(Row {
            line: cells.line,
            walk: walk?,
            node: node?,
            moved: moved?,
            um: um?,
            temperatures_c,
        })
    })
}

/// The walk that a row names by its diagonal, run and direction.
fn walk(
    cells: &mut table::Row<'_, '_>,
    [diagonal, run, direction]: [Option<usize>; 3],
) -> Option<Walk> {
    let pass = |text: &str| Pass::BOTH.into_iter().find(|pass| pass.word() == text);
    let name = |text: &str| Diagonal::from_name(&text.to_ascii_uppercase());
    let name = cells.parsed(diagonal, None, name, DIAGONAL);
    let whole = |text: &str| text.parse().ok().filter(|run| *run > 0);
    let run = cells.parsed(run, Some(1), whole, RUN);
    let direction = cells.parsed(direction, Some(Pass::Forward), pass, DIRECTION);
    let (diagonal, named) = name?;
    Some(Walk { diagonal, run: run?, named, direction: direction? })
}

/// The reading of a row, µm.
fn reading(table: &Columns<'_>, cells: &mut table::Row<'_, '_>) -> Option<f64> {
    let mut values = table.kinds.iter().enumerate();
    values.find_map(|(index, kind)| match kind {
        Column::Value { to_um, .. } => Some(cells.number(index, NEVER_FILLED_IN)? * to_um),
        _ => None,
    })
}
