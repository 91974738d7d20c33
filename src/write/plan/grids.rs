//! The points of each moving axis, and what the tables hold there.

use crate::control::controller::Profile;
use crate::inputs::job::{
    AxisSettings, GridRequest, MachineAxis, OutsideMeasured, without_grid, without_unit,
};
use crate::quantity::{Axis, Deviation, Millimetres, PerAxis, residual, table_values};
use crate::text::{Finding, Problem, Problems};
use crate::write::family::family;
use crate::write::findings::TableFinding;
use crate::write::grid::{self, EDGE_MM, Grid, LengthDigit, as_number};
use crate::write::task::{Target, Task};

pub(super) fn grids(
    task: Task<'_>,
    targets: &[Target],
    notes: &mut Vec<Finding>,
) -> Result<PerAxis<Option<Grid>>, Problems> {
    let mut problems = Problems::none();
    let mut grids = PerAxis::default();
    check_settings(task, targets, &mut problems);
    for axis in Axis::ALL {
        let along: Vec<&Target> = targets.iter().filter(|t| t.term.along == axis).collect();
        let Some((machine, settings)) = task.axis(axis) else {
            continue;
        };
        if along.is_empty() {
            continue;
        }
        if let Some(grid) = problems.take(axis_grid(task, axis, machine, settings, &along)) {
            check_grid(task, axis, machine, settings, &grid, &mut problems);
            refuse_beyond(task, axis, machine, &along, &grid, &mut problems);
            note_spacing(axis, settings, &grid, notes);
            grids[axis] = Some(grid);
        }
    }
    problems.or_ok(grids)
}

fn check_settings(task: Task<'_>, targets: &[Target], problems: &mut Problems) {
    for axis in Axis::ALL {
        let moves = targets.iter().any(|t| t.term.along == axis);
        let corrected = targets.iter().any(|t| t.term.of == axis);
        let settings = task.job.compensation.axes[axis].as_ref();
        let path = format!("compensation.axes.{}", axis.key());
        if moves && settings.is_none_or(|s| s.grid.is_none()) {
            problems.push(task.job.source.at(&path, without_grid(axis, &path)));
        }
        let unit_missing = settings.is_none_or(|s| s.detection_unit_um.is_none());
        if (moves || corrected) && task.profile.detection_unit_required.value && unit_missing {
            problems.push(task.job.source.at(&path, without_unit(&path, &task.profile.name)));
        }
        if corrected && task.job.machine.axes[axis].is_none() {
            problems.push(
                task.job
                    .problem_at(
                        "machine.axes",
                        format!(
                            "axis {axis} is corrected, but [machine.axes.{}] is missing",
                            axis.key()
                        ),
                    )
                    .help("add travel_mm and reference_mm of this axis"),
            );
        }
    }
}

fn axis_grid(
    task: Task<'_>,
    axis: Axis,
    machine: MachineAxis,
    settings: &AxisSettings,
    targets: &[&Target],
) -> Result<Grid, Problems> {
    let digit = length_digit(task);
    let path = |key: &str| format!("compensation.axes.{}.{key}", axis.key());
    let request = settings.grid.unwrap_or(GridRequest::Points(2));
    let ends_given = settings.start_mm.is_some() || settings.end_mm.is_some();
    if ends_given && !matches!(request, GridRequest::Spacing(_)) {
        let key = if settings.start_mm.is_some() { "start_mm" } else { "end_mm" };
        return Err(task
            .job
            .problem_at(&path(key), format!("`{key}` needs a grid of stated spacing"))
            .help("give `spacing_mm`, or leave `start_mm` and `end_mm` out")
            .into());
    }
    match request {
        GridRequest::Spacing(spacing) => {
            grid::with_spacing(task.job, axis, machine, settings, digit, spacing)
        }
        GridRequest::Points(points) => grid::with_points(machine, digit, points)
            .map_err(|problem| at_key(task, &path("points"), problem)),
        GridRequest::MaxResidual(limit) => coarsest(task, axis, machine, targets, limit),
    }
}

fn at_key(task: Task<'_>, path: &str, problem: Problem) -> Problems {
    match task.job.source.place_of(path) {
        Some(place) => problem.at(place).into(),
        None => problem.into(),
    }
}

/// Every number of points is tried, so the work grows with the square of this; a table with more
/// points is not what `max_residual_um` is for.
const MOST_PLANNED_POINTS: u32 = 2000;

/// The grid of the fewest points whose own residual (before rounding) keeps the limit for every
/// term of the axis.
fn coarsest(
    task: Task<'_>,
    axis: Axis,
    machine: MachineAxis,
    targets: &[&Target],
    limit_um: f64,
) -> Result<Grid, Problems> {
    let most = point_limit(task.profile, targets).0.min(MOST_PLANNED_POINTS);
    let mut least = f64::INFINITY;
    for points in 2..=most {
        let Ok(grid) = grid::with_points(machine, length_digit(task), points) else {
            continue;
        };
        let worst =
            targets.iter().map(|target| tabulate(task, target, &grid).1).fold(0.0, f64::max);
        if worst <= limit_um {
            return Ok(grid);
        }
        least = least.min(worst);
        if grid.spacing_digits <= 1 {
            break;
        }
    }
    let path = format!("compensation.axes.{}.max_residual_um", axis.key());
    Err(task
        .job
        .problem_at(&path, format!("no grid of up to {most} points keeps {limit_um} µm on axis {axis}; the best leaves {least:.3} µm"))
        .help("allow a larger residual, or compensate fewer terms")
        .into())
}

