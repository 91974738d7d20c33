//! The text of a control's file cut into lines and words, and what is wrong at a place of it: shared by
//! the readers of all families.

use crate::text::{LineIndex, Problem, Problems, plain_number};
use std::ops::Range;

/// What a reader finds wrong with a piece of the text, before the file's name is known.
#[derive(Clone, Debug)]
pub(super) struct Complaint {
    /// Bytes of the whole text.
    pub(super) span: Range<usize>,
    /// What was found, what was expected, and what to do next.
    pub(super) problem: Box<Problem>,
}

impl Complaint {
    /// A complaint about the bytes `span`.
    pub(super) fn new(span: Range<usize>, problem: Problem) -> Self {
        Complaint { span, problem: Box::new(problem) }
    }
}

/// How many complaints of one file are looked for: nobody reads further, and a binary file has millions.
pub(super) const MOST_COMPLAINTS: usize = 200;

/// What is wrong with the lines of a file, or what stands in them, taken one by one.
pub(super) fn complaints<T>(
    items: impl Iterator<Item = T>,
    mut take: impl FnMut(T) -> Result<(), Complaint>,
) -> Vec<Complaint> {
    items.filter_map(|item| take(item).err()).take(MOST_COMPLAINTS).collect()
}

/// Complaints about a text with their places, in its order.
pub(super) fn located(file: &str, text: &str, mut complaints: Vec<Complaint>) -> Problems {
    complaints.sort_by_key(|complaint| complaint.span.start);
    let index = LineIndex::default();
    let mut problems = Problems::none();
    for complaint in complaints {
        problems.push_with(|| {
            let place = index.place(file, text, complaint.span.start, complaint.span.end);
            complaint.problem.at(place)
        });
    }
    problems
}

/// The lines as bytes of the text, without LF and the CRs before it.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut at = 0;
    text.split('\n').map(move |line| {
        let start = at;
        at += line.len() + 1;
        start..start + line.trim_end_matches('\r').len()
    })
}

/// Words of a line with their places.
pub(super) type Words<'a> = Vec<(&'a str, Range<usize>)>;

/// The words of a piece of a line, between blanks.
pub(super) fn words(text: &str, span: Range<usize>) -> Words<'_> {
    let mut at = span.start;
    let words = text[span].split([' ', '\t']).map(|word| {
        let start = at;
        at += word.len() + 1;
        (word, start..start + word.len())
    });
    words.filter(|(word, _)| !word.is_empty()).collect()
}

/// A decimal number of a file of lengths or angles; in any of their units these lie below a million.
pub(super) fn number(word: &str) -> Option<f64> {
    plain_number(word).filter(|number| number.abs() < 1e6)
}

/// A place in a piece of a text, which is ASCII there: bytes are characters.
#[derive(Clone)]
pub(super) struct Cursor<'a> {
    source: &'a str,
    /// The next byte.
    pub(super) at: usize,
    end: usize,
    blanks: &'static [char],
}

impl<'a> Cursor<'a> {
    /// The beginning of `span`, where `blanks` separate words and mean nothing else.
    pub(super) fn new(source: &'a str, span: Range<usize>, blanks: &'static [char]) -> Self {
        Cursor { source, at: span.start, end: span.end, blanks }
    }

    /// The text of some bytes.
    pub(super) fn text(&self, span: Range<usize>) -> &'a str {
        &self.source[span]
    }

    /// The next character.
    pub(super) fn peek(&self) -> Option<char> {
        self.source[self.at..self.end].chars().next()
    }

    /// The next character that is no blank.
    pub(super) fn peek_word(&mut self) -> Option<char> {
        self.take(|c| self.blanks.contains(&c));
        self.peek()
    }

    /// Takes a character of `wanted` if one comes next, after blanks.
    pub(super) fn eat(&mut self, wanted: &str) -> Option<char> {
        let found = self.peek_word().filter(|c| wanted.contains(*c))?;
        self.at += found.len_utf8();
        Some(found)
    }

    /// Takes the characters that belong to a word, here and without blanks before.
    pub(super) fn take(&mut self, belongs: impl Fn(char) -> bool) -> &'a str {
        let rest = &self.source[self.at..self.end];
        let length = rest.find(|c| !belongs(c)).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    /// Takes digits.
    pub(super) fn digits(&mut self) -> &'a str {
        self.take(|c| c.is_ascii_digit())
    }

    /// From here to the end, without blanks there.
    pub(super) fn rest(&self) -> Range<usize> {
        let text = self.source[self.at..self.end].trim_end_matches(self.blanks);
        self.at..self.at + text.len()
    }

    /// The next character.
    pub(super) fn here(&self) -> Range<usize> {
        self.at..self.at + 1
    }
}
