//! Any delimited text, by a stated mapping of its columns.
//!
//! Separator `;`, tab or comma; quotation marks; a decimal comma where it does not separate and where it
//! cannot stand between thousands: `1,000` may be one or a thousand.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind, Quantity};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::groups::{Group, Row, is_ascending};
use crate::inputs::import::mapping::{Content, Mapped, Mapping, Named, unit_of_name};
use crate::inputs::import::reading::FileContents;
use crate::inputs::import::stated::{COLUMNS, Decimal, Format, PLUS_MOVES, Stated, Travel};
use crate::inputs::target_runs::Values;
use crate::quantity::axis::{Axis, Direction};
use crate::quantity::units::UM_PER_MM;
use crate::text::delimited::{Cell, Line, lines};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};
use std::borrow::Cow;
use std::collections::BTreeMap;

pub(super) fn read(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let mapping = Mapping::read(stated.columns.as_deref().ok_or_else(|| COLUMNS.missing())?)?;
    let mut problems = Problems::none();
    let table = problems.take(Table::read(source, &mapping));
    mapping.require(stated, &mut problems);
    let is_error = mapping.holds_positions();
    let sign = match is_error {
        true => Some(TableSign::AsError),
        false => stated.required_sign(&mut problems),
    };
    let term = match mapping.has_readings() {
        true => stated.required_term(Format::Columns, &mut problems),
        false => None,
    };
    if is_error && term.is_some_and(|term| !term.is_positioning()) {
        let message =
            "a column says where the axis stood, which only positioning (EXX, EYY, EZZ) has";
        problems.push(
            Problem::new(message).help("map deviations, or state the term that was measured"),
        );
    }
    let Some(table) = table else {
        return Err(problems);
    };
    if is_error && stated.sign == Some(TableSign::AsCorrection) {
        let message =
            "`--sign as-correction` contradicts the file, whose columns give measured − target";
        let help = "leave `--sign` out";
        problems.push(Problem::new(message).at(table.header.whole()).help(help));
    }
    let rows = table.rows(term, stated, &mut problems);
    let (Some(sign), true) = (sign, problems.is_empty()) else {
        return Err(problems);
    };
    let line = table.header.number();
    let mut reading = FileContents::saying([ImportFinding::ColumnsNamed { line }]);
    let has_targets = mapping.has(Content::Target);
    let ascending = !has_targets || is_ascending(&rows, &mut problems);
    if mapping.has_directions() {
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
        let first_target = rows.first().map(|row| row.position).filter(|_| has_targets);
        let group = Group { first_target, ascending, axis, direction, rows: of_group };
        let series = group.series(sign, stated, &mut reading, &mut problems);
        reading.series.extend(series);
    }
    problems.or_ok(reading)
}

// What is expected in a column, and the next step where it is something else.
const DIRECTION: (&str, &str) =
    ("`+` or `-`", "write the direction in which the axis moved, in machine coordinates");
