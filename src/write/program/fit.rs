//! What a run must keep: travel, feed, readings; and the largest box that would fit.

use crate::inputs::job::{
    DiagonalMeasurement, Job, MeasuredData, ProgramRequest, RunType, TargetGrid,
};
use crate::quantity::{Axis, PerAxis, pitch, rounded};
use crate::text::{Finding, Problems};
use crate::write::findings::RunFinding;
use crate::write::program::route::{moving, readings_of};
use crate::write::program::run::{MOST_READINGS, problem};
use crate::write::program::{Resolution, RunTask};

pub(super) fn refuse_too_many_readings(
    job: &Job,
    request: &ProgramRequest,
    problems: &mut Problems,
) {
    let readings = readings_of(request);
    if readings > MOST_READINGS {
        problems.push(problem(
            job,
            "program",
            format!("one program would take {readings} readings, expected at most {MOST_READINGS}"),
            "fewer runs or steps: four digits number the blocks of a program",
        ));
    }
}

/// The feed along the path may reach every axis alone, so the slowest axis counts.
pub(super) fn refuse_feed(job: &Job, request: &ProgramRequest, problems: &mut Problems) {
    for axis in moving(request) {
        let largest = job.machine.axes[axis].and_then(|axis| axis.max_feed);
        if let Some(largest) = largest.filter(|largest| request.feed_mm_per_min > *largest) {
            problems.push(problem(
                job,
                "program.feed_mm_per_min",
                format!(
                    "the feed is {} mm/min, but {axis} is stated with at most {largest} mm/min",
                    request.feed_mm_per_min
                ),
                "write `feed_mm_per_min` with a feed that every axis reaches",
            ));
        }
    }
}

/// Neighbouring targets must not change places.
pub(super) fn refuse_shift(job: &Job, request: &ProgramRequest, problems: &mut Problems) {
    if let TargetGrid::Offset { shift } = request.targets {
        for axis in moving(request) {
            let step = request.volume.step_mm(axis);
            let shift = shift.map_or(step / 4.0, |shift| shift.mm());
            if shift >= step / 2.0 {
                problems.push(problem(
                    job,
                    "program.shift_mm",
                    format!("targets {step} mm apart on {axis} are shifted by up to {shift} mm, expected less than half the step"),
                    "a smaller shift, or fewer steps",
                ));
            }
        }
    }
}

/// What a person should know of the run.
pub(super) fn notes(task: RunTask<'_>, programs: usize) -> Vec<Finding> {
    let RunTask { job, request, .. } = task;
    let notes = [
        unchecked(job, request),
        near_the_end(job, request, task.resolution()),
        other_box(job, request),
        hides_pitches(request),
        protected_number(task, programs),
    ];
    notes.into_iter().flatten().map(Finding::from).collect()
}

/// How much shorter a step may be proposed: a share of it.
const SHORTER: f64 = 0.95;

/// Steps that are a multiple of a usual pitch on an axis, and those that are not.
fn hides_pitches(request: &ProgramRequest) -> Option<RunFinding> {
    let steps = u32::try_from(request.volume.steps).ok()?;
    let of = |axis: Axis| {
        let step_mm = request.volume.step_mm(axis);
        let is_hidden = pitch::unseen(&request.volume.positions(axis)).contains(&true);
        let other_mm = pitch::step_mm(SHORTER * step_mm, step_mm, steps);
        (is_hidden && request.targets == TargetGrid::Equal).then_some((axis, step_mm, other_mm))
    };
    let axes: Vec<(Axis, f64, f64)> = moving(request).into_iter().filter_map(of).collect();
    (!axes.is_empty()).then_some(RunFinding::HidesPitches { axes })
}

/// The measurement that the job describes, where this run is of diagonals too; and whether it has
/// the same nodes, so that it will describe the readings of this run.
fn described<'a>(
    job: &'a Job,
    request: &ProgramRequest,
) -> Option<(&'a DiagonalMeasurement, bool)> {
    let MeasuredData::Diagonals(measured) = &job.measurement.data else {
        return None;
    };
    let kind = request.what.path()?;
    let same = measured.volume == request.volume && measured.kind == kind;
    Some((measured, same))
}

