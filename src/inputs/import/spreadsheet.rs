//! A sheet of a workbook as delimited text: a row a line, semicolons between the cells, numbers with all their digits.

use crate::text::{Problem, shown};
use calamine::{Data, Reader, Sheets, open_workbook_auto_from_rs};
use std::io::Cursor;

/// Cells that a sheet may span, empty ones too: a measurement of 50 000 lines with 40 columns.
const MOST_CELLS: u64 = 2_000_000;

/// The sheet of this name, or the first one.
///
/// **limits** the cells that a sheet of an `.xlsx` spans; what a workbook unpacks to is not bounded by this program
pub(super) fn text(path: &str, bytes: &[u8], sheet: Option<&str>) -> Result<String, Problem> {
    let refuse = |error: calamine::Error| {
        let words = format!("`{path}` cannot be read as a workbook: {error}");
        Problem::new(words).help("save it again, or save the sheet as CSV")
    };
    let mut book = open_workbook_auto_from_rs(Cursor::new(bytes)).map_err(refuse)?;
    let names = book.sheet_names();
    let mut wanted = names.iter().filter(|name| sheet.is_none_or(|sheet| *name == sheet));
    let Some(name) = wanted.next().cloned() else {
        let words = format!("`{}` has no sheet `{}`", path, shown(sheet.unwrap_or_default()));
        return Err(Problem::new(words).help(format!("its sheets: {}", names.join(", "))));
    };
    refuse_wide(path, &mut book, &name)?;
    let range = book.worksheet_range(&name).map_err(refuse)?;
    // From A1 on, as people count: a range begins with the first cell that is filled.
    let (row, column) = range.start().unwrap_or_default();
    let [above, before] = [("\n", row), (";", column)].map(|(of, count)| of.repeat(count as usize));
    let line = |row: &[Data]| {
        let cells: Vec<String> = row.iter().map(cell).collect();
        // A comment of a table of ours: a program for tables takes it apart at its commas.
        match cells.first().is_some_and(|first| first.starts_with('#')) {
            true => cells.join(","),
            false => cells.join(";"),
        }
    };
    let lines = range.rows().map(|row| format!("{before}{}\n", line(row)));
    Ok(above + &lines.collect::<String>())
}

/// A few cells may claim a sheet that no memory holds: it is made as a whole, from the first to the last of them.
fn refuse_wide(path: &str, book: &mut Sheets<Cursor<&[u8]>>, name: &str) -> Result<(), Problem> {
    let Sheets::Xlsx(book) = book else {
        return Ok(()); // the others end with 65 536 rows, or are bounded where they are read
    };
    let Ok(mut cells) = book.worksheet_cells_reader(name) else {
        return Ok(()); // told when it is read
    };
    let (mut rows, mut columns) = (0, 0);
    while let Ok(Some(cell)) = cells.next_cell() {
        let (row, column) = cell.get_position();
        (rows, columns) = (rows.max(u64::from(row) + 1), columns.max(u64::from(column) + 1));
    }
    if rows * columns <= MOST_CELLS {
        return Ok(());
    }
    let words = format!(
        "the sheet `{}` of `{path}` spans {rows} rows and {columns} columns, too many for a measurement",
        shown(name)
    );
    Err(Problem::new(words).help("clear what stands far from the table, or save the sheet as CSV"))
}

/// A cell, without what would begin another one; a date as people write it, for the number of its day is none that
/// was measured.
fn cell(cell: &Data) -> String {
    let begins_another = |c: char| c.is_control() || c == ';' || c == '"';
    let Data::DateTime(date) = cell else {
        return cell.to_string().replace(begins_another, " ");
    };
    let (year, month, day, hour, minute, second, _) = date.to_ymd_hms_milli();
    format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}").replace(" 00:00:00", "")
}
