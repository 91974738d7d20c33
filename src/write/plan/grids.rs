//! The points of each moving axis, and what the tables hold there.

use crate::control::controller::Profile;
use crate::inputs::job::{
    AxisSettings, GridRequest, MachineAxis, OutsideMeasured, without_grid, without_unit,
};
use crate::quantity::{Axis, Deviation, Figure, Millimetres, PerAxis, residual, table_values};
use crate::text::{Finding, Problem, Problems};
use crate::write::family::family;
use crate::write::findings::TableFinding;
use crate::write::grid::{self, EDGE_MM, Grid, LengthDigit};
use crate::write::refusals;
use crate::write::task::{Target, Task, axis_key};

pub(super) fn grids(
    task: Task<'_>,
    targets: &[Target],
    notes: &mut Vec<Finding>,
) -> Result<PerAxis<Option<Grid>>, Problems> {
    let mut problems = Problems::none();
    let mut grids = PerAxis::default();
    check_settings(task, targets, &mut problems);
    for axis in Axis::ALL {
        let targets: Vec<&Target> = targets.iter().filter(|t| t.term.along == axis).collect();
        let Some((machine, settings)) = task.axis(axis).filter(|_| !targets.is_empty()) else {
            continue;
        };
        let moving = Moving { task, axis, machine, settings, targets };
        if let Some(grid) = problems.take(moving.grid()) {
            let wrong = [moving.unmeasured(&grid), moving.too_fine(&grid), moving.beyond(&grid)];
            wrong.into_iter().flatten().for_each(|problem| problems.push(problem));
            notes.extend(moving.written_spacing(&grid).map(Finding::from));
            grids[axis] = Some(grid);
        }
    }
    problems.or_ok(grids)
}

fn check_settings(task: Task<'_>, targets: &[Target], problems: &mut Problems) {
    for axis in Axis::ALL {
        let moves = targets.iter().any(|t| t.term.along == axis);
        let corrected = targets.iter().any(|t| t.term.of == axis);
        let settings = task.settings(axis);
        let path = axis_key(axis, "");
        if moves && settings.is_none_or(|s| s.grid.is_none()) {
            problems.push(task.job.source.at(&path, without_grid(axis, &path)));
        }
        let unit_missing = settings.is_none_or(|s| s.detection_unit_um.is_none());
        if (moves || corrected) && task.profile.detection_unit_required.value && unit_missing {
            problems.push(task.job.source.at(&path, without_unit(&path, &task.profile.name)));
        }
        if corrected && task.job.machine.axes[axis].is_none() {
            let wrong = refusals::corrected_axis_missing(axis, axis.key());
            problems.push(task.job.source.at("machine.axes", wrong));
        }
    }
}

/// Every number of points is tried, so the work grows with the square of this; a table with more
/// points is not what `max_residual_um` is for.
const MOST_PLANNED_POINTS: u32 = 2000;

/// Most points of a table for these targets, and of what.
pub(super) fn point_limit(profile: &Profile, targets: &[&Target]) -> (u32, String) {
    let (most, holder) = family(profile).point_limit(targets);
    (most, format!("{holder} of {}", profile.name))
}

/// A moving axis with all that is looked up along it.
struct Moving<'a> {
    task: Task<'a>,
    axis: Axis,
    machine: MachineAxis,
    settings: &'a AxisSettings,
    targets: Vec<&'a Target>,
}

