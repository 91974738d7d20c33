//! Rows of the readings, one by one, and the walks that they belong to.

use crate::inputs::readings::columns::{Column, Columns};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass};
use crate::text::delimited::Line;
use crate::text::problem::{Problem, Problems, nearest, shown};
use std::fmt;

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

pub(super) fn read<'a>(
    columns: &Columns<'_>,
    lines: &[Line<'a>],
) -> Result<Vec<Row<'a>>, Problems> {
    let mut problems = Problems::none();
    let rows = lines
        .iter()
        .filter_map(|line| {
            let cells = line.cells_under(columns.kinds.len(), &mut problems)?;
            let mut cells = Cells {
                columns,
                line: *line,
                texts: cells.iter().map(|cell| &**cell).collect(),
                problems: &mut problems,
            };
            cells.row()
        })
        .collect();
    problems.or_ok(rows)
}

/// The cells of one row, while it is read.
struct Cells<'r, 'a, 'p> {
    columns: &'r Columns<'r>,
    line: Line<'a>,
    texts: Vec<&'r str>,
    problems: &'p mut Problems,
}

impl<'a> Cells<'_, 'a, '_> {
    fn row(&mut self) -> Option<Row<'a>> {
        let name = self.diagonal();
        let run = self.run();
        let direction = self.direction();
        let node = self.node();
        let moved = self.moved();
        let um = self.reading();
        let before = self.problems.iter().count();
        let temperatures_c = PerAxis::from_fn(|axis| self.temperature(axis));
        if self.problems.iter().count() > before {
            return None;
        }
        let (diagonal, named) = name?;
        Some(Row {
            line: self.line,
            walk: Walk {
                diagonal,
                run: run?,
                named,
                direction: direction?,
            },
            node: node?,
            moved: moved?,
            um: um?,
            temperatures_c,
        })
    }

    /// Index and text of a column's cell, if the file has the column.
    fn cell(&self, column: Column) -> Option<(usize, &str)> {
        let index = self.columns.index_of(column)?;
        Some((index, self.texts[index]))
    }

    fn refuse(&mut self, index: usize, message: impl FnOnce() -> String, help: String) {
        let line = self.line;
        self.problems.push_with(|| {
            Problem::new(message())
                .at(line.cell_place(index))
                .help(help)
        });
    }

    fn diagonal(&mut self) -> Option<(Diagonal, Pass)> {
        let (index, text) = self.cell(Column::Diagonal)?;
        let text = text.to_string();
        let found = Diagonal::from_name(&text.to_ascii_uppercase());
        if found.is_none() {
            let message = || {
                format!(
                    "unknown diagonal `{}`, expected `PPP`, `NPP`, `PNP` or `PPN`",
                    shown(&text)
                )
            };
            let help = "P and N: this axis travels positive or negative on the forward run";
            self.refuse(index, message, help.to_string());
        }
        found
    }

    fn run(&mut self) -> Option<u32> {
        let Some((index, text)) = self.cell(Column::Run) else {
            return Some(1);
        };
        let text = text.to_string();
        let run = text.parse().ok().filter(|run| *run > 0);
        if run.is_none() {
            let message = || {
                format!(
                    "`run` is `{}`, expected a whole number from 1",
                    shown(&text)
                )
            };
            let help = "number the repeated runs of a diagonal 1, 2, 3 …";
            self.refuse(index, message, help.to_string());
        }
        run
    }

    fn direction(&mut self) -> Option<Pass> {
        let Some((index, text)) = self.cell(Column::Direction) else {
            return Some(Pass::Forward);
        };
        let text = text.to_string();
        let pass = Pass::BOTH.into_iter().find(|pass| pass.word() == text);
        if pass.is_none() {
            let message = || {
                format!(
                    "`direction` is `{}`, expected `forward` or `reverse`",
                    shown(&text)
                )
            };
            let help = nearest(&text, Pass::BOTH.map(Pass::word)).map_or_else(
                || "`reverse` = back over the same nodes".to_string(),
                |near| format!("did you mean `{near}`?"),
            );
            self.refuse(index, message, help);
        }
        pass
    }

    fn node(&mut self) -> Option<usize> {
        let (index, text) = self.cell(Column::Node)?;
        let text = text.to_string();
        let node = text.parse().ok().filter(|node| *node <= MOST_NODES);
        if node.is_none() {
            let message = || {
                format!(
                    "`node` is `{}`, expected a whole number from 0",
                    shown(&text)
                )
            };
            let help = "nodes count from 0 at the start of the forward run";
            self.refuse(index, message, help.to_string());
        }
        node
    }

    /// The axis that moved; an empty cell is for node 0.
    fn moved(&mut self) -> Option<Option<Axis>> {
        let Some((index, text)) = self.cell(Column::Moved) else {
            return Some(None);
        };
        if text.is_empty() {
            return Some(None);
        }
        let text = text.to_string();
        let axis = Axis::from_letter(&text);
        if axis.is_none() {
            let message = || {
                format!(
                    "`moved` is `{}`, expected `x`, `y`, `z` or, at node 0, an empty cell",
                    shown(&text)
                )
            };
            let help = "name the axis of the forward step that ends at this node";
            self.refuse(index, message, help.to_string());
        }
        axis.map(Some)
    }

    fn reading(&mut self) -> Option<f64> {
        let is_value = |kind: &Column| matches!(kind, Column::Value { .. });
        let index = self.columns.kinds.iter().position(is_value)?;
        let name = &self.columns.names[index];
        let Column::Value { to_um, .. } = self.columns.kinds[index] else {
            return None;
        };
        if self.texts[index].is_empty() {
            let message = || format!("`{name}` is empty, expected a number");
            let help = "a missing reading is never filled in: measure it again";
            self.refuse(index, message, help.to_string());
            return None;
        }
        self.number(index).map(|number| number * to_um)
    }

    fn temperature(&mut self, of: Axis) -> Option<f64> {
        let (index, text) = self.cell(Column::Temperature { of })?;
        if text.is_empty() {
            return None;
        }
        self.number(index)
    }

    fn number(&mut self, index: usize) -> Option<f64> {
        let name = &self.columns.names[index];
        let expected = "write a plain number; its unit stands in the header";
        self.line
            .number_in(index, self.texts[index], name, expected, self.problems)
    }
}