const NUMBER: &str =
    "write a plain number; its unit stands in the mapping, and a missing value is never filled in";
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
    fn read(source: &'a Source, mapping: &'m Mapping) -> Result<Self, Problems> {
        let mut lines: Vec<Line<'a>> = lines(source).collect();
        let header = header_of(&lines, mapping)?;
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

    fn rows(
        &self,
        term: Option<Component>,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Vec<Row<'a>> {
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
            self.rows_of(line, term, stated, problems)
        });
        rows.flatten().collect()
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

    /// What a line holds, if its mapped cells can be read: a row for each run of it.
    fn rows_of(
        &self,
        line: Line<'a>,
        term: Option<Component>,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Vec<Row<'a>>> {
        let cells = line.cells();
        let mut axis = stated.axis.or(term.map(|term| term.along));
        let mut direction = match stated.travel {
            Some(Travel::Plus) => Some(Direction::Plus),
            Some(Travel::Minus) => Some(Direction::Minus),
            _ => None,
        };
        // The way of the axis where the file says `+` or `-`, whose sense may have been stated.
        let way = |symbol: Direction| match stated.plus_moves {
            Some(Direction::Minus) => symbol.opposite(),
            _ => symbol,
        };
        let (mut run, mut position, mut complete) = (Some(1), None, true);
        let mut values = Vec::with_capacity(self.columns.len());
        for Column { index, name, mapped } in &self.columns {
            let cell = Cell { line: &line, index: *index, text: &cells[*index], name };
            match mapped.content {
                Content::Table(Quantity::Axis) => axis = axis_of(&cell, stated, problems),
                Content::Table(Quantity::Direction) => {
                    let read = |text: &str| match text {
                        "up" => Some(Direction::Plus),
                        "dn" | "down" => Some(Direction::Minus),
                        symbol => Direction::from_symbol(symbol),
                    };
                    direction = cell.read(read, "the direction is", DIRECTION, problems).map(way);
                    complete &= direction.is_some();
                }
                Content::Run => {
                    let count = |text: &str| text.parse().ok().filter(|count| *count >= 1_usize);
                    run = cell.read(count, format_args!("`{}` is", cell.name), RUN, problems);
                }
                content => {
                    let number = match content {
                        own if own.is_uncertainty() => cell.uncertainty(NUMBER, problems),
                        _ => cell.number(NUMBER, problems),
                    };
                    let number = number.map(|number| number * mapped.factor);
                    complete &= number.is_some();
                    match content {
                        Content::Target | Content::Table(Quantity::Position) => position = number,
                        _ => values.extend(number.map(|number| (content, number))),
                    }
                }
            }
        }
        let (axis, run, position) = (axis?, run?, position?);
        let mut rows: Vec<Row<'a>> = Vec::with_capacity(1);
        for (content, number) in values {
            let (direction, run, value) = match (content, term.map(|term| term.kind)) {
                (Content::Table(quantity), _) => (direction, run, (quantity, number)),
                (Content::Reading(own), Some(kind @ Kind::Deviation(_))) => {
                    let zero = match own.values {
                        Values::Positions => position * UM_PER_MM,
                        Values::Deviations => 0.0,
                    };
                    let value = (Quantity::Value(kind), number - zero);
                    (own.direction.map(way).or(direction), own.run.unwrap_or(run), value)
                }
                _ => continue,
            };
            match rows.iter_mut().find(|row| (row.direction, row.run) == (direction, run)) {
                Some(row) => row.values.push(value),
                None => {
                    rows.push(Row { line, axis, direction, run, position, values: vec![value] })
                }
            }
        }
        complete.then_some(rows)
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
        // The file's own header says which unit its numbers have.
        if let (Some(found), Some(unit)) = (unit_of_name(&name), mapped.unit.as_deref())
            && found != unit
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

/// The first line that holds every name of the mapping is the header; otherwise the line that comes nearest to
/// them shows what is missing.
fn header_of<'a>(lines: &[Line<'a>], mapping: &Mapping) -> Result<Line<'a>, Problems> {
    let names = mapping.columns.iter().filter_map(|column| match &column.name {
        Named::Text(name) => Some(name.as_str()),
        Named::Number(_) => None,
    });
    let names: Vec<&str> = names.collect();
    let lacks = |line: &Line<'_>| -> Vec<&str> {
        let cells = line.cells();
        names.iter().copied().filter(|name| !cells.iter().any(|cell| cell == name)).collect()
    };
    let is_header = |line: &&Line<'_>| line.cells().len() > 1 && lacks(line).is_empty();
    if let Some(header) = lines.iter().find(is_header) {
        return Ok(*header);
    }
    let mut problems = Problems::none();
    let filled = lines.iter().filter(|line| !line.text().trim().is_empty());
    if let Some(line) = filled.min_by_key(|line| lacks(line).len()).or(lines.first()) {
        lacks(line).iter().for_each(|name| problems.push(no_column(line, name)));
        if problems.is_empty() {
            let message = "the line with the names of `--columns` has no further column";
            let help = "the separator is `;`, a tab or a comma";
            problems.push(Problem::new(message).at(line.whole()).help(help));
        }
    }
    Err(problems)
}
