//! Any delimited text, by a stated mapping of its columns.
//!
//! Separator `;`, tab or comma; quotation marks; a decimal comma where it does not separate and where it
//! cannot stand between thousands: `1,000` may be one or a thousand.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind};
use crate::inputs::findings::ImportFinding;
use crate::inputs::import::intake::{Contents, Intake};
use crate::inputs::import::mapping::{ColumnName, Mapping, unit_of_name};
use crate::inputs::import::reading::{ImportRow, is_ascending, series};
use crate::inputs::import::stated::{COLUMNS, Decimal, PLUS_MOVES, Travel};
use crate::inputs::refusals;
use crate::inputs::table::{Cell, Column, Content, RUN, Table, TableRow, count};
use crate::inputs::target_runs::{Values, approach, small_um};
use crate::quantity::{Axis, Direction, UM_PER_MM};
use crate::text::{Line, Problem, Problems, grouped, lines, shown};
use std::borrow::Cow;

pub(super) fn read<'a>(intake: &'a Intake<'a>) -> Option<Contents> {
    let stated = intake.stated;
    let columns = intake.settled(&COLUMNS, None, stated.columns.as_deref())?;
    let mapping = intake.notes.take(Mapping::read(columns))?;
    let table = table(intake, &mapping);
    mapping.require(intake);
    let is_error = mapping.holds_positions();
    let sign = if is_error { Some(TableSign::AsError) } else { intake.sign(None) };
    let term = if mapping.has_readings() { intake.term() } else { None };
    if is_error && term.is_some_and(|term| !term.is_positioning()) {
        intake.notes.refuse(refusals::position_of_straightness());
    }
    let mut table = table?;
    let header = table.header;
    if is_error && stated.sign == Some(TableSign::AsCorrection) {
        let problem = refusals::is_measured_less_target("columns give", "leave `--sign` out");
        intake.notes.refuse(problem.at(header.whole()));
    }
    let rows = intake.rows(&mut table, term);
    intake.refuse_unclear_values(&table, &rows);
    let sign = intake.if_sound(sign)??;
    intake.say([ImportFinding::ColumnsNamed { line: header.number() }]);
    let has_targets = mapping.has(Content::Target);
    let ascending = !has_targets || is_ascending(&rows, intake);
    if mapping.has_directions() {
        let all_agree = !has_targets || (ascending && stated.targets_run == Some(Direction::Plus));
        intake.say([intake.sense_of_plus(&table, all_agree)]);
    }
    let first_target = rows.first().map(|row| row.position).filter(|_| has_targets);
    Some((series(&rows, (first_target, ascending), sign, intake), Vec::new()))
}

// What is expected in a column, and the next step where it is something else.
const DIRECTION: (&str, &str) =
    ("`+` or `-`", "write the direction in which the axis moved, in machine coordinates");
const NUMBER: &str =
    "write a plain number; its unit stands in the mapping, and a missing value is never filled in";

/// The part of the file below the names of its columns.
fn table<'a>(intake: &'a Intake<'a>, mapping: &Mapping) -> Option<Table<'a>> {
    let mut lines: Vec<Line<'a>> = lines(intake.source).collect();
    let header = intake.notes.take(header_of(&lines, mapping))?;
    lines.drain(..header.number());
    let columns = intake.notes.take(columns_of(&header, mapping))?;
    Some(Table { header, columns, lines, notes: &intake.notes, first_line: "" })
}

impl<'a> Intake<'a> {
    /// What `+` of a mapped direction means: where targets, outward run and axis do not all go the
    /// same way, the file cannot say which of them its `+` follows.
    fn sense_of_plus(&self, table: &Table<'_>, all_agree: bool) -> ImportFinding {
        let stated = self.stated;
        if stated.plus_moves.is_none() && !all_agree && stated.targets_run.is_some() {
            table.refuse(PLUS_MOVES.missing());
        }
        ImportFinding::PlusRows {
            moves: stated.plus_moves.unwrap_or(Direction::Plus),
            stated: stated.plus_moves.is_some(),
        }
    }

