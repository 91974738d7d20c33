//! The two forms of the generic table, CSV and `{"schema":1,"rows":[{…}, …]}`, row by row.

use super::check::{Flaw, RawRow, table};
use crate::control::table::generic::GenericTable;
use crate::text::delimited::{Line, lines, refuse_many_columns};
use crate::text::document::{MOST_ROWS, Source};
use crate::text::problem::{LineIndex, Problem, Problems, nearest, refuse_long_lines};
use serde::Deserialize;

/// Columns of the CSV and keys of a row of the JSON.
pub(super) const COLUMNS: [&str; 9] = [
    "term",
    "base_axis",
    "output_axis",
    "direction",
    "index",
    "position_mm",
    "deviation_um",
    "correction_um",
    "increment_um",
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    schema: u32,
    rows: Vec<RawRow>,
}

/// Reads the JSON form. What is no such document is told at its first place.
pub(super) fn read_json(file: &str, text: &str) -> Result<GenericTable, Problems> {
    const HELP: &str =
        "expected {\"schema\":1,\"rows\":[…]} with the nine columns as keys of each row";
    // JSON may stand in one line; the columns of a long one are not counted.
    let index = refuse_long_lines(file, text).is_ok().then(LineIndex::default);
    let at = |message: String, start: usize, end: usize| match &index {
        Some(index) => Problem::new(message).at(index.place(file, text, start, end)),
        None => Problem::new(format!("`{file}`: {message}")),
    };
    let document: Document = serde_json::from_str(text).map_err(|flaw| {
        let before = text.split_inclusive('\n').take(flaw.line().saturating_sub(1));
        let start = before.map(str::len).sum::<usize>() + flaw.column().saturating_sub(1);
        let whole = flaw.to_string();
        let what = whole.split(" at line ").next().unwrap_or(&whole);
        let message = format!("the JSON cannot be read: {what}");
        at(message, start, start + 1).help(format!("{HELP}; the file may have been cut off"))
    })?;
    if document.schema != 1 {
        let message = format!("`schema` is {}, expected 1", document.schema);
        return Err(at(message, 0, 1).help(HELP).into());
    }
    if let Some(problem) = wrong_count(document.rows.len()) {
        let (start, end) = place_of(text, document.rows.len(), "rows");
        return Err(at(problem.message, start, end).help(HELP).into());
    }
    table(document.rows.into_iter().map(Ok), |flaw| {
        let (start, end) = place_of(text, flaw.row, flaw.column);
        at(format!("rows[{}]: {}", flaw.row, flaw.message), start, end)
    })
}

/// Where a key of a row stands; rows are the only objects inside the outermost one.
fn place_of(text: &str, row: usize, key: &str) -> (usize, usize) {
    let row = text.match_indices('{').nth(row + 1);
    let row = row.map_or(0, |(at, _)| at); // behind the last one: the document
    let quoted = format!("\"{key}\"");
    let start = text[row..].find(&quoted).map_or(row, |at| row + at);
    (start, start + quoted.len())
}

/// Reads the CSV form; blank lines are ignored.
pub(super) fn read_csv(file: &str, text: &str) -> Result<GenericTable, Problems> {
    let source = Source::from_bytes(file, text.as_bytes())?;
    let mut rows = lines(&source)
        .filter(|line| !line.text().trim().is_empty())
        .map(|line| line.separated_by(b',', false));
    let Some(header) = rows.next() else {
        return Err(Problem::new("the file is empty, expected a generic table")
            .at(source.place(&(0..0)))
            .help(format!("first line: {}", COLUMNS.join(",")))
            .into());
    };
    refuse_many_columns(&header, &format!("first line: {}", COLUMNS.join(",")))?;
    let columns = columns(&header)?;
    let rows: Vec<Line<'_>> = rows.take(MOST_ROWS + 1).collect();
    if let Some(problem) = wrong_count(rows.len()) {
        return Err(problem.at(header.whole()).into());
    }
    let raw = rows.iter().map(|row| raw_row(row, &columns));
    table(raw, |flaw: &Flaw| {
        let cell = COLUMNS.iter().position(|name| *name == flaw.column);
        let cell = cell.map_or(0, |column| columns[column]);
        Problem::new(flaw.message.clone()).at(rows[flaw.row].cell_place(cell))
    })
}

pub(super) fn wrong_count(rows: usize) -> Option<Problem> {
    let (message, help) = match rows {
        0 => (
            "the table has no rows".to_string(),
            "each row is one point; the file may have been cut off",
        ),
        1..=MOST_ROWS => return None,
        _ => (
            format!("the table has more than {MOST_ROWS} rows, too many for any control"),
            "check that this is a table of corrections",
        ),
    };
    Some(Problem::new(message).help(help))
}

/// In which cell of a row each of [`COLUMNS`] stands.
fn columns(header: &Line<'_>) -> Result<[usize; 9], Problems> {
    let cells = header.cells();
    let mut problems = Problems::none();
    for (index, cell) in cells.iter().enumerate() {
        let at = |message: String| Problem::new(message).at(header.cell_place(index));
        if !COLUMNS.contains(&cell.as_ref()) {
            problems.push(at(format!("unknown column `{cell}`")).help(
                match nearest(cell, COLUMNS) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("expected {}", COLUMNS.join(",")),
                },
            ));
        } else if cells[..index].contains(cell) {
            let message = format!("column `{cell}` stands in the header twice");
            problems.push(at(message).help("remove one of the two"));
        }
    }
    let place = |name: &str| cells.iter().position(|cell| cell == name);
    for name in COLUMNS.iter().filter(|name| place(name).is_none()) {
        let message = format!("the header has no column `{name}`");
        let help = "a generic table has nine columns, separated by commas";
        problems.push(Problem::new(message).at(header.whole()).help(help));
    }
    problems.or_ok(COLUMNS.map(|name| place(name).unwrap_or_default()))
}

/// The row of a line, or what its columns cannot hold.
fn raw_row(line: &Line<'_>, columns: &[usize; 9]) -> Result<RawRow, Problems> {
    const NUMBER: &str = "write digits with a decimal point; a row without a value is left out";
    let mut problems = Problems::none();
    let Some(cells) = line.cells_under(COLUMNS.len(), &mut problems) else {
        return Err(problems);
    };
    let cell = |column: usize| cells[columns[column]].as_ref();
    let index = cell(4).parse().unwrap_or_else(|_| {
        let message = format!("`index` is `{}`, expected a whole number from 0", cell(4));
        let problem = Problem::new(message).at(line.cell_place(columns[4]));
        problems.push(problem.help("the points of a block are counted 0, 1, 2, …"));
        0
    });
    let mut number = |column: usize| {
        let (place, name) = (columns[column], COLUMNS[column]);
        line.number_in(place, cell(column), name, NUMBER, &mut problems)
    };
    let row = RawRow {
        term: cell(0).to_string(),
        base_axis: cell(1).to_string(),
        output_axis: cell(2).to_string(),
        direction: Some(cell(3).to_string()).filter(|symbol| !symbol.is_empty()),
        index,
        position_mm: number(5).unwrap_or_default(),
        deviation_um: number(6).unwrap_or_default(),
        correction_um: number(7).unwrap_or_default(),
        increment_um: match cell(8) {
            "" => None,
            _ => number(8),
        },
    };
    problems.or_ok(row)
}
