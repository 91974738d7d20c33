//! The CSV form: lines and cells with their bytes in the text.
//!
//! The `csv` crate is not used here: it does not tell where in the line a cell stood.

use super::check::Reading;
use super::row::{Cell, Column, Complaint, RawRow};
use crate::table::generic::GenericTable;
use serde_json::Value;
use std::ops::Range;

pub(super) fn read(text: &str) -> Result<GenericTable, Vec<Complaint>> {
    let mut lines = lines(text).filter(|line| !text[line.clone()].trim().is_empty());
    let Some(header) = lines.next() else {
        let help = "first line: term,base_axis,output_axis,direction,index,position_mm,\
                    deviation_um,correction_um,increment_um";
        let message = "the file is empty, expected a generic table";
        return Err(vec![Complaint::new(0..0, message, help)]);
    };
    let columns = columns(text, header.clone())?;
    let mut reading = Reading::default();
    let mut rows = lines.peekable();
    if rows.peek().is_none() {
        let message = "the table has a header but no rows";
        let help = "each row is one point; the file may have been cut off";
        reading.complain(Complaint::new(header, message, help));
    }
    for line in rows {
        if reading.is_full() {
            break;
        }
        match raw_row(text, line, &columns) {
            Ok(raw) => reading.take(raw),
            Err(complaint) => reading.lose_row(complaint),
        }
    }
    reading.finish()
}

/// The lines without their ends and without a byte order mark, which spreadsheets write.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    const MARK: char = '\u{feff}';
    let mut at = 0;
    text.split('\n').map(move |line| {
        let start = at;
        at += line.len() + 1;
        let end = start + line.trim_end_matches('\r').len();
        let mark = start == 0 && line.starts_with(MARK);
        start + if mark { MARK.len_utf8() } else { 0 }..end
    })
}

/// The bytes of the cells of a line, without the blanks around them.
fn cells(text: &str, line: Range<usize>) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut start = line.start;
    let mut quoted = false;
    for (at, c) in text[line.clone()].char_indices() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => {
                ranges.push(trimmed(text, start..line.start + at));
                start = line.start + at + 1;
            }
            _ => {}
        }
    }
    ranges.push(trimmed(text, start..line.end));
    ranges
}

/// The same bytes without the blanks at both ends.
pub(super) fn trimmed(text: &str, range: Range<usize>) -> Range<usize> {
    let found = &text[range.clone()];
    let start = range.start + found.len() - found.trim_start().len();
    start..start + found.trim().len()
}

fn content(cell: &str) -> String {
    let inside = cell
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    inside.map_or_else(|| cell.to_string(), |inside| inside.replace("\"\"", "\""))
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

fn raw_row(text: &str, line: Range<usize>, columns: &[Column]) -> Result<RawRow, Complaint> {
    let ranges = cells(text, line.clone());
    if ranges.len() != columns.len() {
        let (found, expected) = (ranges.len(), columns.len());
        let help = if found < expected {
            "the file may have been cut off, write or transfer it again"
        } else {
            "cells are separated by commas, decimals by a point"
        };
        let cells = if found == 1 { "cell" } else { "cells" };
        let message = format!("the row has {found} {cells}, expected {expected}");
        return Err(Complaint::new(line, message, help));
    }
    // One cell of each column, as the header was checked to have nine different ones.
    let cell_of = |column: Column| {
        let index = columns.iter().position(|c| *c == column).unwrap_or(0);
        Cell {
            value: value(column, &content(&text[ranges[index].clone()])),
            span: ranges[index].clone(),
        }
    };
    Ok(RawRow {
        label: String::new(),
        span: line,
        cells: Column::ALL.map(cell_of),
    })
}

/// A number where the column holds numbers and the text is one; null if empty; else the text.
fn value(column: Column, text: &str) -> Value {
    if text.is_empty() {
        return Value::Null;
    }
    let as_text = || Value::String(text.to_string());
    if !column.is_number() {
        return as_text();
    }
    if let Ok(whole) = text.parse::<u64>() {
        return Value::from(whole);
    }
    let number = text.parse().ok().and_then(serde_json::Number::from_f64); // not finite: none
    number.map_or_else(as_text, Value::Number)
}
