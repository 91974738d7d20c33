//! Any delimited text, by a stated mapping of its columns.
//!
//! Separator `;`, tab or comma; quotation marks; a decimal comma where it does not separate and
//! where it cannot stand between thousands ([`crate::inputs::import::decimal`]).

use crate::inputs::import::Reading;
use crate::inputs::import::choices::Decimal;
use crate::inputs::import::decimal::{NumberCell, decimal_of};
use crate::inputs::import::groups::{Group, Order, target_order};
use crate::inputs::import::mapped_rows::Row;
use crate::inputs::import::mapping::{EXAMPLE, Mapping, Named, Unit};
use crate::inputs::import::stated::{Stated, missing};
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::{self, Line};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};
use std::borrow::Cow;
use std::collections::BTreeMap;

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let Some(mapping) = &stated.columns else {
        return Err(missing(
            "--columns",
            "which column holds what cannot be seen from the file",
            &format!("add the mapping, {EXAMPLE}"),
        )
        .into());
    };
    let mapping = Mapping::read(mapping)?;
    let mut problems = Problems::none();
    let table = problems.take(Table::read(source, &mapping));
    mapping.refuse_double_statements(stated, &mut problems);
    let sign = stated.required_sign(&mut problems);
    mapping.require(stated, &mut problems);
    let Some(table) = table else {
        return Err(problems);
    };
    let rows = table.rows(&mapping, stated, &mut problems);
    let (Some(sign), true) = (sign, problems.is_empty()) else {
        return Err(problems);
    };
    let mut reading = Reading::default();
    reading.facts.push(format!(
        "table: its columns are named in line {}",
        table.header.number()
    ));
    let order = target_order(&rows, &mapping, &mut problems);
    let said = sense_of_plus(&mapping, order, stated, &table.header, &mut problems);
    reading.facts.extend(said);
    let mut groups: BTreeMap<(Axis, Option<Direction>), Vec<&Row<'_>>> = BTreeMap::new();
    for row in &rows {
        let group = groups.entry((row.axis, row.direction)).or_default();
        group.push(row);
    }
    for ((axis, direction), of_group) in groups {
        let group = Group {
            mapping: &mapping,
            order,
            first_target: rows.first().map_or(0.0, |row| row.position),
            axis,
            direction,
            rows: of_group,
        };
        let facts = &mut reading.facts;
        let series = group.series(sign, stated, facts, &mut problems);
        reading.series.extend(series);
    }
    problems.or_ok(reading)
}

/// What `+` of a mapped direction means: where targets, outward run and axis do not all go the
/// same way, the file cannot say which of them its `+` follows.
fn sense_of_plus(
    mapping: &Mapping,
    order: Order,
    stated: &Stated,
    header: &Line<'_>,
    problems: &mut Problems,
) -> Option<String> {
    if !mapping.has_directions() {
        return None;
    }
    let all_agree = !mapping.has_targets()
        || (order == Order::Ascending && stated.targets_run == Some(Direction::Plus));
    if stated.plus_moves.is_none() && !all_agree && stated.targets_run.is_some() {
        problems.push(
            missing(
                "--plus-moves",
                "targets and axis do not both count up, so `+` of the file may be the machine's, that of the targets or the outward run",
                "add `--plus-moves +` or `--plus-moves -`: the way of the axis, in machine coordinates, in rows whose direction is `+`",
            )
            .at(header.whole()),
        );
    }
    let way = stated.plus_moves.unwrap_or(Direction::Plus);
    let known = if stated.plus_moves.is_some() {
        ", as stated"
    } else {
        ""
    };
    Some(format!(
        "direction: rows with `+` = the axis moving {way}{known}"
    ))
}

/// The part of the file below the names of its columns.
struct Table<'a> {
    header: Line<'a>,
    lines: Vec<Line<'a>>,
    width: usize,
    /// For each mapped column: its place in a row, and its name.
    columns: Vec<(usize, String)>,
}

impl<'a> Table<'a> {
    /// The first line that holds every name of the mapping is the header.
    fn read(source: &'a Source, mapping: &Mapping) -> Result<Table<'a>, Problems> {
        let mut lines: Vec<Line<'a>> = delimited::lines(source).collect();
        let is_header = |line: &&Line<'a>| {
            let cells = line.cells();
            cells.len() > 1
                && mapping.columns.iter().all(|(name, _)| match name {
                    Named::Text(name) => cells.iter().any(|cell| cell == name),
                    Named::Number(_) => true,
                })
        };
        let Some(header) = lines.iter().find(is_header).copied() else {
            return Err(no_header(&lines, mapping));
        };
        let columns = columns_of(&header, mapping)?;
        lines.drain(..header.number());
        Ok(Table {
            header,
            lines,
            width: header.cells().len(),
            columns,
        })
    }

