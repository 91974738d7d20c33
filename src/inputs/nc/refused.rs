//! Why a move is not followed.

/// Why a move cannot be followed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// What was found and what was expected.
    pub message: String,
    /// What to do next.
    pub help: String,
}
