//! `[program]`: the part programs of a measuring run (contract §2.3, docs/program.md).

use crate::inputs::job::diagonals::Reflector;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{PathKind, Volume};
use crate::quantity::units::Millimetres;

/// What the measuring run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunType {
    /// The four body diagonals, one axis at a time (flat mirror).
    StepDiagonal,
    /// The four body diagonals, all axes together (retroreflector; ISO 230-6 motion).
    StraightDiagonal,
    /// Single axes along their length (ISO 230-2 motion).
    SingleAxis,
}

impl RunType {
    /// The word of the job.
    pub const fn word(self) -> &'static str {
        match self {
            RunType::StepDiagonal => "step-diagonal",
            RunType::StraightDiagonal => "straight-diagonal",
            RunType::SingleAxis => "single-axis",
        }
    }

    /// How the diagonals are walked; `None` for single axes.
    pub const fn path(self) -> Option<PathKind> {
        match self {
            RunType::StepDiagonal => Some(PathKind::Step),
            RunType::StraightDiagonal => Some(PathKind::Straight),
            RunType::SingleAxis => None,
        }
    }
}

/// How the target comes back to the start of a run that is measured in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WayBack {
    /// Over the same nodes in the opposite order.
    Retrace,
    /// Straight, all axes together.
    Diagonal,
}

impl WayBack {
    /// The word of the job.
    pub const fn word(self) -> &'static str {
        match self {
            WayBack::Retrace => "retrace",
            WayBack::Diagonal => "diagonal",
        }
    }
}

/// Where the targets of a single axis lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TargetGrid {
    /// Equal steps: the targets are the points of a table.
    Equal,
    /// Each target shifted by up to this length, so that errors that repeat with a period
    /// (screw, gear, scale) are not aliased (ISO 230-2: Pi = (i - 1) p + r).
    Offset {
        /// Largest shift, mm; `None` = a quarter of the step.
        shift: Option<Millimetres>,
    },
}

/// A measuring run to write programs for. Everything that is `Volume` here is the same volume that
/// a measurement of diagonals states, so a rehearsal can walk it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramRequest {
    /// What is run.
    pub what: RunType,
    /// The measured box, its division and the order of the moves in a cell.
    pub volume: Volume,
    /// Key that the size of the box comes from, for problems.
    pub size_path: &'static str,
    /// The axes of single-axis runs, in the order of the programs.
    pub axes: Vec<Axis>,
    /// Where the other axes rest in single-axis runs; `None` = the middle of the box.
    pub rest: Option<PerAxis<Millimetres>>,
    /// Feed along the path, mm/min.
    pub feed_mm_per_min: f64,
    /// Standstill at every node, s.
    pub dwell_s: f64,
    /// How far every axis runs over the far end before the way back is measured; 0 = it turns there.
    pub overrun: Millimetres,
    /// How far behind the first node every axis begins, so that it arrives in its own direction.
    pub preload: Millimetres,
    /// Number of runs.
    pub runs: u32,
    /// Whether the way back is measured too.
    pub bidirectional: bool,
    /// The way back where it is not measured.
    pub way_back: WayBack,
    /// Targets of single axes.
    pub targets: TargetGrid,
    /// Whether the target first goes to the far end and back, so that the beam can be aligned.
    pub alignment_pass: bool,
    /// Fanuc: number of the first program, where it is stated.
    pub number: Option<u32>,
    /// What reflects the beam.
    pub target: Reflector,
}

/// Number of the first program where none is stated.
const DEFAULT_NUMBER: u32 = 1001;

impl ProgramRequest {
    /// Fanuc: number of the program with this index; they follow each other.
    pub(crate) fn number_of(&self, index: usize) -> u32 {
        self.number.unwrap_or(DEFAULT_NUMBER) + u32::try_from(index).unwrap_or(0)
    }

    /// Whether the axes run over the far end before a way back that is measured: what `overrun`
    /// has to state with readings of this run of diagonals. `None` = no such way back.
    pub(crate) fn runs_over(&self) -> Option<bool> {
        let back = self.bidirectional && self.what.path().is_some();
        back.then(|| self.overrun.mm() > 0.0)
    }

    /// Where an axis rests while another one is measured.
    pub(crate) fn rest_of(&self, axis: Axis) -> Millimetres {
        let volume = &self.volume;
        let middle = volume.start[axis].mm() + volume.size[axis].mm() / 2.0;
        self.rest
            .map_or(Millimetres::new(middle), |rest| rest[axis])
    }
}