    fn rows(&self, mapping: &Mapping, stated: &Stated, problems: &mut Problems) -> Vec<Row<'a>> {
        let delimiter = self.header.delimiter();
        let separated = self.lines.iter();
        let whole: Vec<Line<'a>> = separated
            .map(|line| line.separated_by(delimiter, false))
            .filter(|line| !line.is_empty_row())
            .filter(|line| self.cells(line, problems).is_some())
            .collect();
        // Cells are taken apart again where they are needed: together they are many times the file.
        let decimal = decimal_of(&|| self.numbers(&whole, mapping), stated.decimal, problems);
        if !problems.is_empty() {
            return Vec::new();
        }
        let rows = whole.into_iter().filter_map(|line| {
            let cells = line.cells();
            let line = line.separated_by(delimiter, decimal == Decimal::Comma);
            Row::read(line, &cells, &self.columns, (mapping, stated), problems)
        });
        rows.collect()
    }

    /// The cells of a row, as many as in the header; a cell that is missing is never filled in.
    fn cells(&self, line: &Line<'a>, problems: &mut Problems) -> Option<Vec<Cow<'a, str>>> {
        let found = line.cells().len();
        if found >= self.width {
            return line.cells_under(self.width, problems);
        }
        problems.push_with(|| {
            Problem::new(format!(
                "the row has {found} cells, expected {} as in the header",
                self.width
            ))
            .at(line.whole())
            .help("the row is cut off, or does not belong to the table: remove what does not")
        });
        None
    }

    /// The cells of columns that hold quantities.
    fn numbers(
        &self,
        rows: &[Line<'a>],
        mapping: &Mapping,
    ) -> impl Iterator<Item = NumberCell<'a>> {
        let columns = self.columns.iter().zip(&mapping.columns);
        let indices: Vec<usize> = columns
            .filter(|(_, (_, content))| content.unit().is_some())
            .map(|((index, _), _)| *index)
            .collect();
        let of_row = move |line: &Line<'a>| {
            let cells = line.cells();
            let cell = |index: &usize| NumberCell {
                line: *line,
                index: *index,
                text: cells[*index].clone(),
            };
            indices.iter().map(cell).collect::<Vec<_>>()
        };
        rows.iter().flat_map(of_row)
    }
}

/// Place in the row and name of each mapped column.
fn columns_of(header: &Line<'_>, mapping: &Mapping) -> Result<Vec<(usize, String)>, Problems> {
    let cells = header.cells();
    let mut problems = Problems::none();
    let mut columns: Vec<(usize, String)> = Vec::new();
    for (named, content) in &mapping.columns {
        let index = match named {
            Named::Text(name) => only_column(header, &cells, name, &mut problems),
            Named::Number(number) => numbered_column(header, cells.len(), *number, &mut problems),
        };
        let Some(index) = index else { continue };
        if columns.iter().any(|(other, _)| *other == index) {
            problems.push(
                Problem::new(format!("column {} is mapped twice", index + 1))
                    .at(header.cell_place(index))
                    .help("a column holds one thing: map each once"),
            );
        }
        let name = cells[index].to_string();
        if let Some(unit) = content.unit() {
            refuse_other_unit(header, index, &name, unit, &mut problems);
        }
        columns.push((index, name));
    }
    problems.or_ok(columns)
}

/// The column of this name; two of them are not told apart by it.
fn only_column(
    header: &Line<'_>,
    cells: &[Cow<'_, str>],
    name: &str,
    problems: &mut Problems,
) -> Option<usize> {
    let mut found = cells.iter().enumerate().filter(|(_, cell)| *cell == name);
    let (first, _) = found.next()?;
    if let Some((second, _)) = found.next() {
        problems.push(
            Problem::new(format!(
                "columns {} and {} are both called `{}`",
                first + 1,
                second + 1,
                shown(name)
            ))
            .at(header.cell_place(second))
            .help(format!(
                "map the one that is meant by its number: `#{}=…` or `#{}=…`",
                first + 1,
                second + 1
            )),
        );
        return None;
    }
    Some(first)
}

fn numbered_column(
    header: &Line<'_>,
    width: usize,
    number: usize,
    problems: &mut Problems,
) -> Option<usize> {
    if (1..=width).contains(&number) {
        return Some(number - 1);
    }
    problems.push(
        Problem::new(format!(
            "`#{number}` of `--columns` is no column of the file, which has {width}"
        ))
        .at(header.whole())
        .help("columns are counted from 1"),
    );
    None
}

/// The file's own header says which unit its numbers have.
fn refuse_other_unit(
    header: &Line<'_>,
    index: usize,
    name: &str,
    mapped: Unit,
    problems: &mut Problems,
) {
    if let Some(found) = Unit::of_name(name).filter(|found| *found != mapped) {
        problems.push(
            Problem::new(format!(
                "the file gives `{}` in {}, but `--columns` maps it as {}",
                shown(name),
                found.word(),
                mapped.word()
            ))
            .at(header.cell_place(index))
            .help("map it to a column with the unit of the file"),
        );
    }
}

/// The line that comes nearest to the names of the mapping shows what is missing.
fn no_header(lines: &[Line<'_>], mapping: &Mapping) -> Problems {
    let names = || {
        mapping.columns.iter().filter_map(|(name, _)| match name {
            Named::Text(name) => Some(name.as_str()),
            Named::Number(_) => None,
        })
    };
    let found_in = |line: &Line<'_>| names().filter(|name| line.text().contains(*name)).count();
    let first = lines.iter().find(|line| !line.text().trim().is_empty());
    let best = lines.iter().rev().max_by_key(|line| found_in(line));
    let mut problems = Problems::none();
    let Some(line) = best.filter(|line| found_in(line) > 0).or(first).or(best) else {
        return problems;
    };
    for name in names().filter(|name| !line.text().contains(*name)) {
        problems.push(
            Problem::new(format!("the file has no column `{}`", shown(name)))
                .at(line.whole())
                .help("copy the names for `--columns` from the file, letter by letter"),
        );
    }
    if problems.is_empty() {
        problems.push(
            Problem::new("the names of `--columns` do not stand in one line as separated cells")
                .at(line.whole())
                .help("the separator is `;`, a tab or a comma"),
        );
    }
    problems
}
