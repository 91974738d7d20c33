//! Lines, words and numbers of a foreign text, each with its place.

use crate::text::delimited::plain_number;
use crate::text::document::{LARGEST_NUMBER, Source};
use crate::text::problem::{Place, Problem, Problems, shown};

/// A line without its line end.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    source: &'a Source,
    start: usize,
    pub(super) text: &'a str,
}

/// A word or a cell of a line.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    source: &'a Source,
    start: usize,
    pub(super) text: &'a str,
}

/// All lines of a text.
pub(super) fn lines(source: &Source) -> Vec<Line<'_>> {
    let mut start = 0;
    let mut lines = Vec::new();
    for text in source.text.split('\n') {
        lines.push(Line {
            source,
            start,
            text: text.trim_end_matches('\r'),
        });
        start += text.len() + 1;
    }
    lines
}

impl<'a> Line<'a> {
    /// The whole line.
    pub(super) fn place(&self) -> Place {
        self.part(0, self.text.len()).place()
    }

    /// Bytes `from..to`, without blanks around them.
    pub(super) fn part(&self, from: usize, to: usize) -> Word<'a> {
        let text = &self.text[from..to];
        let indent = text.len() - text.trim_start().len();
        Word {
            source: self.source,
            start: self.start + from + indent,
            text: text.trim(),
        }
    }

    /// What stands before a comment sign.
    pub(super) fn before(&self, sign: &str) -> Line<'a> {
        let end = self.text.find(sign).unwrap_or(self.text.len());
        Line {
            text: &self.text[..end],
            ..*self
        }
    }

    pub(super) fn is_blank(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// Key and value of a line `key : value`; the key in small letters, without blanks.
    pub(super) fn key_value(&self) -> Option<(String, Word<'a>)> {
        let colon = self.text.find(':')?;
        let key = self.text[..colon].to_lowercase();
        let key = key.chars().filter(|c| c.is_alphanumeric()).collect();
        Some((key, self.part(colon + 1, self.text.len())))
    }

    /// Words between separators; adjacent separators count as one.
    pub(super) fn words(&self, is_separator: impl Fn(char) -> bool) -> Vec<Word<'a>> {
        let mut words = Vec::new();
        let mut start = None;
        for (at, c) in self.text.char_indices().chain([(self.text.len(), ' ')]) {
            let separates = at == self.text.len() || is_separator(c);
            match (start, separates) {
                (None, false) => start = Some(at),
                (Some(from), true) => {
                    words.push(self.part(from, at));
                    start = None;
                }
                _ => {}
            }
        }
        words
    }
}

impl<'a> Word<'a> {
    /// The word as a line of its own, to be split further.
    pub(super) fn line(&self) -> Line<'a> {
        Line {
            source: self.source,
            start: self.start,
            text: self.text,
        }
    }

    pub(super) fn place(&self) -> Place {
        self.source
            .place(&(self.start..self.start + self.text.len().max(1)))
    }

    /// A finite number with a decimal point; otherwise the problem is noted.
    pub(super) fn number(&self, what: &str, problems: &mut Problems) -> Option<f64> {
        let number = plain_number(self.text).filter(|number| number.abs() <= LARGEST_NUMBER);
        if number.is_none() {
            let help = if self.text.contains(',') {
                "a decimal comma cannot be read here: save the file again with a decimal point"
            } else {
                "a missing value is never filled in: save the file again"
            };
            problems.push_with(|| self.no_number(what, help));
        }
        number
    }

    /// A whole number from 1.
    pub(super) fn count(&self, what: &str, problems: &mut Problems) -> Option<usize> {
        let count = self.text.parse().ok().filter(|count| *count >= 1_usize);
        if count.is_none() {
            problems.push_with(|| {
                Problem::new(format!(
                    "{what} is `{}`, expected a whole number from 1",
                    shown(self.text)
                ))
                .at(self.place())
                .help("the file is damaged: save it again")
            });
        }
        count
    }

    fn no_number(&self, what: &str, help: &str) -> Problem {
        let found = if self.text.is_empty() {
            "empty".to_string()
        } else {
            format!("`{}`", shown(self.text))
        };
        Problem::new(format!("{what} is {found}, expected a finite number"))
            .at(self.place())
            .help(help)
    }
}

/// Whether a text begins like a number.
pub(super) fn looks_like_number(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '.', ',']);
    digits.starts_with(|c: char| c.is_ascii_digit())
}
