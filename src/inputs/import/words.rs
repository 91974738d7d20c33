//! Lines, words, fields and numbers of a foreign text, each with its place.

use crate::inputs::import::findings::ImportFinding;
use crate::text::delimited::plain_number;
use crate::text::document::{LARGEST_NUMBER, Source};
use crate::text::problem::{Place, Problem, Problems, shown};

/// The next step where a file cannot be what its program wrote.
pub(super) const AGAIN: &str = "the file is incomplete or was changed: save it again";

/// The next step where a value is not there.
pub(super) const MISSING: &str = "a missing value is never filled in: save the file again";

/// A piece of a text, a line or a word of it, which knows where it stands.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    source: &'a Source,
    start: usize,
    pub(super) text: &'a str,
}

/// All lines of a text, without their ends.
pub(super) fn lines(source: &Source) -> Vec<Piece<'_>> {
    let mut start = 0;
    let mut lines = Vec::new();
    for line in source.text.split('\n') {
        let text = line.trim_end_matches('\r');
        lines.push(Piece { source, start, text });
        start += line.len() + 1;
    }
    lines
}

impl<'a> Piece<'a> {
    /// Bytes `from..to`, without blanks around them.
    pub(super) fn part(&self, from: usize, to: usize) -> Piece<'a> {
        let text = &self.text[from..to];
        let indent = text.len() - text.trim_start().len();
        Piece { start: self.start + from + indent, text: text.trim(), ..*self }
    }

    /// What stands before a comment sign.
    pub(super) fn before(&self, sign: &str) -> Piece<'a> {
        let end = self.text.find(sign).unwrap_or(self.text.len());
        Piece { text: &self.text[..end], ..*self }
    }

    pub(super) fn is_blank(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// Whether it begins like a number.
    pub(super) fn begins_with_number(&self) -> bool {
        let text = self.text.trim_start();
        let digits = text.trim_start_matches(['+', '-', '.', ',']);
        digits.starts_with(|c: char| c.is_ascii_digit())
    }

    /// Key and value of `key : value`; the key in small letters and digits.
    pub(super) fn key_value(&self) -> Option<(String, Piece<'a>)> {
        let colon = self.text.find(':')?;
        let key = key_of(&self.text[..colon]);
        Some((key, self.part(colon + 1, self.text.len())))
    }

    /// Words between separators; adjacent separators are one.
    pub(super) fn words(&self, is_separator: fn(char) -> bool) -> Vec<Piece<'a>> {
        let (mut words, mut start) = (Vec::new(), 0);
        for part in self.text.split_inclusive(is_separator) {
            let word = part.trim_end_matches(is_separator);
            if !word.is_empty() {
                words.push(self.part(start, start + word.len()));
            }
            start += part.len();
        }
        words
    }

    /// The words of a row of a table: as many as its heading has.
    pub(super) fn row(
        &self,
        columns: usize,
        is_separator: fn(char) -> bool,
        problems: &mut Problems,
    ) -> Option<Vec<Piece<'a>>> {
        let words = self.words(is_separator);
        if words.len() != columns {
            let message = format!("expected {columns} words in this row, found {}", words.len());
            problems.push_with(|| self.problem(message, MISSING));
            return None;
        }
        Some(words)
    }

    pub(super) fn place(&self) -> Place {
        let word = self.part(0, self.text.len());
        let end = word.start + word.text.len().max(1);
        self.source.place(&(word.start..end))
    }

    /// A problem that stands here.
    pub(super) fn problem(&self, message: impl Into<String>, help: impl Into<String>) -> Problem {
        Problem::new(message).at(self.place()).help(help)
    }

    /// A finite number with a decimal point; otherwise the problem is noted.
    pub(super) fn number(&self, what: &str, problems: &mut Problems) -> Option<f64> {
        let number = plain_number(self.text).filter(|number| number.abs() <= LARGEST_NUMBER);
        if number.is_none() {
            let help = if self.text.contains(',') {
                "a decimal comma cannot be read here: save the file again with a decimal point"
            } else {
                MISSING
            };
            problems.push_with(|| self.unexpected(what, "a finite number", help));
        }
        number
    }

    /// A whole number from 1.
    pub(super) fn count(&self, what: &str, problems: &mut Problems) -> Option<usize> {
        let count = self.text.parse().ok().filter(|count| *count >= 1_usize);
        if count.is_none() {
            problems.push_with(|| self.unexpected(what, "a whole number from 1", AGAIN));
        }
        count
    }

    /// What the text means; otherwise the problem is noted.
    pub(super) fn meaning<T>(
        &self,
        what: &str,
        expected: &str,
        read: impl Fn(&str) -> Option<T>,
        problems: &mut Problems,
    ) -> Option<T> {
        let meaning = read(self.text);
        if meaning.is_none() {
            problems.push(self.unexpected(what, expected, AGAIN));
        }
        meaning
    }

    /// The problem that something else was expected here.
    pub(super) fn unexpected(&self, what: &str, expected: &str, help: &str) -> Problem {
        let found = shown(self.text);
        self.problem(format!("{what} is `{found}`, expected {expected}"), help)
    }
}

/// A row of a table of numbers.
pub(super) struct Row<'a> {
    pub(super) line: Piece<'a>,
    pub(super) numbers: Vec<f64>,
}

/// Lines as rows of so many numbers each.
pub(super) fn rows<'l, 'a: 'l>(
    lines: impl Iterator<Item = &'l Piece<'a>>,
    columns: usize,
    is_separator: fn(char) -> bool,
) -> Result<Vec<Row<'a>>, Problems> {
    let mut problems = Problems::none();
    let mut rows = Vec::new();
    for line in lines {
        let words = line.row(columns, is_separator, &mut problems).unwrap_or_default();
        let numbers = words.iter().filter_map(|word| word.number("a value", &mut problems));
        rows.push(Row { line: *line, numbers: numbers.collect() });
    }
    problems.or_ok(rows)
}

fn key_of(label: &str) -> String {
    let letters = label.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// Values with their keys, in the order of the file.
pub(super) struct Fields<'a>(pub(super) Vec<(String, Piece<'a>)>);

impl<'a> Fields<'a> {
    /// Those of lines `key : value`.
    pub(super) fn of(lines: &[Piece<'a>]) -> Fields<'a> {
        Fields(lines.iter().filter_map(Piece::key_value).collect())
    }

    /// The first value of a key, which is named as the file writes it.
    pub(super) fn value(&self, label: &str) -> Option<Piece<'a>> {
        self.values(label).next()
    }

    /// All values of a key.
    pub(super) fn values(&self, label: &str) -> impl Iterator<Item = Piece<'a>> {
        let key = key_of(label);
        let found = self.0.iter().filter(move |(found, _)| *found == key);
        found.map(|(_, value)| *value)
    }

    /// What the file says of some keys.
    pub(super) fn said(&self, labels: &[&str]) -> impl Iterator<Item = ImportFinding> {
        labels.iter().filter_map(|label| {
            let value = self.value(label).filter(|value| !value.text.is_empty())?;
            let entry = format!("{label}: {}", shown(value.text));
            Some(ImportFinding::Says { entry })
        })
    }
}
