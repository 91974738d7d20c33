//! A table that a person brings: its header is read, and its rows come cell by cell.

use crate::text::delimited::{Cell, Expected, Line, columns_of, header_and_rows};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use std::borrow::Cow;

/// A table whose columns are known.
pub(super) struct Table<'a, C> {
    pub(super) header: Line<'a>,
    pub(super) kinds: Vec<C>,
    pub(super) names: Vec<String>,
    lines: Vec<Line<'a>>,
    first_line: &'static str,
}

impl<'a, C: Copy> Table<'a, C> {
    /// Reads the header; `what` is what the table should hold.
    pub(super) fn read(
        source: &'a Source,
        what: &str,
        first_line: &'static str,
        expected: impl FnOnce(&Line<'a>) -> Result<Expected<'static, C>, Problem>,
    ) -> Result<Table<'a, C>, Problems> {
        let Some((header, lines)) = header_and_rows(source) else {
            let name = &source.name;
            let message = format!("`{name}` holds no {what}");
            return Err(Problem::new(message).help(first_line).into());
        };
        let (kinds, names) = columns_of(&header, &expected(&header)?)?;
        Ok(Table { header, kinds, names, lines, first_line })
    }

    /// Where the first column of a kind stands.
    pub(super) fn find(&self, is_wanted: impl Fn(C) -> bool) -> Option<usize> {
        self.kinds.iter().position(|kind| is_wanted(*kind))
    }

    /// Notes a column that is needed and was not found.
    pub(super) fn require(
        &self,
        found: Option<usize>,
        what: &str,
        example: &str,
        problems: &mut Problems,
    ) -> usize {
        if found.is_none() {
            let message = format!("there is no column for {what}, expected {example}");
            problems.push(self.at_header(message, self.first_line));
        }
        found.unwrap_or_default()
    }

    /// A problem of the header as a whole.
    pub(super) fn at_header(&self, message: impl Into<String>, help: &str) -> Problem {
        Problem::new(message).at(self.header.whole()).help(help)
    }

    /// A problem of a column.
    pub(super) fn at_column(&self, index: usize, message: String, help: &str) -> Problem {
        let place = self.header.cell_place(index);
        Problem::new(message).at(place).help(help)
    }

    /// What `read` makes of each row; all problems of the rows are given at once.
    pub(super) fn rows<T>(
        &self,
        read: impl FnMut(&mut Row<'_, 'a>) -> Option<T>,
    ) -> Result<Vec<T>, Problems> {
        let mut problems = Problems::none();
        let rows = self.readable_rows(&mut problems, read);
        problems.or_ok(rows)
    }

    /// What `read` makes of each row that can be read; the problems of the others are noted.
    pub(super) fn readable_rows<T>(
        &self,
        problems: &mut Problems,
        mut read: impl FnMut(&mut Row<'_, 'a>) -> Option<T>,
    ) -> Vec<T> {
        let mut rows = Vec::with_capacity(self.lines.len());
        for line in &self.lines {
            let Some(cells) = line.cells_under(self.kinds.len(), problems) else {
                continue;
            };
            rows.extend(read(&mut Row { line: *line, names: &self.names, cells, problems }));
        }
        rows
    }

    /// Whether there is no row at all.
    pub(super) fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }
}

/// The cells of one row, while it is read.
pub(super) struct Row<'r, 'a> {
    pub(super) line: Line<'a>,
    names: &'r [String],
    cells: Vec<Cow<'a, str>>,
    problems: &'r mut Problems,
}

impl<'a> Row<'_, 'a> {
    /// What stands in a cell.
    pub(super) fn cell(&self, index: usize) -> &str {
        &self.cells[index]
    }

    /// A cell under the name of its column, and where its problems go.
    pub(super) fn named(&mut self, index: usize) -> (Cell<'a, '_>, &mut Problems) {
        let cell =
            Cell { line: &self.line, index, text: &self.cells[index], name: &self.names[index] };
        (cell, self.problems)
    }

    /// What a cell means; `absent` where the table has no such column.
    pub(super) fn parsed<T>(
        &mut self,
        index: Option<usize>,
        absent: Option<T>,
        parse: impl Fn(&str) -> Option<T>,
        expected: (&str, &str),
    ) -> Option<T> {
        let Some(index) = index else { return absent };
        let (cell, problems) = self.named(index);
        cell.read(parse, format_args!("`{}` is", cell.name), expected, problems)
    }

    /// The number of a cell, which must not be empty.
    pub(super) fn number(&mut self, index: usize, help: &str) -> Option<f64> {
        let (cell, problems) = self.named(index);
        if cell.text.is_empty() {
            let message = format!("`{}` is empty, expected a number", cell.name);
            problems.push_with(|| cell.problem(message, help));
            return None;
        }
        let expected = "write a plain number; its unit stands in the header";
        cell.number(expected, problems)
    }

    /// Notes what is wrong with a cell.
    pub(super) fn refuse(&mut self, index: usize, message: String, help: &str) {
        let (cell, problems) = self.named(index);
        problems.push_with(|| cell.problem(message, help));
    }
}
