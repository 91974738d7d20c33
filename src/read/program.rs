//! Part programs of measuring runs back to what the axes do, and a walk along them.
//!
//! ```text
//!   bytes ─→ blocks ─→ actions (stop, machine position, increment, dwell) ─→ walk: where the axes
//!   are, how they came there, whether it is what positions.csv and the job say
//! ```
//! Written from the languages' descriptions, not from the templates; the words of a language stand in the
//! folder of its family. A word that is not known there is refused, whatever the control would make of it: a
//! program that was read moves three axes, stands still and stops, and does nothing else (no offset, no
//! tool, no spindle).

pub(super) mod blocks;
pub mod walk;

pub use self::blocks::{Action, Cancelled, OwnWords, Step};

use crate::control::controller::program::Language;
use crate::read::lexer::located;
use crate::read::{fanuc, linuxcnc, siemens};
use crate::text::{Problem, Problems, refuse_long_lines, refuse_many_lines};

/// Reads a program.
pub fn read(
    language: Language,
    words: &OwnWords<'_>,
    file: &str,
    bytes: &[u8],
) -> Result<Vec<Step>, Problems> {
    let text = std::str::from_utf8(bytes).ok();
    let Some(text) = text.filter(|text| text.is_ascii()) else {
        let message = format!("`{file}` holds a letter that is not ASCII");
        return Err(Problem::new(message).help("part programs are ASCII").into());
    };
    refuse_many_lines(file, text)?;
    refuse_long_lines(file, text)?;
    let vocabulary = match language {
        Language::Siemens => &siemens::VOCABULARY,
        Language::Fanuc => &fanuc::block::VOCABULARY,
        Language::Linuxcnc => &linuxcnc::VOCABULARY,
    };
    blocks::steps(text, vocabulary, words).map_err(|complaint| located(file, text, vec![complaint]))
}
