//! Rows of a delimited text whose columns are mapped.

use crate::inputs::import::choices::Travel;
use crate::inputs::import::mapping::{Content, Mapping};
use crate::inputs::import::stated::Stated;
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::Line;
use crate::text::problem::{Problem, Problems, shown};
use std::borrow::Cow;

/// A cell of a mapped column.
#[derive(Clone, Copy)]
struct Cell<'a, 'b> {
    line: &'b Line<'a>,
    index: usize,
    text: &'b str,
    /// The name of its column.
    name: &'b str,
}

impl Cell<'_, '_> {
    fn problem(&self, message: String, help: &str) -> Problem {
        Problem::new(message)
            .at(self.line.cell_place(self.index))
            .help(help)
    }

    fn number(&self, problems: &mut Problems) -> Option<f64> {
        if self.text.is_empty() {
            problems.push_with(|| {
                self.problem(
                    format!("`{}` is empty, expected a finite number", self.name),
                    "a missing value is never filled in: leave the row out, or measure it",
                )
            });
            return None;
        }
        let expected = "write a plain number; its unit stands in the mapping";
        self.line
            .number_in(self.index, self.text, self.name, expected, problems)
    }

    /// A whole number from 1.
    fn count(&self, problems: &mut Problems) -> Option<usize> {
        let count = self.text.parse().ok().filter(|count| *count >= 1_usize);
        if count.is_none() {
            problems.push_with(|| {
                self.problem(
                    format!(
                        "`{}` is `{}`, expected a whole number from 1",
                        self.name,
                        shown(self.text)
                    ),
                    "number the runs 1, 2, 3 …",
                )
            });
        }
        count
    }

    fn uncertainty(&self, problems: &mut Problems) -> Option<f64> {
        let u = self.number(problems)?;
        if u < 0.0 {
            problems.push_with(|| {
                self.problem(
                    format!(
                        "`{}` is {}, expected an uncertainty of at least 0",
                        self.name,
                        shown(self.text)
                    ),
                    "map the standard uncertainty, k = 1",
                )
            });
            return None;
        }
        Some(u)
    }

    fn axis(&self, stated: Option<Axis>, problems: &mut Problems) -> Option<Axis> {
        let axis = Axis::from_letter(self.text);
        let message = match (axis, stated) {
            (None, _) => format!("the axis is `{}`, expected X, Y or Z", shown(self.text)),
            (Some(axis), Some(stated)) if axis != stated => format!(
                "the file says axis {axis}, but `--axis {}` was stated",
                stated.key()
            ),
            _ => return axis,
        };
        problems.push_with(|| self.problem(message, "leave `--axis` out, or take the right file"));
        None
    }

    /// The way of the axis, whose sense may have been stated.
    fn direction(&self, stated: &Stated, problems: &mut Problems) -> Option<Direction> {
        let Some(direction) = Direction::from_symbol(self.text) else {
            problems.push_with(|| {
                self.problem(
                    format!(
                        "the direction is `{}`, expected `+` or `-`",
                        shown(self.text)
                    ),
                    "write the direction in which the axis moved, in machine coordinates",
                )
            });
            return None;
        };
        Some(match stated.plus_moves {
            Some(Direction::Minus) => direction.opposite(),
            _ => direction,
        })
    }
}

/// A row whose mapped cells could be read.
pub(super) struct Row<'a> {
    pub(super) line: Line<'a>,
    pub(super) axis: Axis,
    pub(super) direction: Option<Direction>,
    pub(super) run: usize,
    /// mm.
    pub(super) position: f64,
    /// Of each mapped column; only those of values and uncertainties have one.
    pub(super) numbers: Vec<Option<f64>>,
}

impl<'a> Row<'a> {
    /// A row from its cells; `columns` = place in the row and name of each mapped column.
    pub(super) fn read(
        line: Line<'a>,
        cells: &[Cow<'a, str>],
        columns: &[(usize, String)],
        (mapping, stated): (&Mapping, &Stated),
        problems: &mut Problems,
    ) -> Option<Row<'a>> {
        let mut axis = stated.axis;
        let mut direction = match stated.travel {
            Some(Travel::One(direction)) => Some(direction),
            _ => None,
        };
        let (mut run, mut position) = (Some(1), None);
        let mut numbers = Vec::with_capacity(columns.len());
        let mut complete = true;
        for ((index, name), (_, content)) in columns.iter().zip(&mapping.columns) {
            let (index, text) = (*index, &*cells[*index]);
            let cell = Cell {
                line: &line,
                index,
                text,
                name,
            };
            let mut number = None;
            match content {
                Content::Axis => axis = cell.axis(stated.axis, problems),
                Content::Direction => {
                    direction = cell.direction(stated, problems);
                    complete &= direction.is_some();
                }
                Content::Run => run = cell.count(problems),
                Content::Position(_) | Content::Target(_) => position = cell.number(problems),
                Content::Value(..) => number = cell.number(problems),
                Content::Uncertainty(..) => number = cell.uncertainty(problems),
            }
            if let Content::Position(_) | Content::Target(_) = content {
                position = position.map(|position| content.converted(position));
            }
            if let Content::Value(..) | Content::Uncertainty(..) = content {
                complete &= number.is_some();
            }
            numbers.push(number.map(|number| content.converted(number)));
        }
        let (axis, run, position) = (axis?, run?, position?);
        complete.then_some(Row {
            line,
            axis,
            direction,
            run,
            position,
            numbers,
        })
    }
}
