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
pub mod walk;
mod words;

use crate::control::controller::program::Language;
use crate::quantity::axis::PerAxis;
use crate::text::problem::{Place, Problem, Problems};
use std::ops::Range;

/// What can be active when a program begins and would falsify its moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cancelled {
    /// Tool length.
    ToolLength,
    /// Tool radius.
    ToolRadius,
    /// Work offsets.
    Offset,
    /// Shifts of the program.
    Shift,
    /// Rotation.
    Rotation,
    /// Scaling.
    Scaling,
    /// Mirroring.
    Mirroring,
    /// Kinematic transformations.
    Transformation,
    /// Drilling cycles.
    Cycle,
}

/// One thing that a program does; lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Deed {
    /// Cancels something.
    Cancel(Cancelled),
    /// Waits for cycle start.
    Stop,
    /// Goes to machine coordinates; `None` = the axis stays.
    ToMachine(PerAxis<Option<f64>>),
    /// Goes by an increment at a feed, mm/min.
    By(PerAxis<f64>, f64),
    /// Stands still for some seconds, in the block with this number.
    Dwell(f64, Option<u32>),
    /// Ends.
    End,
}

/// A deed and the bytes of its block.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What is done.
    pub deed: Deed,
    /// Where it stands.
    pub span: Range<usize>,
}

/// What a machine or a control names itself.
#[derive(Clone, Copy, Debug)]
pub struct OwnWords<'a> {
    /// Addresses of the axes X, Y and Z.
    pub letters: &'a [String],
    /// Address of the seconds of a dwell.
    pub seconds: char,
}

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

/// What keeps a program from being read, and where.
#[derive(Clone, Debug)]
struct Complaint {
    span: Range<usize>,
    message: String,
}

impl Complaint {
    fn new(span: Range<usize>, message: impl Into<String>) -> Complaint {
        Complaint {
            span,
            message: message.into(),
        }
    }

    fn at(self, file: &str, text: &str) -> Problem {
        Problem::new(self.message)
            .at(Place::in_text(file, text, self.span.start, self.span.end))
            .help("a template of your own may lay out the words, not add others (docs/program.md)")
    }
}
