//! The two forms of the generic table, CSV and `{"schema":1,"rows":[{…}, …]}`, row by row.

use super::check::{Flaw, GenericRow, checked};
use super::refusals;
use crate::text::{
    Line, LineIndex, MOST_ROWS, Problem, Problems, Source, bounded, lines, nearest,
    refuse_long_lines, refuse_many_columns, shown,
};
use serde::Deserialize;
use std::borrow::Cow;

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
    rows: Vec<GenericRow>,
}

/// Reads the JSON form. What is no such document is told at its first place.
pub(super) fn read_json(file: &str, text: &str) -> Result<Vec<GenericRow>, Problems> {
    // JSON may stand in one line; the columns of a long one are not counted.
    let index = refuse_long_lines(file, text).is_ok().then(LineIndex::default);
    let at = |problem: Problem, start: usize, end: usize| match &index {
        Some(index) => problem.at(index.place(file, text, start, end)),
        None => behind(&format!("`{file}`"), problem),
    };
    let document: Document = serde_json::from_str(text).map_err(|flaw| {
        let before = text.split_inclusive('\n').take(flaw.line().saturating_sub(1));
        let start = before.map(str::len).sum::<usize>() + flaw.column().saturating_sub(1);
        let whole = flaw.to_string();
        let what = whole.split(" at line ").next().unwrap_or(&whole);
        at(refusals::no_json(what), start, start + 1)
    })?;
    if document.schema != 1 {
        return Err(at(refusals::other_schema(document.schema), 0, 1).into());
    }
    if let Some(problem) = wrong_count(document.rows.len()) {
        let (start, end) = place_of(text, document.rows.len(), "rows");
        return Err(at(problem, start, end).help(refusals::NINE_KEYS).into());
    }
    checked(document.rows.into_iter().map(Ok), |flaw| {
        let (start, end) = place_of(text, flaw.row, flaw.column);
        at(behind(&format!("rows[{}]", flaw.row), flaw.problem), start, end)
    })
}

/// A problem whose words stand behind where it is.
fn behind(place: &str, mut problem: Problem) -> Problem {
    problem.message = bounded(format!("{place}: {}", problem.message));
    problem
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
pub(super) fn read_csv(file: &str, text: &str) -> Result<Vec<GenericRow>, Problems> {
    let source = Source::from_bytes(file, text.as_bytes())?;
    let mut rows = lines(&source)
        .filter(|line| !line.text().trim().is_empty())
        .map(|line| line.separated_by(b',', false));
    let first_line = format!("first line: {}", COLUMNS.join(","));
    let Some(header) = rows.next() else {
        return Err(refusals::no_table(first_line).at(source.place(&(0..0))).into());
    };
    refuse_many_columns(&header, &first_line)?;
    let help = "a generic table has nine columns, separated by commas";
    let names = columns(&header, (&COLUMNS, &[]), help)?;
    let rows: Vec<Line<'_>> = rows.take(MOST_ROWS + 1).collect();
    if let Some(problem) = wrong_count(rows.len()) {
        return Err(problem.at(header.whole()).into());
    }
    checked(rows.iter().map(|line| row(*line, &names)), |flaw: Flaw| {
        let place = rows[flaw.row].cell_place(place_among(&names, flaw.column));
        flaw.problem.at(place)
    })
}

pub(super) fn wrong_count(rows: usize) -> Option<Problem> {
    match rows {
        0 => Some(refusals::no_rows()),
        1..=MOST_ROWS => None,
        _ => Some(refusals::many_rows(MOST_ROWS)),
    }
}

/// The names of the columns of a header: all that are needed, and some that may be there.
pub(super) fn columns(
    header: &Line<'_>,
    (needed, others): (&[&str], &[&str]),
    help: &str,
) -> Result<Vec<String>, Problems> {
    let names: Vec<String> = header.cells().iter().map(ToString::to_string).collect();
    let known = || needed.iter().chain(others).copied();
    let mut problems = Problems::none();
    for (index, name) in names.iter().enumerate() {
        let at = |problem: Problem| problem.at(header.cell_place(index));
        if !known().any(|known| known == name.as_str()) {
            let near = nearest(name, known()).map(|near| format!("did you mean `{near}`?"));
            let help = near.unwrap_or_else(|| format!("expected {}", needed.join(",")));
            problems.push(at(refusals::unknown_column(shown(name), help)));
        } else if names[..index].contains(name) {
            problems.push(at(refusals::column_twice(name)));
        }
    }
    for name in needed.iter().filter(|name| !names.iter().any(|own| own == **name)) {
        problems.push(refusals::no_column(name, help).at(header.whole()));
    }
    problems.or_ok(names)
}

/// Where a column stands.
pub(super) fn place_among(names: &[String], column: &str) -> usize {
    names.iter().position(|own| own == column).unwrap_or_default()
}

/// The cells of a row under the names of their columns, and what is wrong with them.
pub(super) struct Cells<'a, 'b> {
    pub(super) line: Line<'a>,
    names: &'b [String],
    cells: Vec<Cow<'a, str>>,
    /// The next step where a number is none.
    help: &'static str,
    pub(super) problems: Problems,
}

impl<'a, 'b> Cells<'a, 'b> {
    pub(super) fn of(
        line: Line<'a>,
        names: &'b [String],
        help: &'static str,
    ) -> Result<Self, Problem> {
        let cells = line.cells_under(names.len())?;
        Ok(Cells { line, names, cells, help, problems: Problems::none() })
    }

    pub(super) fn text(&self, column: &str) -> String {
        self.cells[place_among(self.names, column)].to_string()
    }

    /// The text of a cell that may be empty.
    pub(super) fn text_if_any(&self, column: &str) -> Option<String> {
        Some(self.text(column)).filter(|text| !text.is_empty())
    }

    /// The number of a cell; 0 where a problem says that it is none.
    pub(super) fn number(&mut self, column: &str) -> f64 {
        let place = place_among(self.names, column);
        let (cell, problems) = (&self.cells[place], &mut self.problems);
        self.line.number_in(place, cell, column, self.help, problems).unwrap_or_default()
    }

    /// The same of one that may be empty.
    pub(super) fn number_if_any(&mut self, column: &str) -> Option<f64> {
        self.text_if_any(column).map(|_| self.number(column))
    }

    /// Notes what is wrong with a cell.
    pub(super) fn refuse(&mut self, column: &str, problem: Problem) {
        let place = self.line.cell_place(place_among(self.names, column));
        self.problems.push(problem.at(place));
    }
}

/// The row of a line, or what its columns cannot hold.
fn row(line: Line<'_>, names: &[String]) -> Result<GenericRow, Problems> {
    const NUMBER: &str = "write digits with a decimal point; a row without a value is left out";
    let mut cells = Cells::of(line, names, NUMBER)?;
    let index = cells.text("index").parse::<u32>();
    if index.is_err() {
        cells.refuse("index", refusals::no_index(cells.text("index")));
    }
    let row = GenericRow {
        term: cells.text("term"),
        base_axis: cells.text("base_axis"),
        output_axis: cells.text("output_axis"),
        direction: cells.text_if_any("direction"),
        index: index.unwrap_or_default(),
        position_mm: cells.number("position_mm"),
        deviation_um: cells.number("deviation_um"),
        correction_um: cells.number("correction_um"),
        increment_um: cells.number_if_any("increment_um"),
    };
    cells.problems.or_ok(row)
}
