//! What a reader finds wrong at a place of a text, before the file's name is known.

use std::ops::Range;

/// What is wrong with a piece of the text.
#[derive(Clone, Debug)]
pub(super) struct Complaint {
    /// Bytes of the whole text.
    pub(super) span: Range<usize>,
    /// What was found and what was expected.
    pub(super) message: String,
    /// What to do next.
    pub(super) help: String,
}

impl Complaint {
    /// A complaint about the bytes `span`.
    pub(super) fn new(
        span: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Complaint {
            span,
            message: message.into(),
            help: help.into(),
        }
    }
}
