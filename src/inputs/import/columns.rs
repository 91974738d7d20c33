//! Any delimited text, by a stated mapping of its columns.
//!
//! Separator `;`, tab or comma; quotation marks; a decimal comma where it does not separate and where it
//! cannot stand between thousands: `1,000` may be one or a thousand.

use crate::inputs::error_table::Quantity;
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::groups::{Group, Row, is_ascending};
use crate::inputs::import::mapping::{Content, Mapped, Mapping, Named, unit_of_name};
use crate::inputs::import::reading::FileContents;
use crate::inputs::import::stated::{COLUMNS, Decimal, PLUS_MOVES, Stated, Travel};
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::{Cell, Line, lines};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};
use std::borrow::Cow;
use std::collections::BTreeMap;

pub(super) fn read(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let Some(mapping) = &stated.columns else {
        return Err(COLUMNS.missing().into());
    };
    let mapping = Mapping::read(mapping)?;
    let mut problems = Problems::none();
    let table = problems.take(Table::read(source, &mapping));
    mapping.refuse_twice(stated, &mut problems);
    mapping.require(stated, &mut problems);
    let sign = stated.required_sign(&mut problems);
    let Some(table) = table else {
        return Err(problems);
    };
    let rows = table.rows(stated, &mut problems);
    let (Some(sign), true) = (sign, problems.is_empty()) else {
        return Err(problems);
    };
    let line = table.header.number();
    let mut reading = FileContents::saying([ImportFinding::ColumnsNamed { line }]);
    let has_targets = mapping.has(Content::Target);
    let ascending = !has_targets || is_ascending(&rows, &mut problems);
    if mapping.has(Content::Table(Quantity::Direction)) {
        let all_agree = !has_targets || (ascending && stated.targets_run == Some(Direction::Plus));
        let fact = table.sense_of_plus(all_agree, stated, &mut problems);
        reading.find([fact]);
    }
    let mut groups: BTreeMap<(Axis, Option<Direction>), Vec<&Row<'_>>> = BTreeMap::new();
    for row in &rows {
        let group = groups.entry((row.axis, row.direction)).or_default();
        group.push(row);
    }
    for ((axis, direction), of_group) in groups {
        let group = Group {
            columns: &mapping.columns,
            first_target: rows.first().map(|row| row.position).filter(|_| has_targets),
            ascending,
            axis,
            direction,
            rows: of_group,
        };
        let series = group.series(sign, stated, &mut reading, &mut problems);
        reading.series.extend(series);
    }
    problems.or_ok(reading)
}

// What is expected in a column, and the next step where it is something else.
const DIRECTION: (&str, &str) =
    ("`+` or `-`", "write the direction in which the axis moved, in machine coordinates");
const RUN: (&str, &str) = ("a whole number from 1", "number the runs 1, 2, 3 …");

/// A mapped column where it stands in the file.
struct Column<'m> {
    index: usize,
    name: String,
    mapped: &'m Mapped,
}

/// The part of the file below the names of its columns.
struct Table<'a, 'm> {
    header: Line<'a>,
    lines: Vec<Line<'a>>,
    columns: Vec<Column<'m>>,
}