    /// What the rows hold, if all can be read; a row of the file for each run of it.
    fn rows(&self, table: &mut Table<'a>, term: Option<Component>) -> Vec<ImportRow<'a>> {
        let (delimiter, width) = (table.header.delimiter(), table.header.cells().len());
        let separated = table.lines.iter().map(|line| line.separated_by(delimiter, false));
        let filled = separated.filter(|line| !line.is_empty_row());
        // Cells are taken apart again where they are needed: together they are many times the file.
        let is_whole = |line: &Line<'_>| self.notes.take(line.cells_under(width)).is_some();
        table.lines = filled.filter(is_whole).collect();
        let decimal = self.notes.take(self.decimal(table));
        let Some(decimal) = decimal.filter(|_| self.notes.is_sound()) else {
            return Vec::new();
        };
        for line in &mut table.lines {
            *line = line.separated_by(delimiter, decimal == Decimal::Comma);
        }
        table.rows(|row| self.rows_of(&table.columns, row, term)).into_iter().flatten().collect()
    }

    /// Where no name says whether values are positions, each has to be near its target.
    fn refuse_unclear_values(&self, table: &Table<'_>, rows: &[ImportRow<'_>]) {
        const NAME_VALUES: &str = "`up1_actual_mm` holds positions, `up1_deviation_mm` deviations";
        let small_um = small_um(rows.iter().map(|row| row.position));
        let is_open = |own: Content| own.as_reading().is_some_and(|own| own.values.is_none());
        let mut values = rows.iter().flat_map(|row| &row.values);
        let open = table.find(is_open);
        if let Some(open) = open.filter(|_| values.any(|(_, um)| um.abs() > small_um)) {
            let found =
                "they are far from the targets; map them to `…_actual_…` or `…_deviation_…`";
            let problem = refusals::unclear_values(&open.name, found, NAME_VALUES);
            self.notes.refuse(table.at(open, problem));
        }
    }

    /// The sign before the decimals: as stated, else as all numbers of the file show it.
    fn decimal(&self, table: &Table<'_>) -> Result<Decimal, Problem> {
        let Table { header, columns, lines, .. } = table;
        let (mut comma, mut point, mut only_thousands) = (None, None, true);
        for (row, line) in lines.iter().enumerate() {
            let cells = line.cells();
            for index in columns.iter().filter(|own| own.unit.is_some()).map(|own| own.index) {
                if cells[index].contains(',') {
                    comma.get_or_insert((row, index));
                    only_thousands &= may_be_thousands(&cells[index]);
                }
                if cells[index].contains('.') {
                    point.get_or_insert((row, index));
                }
            }
        }
        let (stated, by_commas) = (self.stated.decimal, header.delimiter() == b',');
        let refused = |(row, index): (usize, usize), problem: fn(String) -> Problem| {
            Err(problem(shown(&lines[row].cells()[index])).at(lines[row].cell_place(index)))
        };
        match (stated, comma, point) {
            (Some(Decimal::Point), Some(at), _) => refused(at, refusals::comma_not_point),
            (Some(Decimal::Comma), _, Some(at)) => refused(at, refusals::point_not_comma),
            (Some(stated), ..) => Ok(stated),
            (None, Some(at), _) if by_commas => refused(at, refusals::comma_between_commas),
            (None, Some(comma), Some(point)) => {
                refused(comma.max(point), refusals::comma_and_point)
            }
            (None, Some(at), None) if only_thousands => refused(at, refusals::thousand_or_decimal),
            (None, Some(_), None) => Ok(Decimal::Comma),
            (None, None, _) => Ok(Decimal::Point),
        }
    }

    /// What a line holds, if its mapped cells can be read: a row for each run of it.
    fn rows_of(
        &self,
        columns: &[Column],
        line: &TableRow<'_, 'a>,
        term: Option<Component>,
    ) -> Option<Vec<ImportRow<'a>>> {
        let stated = self.stated;
        // The way of the axis where the file says `+` or `-`, whose sense may have been stated.
        let way = |symbol: Direction| match stated.plus_moves {
            Some(Direction::Minus) => symbol.opposite(),
            _ => symbol,
        };
        let mut axis = stated.axis.or(term.map(|term| term.along));
        let mut direction = stated.travel.and_then(Travel::direction);
        let (mut run, mut position, mut complete) = (Some(1), None, true);
        let mut values = Vec::with_capacity(columns.len());
        for column in columns {
            let cell = line.cell(column);
            match column.content {
                Content::Axis => axis = axis_of(&cell, stated.axis),
                Content::Direction => {
                    direction = cell.read(approach, "the direction is", DIRECTION).map(way);
                    complete &= direction.is_some();
                }
                Content::Run => run = line.parsed(Content::Run, None, count, RUN),
                content => {
                    let number = match content {
                        Content::Uncertainty(_) => cell.uncertainty(NUMBER),
                        _ => cell.number(NUMBER),
                    };
                    let number = number.map(|number| number * column.factor());
                    complete &= number.is_some();
                    match content {
                        Content::Target | Content::Position => position = number,
                        _ => values.extend(number.map(|number| (content, number))),
                    }
                }
            }
        }
        let (axis, run, position) = (axis?, run?, position?);
        let of_runs = values.into_iter().filter_map(|(content, number)| {
            let Content::Reading(own) = content else {
                return Some(((direction, run), (content, number)));
            };
            let Some(kind @ Kind::Deviation(_)) = term.map(|term| term.kind) else {
                return None;
            };
            let zero = match own.values {
                Some(Values::Deviations) => 0.0,
                _ => position * UM_PER_MM,
            };
            let run = (own.direction.map(way).or(direction), own.run.map_or(run, u64::from));
            Some((run, (Content::Value(kind), number - zero)))
        });
        let row = |((direction, run), values)| {
            let line = line.line;
            ImportRow { line, axis, direction, run, position, values }
        };
        complete.then(|| grouped(of_runs).into_iter().map(row).collect())
    }
}

