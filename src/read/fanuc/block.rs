//! The frame of a Fanuc file and its blocks, of data and of part programs: `N<number>[Q<0|1>]` and segments (grammar of B-63950EN/02
//! §3.3, B-63330EN/03 §3).
//!
//! ```text
//!   % title LF  block LF  block LF … LF % anything        N03620 Q1 A1P40 A2P140      N01411 Q1 L1M0.0
//!     └ skipped └──── read, one by one ┘ └ not read
//! ```
//! Only LF ends a block: CR beside it (CR LF, LF CR CR) means nothing, alone it ends none, nor does `;`,
//! which stands for LF in manuals. A file starts with `%` or LF, and what stands between `%` and the
//! next LF is skipped (all of it: B-63524EN/01 p. 649, file format; 16i/18i, taken to hold for the others). So a kit's
//! file starts with `%`: whether a control takes text before it for data or skips it is not said.
//! Behind the closing `%` nothing is read; a block there is one that never reaches the control.
//!
//! Blanks between words mean nothing; letters are capitals, as a control skips others when it reads
//! (B-63524EN/01 p. 649: `n10033` would be the number 10033 without its `N`). A block that is not in the
//! grammar gives one complaint, at the first character that does not fit.

use crate::read::lexer::{Complaint, Cursor, lines};
use crate::read::program::blocks::Cancelled::*;
use crate::read::program::blocks::Meaning::{self, *};
use crate::read::program::blocks::{Code, Vocabulary, refuse, without_comments};
use crate::read::refusals;
use part_program::Language;
use std::ops::Range;

/// What means nothing at the end of a block.
const BLANKS: [char; 3] = [' ', '\t', '\r'];

/// The same number of bytes, but in each run of line ends with an LF the CR stand first: LF CR CR and
/// CR LF then both end a line exactly once, which an editor shows. A CR alone stays where it is and ends none.
pub(super) fn uniform_line_ends(text: &str) -> String {
    let is_end = |byte: &u8| matches!(byte, b'\r' | b'\n');
    let mut bytes = text.as_bytes().to_vec();
    for run in bytes.chunk_by_mut(|a, b| is_end(a) && is_end(b)) {
        run.sort_unstable_by(|a, b| b.cmp(a));
    }
    String::from_utf8(bytes).unwrap_or_default()
}

/// The number of a block and what follows it, where the text begins with `N` and a number as data do, also
/// in letters that no control reads.
pub(super) fn number(block: &str) -> Option<(u32, &str)> {
    let rest = block.trim_start().strip_prefix(['N', 'n'])?.trim_start();
    let behind = rest.trim_start_matches(|c: char| c.is_ascii_digit());
    let digits = &rest[..rest.len() - behind.len()];
    let number = (!digits.is_empty()).then(|| digits.parse().unwrap_or(u32::MAX))?;
    Some((number, behind.trim_start()))
}

/// What stands between the two `%`; what is wrong with the frame is noted. The file of a kit starts
/// with `%`; before that of a read-out some text may stand.
pub(super) fn record(text: &str, of_kit: bool, complaints: &mut Vec<Complaint>) -> Range<usize> {
    let mut refuse = |span: Range<usize>, message: &str| {
        complaints.push(Complaint::new(span, refusals::frame(message)));
    };
    let (Some(opening), Some(closing)) = (text.find('%'), text.rfind('%')) else {
        refuse(0..0, "the file has no opening `%`");
        return 0..0;
    };
    let is_block = |span: &Range<usize>| number(&text[span.clone()]).is_some();
    let has_block = |span: Range<usize>| blocks(text, span).find(is_block);
    let title_end = text[opening..].find('\n').map_or(text.len(), |at| opening + at);
    let before = has_block(0..opening);
    if opening == closing {
        if before.is_some() {
            refuse(0..0, "the file has no opening `%`");
            return 0..opening;
        }
        let end = text.trim_end().len();
        refuse(end - 1..end, "the file has no closing `%`");
        return title_end..text.len();
    }
    if let Some(span) = before.or((of_kit && opening > 0).then_some(0..opening)) {
        refuse(
            span,
            "text stands before the opening `%`: a control may take it for data, and `%` for their end",
        );
    }
    if let Some(span) = has_block(closing + 1..text.len()) {
        refuse(span, "a block stands behind the closing `%`, where no control reads");
    }
    let title = opening + 1..title_end.min(closing);
    if text[title.clone()].trim_end_matches('\r').contains('\r') {
        refuse(
            title,
            "a carriage return alone ends the line of the opening `%`, which controls skip up to the line feed",
        );
    } else if is_block(&title) {
        refuse(title, "a block stands on the line of the opening `%`, which controls skip");
    }
    let last = text[opening..closing].rsplit('\n').next().unwrap_or("");
    if !last.trim_matches(BLANKS).is_empty() {
        refuse(
            closing..closing + 1,
            "the closing `%` stands inside a block (`END OF RECORD` on the control)",
        );
    }
    title_end..closing
}

/// The blocks of a record, blank ones left out.
pub(super) fn blocks(text: &str, record: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let mut at = record.start.min(record.end);
    let spans = text[at..record.end].split('\n').map(move |piece| {
        let start = at;
        at += piece.len() + 1;
        start..start + piece.trim_end_matches(BLANKS).len()
    });
    spans.filter(|span| !span.is_empty())
}

/// A block, cut into words.
pub(super) struct Block {
    /// The number after `N`.
    pub(super) number: u32,
    /// Where `N` and its number stand.
    pub(super) number_span: Range<usize>,
    /// The data identifier, if there is one: `Q0` for pitch data, `Q1` for a parameter.
    pub(super) is_point: Option<bool>,
    /// Its values, at least one.
    pub(super) segments: Vec<Segment>,
}

