//! What is wrong: in a line, and of a whole program.

/// First and last byte (exclusive) in the line.
pub(crate) type Span = (usize, usize);

/// What cannot be read or executed in a line, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// What was found and what was expected.
    pub message: String,
    /// What to do next.
    pub help: String,
    /// First byte in the line, and the byte behind the last one.
    pub span: (usize, usize),
}

impl Wrong {
    /// Something wrong at bytes of a line.
    pub(crate) fn new(span: Span, message: impl Into<String>, help: impl Into<String>) -> Wrong {
        Wrong { message: message.into(), help: help.into(), span }
    }
}

/// The same as a result.
pub(crate) fn refuse<T>(
    span: Span,
    message: impl Into<String>,
    help: impl Into<String>,
) -> Result<T, Wrong> {
    Err(Wrong::new(span, message, help))
}

/// Digits of one number; nobody writes more, and `f64` holds 17.
const MOST_DIGITS: usize = 40;

/// Refuses a number of more digits than anybody writes.
pub(crate) fn refuse_long_number(span: Span, digits: usize) -> Result<(), Wrong> {
    if digits <= MOST_DIGITS {
        return Ok(());
    }
    let message = format!("a number has {digits} digits, expected at most {MOST_DIGITS}");
    refuse(span, message, "write the number with as many digits as the control reads")
}

/// Why a program, or a move of it, cannot be followed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Refused {
    /// What was found and what was expected.
    pub message: String,
    /// What to do next.
    pub help: Option<String>,
    /// Where, if it stands in a line.
    pub place: Option<Excerpt>,
}

impl Refused {
    /// Something wrong without a place.
    pub fn new(message: impl Into<String>) -> Refused {
        Refused { message: message.into(), ..Refused::default() }
    }

    /// The same, with the next step.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Refused {
        Refused { help: Some(help.into()), ..self }
    }

    /// The same, at a place.
    #[must_use]
    pub(crate) fn at(self, place: Excerpt) -> Refused {
        Refused { place: Some(place), ..self }
    }
}

/// Part of a line of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// Number of the line, from 1.
    pub line: usize,
    /// The line; bytes that are no UTF-8 are shown as such.
    pub text: String,
    /// First byte of the text that is meant, and the byte behind the last one.
    pub span: (usize, usize),
}