fn axis_of(cell: &Cell<'_>, stated: Option<Axis>) -> Option<Axis> {
    let axis = Axis::from_letter(cell.text);
    cell.refuse(match (axis, stated) {
        (None, _) => refusals::no_axis(shown(cell.text)),
        (Some(axis), Some(own)) if axis != own => refusals::other_axis_in_row(axis, own.key()),
        _ => return axis,
    });
    None
}

/// Whether a number is one as a thousand or more would be written with a comma, e.g. `1,000`.
fn may_be_thousands(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '\u{2212}']);
    let is_digits = |part: &str| part.chars().all(|c| c.is_ascii_digit());
    digits.split_once(',').is_some_and(|(before, behind)| {
        let may_be = (1..=3).contains(&before.len()) && !before.starts_with('0');
        may_be && behind.len() == 3 && is_digits(before) && is_digits(behind)
    })
}

/// Where the mapped columns stand.
fn columns_of(header: &Line<'_>, mapping: &Mapping) -> Result<Vec<Column>, Problems> {
    let cells = header.cells();
    let mut problems = Problems::none();
    let mut columns: Vec<Column> = Vec::new();
    for (named, mapped) in &mapping.columns {
        let Some(index) = problems.take(place_of(header, &cells, named)) else {
            continue;
        };
        let mut refuse = |problem: Problem| problems.push(problem.at(header.cell_place(index)));
        if columns.iter().any(|other| other.index == index) {
            refuse(refusals::mapped_twice(index + 1));
        }
        let name = cells[index].to_string();
        // The file's own header says which unit its numbers have.
        if let (Some((_, found)), Some(unit)) = (unit_of_name(&name), mapped.unit)
            && found != unit.word
        {
            refuse(refusals::other_unit(shown(&name), found, unit.word));
        }
        columns.push(Column { index, name, ..mapped.clone() });
    }
    problems.or_ok(columns)
}

/// The column of this name, two of which are not told apart by it, or of this number.
fn place_of(
    header: &Line<'_>,
    cells: &[Cow<'_, str>],
    named: &ColumnName,
) -> Result<usize, Problem> {
    let name = match named {
        ColumnName::Text(name) => name,
        ColumnName::Number(number) if (1..=cells.len()).contains(number) => return Ok(number - 1),
        ColumnName::Number(number) => {
            return Err(refusals::no_such_number(number, cells.len()).at(header.whole()));
        }
    };
    let found = cells.iter().enumerate().filter(|(_, cell)| *cell == name);
    match found.map(|(index, _)| index).collect::<Vec<usize>>()[..] {
        [first, second, ..] => {
            let problem = refusals::same_names(first + 1, second + 1, shown(name));
            Err(problem.at(header.cell_place(second)))
        }
        [only] => Ok(only),
        [] => Err(refusals::no_column(shown(name)).at(header.whole())),
    }
}

/// The first line that holds every name of the mapping is the header; otherwise the line that comes nearest to
/// them shows what is missing.
fn header_of<'a>(lines: &[Line<'a>], mapping: &Mapping) -> Result<Line<'a>, Problems> {
    let lacks = |line: &Line<'_>| -> Vec<&str> {
        let cells = line.cells();
        let names = mapping.columns.iter().filter_map(|(name, _)| match name {
            ColumnName::Text(name) => Some(name.as_str()),
            ColumnName::Number(_) => None,
        });
        names.filter(|name| !cells.iter().any(|cell| cell == name)).collect()
    };
    let is_header = |line: &&Line<'_>| line.cells().len() > 1 && lacks(line).is_empty();
    if let Some(header) = lines.iter().find(is_header) {
        return Ok(*header);
    }
    let mut problems = Problems::none();
    let filled = lines.iter().filter(|line| !line.text().trim().is_empty());
    if let Some(line) = filled.min_by_key(|line| lacks(line).len()).or(lines.first()) {
        let lacking = lacks(line);
        let lacking = lacking.iter().map(|name| refusals::no_column(shown(name)).at(line.whole()));
        lacking.for_each(|problem| problems.push(problem));
        if problems.is_empty() {
            problems.push(refusals::no_further_column().at(line.whole()));
        }
    }
    Err(problems)
}
