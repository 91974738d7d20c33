//! One block of a Fanuc file: `N<number>[Q<0|1>]` and its segments (grammar of B-63950EN/02
//! §3.3, B-63330EN/03 §3).
//!
//! ```text
//!   N03620 Q1 A1P40 A2P140        N10033 Q0 P-2        N01411 Q1 L1M0.0
//! ```
//! Blanks between words mean nothing; letters are capitals, as a control skips others when it reads
//! (B-63524EN/01 p. 649: `n10033` would be the number 10033 without its `N`). A block that is not in the
//! grammar gives one problem, at the first character that does not fit.

use super::record::{Source, Span};
use crate::text::problem::Problem;

/// `Q` of a block: what its number means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Identifier {
    /// `Q0`: pitch data.
    Point,
    /// `Q1`: parameter.
    Parameter,
}

/// A block, cut into words.
pub(super) struct Block {
    /// The number after `N`.
    pub(super) number: u32,
    /// Where `N` and its number stand.
    pub(super) number_span: Span,
    /// The data identifier, if there is one.
    pub(super) identifier: Option<Identifier>,
    /// Its values, at least one.
    pub(super) segments: Vec<Segment>,
}

/// One value of a block with the axis it belongs to.
pub(super) struct Segment {
    /// Where a path of the control is named that is not the first: `L2`.
    pub(super) other_path: Option<Span>,
    /// Controlled axis from 1.
    pub(super) axis: Option<u32>,
    /// Where a spindle is named: `S1`.
    pub(super) spindle: Option<Span>,
    /// `P`, or `M` (metric), or `I` (inch).
    pub(super) letter: char,
    /// Sign, digits and decimal point as they stand.
    pub(super) value: Span,
}

/// Cuts a block into words.
pub(super) fn parse(source: &Source, span: &Span) -> Result<Block, Problem> {
    let mut cursor = Cursor {
        source,
        at: span.start,
        end: span.end,
    };
    cursor.refuse_other_kinds()?;
    let start = cursor.at;
    if cursor.letter("N").is_none() {
        return Err(cursor.unexpected("a block that begins with `N`"));
    }
    let number = cursor.unsigned()?;
    let number_span = start..cursor.at;
    let identifier = cursor.identifier()?;
    let mut segments = vec![cursor.segment()?];
    while cursor.peek_word().is_some() {
        segments.push(cursor.segment()?);
    }
    Ok(Block {
        number,
        number_span,
        identifier,
        segments,
    })
}

struct Cursor<'a> {
    source: &'a Source,
    at: usize,
    end: usize,
}

