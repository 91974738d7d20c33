//! The motion of a measuring run, planned as data: where the axes go, where they stand still, and
//! which reading belongs to each standstill.
//!
//! ```text
//!            far end ●──► overrun           every axis arrives at node 0 and at the far end in
//!                  ┌─┘◄──                   the direction in which it is measured next
//!              ┌───┘
//!          ┌───┘     single-axis steps: move, stand still, read
//!    ──►●──┘
//!  preload  node 0
//! ```
//! All places are whole numbers of the control's last digit ([`LengthDigit`]), so increments never
//! add up to something else, and what a program commands is exactly what `positions.csv` says.

mod fit;
mod mirror;
mod route;
mod run;

pub use self::mirror::MirrorSize;
pub use self::run::{Digits, MeasuringRun, Move, PlannedReading, RunTask, SetUpProgram, Subject};

use crate::control::controller::ControlUnit;
use crate::inputs::job::{Job, ProgramRequest, RunType};
use crate::quantity::Axis;
use crate::text::{Finding, Problems, findings};
use crate::write::grid::LengthDigit;

/// The last digit of a position on most controls.
const MICROMETRE: LengthDigit = LengthDigit { unit: ControlUnit::Millimetre, decimals: 3 };

/// The motion of a run before a control is asked: lengths to the nearest micrometre, whatever the travel.
pub(crate) fn motion(request: &ProgramRequest) -> MeasuringRun {
    MeasuringRun {
        resolution: MICROMETRE,
        programs: route::programs(request, &route::Scale::nearest(request, MICROMETRE)),
        mirror: mirror::needed(request),
        notes: Vec::new(),
    }
}

/// Plans a run; refused where it leaves the travel.
pub fn plan(task: RunTask<'_>) -> Result<MeasuringRun, Problems> {
    let (request, resolution) = (task.request, task.resolution());
    let mut problems = Problems::none();
    for refuse in fit::REFUSALS {
        refuse(task, &mut problems);
    }
    problems.or_ok(())?;
    let programs = route::programs(request, &route::Scale::nearest(request, resolution));
    let mirror = mirror::needed(request);
    Ok(MeasuringRun { resolution, notes: fit::notes(task, programs.len()), programs, mirror })
}

// What a run leaves open, said before it is measured, with the measurement that closes it.

/// Axes measured along their length that determine all scales (docs/method.md §5).
const LINEAR_AXES: usize = 2;

findings! {
    /// What a run alone cannot determine.
    Open {
        Scales { given: usize } => Label,
            "scales (positioning over the whole length): a tilt of the mirror looks the same, and the job names {given} linear axes; measure two axes along their length, three to check them";
        Reversal => Label,
            "reversal: every node is read in one direction; measure with `bidirectional = true`, or linear axes in both directions";
        ReversalOfAnAxis => Label,
            "reversal of a single axis: with overrun only its sum along each diagonal shows; `overrun_mm = 0`, or linear axes in both directions";
        NineErrors => Label,
            "the nine errors: straight runs give the lengths of the diagonals only; use `what = \"step-diagonal\"`";
        Straightness { axes: String } => Label,
            "straightness and squareness: runs along {axes} give the positioning only; use `what = \"step-diagonal\"`, or measure them separately";
        Angles => Label,
            "angular errors: what they do to the diagonals is taken for straightness; measure roll, pitch and yaw and give them as `angles`";
    }
}

/// What the run of a job cannot determine.
pub fn left_open(job: &Job, request: &ProgramRequest) -> Vec<Finding> {
    let is_step = request.what == RunType::StepDiagonal;
    let reversal = match (request.bidirectional, request.runs_over()) {
        (false, _) => Some(Open::Reversal),
        (true, Some(true)) if is_step => Some(Open::ReversalOfAnAxis),
        (true, _) => None,
    };
    let of_run = match request.what {
        RunType::StepDiagonal => scales(job).into_iter().chain([Open::Angles]).collect(),
        RunType::StraightDiagonal => vec![Open::NineErrors],
        RunType::SingleAxis => vec![Open::Straightness { axes: Axis::letters(&request.axes) }],
    };
    of_run.into_iter().chain(reversal).map(Finding::from).collect()
}

fn scales(job: &Job) -> Option<Open> {
    let given = job.measurement.diagonals().map_or(0, |how| how.linear.len());
    (given < LINEAR_AXES).then_some(Open::Scales { given })
}
