//! The text of a program, line by line.

use crate::wrong::Refused;

/// The bytes that some editors put before a text (UTF-8).
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A line of a program: its number from 1, and its bytes without line end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line<'a> {
    /// From 1.
    pub number: usize,
    /// Without line end.
    pub bytes: &'a [u8],
}

/// Where a line begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    /// Bytes before it.
    pub bytes: u64,
    /// Lines before it.
    pub lines: usize,
}

/// A program that is read line by line and can be taken up again at a place.
pub trait Text {
    /// The next line; `None` at the end.
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Refused>;
    /// Where the next line begins.
    fn mark(&self) -> Mark;
    /// Goes on at a mark.
    fn go_to(&mut self, mark: Mark) -> Result<(), Refused>;
}

/// The first line without the mark that some editors put before it.
pub(super) fn without_mark(line: Line<'_>) -> Line<'_> {
    let first = line.number == 1;
    let bytes = line.bytes.strip_prefix(BYTE_ORDER_MARK).filter(|_| first);
    Line { bytes: bytes.unwrap_or(line.bytes), ..line }
}
