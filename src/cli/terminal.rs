//! What a person is told at once.

use super::screen::spoken;
use std::io::Write;

/// Says it at once.
pub(super) fn say(text: &str) {
    tell(&spoken(text));
}

/// Words as they are.
pub(super) fn tell(text: &str) {
    // Nothing can be said about a standard error that is closed.
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}