impl Moving<'_> {
    fn at(&self, key: &str, wrong: Problem) -> Problem {
        self.task.job.source.at(&axis_key(self.axis, key), wrong)
    }

    fn grid(&self) -> Result<Grid, Problems> {
        let Moving { task, axis, machine, settings, .. } = self;
        let digit = length_digit(*task);
        let request = settings.grid.unwrap_or(GridRequest::Points(2));
        let ends = [("start_mm", settings.start_mm), ("end_mm", settings.end_mm)];
        let stated = ends.into_iter().find(|(_, mm)| mm.is_some());
        match (request, stated) {
            (GridRequest::Spacing(spacing), _) => {
                grid::with_spacing(task.job, *axis, *machine, settings, digit, spacing)
            }
            (_, Some((key, _))) => {
                Err(self.at(&format!(".{key}"), refusals::needs_spacing(key)).into())
            }
            (GridRequest::Points(points), None) => grid::with_points(*machine, digit, points)
                .map_err(|mut problem| {
                    problem.place = task.job.source.place_of(&axis_key(*axis, ".points"));
                    problem.into()
                }),
            (GridRequest::MaxResidual(limit_um), None) => self.coarsest(limit_um),
        }
    }

    /// The grid of the fewest points whose own residual (before rounding) keeps the limit for every
    /// term of the axis.
    fn coarsest(&self, limit_um: f64) -> Result<Grid, Problems> {
        let task = self.task;
        let most = point_limit(task.profile, &self.targets).0.min(MOST_PLANNED_POINTS);
        let mut least = f64::INFINITY;
        for points in 2..=most {
            let Ok(grid) = grid::with_points(self.machine, length_digit(task), points) else {
                continue;
            };
            let residuals = self.targets.iter().map(|target| tabulate(task, target, &grid).1);
            let worst = residuals.fold(0.0, f64::max);
            if worst <= limit_um {
                return Ok(grid);
            }
            least = least.min(worst);
            if grid.spacing_digits <= 1 {
                break;
            }
        }
        let wrong = refusals::no_grid(most, limit_um, self.axis, least);
        Err(self.at(".max_residual_um", wrong).into())
    }

    fn too_fine(&self, grid: &Grid) -> Option<Problem> {
        let (feed, profile) = (self.machine.max_feed?, self.task.profile);
        let (least, spacing) = (family(profile).least_spacing_mm(feed), grid.spacing().mm());
        let wrong = || refusals::small_spacing(spacing, least, &profile.name, feed);
        (spacing < least).then(|| self.at("", wrong()))
    }

    /// Points beyond the travel where the control uses none.
    fn beyond(&self, grid: &Grid) -> Option<Problem> {
        let Moving { task, axis, machine, targets, .. } = self;
        if family(task.profile).takes_points_beyond() || grid.is_within(*machine) {
            return None;
        }
        let most = f64::from(point_limit(task.profile, targets).0);
        let travel = (machine.high - machine.low).mm();
        let spacing = grid::ending_with_travel(*machine, grid.digit, grid.spacing().mm());
        let spacing = spacing.filter(|spacing| travel / spacing + 1.0 <= most + 0.5);
        let name = &task.profile.name;
        Some(self.at(
            "",
            match spacing {
                Some(mm) => refusals::beyond_with_spacing(axis, name, Figure(mm).trimmed(6)),
                None => refusals::beyond(axis, name),
            },
        ))
    }

    fn unmeasured(&self, grid: &Grid) -> Option<Problem> {
        let (low, high) = self.task.model.ranges[self.axis]?;
        let (first, last) = grid.range();
        let beyond = first.mm() < low.mm() - EDGE_MM || last.mm() > high.mm() + EDGE_MM;
        let [first, last, low, high] = [first, last, low, high].map(Millimetres::mm);
        (beyond && self.settings.outside == OutsideMeasured::Refuse)
            .then(|| self.at(".outside", refusals::not_measured(self.axis, first, last, low, high)))
    }

    fn written_spacing(&self, grid: &Grid) -> Option<TableFinding> {
        let spacing_mm = grid.spacing().mm();
        let Some(GridRequest::Spacing(asked_mm)) = self.settings.grid else {
            return None;
        };
        ((asked_mm - spacing_mm).abs() > 1e-9).then(|| TableFinding::WrittenSpacing {
            axis: self.axis,
            asked_mm,
            written: grid.written_spacing(),
            unit: grid.digit.unit.word(),
            spacing_mm,
        })
    }
}

pub(super) fn tabulate(task: Task<'_>, target: &Target, grid: &Grid) -> (Vec<Deviation>, f64) {
    // The reference node of a table is exactly zero, except for the direction that carries the
    // reversal: its curve is fitted about its own value there.
    let nodes = grid.nodes();
    let machine = task.job.machine.axes[target.term.along];
    let homing = machine.map(|machine| machine.homing());
    let carries_reversal = target.direction.is_some_and(|own| Some(own) != homing);
    let offset = if carries_reversal { target.curve.at(grid.reference) } else { Deviation::ZERO };
    let values: Vec<Deviation> =
        table_values(&target.curve.less(offset), &nodes, task.job.compensation.fit)
            .into_iter()
            .map(|value| Deviation::from_um(value.um() + offset.um()))
            .collect();
    let (low, high) = machine.map_or_else(|| grid.range(), |machine| (machine.low, machine.high));
    let worst = residual(&target.curve, &nodes, &values, low, high);
    (values, worst)
}

/// The last digit of positions and spacings in the control's files.
fn length_digit(task: Task<'_>) -> LengthDigit {
    family(task.profile).length_digit(task.job.compensation.control_unit)
}
