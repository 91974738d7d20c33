//! The box, the margins and the targets of a run in whole digits of the control.

use crate::inputs::job::{Job, ProgramRequest, RunType, TargetGrid};
use crate::quantity::axis::{Axis, PerAxis};
use crate::text::problem::Problems;
use crate::write::program::run::problem;
use crate::write::program::{Digits, Resolution};

/// A run's lengths in digits.
pub(super) struct Scale {
    pub(super) resolution: Resolution,
    pub(super) start: PerAxis<Digits>,
    pub(super) step: PerAxis<Digits>,
    pub(super) rest: PerAxis<Digits>,
    pub(super) preload: Digits,
    pub(super) overrun: Digits,
    pub(super) targets: PerAxis<Vec<Digits>>,
}

impl Scale {
    /// Refused where a length is not a whole number of digits: the control would round it, and the
    /// readings would hold the rounding as a deviation of the machine.
    pub(super) fn of(
        job: &Job,
        request: &ProgramRequest,
        resolution: Resolution,
    ) -> Result<Scale, Problems> {
        let mut problems = Problems::none();
        let volume = &request.volume;
        let start_path = request.size_path.replace("size_mm", "start_mm");
        let start = PerAxis::from_fn(|axis| {
            let mm = volume.start[axis].mm();
            let near = resolution.nearest(mm);
            if resolution.digits(mm).is_none() && moving(request).contains(&axis) {
                problems.push(problem(
                    job,
                    &format!("{start_path}.{}", axis.key()),
                    format!(
                        "the start of {axis} is {mm} mm, expected a multiple of {}, the last digit of a position",
                        resolution.digit_words()
                    ),
                    format!("the nearest is {} mm", resolution.mm(near)),
                ));
            }
            near
        });
        // Preload, overrun and rest are no nodes: nothing is measured against them.
        let preload = resolution.at_least(request.preload.mm());
        let overrun = resolution.at_least(request.overrun.mm());
        let rest = PerAxis::from_fn(|axis| resolution.nearest(request.rest_of(axis).mm()));
        let step =
            PerAxis::from_fn(|axis| whole_step(job, request, resolution, axis, &mut problems));
        let targets =
            PerAxis::from_fn(|axis| targets(request, resolution, axis, start[axis], step[axis]));
        problems.or_ok(Scale {
            resolution,
            start,
            step,
            rest,
            preload,
            overrun,
            targets,
        })
    }
}

fn whole_step(
    job: &Job,
    request: &ProgramRequest,
    resolution: Resolution,
    axis: Axis,
    problems: &mut Problems,
) -> Digits {
    let (size, steps) = (request.volume.size[axis].mm(), request.volume.steps);
    let step = request.volume.step_mm(axis);
    let unused = request.what == RunType::SingleAxis
        && (!request.axes.contains(&axis) || request.targets != TargetGrid::Equal);
    if let Some(whole) = resolution.digits(step).filter(|whole| *whole > 0 || unused) {
        return whole;
    }
    if unused {
        return resolution.nearest(step);
    }
    let below = resolution.at_most(step).max(1);
    let nearest = resolution.mm(below * i64::try_from(steps).unwrap_or(1));
    problems.push(problem(
        job,
        &format!("{}.{}", request.size_path, axis.key()),
        format!(
            "{size} mm of {axis} in {steps} steps are {step:.6} mm each, expected a multiple of {}, the last digit of a position",
            resolution.digit_words()
        ),
        format!(
            "the nearest below is {nearest} mm ({steps} x {} mm)",
            resolution.mm(below)
        ),
    ));
    below
}

/// Golden section: its multiples fill an interval evenly, and no period of a machine meets them.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Targets of one axis, ascending. Offset targets: Pi = start + i·p + r_i with
/// r_i = a·(2·frac(g·(i + 1)) − 1), g = 0.618…, a = the largest shift; the first is shifted inwards by
/// |r_0|, the last by |r_n|, so all lie in the box. The shifts are the same in every version.
fn targets(
    request: &ProgramRequest,
    resolution: Resolution,
    axis: Axis,
    start: Digits,
    step: Digits,
) -> Vec<Digits> {
    let volume = &request.volume;
    let last = volume.steps;
    let TargetGrid::Offset { shift } = request.targets else {
        let counts = 0..=i64::try_from(last).unwrap_or(0);
        return counts.map(|count| start + count * step).collect();
    };
    let largest = shift.map_or(volume.step_mm(axis) / 4.0, |shift| shift.mm());
    let of_index = |index: usize| {
        #[allow(
            clippy::cast_precision_loss,
            reason = "a run has far fewer than 2^52 targets"
        )]
        let turns = GOLDEN * (index + 1) as f64;
        let shift = largest * (2.0 * turns.fract() - 1.0);
        let shift = match index {
            0 => shift.abs(),
            index if index == last => -shift.abs(),
            _ => shift,
        };
        resolution.nearest(volume.start[axis].mm() + volume.along_mm(axis, index) + shift)
    };
    (0..=last).map(of_index).collect()
}

/// The axes that move while readings are taken.
pub(super) fn moving(request: &ProgramRequest) -> Vec<Axis> {
    match request.what {
        RunType::SingleAxis => request.axes.clone(),
        RunType::StepDiagonal | RunType::StraightDiagonal => Axis::ALL.to_vec(),
    }
}