/// Readings of this run must be described with this box, not with that of another measurement.
fn other_box(job: &Job, request: &ProgramRequest) -> Option<RunFinding> {
    let (measured, same) = described(job, request)?;
    let turns = measured.overrun.zip(request.runs_over());
    let turns_otherwise = turns.is_some_and(|(stated, over)| stated != over);
    (!same).then_some(RunFinding::OtherBox { turns_otherwise })
}

/// The section that describes the readings of this run must not say that the axes turned in
/// another way: the reversal would be looked for where it is not.
pub(super) fn refuse_other_turn(job: &Job, request: &ProgramRequest, problems: &mut Problems) {
    let (Some((measured, true)), Some(over)) = (described(job, request), request.runs_over())
    else {
        return;
    };
    let Some(stated) = measured.overrun.filter(|stated| *stated != over) else {
        return;
    };
    let (does, other) = if over {
        let mm = request.overrun.mm();
        (
            format!("goes {mm} mm past the end point before the return pass"),
            "`overrun_mm = 0` in [program] for a turn without it",
        )
    } else {
        (
            "turns at the last node without overrun".to_string(),
            "an `overrun_mm` above 0 in [program]",
        )
    };
    problems.push(problem(
        job,
        "measurement.step_diagonal.overrun",
        format!("`overrun` is {stated}, but this run {does}: its readings would be separated with the wrong reversal"),
        format!("write `overrun = {over}`, or {other}"),
    ));
}

/// Not every language has numbers of programs.
pub(super) fn refuse_number(task: RunTask<'_>, problems: &mut Problems) {
    if task.request.number.is_some() && task.facts.language.facts().numbered.is_none() {
        problems.push(problem(
            task.job,
            "program.number",
            format!("`number` is stated, but programs of `{}` have names", task.profile.id),
            "remove it",
        ));
    }
}

fn protected_number(task: RunTask<'_>, programs: usize) -> Option<RunFinding> {
    let last = task.request.number_of(programs.saturating_sub(1));
    let (from, by) = task.facts.language.facts().numbered?;
    (last >= from).then_some(RunFinding::ProtectedNumber { from, by })
}

fn unchecked(job: &Job, request: &ProgramRequest) -> Option<RunFinding> {
    let mut axes = moving(request);
    axes.retain(|axis| job.machine.axes[*axis].is_none_or(|axis| axis.max_feed.is_none()));
    (!axes.is_empty()).then_some(RunFinding::FeedNotChecked { axes })
}

pub(super) fn refuse_outside_travel(
    job: &Job,
    request: &ProgramRequest,
    resolution: Resolution,
    problems: &mut Problems,
) {
    for axis in Axis::ALL.into_iter().filter(|axis| job.machine.axes[*axis].is_none()) {
        problems.push(problem(
            job,
            "machine.axes",
            format!("the travel of {axis} is not stated, so nobody could tell where the program leaves it"),
            format!("add [machine.axes.{}] with travel_mm and reference_mm", axis.key()),
        ));
    }
    let axes = moving(request).into_iter();
    let outside = axes.filter_map(|axis| outside_travel(job, request, resolution, axis));
    let outside: Vec<String> = outside.collect();
    if outside.is_empty() {
        return;
    }
    let message = format!(
        "with {} mm of preload and {} mm of overrun the run needs {}",
        request.preload.mm(),
        overrun_mm(request),
        outside.join(", ")
    );
    let help = largest_box(job, request, resolution);
    problems.push(problem(job, request.size_path, message, help));
}

/// Where an axis goes that leaves its travel.
fn outside_travel(
    job: &Job,
    request: &ProgramRequest,
    resolution: Resolution,
    axis: Axis,
) -> Option<String> {
    let travel = job.machine.axes[axis]?;
    let (low, high) = reach(request, resolution, axis);
    let slack = resolution.digit_mm() / 100.0;
    let leaves = low < travel.low.mm() - slack || high > travel.high.mm() + slack;
    leaves.then(|| {
        format!(
            "{axis} from {} to {} mm (travel {} … {} mm)",
            plain(low),
            plain(high),
            travel.low.mm(),
            travel.high.mm()
        )
    })
}