/// One value of a block with the axis it belongs to.
pub(super) struct Segment {
    /// Where a path of the control is named that is not the first: `L2`.
    pub(super) other_path: Option<Range<usize>>,
    /// Controlled axis from 1.
    pub(super) axis: Option<u32>,
    /// Where a spindle is named: `S1`.
    pub(super) spindle: Option<Range<usize>>,
    /// `P`, or `M` (metric), or `I` (inch).
    pub(super) letter: char,
    /// Sign, digits and decimal point as they stand.
    pub(super) value: Range<usize>,
}

/// Cuts a block into words.
pub(super) fn parse(text: &str, span: Range<usize>) -> Result<Block, Complaint> {
    if let Some((at, c)) = text[span.clone()].char_indices().find(|(_, c)| !c.is_ascii()) {
        let at = span.start + at;
        return Err(Complaint::new(at..at + c.len_utf8(), refusals::not_ascii(c)));
    }
    let mut words = Words(Cursor::new(text, span, &[' ', '\t']));
    words.0.peek_word();
    let Some((number, number_span)) = words.marked("N")? else {
        return Err(words.unexpected("a block that begins with `N`"));
    };
    let is_point = words.identifier()?;
    let mut segments = vec![words.segment()?];
    while words.0.peek_word().is_some() {
        segments.push(words.segment()?);
    }
    Ok(Block { number, number_span, is_point, segments })
}

struct Words<'a>(Cursor<'a>);

impl Words<'_> {
    fn digits(&mut self) -> Result<Range<usize>, Complaint> {
        let start = self.0.at;
        match self.0.digits() {
            "" => Err(self.unexpected("a digit")),
            _ => Ok(start..self.0.at),
        }
    }

    /// A letter and the number behind it, where one of these letters comes next.
    fn marked(&mut self, letters: &str) -> Result<Option<(u32, Range<usize>)>, Complaint> {
        if self.0.eat(letters).is_none() {
            return Ok(None);
        }
        let start = self.0.at - 1;
        let span = self.digits()?;
        let text = self.0.text(span.clone());
        match text.parse() {
            Ok(number) => Ok(Some((number, start..span.end))),
            Err(_) => Err(Complaint::new(span, refusals::large_number(text))),
        }
    }

    /// `Q0` or `Q1`, in one digit: whether a point follows.
    fn identifier(&mut self) -> Result<Option<bool>, Complaint> {
        if self.0.eat("Q").is_none() {
            return Ok(None);
        }
        let span = self.digits()?;
        match self.0.text(span.clone()) {
            "0" => Ok(Some(true)),
            "1" => Ok(Some(false)),
            other => Err(Complaint::new(span, refusals::other_identifier(other))),
        }
    }

    /// `L1` or `T1` before the axis is path 1, the only one a kit writes.
    fn segment(&mut self) -> Result<Segment, Complaint> {
        let other_path = self.marked("LT")?.filter(|(path, _)| *path != 1);
        let spindle = self.marked("S")?;
        let axis = self.marked("A")?;
        if let Some((0, span)) = axis {
            return Err(Complaint::new(span, refusals::axis_0()));
        }
        let Some(letter) = self.0.eat("PMI") else {
            return Err(self.unexpected("`P` and a value"));
        };
        let start = self.0.at;
        if self.0.peek() == Some('-') {
            self.0.at += 1;
        }
        self.digits()?;
        if self.0.peek() == Some('.') {
            self.0.at += 1;
            self.digits()?;
        }
        Ok(Segment {
            other_path: other_path.map(|(_, span)| span),
            axis: axis.map(|(axis, _)| axis),
            spindle: spindle.map(|(_, span)| span),
            letter,
            value: start..self.0.at,
        })
    }

    /// The complaint that the next character is not the one the grammar wants.
    fn unexpected(&self, expected: &str) -> Complaint {
        let Some(found) = self.0.peek() else {
            let span = self.0.at.saturating_sub(1)..self.0.at;
            return Complaint::new(span, refusals::block_ends(expected));
        };
        let wrong = match found {
            '\r' => refusals::carriage_return(),
            'a'..='z' => refusals::lower_case(),
            ';' => refusals::semicolon(),
            '(' => refusals::comment(),
            'O' | ':' => refusals::program_number(),
            'G' | 'R' => refusals::program_block(),
            '%' => refusals::percent_inside(),
            ',' => refusals::decimal_comma(),
            _ => refusals::not_expected(found.escape_debug(), expected),
        };
        Complaint::new(self.0.at..self.0.at + found.len_utf8(), wrong)
    }
}

// FANUC part programs of measuring runs: `%` frames the program, `O` numbers it, `(…)` is a comment.

/// Its language (B-64484EN, G-code system of a machining centre).
pub(in crate::read) const VOCABULARY: Vocabulary =
    Vocabulary { language: Language::Iso, words: &WORDS, blocks: blocks_of_program };

/// G61 (exact stop) does not change where the axes go, nor does G64 (cutting).
const WORDS: [(&str, Meaning); 5] = [
    ("G50", Cancel(Scaling)),
    ("G50.1", CancelOfAxes(Mirroring)),
    ("G61", Neutral),
    ("G69", Cancel(Rotation)),
    ("M30", End),
];

fn blocks_of_program(text: &str) -> Result<Vec<Code>, Complaint> {
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
    match frames {
        2 => Ok(blocks),
        _ => Err(refuse(text.len()..text.len(), "a program stands between two `%`")),
    }
}

fn is_number_of_program(code: &str) -> bool {
    let digits = code.strip_prefix('O').unwrap_or("");
    digits.len() == 4 && digits.bytes().all(|byte| byte.is_ascii_digit())
}