impl<'a, 'm> Table<'a, 'm> {
    /// The first line that holds every name of the mapping is the header.
    fn read(source: &'a Source, mapping: &'m Mapping) -> Result<Self, Problems> {
        let mut lines: Vec<Line<'a>> = lines(source).collect();
        let is_header = |line: &&Line<'a>| {
            let cells = line.cells();
            cells.len() > 1
                && mapping.columns.iter().all(|column| match &column.name {
                    Named::Text(name) => cells.iter().any(|cell| cell == name),
                    Named::Number(_) => true,
                })
        };
        let Some(header) = lines.iter().find(is_header).copied() else {
            return Err(no_header(&lines, mapping));
        };
        lines.drain(..header.number());
        let columns = columns_of(&header, mapping)?;
        Ok(Table { header, lines, columns })
    }

    /// What `+` of a mapped direction means: where targets, outward run and axis do not all go the
    /// same way, the file cannot say which of them its `+` follows.
    fn sense_of_plus(
        &self,
        all_agree: bool,
        stated: &Stated,
        problems: &mut Problems,
    ) -> ImportFinding {
        if stated.plus_moves.is_none() && !all_agree && stated.targets_run.is_some() {
            problems.push(PLUS_MOVES.missing().at(self.header.whole()));
        }
        ImportFinding::PlusRows {
            moves: stated.plus_moves.unwrap_or(Direction::Plus),
            stated: stated.plus_moves.is_some(),
        }
    }

    fn rows(&self, stated: &Stated, problems: &mut Problems) -> Vec<Row<'a>> {
        let (delimiter, width) = (self.header.delimiter(), self.header.cells().len());
        let separated = self.lines.iter();
        let separated = separated.map(|line| line.separated_by(delimiter, false));
        let filled = separated.filter(|line| !line.is_empty_row());
        let whole = filled.filter(|line| line.cells_under(width, problems).is_some());
        // Cells are taken apart again where they are needed: together they are many times the file.
        let whole: Vec<Line<'a>> = whole.collect();
        let decimal = problems.take(self.decimal(&whole, stated.decimal));
        let (Some(decimal), true) = (decimal, problems.is_empty()) else {
            return Vec::new();
        };
        let rows = whole.into_iter().filter_map(|line| {
            let line = line.separated_by(delimiter, decimal == Decimal::Comma);
            self.row(line, stated, problems)
        });
        rows.collect()
    }

    /// The sign before the decimals: as stated, else as all numbers of the file show it.
    fn decimal(&self, rows: &[Line<'a>], stated: Option<Decimal>) -> Result<Decimal, Problem> {
        let (mut first_comma, mut first_point, mut only_thousands) = (None, None, true);
        for (row, line) in rows.iter().enumerate() {
            let cells = line.cells();
            let numbers = self.columns.iter().filter(|column| column.mapped.unit.is_some());
            for index in numbers.map(|column| column.index) {
                let text = &*cells[index];
                if text.contains(',') {
                    first_comma.get_or_insert((row, index));
                    only_thousands &= may_be_thousands(text);
                }
                if text.contains('.') {
                    first_point.get_or_insert((row, index));
                }
            }
        }
        let plain = "write all numbers with a decimal point or all with a comma, and nothing between thousands; `--decimal` says which of them stands before decimals";
        let (at, what) = match (stated, first_comma, first_point) {
            (Some(Decimal::Point), Some(at), _) => {
                (at, "holds a comma, but `--decimal point` was stated")
            }
            (Some(Decimal::Comma), _, Some(at)) => {
                (at, "holds a point, but `--decimal comma` was stated")
            }
            (None, Some(at), _) if self.header.delimiter() == b',' => (
                at,
                "holds a comma in a file whose columns are separated by commas: it may stand between thousands",
            ),
            (None, Some(comma), Some(point)) => {
                (comma.max(point), "has another decimal separator than the numbers above it")
            }
            (None, Some(at), None) if only_thousands => (
                at,
                "may be a thousand or a decimal: no number of the file shows what its comma means",
            ),
            (_, comma, _) => {
                let shows = if comma.is_some() { Decimal::Comma } else { Decimal::Point };
                return Ok(stated.unwrap_or(shows));
            }
        };
        let (line, index) = (&rows[at.0], at.1);
        let message = format!("`{}` {what}", shown(&line.cells()[index]));
        Err(Problem::new(message).at(line.cell_place(index)).help(plain))
    }

    /// A row whose mapped cells can be read.
    fn row(&self, line: Line<'a>, stated: &Stated, problems: &mut Problems) -> Option<Row<'a>> {
        let cells = line.cells();
        let mut axis = stated.axis;
        let mut direction = match stated.travel {
            Some(Travel::Plus) => Some(Direction::Plus),
            Some(Travel::Minus) => Some(Direction::Minus),
            _ => None,
        };
        let (mut run, mut position, mut complete) = (Some(1), None, true);
        let mut numbers = Vec::with_capacity(self.columns.len());
        for column in &self.columns {
            let cell = Cell {
                line: &line,
                index: column.index,
                text: &cells[column.index],
                name: &column.name,
            };
            let mut number = None;
            match column.mapped.content {
                Content::Table(Quantity::Axis) => axis = axis_of(&cell, stated, problems),
                Content::Table(Quantity::Direction) => {
                    let read = Direction::from_symbol;
                    let found = cell.read(read, "the direction is", DIRECTION, problems);
                    // The way of the axis, whose sense may have been stated.
                    direction = match stated.plus_moves {
                        Some(Direction::Minus) => found.map(Direction::opposite),
                        _ => found,
                    };
                    complete &= direction.is_some();
                }
                Content::Run => {
                    let count = |text: &str| text.parse().ok().filter(|count| *count >= 1_usize);
                    run = cell.read(count, format_args!("`{}` is", cell.name), RUN, problems);
                }
                content => {
                    let expected = "write a plain number; its unit stands in the mapping, and a missing value is never filled in";
                    number = match content {
                        Content::Table(Quantity::Uncertainty(_)) => {
                            cell.uncertainty(expected, problems)
                        }
                        _ => cell.number(expected, problems),
                    };
                    number = number.map(|number| number * column.mapped.factor);
                    complete &= number.is_some();
                }
            }
            if let Content::Target | Content::Table(Quantity::Position) = column.mapped.content {
                position = number;
            }
            numbers.push(number);
        }
        let (axis, run, position) = (axis?, run?, position?);
        complete.then_some(Row { line, axis, direction, run, position, numbers })
    }
}

fn axis_of(cell: &Cell<'_, '_>, stated: &Stated, problems: &mut Problems) -> Option<Axis> {
    let axis = Axis::from_letter(cell.text);
    let message = match (axis, stated.axis) {
        (None, _) => format!("the axis is `{}`, expected X, Y or Z", shown(cell.text)),
        (Some(axis), Some(stated)) if axis != stated => {
            format!("the file says axis {axis}, but `--axis {}` was stated", stated.key())
        }
        _ => return axis,
    };
    problems.push_with(|| cell.problem(message, "leave `--axis` out, or take the right file"));
    None
}

/// Whether a number is one as a thousand or more would be written with a comma, e.g. `1,000`.
fn may_be_thousands(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-']);
    let is_digits = |part: &str| part.chars().all(|c| c.is_ascii_digit());
    digits.split_once(',').is_some_and(|(before, behind)| {
        let may_be = (1..=3).contains(&before.len()) && !before.starts_with('0');
        may_be && behind.len() == 3 && is_digits(before) && is_digits(behind)
    })
}

/// Where the mapped columns stand.
fn columns_of<'m>(header: &Line<'_>, mapping: &'m Mapping) -> Result<Vec<Column<'m>>, Problems> {
    let cells = header.cells();
    let mut problems = Problems::none();
    let mut columns: Vec<Column<'m>> = Vec::new();
    for mapped in &mapping.columns {
        let index = match &mapped.name {
            Named::Text(name) => only_column(header, &cells, name),
            Named::Number(number) if (1..=cells.len()).contains(number) => Ok(number - 1),
            Named::Number(number) => {
                let width = cells.len();
                let message = format!(
                    "`#{number}` of `--columns` is no column of the file, which has {width}"
                );
                Err(Problem::new(message).at(header.whole()).help("columns are counted from 1"))
            }
        };
        let Some(index) = problems.take(index) else {
            continue;
        };
        let mut refuse = |message: String, help: &str| {
            problems.push(Problem::new(message).at(header.cell_place(index)).help(help));
        };
        if columns.iter().any(|other| other.index == index) {
            let message = format!("column {} is mapped twice", index + 1);
            refuse(message, "a column holds one thing: map each once");
        }
        let name = cells[index].to_string();
        let unit = mapped.unit.as_deref();
        // The file's own header says which unit its numbers have.
        if let (Some(found), Some(unit)) =
            (unit_of_name(&name).filter(|found| Some(*found) != unit), unit)
        {
            let name = shown(&name);
            let message =
                format!("the file gives `{name}` in {found}, but `--columns` maps it as {unit}");
            refuse(message, "map it to a column with the unit of the file");
        }
        columns.push(Column { index, name, mapped });
    }
    problems.or_ok(columns)
}

/// The column of this name; two of them are not told apart by it.
fn only_column(header: &Line<'_>, cells: &[Cow<'_, str>], name: &str) -> Result<usize, Problem> {
    let found = cells.iter().enumerate().filter(|(_, cell)| *cell == name);
    match found.map(|(index, _)| index).collect::<Vec<usize>>()[..] {
        [first, second, ..] => {
            let (one, other) = (first + 1, second + 1);
            let message = format!("columns {one} and {other} are both called `{}`", shown(name));
            let help =
                format!("map the one that is meant by its number: `#{one}=…` or `#{other}=…`");
            Err(Problem::new(message).at(header.cell_place(second)).help(help))
        }
        [only] => Ok(only),
        [] => Err(no_column(header, name)),
    }
}