impl Cursor<'_> {
    fn rest(&self) -> &str {
        self.source.slice(&(self.at..self.end))
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// The next character that is no blank.
    fn peek_word(&mut self) -> Option<char> {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start_matches([' ', '\t']).len();
        self.peek()
    }

    fn letter(&mut self, allowed: &str) -> Option<char> {
        let letter = self.peek_word()?;
        allowed.contains(letter).then(|| {
            self.at += 1;
            letter
        })
    }

    fn digits(&mut self) -> Result<Span, Problem> {
        let count = self.rest().bytes().take_while(u8::is_ascii_digit).count();
        if count == 0 {
            return Err(self.unexpected("a digit"));
        }
        self.at += count;
        Ok(self.at - count..self.at)
    }

    fn unsigned(&mut self) -> Result<u32, Problem> {
        let span = self.digits()?;
        let text = self.source.slice(&span);
        text.parse().map_err(|_| {
            let message = format!("the number `{text}` is too large");
            self.source.problem(&span, message)
        })
    }

    fn identifier(&mut self) -> Result<Option<Identifier>, Problem> {
        if self.letter("Q").is_none() {
            return Ok(None);
        }
        let span = self.digits()?;
        match self.source.slice(&span) {
            "0" => Ok(Some(Identifier::Point)),
            "1" => Ok(Some(Identifier::Parameter)),
            other => {
                let message = format!("the data identifier `Q{other}` is neither `Q0` nor `Q1`");
                let problem = self.source.problem(&span, message);
                Err(problem.help("`Q0` marks pitch data, `Q1` a parameter"))
            }
        }
    }

    fn segment(&mut self) -> Result<Segment, Problem> {
        let other_path = self.path()?;
        let spindle = self.spindle()?;
        let axis = self.axis()?;
        let Some(letter) = self.letter("PMI") else {
            return Err(self.unexpected("`P` and a value"));
        };
        let start = self.at;
        if self.peek() == Some('-') {
            self.at += 1;
        }
        self.digits()?;
        if self.peek() == Some('.') {
            self.at += 1;
            self.digits()?;
        }
        Ok(Segment {
            other_path,
            axis,
            spindle,
            letter,
            value: start..self.at,
        })
    }

    /// `L1` or `T1` before the axis is path 1, the only one a kit writes.
    fn path(&mut self) -> Result<Option<Span>, Problem> {
        if self.letter("LT").is_none() {
            return Ok(None);
        }
        let start = self.at - 1;
        let path = self.unsigned()?;
        Ok((path != 1).then_some(start..self.at))
    }

    fn spindle(&mut self) -> Result<Option<Span>, Problem> {
        if self.letter("S").is_none() {
            return Ok(None);
        }
        let start = self.at - 1;
        self.unsigned()?;
        Ok(Some(start..self.at))
    }

    fn axis(&mut self) -> Result<Option<u32>, Problem> {
        if self.letter("A").is_none() {
            return Ok(None);
        }
        let start = self.at - 1;
        match self.unsigned()? {
            0 => {
                let span = start..self.at;
                Err(self.source.problem(&span, "axis numbers count from 1"))
            }
            number => Ok(Some(number)),
        }
    }

    /// Text that other kinds of files hold: non-ASCII, comments, program numbers, G codes.
    fn refuse_other_kinds(&mut self) -> Result<(), Problem> {
        if let Some((at, c)) = self.rest().char_indices().find(|(_, c)| !c.is_ascii()) {
            let at = self.at + at;
            let message = format!("`{c}` is not an ASCII character");
            return Err(self.source.problem(&(at..at + c.len_utf8()), message).help(
                "files of this control are plain ASCII; the file is damaged or of another kind",
            ));
        }
        match self.peek_word() {
            Some(c) if "OG%(:".contains(c) => Err(self.unexpected("a block that begins with `N`")),
            _ => Ok(()),
        }
    }

    /// The problem that the next character is not the one the grammar wants.
    fn unexpected(&self, expected: &str) -> Problem {
        let Some(found) = self.peek() else {
            let span = self.end.saturating_sub(1)..self.end;
            let message = format!("the block ends where {expected} was expected");
            return self.source.problem(&span, message).help(GRAMMAR_HELP);
        };
        let (message, help) = match found {
            '\r' => (
                "a carriage return alone, which ends no block on a control",
                END_OF_BLOCK_HELP,
            ),
            'a'..='z' => (
                "a letter in lower case, which a control skips",
                "write it in capitals",
            ),
            ';' => ("a `;`; in a file `;` ends no block", END_OF_BLOCK_HELP),
            '(' => (
                "a comment, which this control's data files cannot hold",
                COMMENT_HELP,
            ),
            'O' | ':' => ("a program number in a data file", PROGRAM_HELP),
            'G' | 'R' => ("a block of a G10 program", PROGRAM_HELP),
            '%' => (
                "a `%` inside the record; a control reads no further",
                RECORD_HELP,
            ),
            ',' => ("a decimal comma", "the decimal sign is a point"),
            _ => ("", GRAMMAR_HELP),
        };
        let message = if message.is_empty() {
            let found = found.escape_debug();
            format!("found `{found}` where {expected} was expected")
        } else {
            format!("found {message}")
        };
        let span = self.at..self.at + found.len_utf8();
        self.source.problem(&span, message).help(help)
    }
}

const END_OF_BLOCK_HELP: &str = "a line feed (0A hexadecimal) ends a block; transfer the file again, without a change of its line ends";
const GRAMMAR_HELP: &str =
    "a block is `N<number>`, `Q0` or `Q1`, then `A<axis>P<value>` or `P<value>`";
const COMMENT_HELP: &str = "remove the text in parentheses";
const RECORD_HELP: &str = "keep one record in a file, with one `%` before and one after it";
pub(super) const PROGRAM_HELP: &str =
    "this reader reads files of `N…P…` blocks only; a G10 program is loaded by running it";