/// Most points of a table for these targets, and of what.
pub(super) fn point_limit(profile: &Profile, targets: &[&Target]) -> (u32, String) {
    let (most, holder) = family(profile).point_limit(targets);
    (most, format!("{holder} of {}", profile.name))
}

fn check_grid(
    task: Task<'_>,
    axis: Axis,
    machine: MachineAxis,
    settings: &AxisSettings,
    grid: &Grid,
    problems: &mut Problems,
) {
    refuse_unmeasured(task, axis, settings, grid, problems);
    let Some(feed) = machine.max_feed else {
        return;
    };
    let least = family(task.profile).least_spacing_mm(feed);
    let spacing = grid.spacing().mm();
    if spacing < least {
        problems.push(
            task.job
                .problem_at(&format!("compensation.axes.{}", axis.key()), format!("a spacing of {spacing} mm is below {least} mm, the smallest that {} takes at {feed} mm/min", task.profile.name))
                .help("use a larger spacing"),
        );
    }
}

/// Points beyond the travel where the control uses none.
fn refuse_beyond(
    task: Task<'_>,
    axis: Axis,
    machine: MachineAxis,
    targets: &[&Target],
    grid: &Grid,
    problems: &mut Problems,
) {
    if family(task.profile).takes_points_beyond() || grid.is_within(machine) {
        return;
    }
    let most = f64::from(point_limit(task.profile, targets).0);
    let travel = (machine.high - machine.low).mm();
    let spacing = grid::ending_with_travel(machine, grid.digit, grid.spacing().mm());
    let help = match spacing.filter(|spacing| travel / spacing + 1.0 <= most + 0.5) {
        Some(spacing) => {
            format!("`spacing_mm = {spacing}` has points at both ends of the travel and none beyond")
        }
        None => "no spacing has points at both ends of this travel: state as `travel_mm` ends that lie whole spacings from the reference point, which lies between them".to_string(),
    };
    let message = format!(
        "the table of axis {axis} would have points beyond the travel, and {} uses none there",
        task.profile.name
    );
    let key = format!("compensation.axes.{}", axis.key());
    problems.push(task.job.problem_at(&key, message).help(help));
}

fn refuse_unmeasured(
    task: Task<'_>,
    axis: Axis,
    settings: &AxisSettings,
    grid: &Grid,
    problems: &mut Problems,
) {
    let Some((low, high)) = task.model.ranges[axis] else {
        return;
    };
    let (first, last) = grid.range();
    let beyond = first.mm() < low.mm() - EDGE_MM || last.mm() > high.mm() + EDGE_MM;
    if beyond && settings.outside == OutsideMeasured::Refuse {
        let path = format!("compensation.axes.{}.outside", axis.key());
        problems.push(
            task.job
                .problem_at(&path, format!("the table of axis {axis} runs from {} to {} mm, but only {} … {} mm was measured", first.mm(), last.mm(), low.mm(), high.mm()))
                .help("measure the whole travel, give `start_mm` and `end_mm`, or hold the end value with `outside = \"hold\"`"),
        );
    }
}

fn note_spacing(axis: Axis, settings: &AxisSettings, grid: &Grid, notes: &mut Vec<Finding>) {
    let spacing = grid.spacing().mm();
    if let Some(GridRequest::Spacing(asked)) = settings.grid
        && (asked - spacing).abs() > 1e-9
    {
        let found = TableFinding::WrittenSpacing {
            axis,
            asked_mm: asked,
            written: as_number(grid.spacing_digits) / grid.digit.per_unit(),
            unit: grid.digit.unit.word(),
            spacing_mm: spacing,
        };
        notes.push(found.into());
    }
}

pub(super) fn tabulate(task: Task<'_>, target: &Target, grid: &Grid) -> (Vec<Deviation>, f64) {
    // The reference node of a table is exactly zero, except for the direction that carries the
    // reversal: its curve is fitted about its own value there.
    let nodes = grid.nodes();
    let homing = task.job.machine.axes[target.term.along].map(|machine| machine.homing());
    let carries_reversal = target.direction.is_some_and(|own| Some(own) != homing);
    let offset = if carries_reversal { target.curve.at(grid.reference) } else { Deviation::ZERO };
    let values: Vec<Deviation> =
        table_values(&target.curve.less(offset), &nodes, task.job.compensation.fit)
            .into_iter()
            .map(|value| Deviation::from_um(value.um() + offset.um()))
            .collect();
    let (low, high) = whole_axis(task, target.term.along, grid);
    let worst = residual(&target.curve, &nodes, &values, low, high);
    (values, worst)
}

fn whole_axis(task: Task<'_>, axis: Axis, grid: &Grid) -> (Millimetres, Millimetres) {
    task.job.machine.axes[axis].map_or_else(|| grid.range(), |machine| (machine.low, machine.high))
}

/// The last digit of positions and spacings in the control's files.
fn length_digit(task: Task<'_>) -> LengthDigit {
    family(task.profile).length_digit(task.job.compensation.control_unit)
}
