//! What a field kit is made from.

use crate::judge::conformity::Verdict;
use crate::judge::forecast::Forecast;
use crate::kit::Inputs;
use crate::quantity::axis::Axis;
use crate::read::{KitFile, ReadBack};
use crate::write::compensation::Compiled;
use crate::write::emit::{Context, RenderedFile, Templates};
use crate::write::plan::{Plan, Task};

/// What a field kit is made from.
pub(crate) struct Made<'a> {
    pub(crate) inputs: &'a Inputs,
    pub(crate) plan: &'a Plan,
    pub(crate) compiled: &'a Compiled,
    pub(crate) context: &'a Context,
    pub(crate) templates: &'a Templates,
    /// The files of the kit itself.
    pub(crate) files: &'a [RenderedFile],
    /// What was read back from them.
    pub(crate) read: &'a ReadBack,
    /// What the files will leave.
    pub(crate) forecast: &'a Forecast,
    /// Forecast against the acceptance of the job.
    pub(crate) verdict: Verdict,
    /// Why the measured errors are doubtful.
    pub(crate) doubts: &'a [String],
}

impl Made<'_> {
    pub(super) fn task(&self) -> Task<'_> {
        self.inputs.task()
    }

    /// `X (AX1)`, or `X (AX1 and AX4)` for a gantry.
    pub(super) fn axes(&self, axis: Axis) -> String {
        format!("{axis} ({})", self.plan.names[axis].join(" and "))
    }
}

/// A file as the readers take it.
pub(crate) fn as_kit_file(file: &RenderedFile) -> KitFile<'_> {
    KitFile {
        path: &file.path,
        role: file.role,
        bytes: &file.bytes,
    }
}
