//! FANUC part programs of measuring runs: `%` frames the program, `O` numbers it, `(…)` is a comment.

use crate::read::lexer::{Complaint, lines};
use crate::read::program::blocks::Meaning::{self, *};
use crate::read::program::blocks::{Cancelled::*, Code, Vocabulary, refuse, without_comments};
use part_program::Language;

/// Its language (B-64484EN, G-code system of a machining centre).
pub(in crate::read) const VOCABULARY: Vocabulary =
    Vocabulary { language: Language::Iso, words: &WORDS, blocks };

/// G61 (exact stop) does not change where the axes go, nor does G64 (cutting).
const WORDS: [(&str, Meaning); 5] = [
    ("G50", Cancel(Scaling)),
    ("G50.1", CancelOfAxes(Mirroring)),
    ("G61", Neutral),
    ("G69", Cancel(Rotation)),
    ("M30", End),
];

fn blocks(text: &str) -> Result<Vec<Code>, Complaint> {
    let mut blocks = Vec::new();
    let (mut frames, mut numbered) = (0, false);
    for line in lines(text) {
        let code = without_comments(text, &line)?;
        let code = code.trim();
        match (code, frames) {
            ("%", _) => frames += 1,
            ("", _) => {}
            // The control stores what stands before the number, or behind a second one, as another program.
            (_, 1) if !numbered && is_number_of_program(code) => numbered = true,
            (_, 1) if !numbered => {
                let message = "a block before the number of the program (`O` and four digits)";
                return Err(refuse(line, message));
            }
            (_, 1) => blocks.push((line.start, code.to_string())),
            _ => return Err(refuse(line, "a block outside the two `%` of a program")),
        }
    }
    let end = text.len()..text.len();
    match frames {
        2 => Ok(blocks),
        _ => Err(refuse(end, "a program stands between two `%`")),
    }
}

fn is_number_of_program(code: &str) -> bool {
    let digits = code.strip_prefix('O').unwrap_or("");
    digits.len() == 4 && digits.bytes().all(|byte| byte.is_ascii_digit())
}
