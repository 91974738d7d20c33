//! Rows of a file of runs → readings, each with its cell.

use crate::inputs::target_runs::complete::complete;
use crate::inputs::target_runs::header::{Content, FIRST_LINE, Form, Layout};
use crate::inputs::target_runs::reading::{Length, Reading};
use crate::inputs::target_runs::{Runs, Stated};
use crate::quantity::axis::Direction;
use crate::text::delimited::{Line, header_and_rows};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

pub(super) fn runs(source: &Source, stated: Stated) -> Result<Runs, Problems> {
    let Some((header, rows)) = header_and_rows(source) else {
        return Err(Problem::new(format!(
            "`{}` holds no table, expected a header and the runs of an axis",
            source.name
        ))
        .help(FIRST_LINE)
        .into());
    };
    let layout = Layout::read(&header, stated)?;
    if rows.is_empty() {
        return Err(
            Problem::new("the table has a header but no rows, expected readings")
                .at(header.whole())
                .help("write one row for each target, or one for each reading")
                .into(),
        );
    }
    let readings = read_rows(&layout, &rows)?;
    complete(&layout, &header, &readings)
}

/// Readings of a test: each takes some 700 bytes of memory until the figures are printed. A test of 100
/// targets with five runs each way has 1000.
const MOST_READINGS: usize = 50_000;

fn read_rows<'a>(layout: &Layout, lines: &[Line<'a>]) -> Result<Vec<Reading<'a>>, Problems> {
    let mut problems = Problems::none();
    let mut readings = Vec::new();
    for line in lines {
        let Some(cells) = line.cells_under(layout.columns.len(), &mut problems) else {
            continue;
        };
        let mut row = Row {
            layout,
            line: *line,
            cells: cells.iter().map(|cell| &**cell).collect(),
            problems: &mut problems,
        };
        row.read(&mut readings);
        if readings.len() > MOST_READINGS {
            let words = format!("here are more than {MOST_READINGS} readings, too many for a test");
            let problem = Problem::new(words).at(line.whole());
            problems.push(problem.help("check that the file is a test of one axis"));
            break;
        }
    }
    problems.or_ok(readings)
}

/// The cells of one row, while it is read.
struct Row<'r, 'a, 'p> {
    layout: &'r Layout,
    line: Line<'a>,
    cells: Vec<&'r str>,
    problems: &'p mut Problems,
}

impl<'a> Row<'_, 'a, '_> {
    fn read(&mut self, readings: &mut Vec<Reading<'a>>) {
        let target = self.length(self.layout.target);
        let line = self.line;
        let mut add = |cell: usize, direction, run, value: Option<Length>| {
            if let (Some(target), Some(direction), Some(run), Some(value)) =
                (target, direction, run, value)
            {
                readings.push(Reading {
                    line,
                    cell,
                    direction,
                    run,
                    target,
                    value,
                });
            }
        };
        match self.layout.form {
            Form::RowForReading {
                run,
                direction,
                reading,
            } => {
                let number = self.run(run);
                let approach = self.direction(direction);
                add(reading, approach, number, self.length(reading));
            }
            Form::RowForTarget => {
                for (cell, column) in self.layout.columns.iter().enumerate() {
                    if let Content::RunOf(direction, run) = column.content {
                        add(cell, Some(direction), Some(run), self.length(cell));
                    }
                }
            }
        }
    }

    fn refuse(&mut self, index: usize, message: String, help: &str) {
        let line = self.line;
        self.problems
            .push_with(|| Problem::new(message).at(line.cell_place(index)).help(help));
    }

    fn length(&mut self, index: usize) -> Option<Length> {
        let (name, cell) = (&self.layout.names[index], self.cells[index]);
        if cell.is_empty() {
            let message = format!("`{name}` is empty, expected a number");
            let help =
                "a missing reading is not filled in; leave out its run or its target as a whole";
            self.refuse(index, message, help);
            return None;
        }
        let expected = "write a plain number; its unit stands in the header";
        let number = self
            .line
            .number_in(index, cell, name, expected, self.problems)?;
        let unit = self.layout.columns[index].unit?;
        Some(Length { number, unit })
    }

    fn run(&mut self, index: usize) -> Option<u32> {
        let cell = self.cells[index];
        let number = cell.parse().ok().filter(|run| *run > 0);
        if number.is_none() {
            let message = format!(
                "the run is `{}`, expected a whole number from 1",
                shown(cell)
            );
            self.refuse(index, message, "number the runs 1, 2, 3 …");
        }
        number
    }

    fn direction(&mut self, index: usize) -> Option<Direction> {
        let cell = self.cells[index];
        let direction = match cell {
            "up" => Some(Direction::Plus),
            "dn" | "down" => Some(Direction::Minus),
            symbol => Direction::from_symbol(symbol),
        };
        if direction.is_none() {
            let message = format!(
                "unknown direction `{}`, expected `+` (up) or `-` (down)",
                shown(cell)
            );
            let help = "`+` = the axis came from smaller coordinates";
            self.refuse(index, message, help);
        }
        direction
    }
}
