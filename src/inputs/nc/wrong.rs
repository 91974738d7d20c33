//! What is wrong in a line, with its place.

/// What cannot be read or executed in a line, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// What was found and what was expected.
    pub message: String,
    /// What to do next.
    pub help: String,
    /// First byte in the line.
    pub start: usize,
    /// Byte behind the last one.
    pub end: usize,
}

impl Wrong {
    /// Something wrong at bytes of a line.
    pub fn new(span: (usize, usize), message: impl Into<String>, help: impl Into<String>) -> Wrong {
        Wrong { message: message.into(), help: help.into(), start: span.0, end: span.1 }
    }
}
