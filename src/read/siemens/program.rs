//! SINUMERIK part programs of measuring runs: `;` begins a comment, `MSG("…")` is a text for the screen.

use crate::control::controller::ControlUnit;
use crate::read::lexer::{Complaint, lines};
use crate::read::program::blocks::Meaning::{self, *};
use crate::read::program::blocks::{Cancelled::*, Code, Vocabulary};
use part_program::Language;

/// Its language (Programming Manual).
pub(in crate::read) const VOCABULARY: Vocabulary =
    Vocabulary { language: Language::Siemens, words: &WORDS, blocks };

/// G17 and G60 (exact stop) do not change where the axes go.
const WORDS: [(&str, Meaning); 21] = [
    ("G0", Rapid),
    ("G1", Feed),
    ("G4", Dwell),
    ("G17", Neutral),
    ("G60", Neutral),
    ("G94", FeedPerMinute),
    ("G40", Cancel(ToolRadius)),
    ("D0", Cancel(ToolLength)),
    ("G500", Cancel(Offset)),
    ("TRANS", Cancel(Shift)),
    ("ROT", Cancel(Rotation)),
    ("SCALE", Cancel(Scaling)),
    ("MIRROR", Cancel(Mirroring)),
    ("TRAFOOF", Cancel(Transformation)),
    ("G90", Absolute),
    ("G91", Incremental),
    ("G700", Unit(ControlUnit::Inch)),
    ("G710", Unit(ControlUnit::Millimetre)),
    ("SUPA", Machine),
    ("M0", Stop),
    ("M30", End),
];

fn blocks(text: &str) -> Result<Vec<Code>, Complaint> {
    let code = |line: std::ops::Range<usize>| {
        let whole = text[line.clone()].trim_end();
        let code = whole.split(';').next().unwrap_or("");
        (!is_message(whole)).then(|| (line.start, code.to_string()))
    };
    Ok(lines(text).filter_map(code).collect())
}

/// `MSG("text")` shows a text, `MSG()` takes it away; nothing moves.
fn is_message(line: &str) -> bool {
    let inside = line.strip_prefix("MSG(");
    let Some(inside) = inside.and_then(|rest| rest.strip_suffix(')')) else {
        return false;
    };
    let text = inside.strip_prefix('"');
    let text = text.and_then(|rest| rest.strip_suffix('"'));
    inside.is_empty() || text.is_some_and(|text| !text.contains('"'))
}
