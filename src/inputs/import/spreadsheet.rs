//! A sheet of a workbook as delimited text: a row a line, semicolons between the cells, numbers with all their digits.

use crate::text::problem::{Problem, shown};
use calamine::{Data, Reader, open_workbook_auto_from_rs};
use std::io::Cursor;

/// The sheet of this name, or the first one.
///
/// **limits** what a workbook unpacks to is not bounded by this program
pub(super) fn text(path: &str, bytes: &[u8], sheet: Option<&str>) -> Result<String, Problem> {
    let refuse = |error: calamine::Error| {
        let words = format!("`{path}` cannot be read as a workbook: {error}");
        Problem::new(words).help("save it again, or save the sheet as CSV")
    };
    let mut book = open_workbook_auto_from_rs(Cursor::new(bytes)).map_err(refuse)?;
    let names = book.sheet_names();
    let mut wanted = names.iter().filter(|name| sheet.is_none_or(|sheet| *name == sheet));
    let Some(name) = wanted.next() else {
        let words = format!("`{}` has no sheet `{}`", path, shown(sheet.unwrap_or_default()));
        return Err(Problem::new(words).help(format!("its sheets: {}", names.join(", "))));
    };
    let range = book.worksheet_range(name).map_err(refuse)?;
    let line = |row: &[Data]| row.iter().map(cell).collect::<Vec<String>>().join(";") + "\n";
    Ok(range.rows().map(line).collect())
}

/// A cell, without what would begin another one.
fn cell(cell: &Data) -> String {
    let begins_another = |c: char| c.is_control() || c == ';' || c == '"';
    cell.to_string().replace(begins_another, " ")
}
