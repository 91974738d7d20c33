//! What a program does, step by step.

use crate::quantity::axis::PerAxis;
use crate::text::problem::{Place, Problem};
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

/// What keeps a program from being read, and where.
#[derive(Clone, Debug)]
pub(super) struct Complaint {
    pub(super) span: Range<usize>,
    pub(super) message: String,
}

impl Complaint {
    pub(super) fn new(span: Range<usize>, message: impl Into<String>) -> Complaint {
        Complaint {
            span,
            message: message.into(),
        }
    }

    pub(super) fn at(self, file: &str, text: &str) -> Problem {
        Problem::new(self.message)
            .at(Place::in_text(file, text, self.span.start, self.span.end))
            .help("a template of your own may lay out the words, not add others (docs/program.md)")
    }
}