fn no_column(line: &Line<'_>, name: &str) -> Problem {
    Problem::new(format!("the file has no column `{}`", shown(name)))
        .at(line.whole())
        .help("copy the names for `--columns` from the file, letter by letter; the separator is `;`, a tab or a comma")
}

/// The line that comes nearest to the names of the mapping shows what is missing.
fn no_header(lines: &[Line<'_>], mapping: &Mapping) -> Problems {
    let names = mapping.columns.iter().filter_map(|column| match &column.name {
        Named::Text(name) => Some(name.as_str()),
        Named::Number(_) => None,
    });
    let names: Vec<&str> = names.collect();
    let is_cell = |line: &Line<'_>, name: &str| line.cells().iter().any(|cell| cell == name);
    let found_in = |line: &&Line<'_>| names.iter().filter(|name| is_cell(line, name)).count();
    let filled = lines.iter().filter(|line| !line.text().trim().is_empty());
    let mut problems = Problems::none();
    let nearest = filled.rev().max_by_key(found_in).or(lines.first());
    if let Some(line) = nearest {
        for name in names.iter().filter(|name| !is_cell(line, name)) {
            problems.push(no_column(line, name));
        }
        if problems.is_empty() {
            let message = "the line with the names of `--columns` has no further column";
            let help = "the separator is `;`, a tab or a comma";
            problems.push(Problem::new(message).at(line.whole()).help(help));
        }
    }
    problems
}
