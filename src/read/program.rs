//! Part programs of measuring runs back to what the axes do, and a walk along them.
//!
//! ```text
//!   bytes ─→ words ─→ deeds (stop, machine position, increment, dwell) ─→ walk: where the axes
//!   are, how they came there, whether it is what positions.csv and the job say
//! ```
//! Written from the languages' descriptions, not from the templates. A word that is not known here
//! is refused, whatever the control would make of it: a program that was read moves three axes,
//! stands still and stops, and does nothing else (no offset, no tool, no spindle).

mod blocks;
mod fanuc;
pub mod positions;
mod siemens;
mod steps;
pub mod walk;
mod words;

pub use self::steps::{Cancelled, Deed, OwnWords, Step};

use crate::control::controller::program::Language;
use crate::text::problem::{Problem, Problems};

/// Reads a program.
pub fn read(
    language: Language,
    words: &OwnWords<'_>,
    file: &str,
    bytes: &[u8],
) -> Result<Vec<Step>, Problems> {
    let text = ascii(file, bytes)?;
    let result = match language {
        Language::Siemens => siemens::read(text, words),
        Language::Fanuc => fanuc::read(text, words),
    };
    result.map_err(|complaint| complaint.at(file, text).into())
}

fn ascii<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a str, Problems> {
    match std::str::from_utf8(bytes) {
        Ok(text) if text.is_ascii() => Ok(text),
        _ => Err(
            Problem::new(format!("`{file}` holds a letter that is not ASCII"))
                .help("part programs are ASCII")
                .into(),
        ),
    }
}
