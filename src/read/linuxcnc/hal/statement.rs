//! The lines of a HAL file, cut into words.

use crate::read::lexer::{Complaint, lines};
use std::ops::Range;

/// A word of a line.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    pub(super) text: &'a str,
    start: usize,
}

impl Word<'_> {
    /// Its place.
    pub(super) fn span(&self) -> Range<usize> {
        self.start..self.start + self.text.len()
    }

    /// What is wrong with it.
    pub(super) fn wrong(&self, message: impl Into<String>, help: &str) -> Complaint {
        Complaint::new(self.span(), message, help)
    }
}

/// The words of each line that is neither blank nor a comment: at least one.
pub(super) fn statements(text: &str) -> impl Iterator<Item = Vec<Word<'_>>> {
    let words = |line: Range<usize>| {
        let start = line.start;
        let pieces = text[line].split_inclusive([' ', '\t']);
        let words = pieces.scan(start, |at, piece| {
            let start = *at;
            *at += piece.len();
            let text = piece.trim_end_matches([' ', '\t']);
            Some(Word { text, start })
        });
        words.filter(|word| !word.text.is_empty()).collect()
    };
    let is_statement =
        |words: &Vec<Word<'_>>| words.first().is_some_and(|first| !first.text.starts_with('#'));
    lines(text).map(words).filter(is_statement)
}
