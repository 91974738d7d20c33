//! What a run must keep: travel, feed, readings; and the largest box that would fit.

use crate::control::controller::ControlUnit;
use crate::inputs::job::{DiagonalMeasurement, RunType, TargetGrid};
use crate::quantity::{Axis, PerAxis, pitch, rounded};
use crate::text::{Finding, Problems};
use crate::write::findings::RunFinding;
use crate::write::program::RunTask;
use crate::write::program::route::{moving, readings_of, refuse_between_digits};
use crate::write::program::run::{MOST_READINGS, overrun_mm};
use crate::write::refusals;

/// What a run is refused for, in the order in which it is told.
pub(super) const REFUSALS: [fn(RunTask<'_>, &mut Problems); 8] = [
    refuse_too_many_readings,
    refuse_feed,
    refuse_shift,
    refuse_rest_outside,
    refuse_outside_travel,
    refuse_other_turn,
    refuse_number,
    refuse_between_digits,
];

fn refuse_too_many_readings(task: RunTask<'_>, problems: &mut Problems) {
    let readings = readings_of(task.request);
    if readings > MOST_READINGS {
        let wrong = refusals::many_readings(readings, MOST_READINGS);
        problems.push(task.job.source.at("program", wrong));
    }
}

/// The feed along the path may reach every axis alone, so the slowest axis counts.
fn refuse_feed(task: RunTask<'_>, problems: &mut Problems) {
    let feed = task.request.feed_mm_per_min;
    for axis in moving(task.request) {
        let largest = task.job.machine.axes[axis].and_then(|axis| axis.max_feed);
        if let Some(largest) = largest.filter(|largest| feed > *largest) {
            let wrong = refusals::large_feed(feed, axis, largest);
            problems.push(task.job.source.at("program.feed_mm_per_min", wrong));
        }
    }
}

/// Neighbouring targets must not change places.
fn refuse_shift(task: RunTask<'_>, problems: &mut Problems) {
    let TargetGrid::Offset { shift } = task.request.targets else {
        return;
    };
    for axis in moving(task.request) {
        let step = task.request.volume.step_mm(axis);
        let shift = shift.map_or(step / 4.0, |shift| shift.mm());
        if shift >= step / 2.0 {
            let wrong = refusals::large_shift(step, axis, shift);
            problems.push(task.job.source.at("program.shift_mm", wrong));
        }
    }
}

/// What a person should know of the run.
pub(super) fn notes(task: RunTask<'_>, programs: usize) -> Vec<Finding> {
    let notes = [
        unchecked(task),
        near_the_end(task),
        other_box(task),
        hides_pitches(task),
        protected_number(task, programs),
    ];
    notes.into_iter().flatten().map(Finding::from).collect()
}

/// How much shorter a step may be proposed: a share of it.
const SHORTER: f64 = 0.95;

/// Steps that are a multiple of a usual pitch on an axis, and those that are not.
fn hides_pitches(task: RunTask<'_>) -> Option<RunFinding> {
    let request = task.request;
    let inches = task.job.compensation.control_unit == ControlUnit::Inch;
    let steps = u32::try_from(request.volume.steps).ok()?;
    let of = |axis: Axis| {
        let step_mm = request.volume.step_mm(axis);
        let is_hidden = pitch::unseen(&request.volume.positions(axis)).contains(&true);
        let digit_mm = pitch::DIGIT_MM[usize::from(inches)];
        let other_mm = pitch::step_mm(SHORTER * step_mm, step_mm, steps, digit_mm);
        let shows_more = pitch::seen(other_mm, steps) > pitch::seen(step_mm, steps);
        let better = shows_more.then(|| plain(other_mm));
        let is_told = is_hidden && request.targets == TargetGrid::Equal;
        is_told.then_some((axis, plain(step_mm), better))
    };
    let axes: Vec<(Axis, f64, Option<f64>)> = moving(request).into_iter().filter_map(of).collect();
    (!axes.is_empty()).then_some(RunFinding::HidesPitches { axes })
}

/// The measurement that the job describes, where this run is of diagonals too; and whether it has
/// the same nodes, so that it will describe the readings of this run.
fn described(task: RunTask<'_>) -> Option<(&DiagonalMeasurement, bool)> {
    let measured = task.job.measurement.diagonals()?;
    let kind = task.request.what.path()?;
    Some((measured, measured.volume == task.request.volume && measured.kind == kind))
}

/// Readings of this run must be described with this box, not with that of another measurement.
fn other_box(task: RunTask<'_>) -> Option<RunFinding> {
    let (measured, same) = described(task)?;
    let turns = measured.overrun.zip(task.request.runs_over());
    let turns_otherwise = turns.is_some_and(|(stated, over)| stated != over);
    (!same).then_some(RunFinding::OtherBox { turns_otherwise })
}

/// The section that describes the readings of this run must not say that the axes turned in
/// another way: the reversal would be looked for where it is not.
fn refuse_other_turn(task: RunTask<'_>, problems: &mut Problems) {
    let stated = described(task).filter(|(_, same)| *same).and_then(|(how, _)| how.overrun);
    let turns = stated.zip(task.request.runs_over());
    let Some((stated, over)) = turns.filter(|(stated, over)| stated != over) else {
        return;
    };
    let (does, other) = if over {
        let mm = task.request.overrun.mm();
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
    let wrong = refusals::other_turn(stated, does, over, other);
    problems.push(task.job.source.at("measurement.step_diagonal.overrun", wrong));
}

/// Not every language has numbers of programs.
fn refuse_number(task: RunTask<'_>, problems: &mut Problems) {
    if task.request.number.is_some() && task.facts.language.facts().numbered.is_none() {
        problems.push(task.job.source.at("program.number", refusals::no_number(&task.profile.id)));
    }
}

fn protected_number(task: RunTask<'_>, programs: usize) -> Option<RunFinding> {
    let last = task.request.number_of(programs.saturating_sub(1));
    let (from, by) = task.facts.language.facts().numbered?;
    (last >= from).then_some(RunFinding::ProtectedNumber { from, by })
}

fn unchecked(task: RunTask<'_>) -> Option<RunFinding> {
    let mut axes = moving(task.request);
    axes.retain(|axis| task.job.machine.axes[*axis].is_none_or(|axis| axis.max_feed.is_none()));
    (!axes.is_empty()).then_some(RunFinding::FeedNotChecked { axes })
}

fn refuse_outside_travel(task: RunTask<'_>, problems: &mut Problems) {
    let RunTask { job, request, .. } = task;
    for axis in Axis::ALL.into_iter().filter(|axis| job.machine.axes[*axis].is_none()) {
        problems.push(job.source.at("machine.axes", refusals::no_travel(axis, axis.key())));
    }
    let axes = moving(request).into_iter();
    let outside: Vec<String> = axes.filter_map(|axis| outside_travel(task, axis)).collect();
    if outside.is_empty() {
        return;
    }
    let (preload, overrun) = (request.preload.mm(), overrun_mm(request));
    let wrong = refusals::leaves(preload, overrun, outside.join(", "), largest_box(task));
    problems.push(job.source.at(request.size_path, wrong));
}

/// Where an axis goes that leaves its travel.
fn outside_travel(task: RunTask<'_>, axis: Axis) -> Option<String> {
    let travel = task.job.machine.axes[axis]?;
    let (low, high) = reach(task, axis);
    let slack = task.resolution().digit_mm() / 100.0;
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

/// From where to where an axis moves: both ends of a diagonal's box are start corners. What lies
/// beside the box is rounded up to whole digits, as it is in the program.
fn reach(task: RunTask<'_>, axis: Axis) -> (f64, f64) {
    let (request, resolution) = (task.request, task.resolution());
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
fn largest_box(task: RunTask<'_>) -> String {
    let (request, resolution) = (task.request, task.resolution());
    let (volume, steps) = (&request.volume, i64::try_from(request.volume.steps).unwrap_or(1));
    let fitted: PerAxis<Option<(f64, f64)>> = PerAxis::from_fn(|axis| {
        let travel = task.job.machine.axes[axis]?;
        let (start, size) = (volume.start[axis].mm(), volume.size[axis].mm());
        if !moving(request).contains(&axis) {
            return Some((start, size));
        }
        let (low, high) = reach(task, axis);
        let (before, after) = (start - low, high - start - size);
        let first = resolution.at_least(travel.low.mm() + before);
        let step = (resolution.at_most(travel.high.mm() - after) - first) / steps;
        (step > 0).then(|| (resolution.mm(first), resolution.mm(step * steps)))
    });
    let Some(PerAxis { x, y, z }) = fitted.all() else {
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
fn refuse_rest_outside(task: RunTask<'_>, problems: &mut Problems) {
    let RunTask { job, request, .. } = task;
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
            let (at, low, high) = (plain(place.mm()), travel.low.mm(), travel.high.mm());
            problems.push(job.source.at("program.rest_mm", refusals::rests(axis, at, low, high)));
        }
    }
}

/// Less than this between a run and the end of the travel is worth a word, mm.
const NEAR_THE_END_MM: f64 = 1.0;

/// Axes that go to the very end of their travel: software limits may lie before it.
fn near_the_end(task: RunTask<'_>) -> Option<RunFinding> {
    let near = |axis: &Axis| {
        let (low, high) = reach(task, *axis);
        task.job.machine.axes[*axis].is_some_and(|travel| {
            low - travel.low.mm() < NEAR_THE_END_MM || travel.high.mm() - high < NEAR_THE_END_MM
        })
    };
    let axes: Vec<Axis> = moving(task.request).into_iter().filter(near).collect();
    (!axes.is_empty()).then_some(RunFinding::NearTheEnd { axes })
}

/// A coordinate without the digits that binary numbers add.
fn plain(mm: f64) -> f64 {
    rounded(mm, 6)
}
