//! Lines of the files of a volumetric compensation: words between blanks, numbers, comments.

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

/// A line without the comment that `//` begins.
pub(super) fn without_comment(text: &str, span: Range<usize>) -> Range<usize> {
    let end = text[span.clone()].find("//");
    end.map_or(span.clone(), |at| span.start..span.start + at)
}
