//! LinuxCNC part programs of measuring runs: `(…)` is a comment, `(MSG,…)` a text for the screen.

use crate::control::controller::ControlUnit;
use crate::read::lexer::{Complaint, lines};
use crate::read::program::blocks::Meaning::{self, *};
use crate::read::program::blocks::{Cancelled::*, Code, Vocabulary, refuse, without_comments};
use part_program::Language;

/// Its language (LinuxCNC documentation, G-Code; RS274NGC).
pub(in crate::read) const VOCABULARY: Vocabulary =
    Vocabulary { language: Language::Iso, words: &WORDS, blocks };

/// G17 and G61.1 (exact stop) do not change where the axes go.
const WORDS: [(&str, Meaning); 17] = [
    ("G0", Rapid),
    ("G1", Feed),
    ("G4", Dwell),
    ("G17", Neutral),
    ("G61.1", Neutral),
    ("G64", Neutral),
    ("G94", FeedPerMinute),
    ("G20", Unit(ControlUnit::Inch)),
    ("G21", Unit(ControlUnit::Millimetre)),
    ("G40", Cancel(ToolRadius)),
    ("G49", Cancel(ToolLength)),
    ("G80", Cancel(Cycle)),
    ("G53", Machine),
    ("G90", Absolute),
    ("G91", Incremental),
    ("M0", Stop),
    ("M2", End),
];

/// A comment that begins with one of these words does something.
const ACTIVE: [&str; 6] = ["LOG", "PROBE", "DEBUG", "PRINT", "PY", "ABORT"];

fn blocks(text: &str) -> Result<Vec<Code>, Complaint> {
    let mut blocks = Vec::new();
    for line in lines(text) {
        let written = &text[line.clone()];
        let Some(code) = without_comments(written) else {
            return Err(refuse(line, "the brackets of a comment do not match"));
        };
        if comments(written).any(is_active) {
            return Err(refuse(line, "a comment that LinuxCNC executes"));
        }
        let code = code.trim();
        if !code.is_empty() {
            blocks.push((line.start, code.to_string()));
        }
    }
    Ok(blocks)
}

/// What stands behind each opening bracket.
fn comments(line: &str) -> impl Iterator<Item = &str> {
    line.split('(').skip(1)
}

fn is_active(comment: &str) -> bool {
    let word = comment.trim_start().to_ascii_uppercase();
    ACTIVE.iter().any(|active| word.starts_with(active))
}
