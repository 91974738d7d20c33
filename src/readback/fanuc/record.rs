//! The frame of a Fanuc file: text before the first `%`, the record, anything after the last `%`.
//!
//! ```text
//!   junk % title EOB  block EOB  block EOB … % anything
//!        └ opening    └──── spans given to the block reader ┘ └ closing
//! ```
//! EOB is any mixture of LF and CR, or `;` (B-63950EN/02 §3.3, B-63330EN/03 §3; a 30i-class
//! control itself writes LF CR CR).

use crate::problem::{LineIndex, Problem, Problems};
use std::ops::Range;

/// Bytes `start..end` of the source.
pub(super) type Span = Range<usize>;

const FRAME_HELP: &str = "a record begins with `%` and ends with `%`, each on a line of its own; \
    the file may have been cut when it was copied; if it is no file of the control, take it out of the \
    directory";

/// A file with its line ends made uniform, so that places name the line an editor shows.
pub(super) struct Source {
    file: String,
    text: String,
    lines: LineIndex,
}

impl Source {
    /// The source of a file.
    pub(super) fn new(file: &str, text: &str) -> Source {
        Source {
            file: file.to_string(),
            text: uniform_line_ends(text),
            lines: LineIndex::default(),
        }
    }

    /// The whole text, its line ends made uniform.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// The text of a span.
    pub(super) fn slice(&self, span: &Span) -> &str {
        &self.text[span.clone()]
    }

    /// A problem at a span.
    pub(super) fn problem(&self, span: &Span, message: impl Into<String>) -> Problem {
        let place = self
            .lines
            .place(&self.file, &self.text, span.start, span.end);
        Problem::new(message).at(place)
    }

    /// What stands between the two `%`; what is wrong with the frame is noted.
    pub(super) fn record(&self, problems: &mut Problems) -> Span {
        let (Some(opening), Some(closing)) = (self.text.find('%'), self.text.rfind('%')) else {
            problems.push(self.frame_problem(0..0, "the file has no opening `%`"));
            return 0..0;
        };
        if opening < closing {
            self.note_frame(opening, closing, problems);
            return self.after_title(opening)..closing;
        }
        if self.blocks(0..opening).any(|span| self.is_block(&span)) {
            problems.push(self.frame_problem(0..0, "the file has no opening `%`"));
            return 0..opening;
        }
        let end = self.text.trim_end().len();
        problems.push(self.frame_problem(end - 1..end, "the file has no closing `%`"));
        self.after_title(opening)..self.text.len()
    }

    fn frame_problem(&self, span: Span, message: &str) -> Problem {
        self.problem(&span, message).help(FRAME_HELP)
    }

    /// A block on the line of one of the two `%` would be lost, or stop the control.
    fn note_frame(&self, opening: usize, closing: usize, problems: &mut Problems) {
        let title = opening + 1..self.after_title(opening).min(closing);
        if self.is_block(&title) {
            let message = "a block stands on the line of the opening `%`, which controls skip";
            problems.push(self.frame_problem(title, message));
        }
        let line = &self.text[opening..closing];
        let last = line.rsplit(is_end_of_block).next().unwrap_or("");
        if !last.trim().is_empty() {
            let message = "the closing `%` stands inside a block (`END OF RECORD` on the control)";
            problems.push(self.frame_problem(closing..closing + 1, message));
        }
    }

    /// Where the text on the line of the opening `%` ends.
    fn after_title(&self, opening: usize) -> usize {
        self.text[opening..]
            .find(is_end_of_block)
            .map_or(self.text.len(), |at| opening + at)
    }

    fn is_block(&self, span: &Span) -> bool {
        let mut letters = self.slice(span).trim_start().chars();
        letters.next().is_some_and(|c| c.eq_ignore_ascii_case(&'N'))
            && letters.next().is_some_and(|c| c.is_ascii_digit())
    }

    /// The blocks of a record, blank ones left out.
    pub(super) fn blocks(&self, record: Span) -> impl Iterator<Item = Span> {
        let mut at = record.start.min(record.end);
        let pieces = self.text[at..record.end].split(is_end_of_block);
        let spans = pieces.map(move |piece| {
            let start = at;
            at += piece.len() + 1;
            start..start + piece.len()
        });
        spans.filter(|span| !self.slice(span).trim().is_empty())
    }
}

fn is_end_of_block(c: char) -> bool {
    matches!(c, '\n' | '\r' | ';')
}

/// The same number of bytes, but in each run of line ends the CR stand first, and a run without
/// LF ends in one: LF CR CR, CR LF and CR alone then all end a line exactly once.
fn uniform_line_ends(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(['\r', '\n']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let length = rest.find(|c| c != '\r' && c != '\n').unwrap_or(rest.len());
        let feeds = rest[..length].matches('\n').count().max(1);
        out.push_str(&"\r".repeat(length - feeds));
        out.push_str(&"\n".repeat(feeds));
        rest = &rest[length..];
    }
    out.push_str(rest);
    out
}
