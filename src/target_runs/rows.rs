//! Rows and cells of a text table, with their places.

use crate::document::Source;
use crate::problem::Place;
use std::ops::Range;

/// A line with content.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    file: &'a str,
    number: usize,
    text: &'a str,
    delimiter: char,
}

/// The lines of a file that are neither empty nor comments. The first one decides whether cells
/// are separated by commas or semicolons.
pub(super) fn rows_of(source: &Source) -> Vec<Row<'_>> {
    let mut content = source
        .text
        .split('\n')
        .enumerate()
        .map(|(index, text)| (index + 1, text.trim_end_matches('\r')))
        .filter(|(_, text)| !text.trim_start().starts_with('#'))
        .filter(|(_, text)| text.contains(|c: char| !",;\"".contains(c) && !c.is_whitespace()))
        .peekable();
    let delimiter = match content.peek() {
        Some((_, header)) if header.contains(';') => ';',
        _ => ',',
    };
    content
        .map(|(number, text)| Row {
            file: &source.name,
            number,
            text,
            delimiter,
        })
        .collect()
}

impl<'a> Row<'a> {
    /// The cells, without blanks and quotation marks around them.
    pub(super) fn cells(&self) -> Vec<&'a str> {
        let bare = |cell: &'a str| cell.trim().trim_matches('"').trim();
        self.text.split(self.delimiter).map(bare).collect()
    }

    /// Number of the line, from 1.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// Whether a comma may be a decimal sign.
    pub(super) fn decimal_comma(&self) -> bool {
        self.delimiter == ';'
    }

    /// Whether the cells seem to be separated by tabs.
    pub(super) fn has_tabs(&self) -> bool {
        self.text.contains('\t') && !self.text.contains(self.delimiter)
    }

    /// The place of the whole line.
    pub(super) fn whole(&self) -> Place {
        self.place(0..self.text.len())
    }

    /// The place of a cell.
    pub(super) fn cell(&self, index: usize) -> Place {
        let before = self.text.split(self.delimiter).take(index);
        let start: usize = before.map(|cell| cell.len() + 1).sum();
        let cell = self
            .text
            .split(self.delimiter)
            .nth(index)
            .unwrap_or_default();
        let indent = cell.len() - cell.trim_start().len();
        let start = (start + indent).min(self.text.len());
        self.place(start..start + cell.trim().len().max(1))
    }

    fn place(&self, span: Range<usize>) -> Place {
        Place {
            line: self.number,
            ..Place::in_text(self.file, self.text, span.start, span.end)
        }
    }
}
