//! The CSV form: lines and cells with their bytes in the text.
//!
//! The `csv` crate is not used here: it does not tell where in the line a cell stood.

use super::check::Reading;
use super::row::{Cell, Column, RawRow, RowFlaw};
use crate::control::table::generic::GenericTable;
use crate::read::lexer::Complaint;
use crate::text::document::MOST_ROWS;
use serde_json::Number;
use std::borrow::Cow;
use std::ops::Range;

pub(super) fn read(text: &str) -> Result<GenericTable, Vec<Complaint>> {
    let mut lines = lines(text);
    let Some(header) = lines.next() else {
        let help = "first line: term,base_axis,output_axis,direction,index,position_mm,\
                    deviation_um,correction_um,increment_um";
        let message = "the file is empty, expected a generic table";
        return Err(vec![Complaint::new(0..0, message, help)]);
    };
    let columns = columns(text, header.clone())?;
    let rows: Vec<Range<usize>> = lines.take(MOST_ROWS + 1).collect();
    if let Some(first) = rows.get(MOST_ROWS) {
        return Err(vec![super::check::too_many_rows(first.clone())]);
    }
    if rows.is_empty() {
        let message = "the table has a header but no rows";
        let help = "each row is one point; the file may have been cut off";
        return Err(vec![Complaint::new(header, message, help)]);
    }
    let mut reading = Reading::default();
    for (number, line) in rows.iter().enumerate() {
        if reading.is_full() {
            break;
        }
        match raw_row(text, number, line.clone(), &columns) {
            Ok(raw) => reading.take(&raw),
            Err(flaw) => reading.lose_row([flaw]),
        }
    }
    let located = |flaw: RowFlaw| {
        let span = place(text, rows[flaw.row].clone(), &columns, flaw.cell.as_deref());
        Complaint::new(span, flaw.message, flaw.help)
    };
    let complaints = |flaws: Vec<RowFlaw>| flaws.into_iter().map(located).collect();
    reading.finish().map_err(complaints)
}

/// The bytes of a cell of a line, or of the whole line.
fn place(text: &str, line: Range<usize>, columns: &[Column], cell: Option<&str>) -> Range<usize> {
    let index = columns.iter().position(|c| Some(c.name()) == cell);
    let found = index.and_then(|index| cells(text, line.clone()).nth(index));
    found.unwrap_or(line)
}

/// The lines that hold something, without their ends and without a byte order mark, which
/// spreadsheets write.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    const MARK: char = '\u{feff}';
    let mut at = 0;
    let whole = text.split('\n').map(move |line| {
        let start = at;
        at += line.len() + 1;
        let end = start + line.trim_end_matches('\r').len();
        let mark = start == 0 && line.starts_with(MARK);
        start + if mark { MARK.len_utf8() } else { 0 }..end
    });
    whole.filter(move |line| !text[line.clone()].trim().is_empty())
}

/// The bytes of the cells of a line, without the blanks around them.
fn cells(text: &str, line: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let mut quoted = false;
    let mut at = line.start;
    let ends_cell = move |c: char| {
        quoted ^= c == '"';
        c == ',' && !quoted
    };
    text[line].split(ends_cell).map(move |cell| {
        let start = at;
        at += cell.len() + 1;
        trimmed(text, start..start + cell.len())
    })
}

/// The same bytes without the blanks at both ends.
pub(super) fn trimmed(text: &str, range: Range<usize>) -> Range<usize> {
    let found = &text[range.clone()];
    let start = range.start + found.len() - found.trim_start().len();
    start..start + found.trim().len()
}

fn content(cell: &str) -> Cow<'_, str> {
    let inside = cell
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    match inside {
        Some(inside) if inside.contains("\"\"") => inside.replace("\"\"", "\"").into(),
        _ => inside.unwrap_or(cell).into(),
    }
}

/// Which column each cell of a row belongs to.
fn columns(text: &str, header: Range<usize>) -> Result<Vec<Column>, Vec<Complaint>> {
    let mut complaints = Vec::new();
    let mut columns = Vec::new();
    for cell in cells(text, header.clone()) {
        let name = content(&text[cell.clone()]);
        match Column::from_name(&name) {
            Some(column) if columns.contains(&column) => complaints.push(Complaint::new(
                cell,
                format!("column `{name}` stands in the header twice"),
                "remove one of the two",
            )),
            Some(column) => columns.push(column),
            None => complaints.push(Complaint::new(
                cell,
                format!("unknown column `{name}`"),
                Column::help_for(&name),
            )),
        }
    }
    let missing = Column::ALL.into_iter().filter(|c| !columns.contains(c));
    complaints.extend(missing.map(|column| {
        let message = format!("the header has no column `{}`", column.name());
        let help = "a generic table has nine columns, separated by commas";
        Complaint::new(header.clone(), message, help)
    }));
    if complaints.is_empty() {
        Ok(columns)
    } else {
        Err(complaints)
    }
}

/// The row of a line; the columns were checked to be nine different ones.
fn raw_row<'a>(
    text: &'a str,
    number: usize,
    line: Range<usize>,
    columns: &[Column],
) -> Result<RawRow<'a>, RowFlaw> {
    let mut row = RawRow {
        number,
        cells: [const { Cell::Empty }; 9],
    };
    let mut found = 0;
    for cell in cells(text, line) {
        if let Some(column) = columns.get(found) {
            row.cells[*column as usize] = value(*column, content(&text[cell]));
        }
        found += 1;
    }
    if found == columns.len() {
        Ok(row)
    } else {
        Err(wrong_count(number, found, columns.len()))
    }
}

fn wrong_count(row: usize, found: usize, expected: usize) -> RowFlaw {
    let help = if found < expected {
        "the file may have been cut off, write or transfer it again"
    } else {
        "cells are separated by commas, decimals by a point"
    };
    let cells = if found == 1 { "cell" } else { "cells" };
    let message = format!("the row has {found} {cells}, expected {expected}");
    RowFlaw::of_row(row, message, help)
}

/// A number where the column holds numbers and the text is one; empty if empty; else the text.
fn value(column: Column, text: Cow<'_, str>) -> Cell<'_> {
    if text.is_empty() {
        return Cell::Empty;
    }
    if !column.is_number() {
        return Cell::Text(text);
    }
    if let Ok(whole) = text.parse::<u64>() {
        return Cell::Number(whole.into());
    }
    let number = text.parse().ok().and_then(Number::from_f64); // not finite: none
    number.map_or(Cell::Text(text), Cell::Number)
}
