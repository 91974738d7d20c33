//! The frame of a Fanuc file: the record between two `%`, and what stands around it.
//!
//! ```text
//!   % title LF  block LF  block LF … LF % anything
//!     └ skipped └── spans given to the block reader ┘ └ not read
//! ```
//! Only LF ends a block: CR beside it (CR LF, LF CR CR) means nothing, alone it ends none, nor does `;`,
//! which stands for LF in manuals. A file starts with `%` or LF, and what stands between `%` and the
//! next LF is skipped (all of it: B-63524EN/01 p. 649, file format; 16i/18i, taken to hold for the others). So a kit's
//! file starts with `%`: whether a control takes text before it for data or skips it is not said.
//! Behind the closing `%` nothing is read; a block there is one that never reaches the control.

use crate::text::problem::{LineIndex, Problem, Problems};
use std::ops::Range;

/// Bytes `start..end` of the source.
pub(super) type Span = Range<usize>;

const FRAME_HELP: &str = "a record begins with `%` and ends with `%`, each on a line of its own; \
    the file may have been cut when it was copied; if it is no file of the control, take it out of the \
    directory";

const TEXT_BEFORE: &str =
    "text stands before the opening `%`: a control may take it for data, and `%` for their end";

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

    /// What stands between the two `%`; what is wrong with the frame is noted. The file of a kit starts
    /// with `%`; before that of a read-out some text may stand.
    pub(super) fn record(&self, of_kit: bool, problems: &mut Problems) -> Span {
        let (Some(opening), Some(closing)) = (self.text.find('%'), self.text.rfind('%')) else {
            problems.push(self.frame_problem(0..0, "the file has no opening `%`"));
            return 0..0;
        };
        let has_block = |span: Span| self.blocks(span).find(|span| self.is_block(span));
        let before = has_block(0..opening);
        if opening < closing {
            let before = before.or((of_kit && opening > 0).then_some(0..opening));
            if let Some(span) = before {
                problems.push(self.frame_problem(span, TEXT_BEFORE));
            }
            if let Some(span) = has_block(closing + 1..self.text.len()) {
                let message = "a block stands behind the closing `%`, where no control reads";
                problems.push(self.frame_problem(span, message));
            }
            self.note_frame(opening, closing, problems);
            return self.after_title(opening)..closing;
        }
        if before.is_some() {
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
        let goes_on = self.slice(&title).trim_end_matches('\r').contains('\r');
        if self.is_block(&title) || goes_on {
            let message = match goes_on {
                true => {
                    "a carriage return alone ends the line of the opening `%`, which controls skip up to the line feed"
                }
                false => "a block stands on the line of the opening `%`, which controls skip",
            };
            problems.push(self.frame_problem(title, message));
        }
        let line = &self.text[opening..closing];
        let last = line.rsplit('\n').next().unwrap_or("");
        if !last.trim_matches(BLANKS).is_empty() {
            let message = "the closing `%` stands inside a block (`END OF RECORD` on the control)";
            problems.push(self.frame_problem(closing..closing + 1, message));
        }
    }

    /// Where the text on the line of the opening `%` ends.
    fn after_title(&self, opening: usize) -> usize {
        self.text[opening..]
            .find('\n')
            .map_or(self.text.len(), |at| opening + at)
    }

    /// Whether a piece begins with `N` and a number, as data do, also in letters that no control reads.
    fn is_block(&self, span: &Span) -> bool {
        let piece = self.slice(span).trim_start();
        let number = piece.strip_prefix(['N', 'n']).map(str::trim_start);
        number.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    }

    /// The blocks of a record, blank ones left out.
    pub(super) fn blocks(&self, record: Span) -> impl Iterator<Item = Span> {
        let mut at = record.start.min(record.end);
        let pieces = self.text[at..record.end].split('\n');
        let spans = pieces.map(move |piece| {
            let start = at;
            at += piece.len() + 1;
            start..start + piece.trim_end_matches(BLANKS).len()
        });
        spans.filter(|span| !span.is_empty())
    }
}

/// What means nothing at the end of a block.
const BLANKS: [char; 3] = [' ', '\t', '\r'];

/// The same number of bytes, but in each run of line ends with an LF the CR stand first: LF CR CR and
/// CR LF then both end a line exactly once. A CR alone stays where it is and ends none.
fn uniform_line_ends(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(['\r', '\n']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let length = rest.find(|c| c != '\r' && c != '\n').unwrap_or(rest.len());
        let feeds = rest[..length].matches('\n').count();
        out.push_str(&"\r".repeat(length - feeds));
        out.push_str(&"\n".repeat(feeds));
        rest = &rest[length..];
    }
    out.push_str(rest);
    out
}
