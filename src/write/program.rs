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
//! All places are whole numbers of the control's last digit ([`Resolution`]), so increments never
//! add up to something else, and what a program commands is exactly what `positions.csv` says.

mod fit;
mod mirror;
mod open;
mod route;
mod run;

pub use self::mirror::MirrorSize;
pub use self::open::{Open, left_open};
pub use self::run::{
    Digits, MeasuringRun, Move, PlannedReading, Resolution, RunTask, SetUpProgram, Subject,
};

use crate::control::controller::ControlUnit;
use crate::inputs::job::ProgramRequest;
use crate::text::Problems;

/// The last digit of a position on most controls.
const MICROMETRE: Resolution = Resolution { unit: ControlUnit::Millimetre, decimals: 3 };

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
    let RunTask { job, request, .. } = task;
    let resolution = task.resolution();
    let mut problems = Problems::none();
    fit::refuse_too_many_readings(job, request, &mut problems);
    fit::refuse_feed(job, request, &mut problems);
    fit::refuse_shift(job, request, &mut problems);
    fit::refuse_rest_outside(job, request, &mut problems);
    fit::refuse_outside_travel(job, request, resolution, &mut problems);
    fit::refuse_other_turn(job, request, &mut problems);
    fit::refuse_number(task, &mut problems);
    let scale = problems.take(route::Scale::of(job, request, resolution));
    let Some(scale) = scale.filter(|_| problems.is_empty()) else {
        return Err(problems);
    };
    let programs = route::programs(request, &scale);
    let mirror = mirror::needed(request);
    Ok(MeasuringRun { resolution, notes: fit::notes(task, programs.len()), programs, mirror })
}
