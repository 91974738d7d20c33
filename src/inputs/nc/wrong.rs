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

/// Digits of one number; nobody writes more, and `f64` holds 17.
const MOST_DIGITS: usize = 40;

/// Refuses a number of more digits than anybody writes.
pub(super) fn refuse_long_number(span: (usize, usize), digits: usize) -> Result<(), Wrong> {
    if digits <= MOST_DIGITS {
        return Ok(());
    }
    let message = format!("a number has {digits} digits, expected at most {MOST_DIGITS}");
    Err(Wrong::new(span, message, "write the number with as many digits as the control reads"))
}
