//! Lines of the files of a volumetric compensation: words between blanks, numbers, comments.

use crate::read::lexer::Cursor;
use std::ops::Range;

/// Positions and values lie below it, in mm or rad.
const LARGEST: f64 = 1e6;

/// A decimal number.
pub(super) fn number(word: &str) -> Option<f64> {
    let plain = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    let number = word.chars().all(plain).then(|| word.parse::<f64>().ok());
    let number = number.flatten().filter(|number| number.abs() < LARGEST)?;
    Some(number + 0.0) // −0 is 0
}

/// The words of a piece of a line with their places.
pub(super) fn words(text: &str, span: Range<usize>) -> Vec<(&str, Range<usize>)> {
    let mut cursor = Cursor::new(text, span, &[' ', '\t']);
    let mut words = Vec::new();
    while cursor.peek_word().is_some() {
        let start = cursor.at;
        let word = cursor.take(|c| c != ' ' && c != '\t');
        words.push((word, start..start + word.len()));
    }
    words
}

/// A line without the comment that `//` begins.
pub(super) fn without_comment(text: &str, span: Range<usize>) -> Range<usize> {
    let end = text[span.clone()].find("//");
    end.map_or(span.clone(), |at| span.start..span.start + at)
}