/// Only a run in both directions goes past the end point.
fn overrun_mm(request: &ProgramRequest) -> f64 {
    match request.bidirectional {
        true => request.overrun.mm(),
        false => 0.0,
    }
}

/// From where to where an axis moves: both ends of a diagonal's box are start corners. What lies
/// beside the box is rounded up to whole digits, as it is in the program.
fn reach(request: &ProgramRequest, resolution: Resolution, axis: Axis) -> (f64, f64) {
    let low = request.volume.start[axis].mm();
    let high = low + request.volume.size[axis].mm();
    let whole = |mm: f64| resolution.mm(resolution.at_least(mm));
    let preload = whole(request.preload.mm());
    let overrun = whole(overrun_mm(request));
    match request.what {
        RunType::SingleAxis => (low - preload, high + overrun),
        RunType::StepDiagonal | RunType::StraightDiagonal => {
            let margin = preload.max(overrun);
            (low - margin, high + margin)
        }
    }
}

/// The largest box of whole steps inside the travel, as the job would state it.
fn largest_box(job: &Job, request: &ProgramRequest, resolution: Resolution) -> String {
    let (volume, steps) = (&request.volume, i64::try_from(request.volume.steps).unwrap_or(1));
    let fitted: PerAxis<Option<(f64, f64)>> = PerAxis::from_fn(|axis| {
        let travel = job.machine.axes[axis]?;
        if !moving(request).contains(&axis) {
            return Some((volume.start[axis].mm(), volume.size[axis].mm()));
        }
        let (low, high) = reach(request, resolution, axis);
        let before = volume.start[axis].mm() - low;
        let after = high - volume.start[axis].mm() - volume.size[axis].mm();
        let first = resolution.at_least(travel.low.mm() + before);
        let last = resolution.at_most(travel.high.mm() - after);
        let step = (last - first) / steps;
        (step > 0).then(|| (resolution.mm(first), resolution.mm(step * steps)))
    });
    let (Some(x), Some(y), Some(z)) = (fitted.x, fitted.y, fitted.z) else {
        return "no box of that many steps fits: less preload and overrun, or fewer steps"
            .to_string();
    };
    let of = |a: f64, b: f64, c: f64| format!("{{ x = {a:?}, y = {b:?}, z = {c:?} }}");
    format!(
        "the largest box that fits: start_mm = {} and size_mm = {} in [program]; the readings of it are described with the same box",
        of(x.0, y.0, z.0),
        of(x.1, y.1, z.1)
    )
}

/// Where the other axes rest while one is measured.
pub(super) fn refuse_rest_outside(job: &Job, request: &ProgramRequest, problems: &mut Problems) {
    if request.what != RunType::SingleAxis {
        return;
    }
    for axis in Axis::ALL {
        let Some(travel) = job.machine.axes[axis] else {
            continue;
        };
        let rests = request.axes.iter().any(|moving| *moving != axis);
        let place = request.rest_of(axis);
        if rests && (place < travel.low || place > travel.high) {
            problems.push(problem(
                job,
                "program.rest_mm",
                format!(
                    "{axis} would rest at {} mm, but the travel is {} … {} mm",
                    plain(place.mm()),
                    travel.low.mm(),
                    travel.high.mm()
                ),
                "write `rest_mm = { x = …, y = …, z = … }` with places inside the travel",
            ));
        }
    }
}

/// Less than this between a run and the end of the travel is worth a word, mm.
const NEAR_THE_END_MM: f64 = 1.0;

/// Axes that go to the very end of their travel: software limits may lie before it.
fn near_the_end(job: &Job, request: &ProgramRequest, resolution: Resolution) -> Option<RunFinding> {
    let near = |axis: &Axis| {
        let (low, high) = reach(request, resolution, *axis);
        job.machine.axes[*axis].is_some_and(|travel| {
            low - travel.low.mm() < NEAR_THE_END_MM || travel.high.mm() - high < NEAR_THE_END_MM
        })
    };
    let axes: Vec<Axis> = moving(request).into_iter().filter(near).collect();
    (!axes.is_empty()).then_some(RunFinding::NearTheEnd { axes })
}

/// A coordinate without the digits that binary numbers add.
fn plain(mm: f64) -> f64 {
    rounded(mm, 6)
}
