//! Which table gets which points and values: everything that does not depend on a format.
//!
//! ```text
//!   targets ─→ selection (what the control can hold) ─→ one grid per moving axis
//!           ─→ table values (sample, least squares, minimax) ─→ limits ─→ Plan
//! ```

use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::controller::{Dialect, Profile};
use crate::curve::ErrorCurve;
use crate::fit::{residual, table_values};
use crate::grid::{self, EDGE_MM, Grid, LengthDigit};
use crate::job::ahead::{GRID_HELP, UNIT_HELP, without_grid, without_unit};
use crate::job::{AxisSettings, BacklashPolicy, GridRequest, Job, MachineAxis, OutsideMeasured};
use crate::model::ErrorModel;
use crate::problem::{Problem, Problems};
use crate::selection::{self, Budget, Choice, Cost};
use crate::target::{self, Omission, Target, TermTargets};
use crate::units::{Deviation, Millimetres};

/// One table, before it is put into a control's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedTable {
    /// Which error.
    pub term: ErrorTerm,
    /// Direction of the moving axis it acts in; `None` = both.
    pub direction: Option<Direction>,
    /// Its points.
    pub grid: Grid,
    /// The deviation to cancel.
    pub curve: ErrorCurve,
    /// The deviation that each point of the table stands for, unrounded.
    pub values: Vec<Deviation>,
    /// Largest difference of curve and unrounded table over the whole axis, µm.
    pub grid_residual_um: f64,
}

/// All tables of a kit, before they are put into a control's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The tables, in the contract's order of terms.
    pub tables: Vec<PlannedTable>,
    /// The points of each moving axis.
    pub grids: PerAxis<Option<Grid>>,
    /// The control's names of the physical axes.
    pub names: PerAxis<Vec<String>>,
    /// Axes whose names are the profile's default.
    pub default_names: Vec<Axis>,
    /// Value of the backlash parameter (−B) of each axis, µm, where the policy names one.
    pub backlash_um: PerAxis<Option<f64>>,
    /// Terms that get no table: not wanted, not determined, or beyond what the control holds.
    pub omitted: Vec<Omission>,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl Plan {
    /// Whether the tables name the backlash parameter of an axis: 0 with two tables, else −B.
    pub fn sets_backlash(&self, axis: Axis) -> bool {
        let two_tables = |t: &PlannedTable| {
            t.term.is_positioning() && t.term.of == axis && t.direction.is_some()
        };
        self.backlash_um[axis].is_some() || self.tables.iter().any(two_tables)
    }
}

/// What a plan is made from.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The job.
    pub job: &'a Job,
    /// The control.
    pub profile: &'a Profile,
    /// The measured errors.
    pub model: &'a ErrorModel,
}

impl Task<'_> {
    /// Settings and machine data of an axis that moves or is corrected.
    pub fn axis(&self, axis: Axis) -> Option<(MachineAxis, &AxisSettings)> {
        Some((
            self.job.machine.axes[axis]?,
            self.job.compensation.axes[axis].as_ref()?,
        ))
    }

    /// The last digit of positions and spacings in the control's files.
    pub fn length_digit(&self) -> LengthDigit {
        let unit = self.job.compensation.control_unit;
        let decimals = match &self.profile.dialect {
            Dialect::Siemens(facts) => facts.position_decimals.value,
            Dialect::Fanuc(facts) => match unit {
                crate::controller::LengthUnit::Millimetre => facts.interval_decimals_mm.value,
                crate::controller::LengthUnit::Inch => facts.interval_decimals_inch.value,
            },
            Dialect::Generic(_) => GENERIC_POSITION_DECIMALS,
        };
        let unit = match &self.profile.dialect {
            Dialect::Generic(_) => crate::controller::LengthUnit::Millimetre,
            _ => unit,
        };
        LengthDigit { unit, decimals }
    }
}

/// The generic table has positions in mm with nanometres.
const GENERIC_POSITION_DECIMALS: u32 = 6;

/// Makes the plan; all problems are given at once, nothing is rounded yet.
pub fn plan(task: Task<'_>) -> Result<Plan, Problems> {
    let mut problems = Problems::none();
    let names = problems.take(axis_names(task.job, task.profile));
    let targets = problems.take(target::targets(task.job, task.profile, task.model));
    let (Some(names), Some((mut targets, mut omitted))) = (names, targets) else {
        return Err(problems);
    };
    let mut notes = Vec::new();
    if let Some((costs, budget)) = costs(task, &names, &targets) {
        if budget.used > budget.tables && !costs.is_empty() {
            problems.push(none_left(task, budget));
            return Err(problems);
        }
        if let Some(choice) = selection::choose(task.model, &targets, &costs, budget) {
            apply(choice, &mut targets, &mut omitted, &mut notes);
        }
    }
    if targets.is_empty() {
        problems.push(no_table(task, &omitted));
        return Err(problems);
    }
    notes.splice(0..0, targets.iter().filter_map(|t| t.note.clone()));
    omitted.sort_by_key(|omission| {
        ErrorTerm::ALL
            .iter()
            .position(|term| *term == omission.term)
    });
    let all: Vec<Target> = targets.iter().flat_map(|t| t.targets.clone()).collect();
    let grids = problems.take(grids(task, &all, &mut notes));
    let Some(grids) = grids else {
        return Err(problems);
    };
    let tables = tables(task, all, &grids, &mut problems);
    let backlash_um = backlash(task, &targets);
    problems.or_ok(Plan {
        tables,
        grids,
        default_names: default_names(task, &names),
        names,
        backlash_um,
        omitted,
        notes,
    })
}

/// What the selection decided, on targets, omissions and notes.
fn apply(
    choice: Choice,
    targets: &mut Vec<TermTargets>,
    omitted: &mut Vec<Omission>,
    notes: &mut Vec<String>,
) {
    targets.retain(|t| !choice.omitted.iter().any(|o| o.term == t.term));
    for reduction in choice.reduced {
        if let Some(own) = targets.iter_mut().find(|t| t.term == reduction.term) {
            own.take_mean();
        }
        notes.push(reduction.reason);
    }
    omitted.extend(choice.omitted);
}

/// Nothing is left to put into files.
fn no_table(task: Task<'_>, omitted: &[Omission]) -> Problem {
    let reasons: Vec<String> = omitted
        .iter()
        .map(|omission| format!("{}: {}", omission.term, omission.reason))
        .collect();
    task.job
        .problem_at(
            "compensation.controller",
            format!(
                "no measured term gets a table on {}, so there is nothing to write ({})",
                task.profile.name,
                reasons.join(" · ")
            ),
        )
        .help("free tables on the control, or compensate terms that need none of them")
}

/// How the control names the physical axes: as the job states, else the profile's default.
pub fn axis_names(job: &Job, profile: &Profile) -> Result<PerAxis<Vec<String>>, Problems> {
    let defaults = &profile.axis_names.value;
    let mut problems = Problems::none();
    let names = PerAxis::from_fn(|axis| {
        let stated = job.compensation.axes[axis]
            .as_ref()
            .map(|s| s.ids.clone())
            .unwrap_or_default();
        if stated.is_empty() {
            let index = Axis::ALL.iter().position(|a| *a == axis).unwrap_or(0);
            vec![defaults[index].clone()]
        } else {
            stated
        }
    });
    let mut seen: Vec<&String> = Vec::new();
    for (axis, of_axis) in names.iter() {
        for name in of_axis {
            let path = format!("compensation.axes.{}.id", axis.key());
            if let Some(expected) = refused_name(profile, name) {
                problems.push(
                    job.problem_at(
                        &path,
                        format!("`{name}` is no axis of this control, expected {expected}"),
                    )
                    .help("write it as the control shows it"),
                );
            }
            if seen.iter().any(|other| other.eq_ignore_ascii_case(name)) {
                problems.push(
                    job.problem_at(
                        &path,
                        format!("`{name}` names two axes, expected a name of its own for {axis}"),
                    )
                    .help("correct `id` or `ids`"),
                );
            }
            seen.push(name);
        }
    }
    problems.or_ok(names)
}

/// The pairs (base, output) of physical axes that a term concerns: each axis of a gantry is
/// corrected, the first one is looked up.
pub fn axis_pairs(names: &PerAxis<Vec<String>>, term: ErrorTerm) -> Vec<(&str, &str)> {
    names[term.of]
        .iter()
        .map(|output| {
            let base = if term.is_positioning() {
                output
            } else {
                &names[term.along][0]
            };
            (base.as_str(), output.as_str())
        })
        .collect()
}

fn refused_name(profile: &Profile, name: &str) -> Option<&'static str> {
    let upper = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    match &profile.dialect {
        Dialect::Fanuc(_) => {
            let number: Option<u32> = name.parse().ok();
            let plain = name.chars().all(|c| c.is_ascii_digit()) && !name.starts_with('0');
            (!plain || number.is_none_or(|n| n > 99))
                .then_some("the number of a controlled axis, e.g. \"1\"")
        }
        Dialect::Siemens(_) => {
            let starts = name.chars().next().is_some_and(|c| c.is_ascii_uppercase());
            (!starts || !name.chars().all(upper))
                .then_some("a machine axis name in capitals, e.g. \"AX1\"")
        }
        Dialect::Generic(_) => None,
    }
}

fn default_names(task: Task<'_>, names: &PerAxis<Vec<String>>) -> Vec<Axis> {
    let is_default = |axis: Axis| {
        task.job.compensation.axes[axis]
            .as_ref()
            .is_none_or(|s| s.ids.is_empty())
    };
    names
        .iter()
        .map(|(axis, _)| axis)
        .filter(|axis| is_default(*axis))
        .collect()
}

/// Cost of each term in tables the control has few of, and how many it has.
fn costs(
    task: Task<'_>,
    names: &PerAxis<Vec<String>>,
    targets: &[TermTargets],
) -> Option<(Vec<Cost>, Budget)> {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let budget = budget(task)?;
    let siemens = matches!(task.profile.dialect, Dialect::Siemens(_));
    let costs = targets
        .iter()
        .filter(|t| t.term.is_cross() || (siemens && t.targets.len() > 1))
        .map(|t| {
            let outputs = names[t.term.of].len();
            // The mean of a positioning error goes into ENC_COMP, of which each axis has its own.
            let mean = if t.term.is_positioning() { 0 } else { outputs };
            Cost {
                term: t.term,
                tables: count(outputs * t.targets.len()),
                mean_tables: t.mean.as_ref().map(|_| count(mean)),
            }
        })
        .collect();
    Some((costs, budget))
}

/// The tables that a control has few of; `None` where it has enough for everything.
fn budget(task: Task<'_>) -> Option<Budget> {
    let compensation = &task.job.compensation;
    match &task.profile.dialect {
        Dialect::Siemens(facts) => Some(Budget {
            tables: facts.cec_tables.value,
            used: compensation.first_table.unwrap_or(0),
            resource: "CEC tables",
            key: "first_table",
        }),
        Dialect::Fanuc(facts) => Some(Budget {
            tables: facts.straightness_sets.value,
            used: compensation.first_set.unwrap_or(1).saturating_sub(1),
            resource: "straightness sets",
            key: "first_set",
        }),
        Dialect::Generic(_) => None,
    }
}

/// `first_table` or `first_set` names one that the control does not have.
fn none_left(task: Task<'_>, budget: Budget) -> Problem {
    let Budget {
        tables,
        resource,
        key,
        ..
    } = budget;
    task.job
        .problem_at(
            &format!("compensation.{key}"),
            format!(
                "`{key}` lies behind the {tables} {resource} of {}, expected a smaller number",
                task.profile.name
            ),
        )
        .help("give the number of the first one that is free on the control")
}

fn grids(
    task: Task<'_>,
    targets: &[Target],
    notes: &mut Vec<String>,
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
            problems.push(
                task.job
                    .problem_at(&path, without_grid(axis, &path))
                    .help(GRID_HELP),
            );
        }
        let unit_missing = settings.is_none_or(|s| s.detection_unit_um.is_none());
        if (moves || corrected) && task.profile.detection_unit_required.value && unit_missing {
            problems.push(
                task.job
                    .problem_at(&path, without_unit(&path, &task.profile.name))
                    .help(UNIT_HELP),
            );
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
    let digit = task.length_digit();
    let path = |key: &str| format!("compensation.axes.{}.{key}", axis.key());
    let request = settings.grid.unwrap_or(GridRequest::Points(2));
    let ends_given = settings.start_mm.is_some() || settings.end_mm.is_some();
    if ends_given && !matches!(request, GridRequest::Spacing(_)) {
        let key = if settings.start_mm.is_some() {
            "start_mm"
        } else {
            "end_mm"
        };
        return Err(task
            .job
            .problem_at(
                &path(key),
                format!("`{key}` needs a grid of stated spacing"),
            )
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
    let most = point_limit(task.profile, targets)
        .0
        .min(MOST_PLANNED_POINTS);
    let mut least = f64::INFINITY;
    for points in 2..=most {
        let Ok(grid) = grid::with_points(machine, task.length_digit(), points) else {
            continue;
        };
        let worst = targets
            .iter()
            .map(|target| tabulate(task, target, &grid).1)
            .fold(0.0, f64::max);
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

/// Most points of a table for these targets, and why.
fn point_limit(profile: &Profile, targets: &[&Target]) -> (u32, String) {
    let crosses = targets.iter().any(|t| t.term.is_cross());
    let directed = targets.iter().any(|t| t.direction.is_some());
    let name = &profile.name;
    match &profile.dialect {
        Dialect::Siemens(facts) => {
            let lec = targets
                .iter()
                .any(|t| t.term.is_positioning() && t.direction.is_none());
            let cec = crosses || directed;
            match (lec, cec) {
                (true, true) => (
                    facts.lec_points.value.min(facts.cec_points.value),
                    format!("a CEC table of {name}"),
                ),
                (false, true) => (facts.cec_points.value, format!("a CEC table of {name}")),
                _ => (
                    facts.lec_points.value,
                    format!("an ENC_COMP table of {name}"),
                ),
            }
        }
        Dialect::Fanuc(facts) => {
            let space = facts
                .pitch_points
                .value
                .iter()
                .map(|r| r.last - r.first + 1)
                .max()
                .unwrap_or(0);
            if crosses {
                (
                    facts.straightness_axis_points.value.min(space),
                    format!("the moving axis of a straightness compensation of {name}"),
                )
            } else {
                (space, format!("the pitch points of {name}"))
            }
        }
        Dialect::Generic(facts) => (facts.points.value, format!("a table of {name}")),
    }
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
    if let (Dialect::Fanuc(facts), Some(feed)) = (&task.profile.dialect, machine.max_feed) {
        let least = feed / facts.interval_feed_divisor.value;
        let spacing = grid.spacing().mm();
        if spacing < least {
            problems.push(
                task.job
                    .problem_at(&format!("compensation.axes.{}", axis.key()), format!("a spacing of {spacing} mm is below {least} mm, the smallest that {} takes at {feed} mm/min", task.profile.name))
                    .help("use a larger spacing"),
            );
        }
    }
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

fn note_spacing(axis: Axis, settings: &AxisSettings, grid: &Grid, notes: &mut Vec<String>) {
    let spacing = grid.spacing().mm();
    if let Some(GridRequest::Spacing(asked)) = settings.grid
        && (asked - spacing).abs() > 1e-9
    {
        let per_unit = grid.digit.per_unit();
        #[allow(
            clippy::cast_precision_loss,
            reason = "spacings are far below 2^52 digits"
        )]
        let written = grid.spacing_digits as f64 / per_unit;
        notes.push(format!(
            "{axis}: the control writes a spacing of {asked} mm as {written} {} = {spacing:.6} mm; points and values are those of the written spacing",
            grid.digit.unit.word()
        ));
    }
}

fn tabulate(task: Task<'_>, target: &Target, grid: &Grid) -> (Vec<Deviation>, f64) {
    // The reference node of a table is exactly zero, except for the direction that carries the
    // reversal: its curve is fitted about its own value there.
    let nodes = grid.nodes();
    let homing = task.job.machine.axes[target.term.along].map(|machine| machine.homing());
    let carries_reversal = target.direction.is_some_and(|own| Some(own) != homing);
    let offset = if carries_reversal {
        target.curve.at(grid.reference)
    } else {
        Deviation::ZERO
    };
    let values: Vec<Deviation> = table_values(
        &target.curve.less(offset),
        &nodes,
        task.job.compensation.fit,
    )
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

fn tables(
    task: Task<'_>,
    targets: Vec<Target>,
    grids: &PerAxis<Option<Grid>>,
    problems: &mut Problems,
) -> Vec<PlannedTable> {
    let mut tables = Vec::new();
    let mut limited: Vec<Axis> = Vec::new();
    for target in &targets {
        let Some(grid) = grids[target.term.along] else {
            continue;
        };
        let (most, holder) = point_limit(task.profile, &[target]);
        if grid.count() > most as usize && !limited.contains(&target.term.along) {
            limited.push(target.term.along);
            let path = format!("compensation.axes.{}", target.term.along.key());
            problems.push(
                task.job
                    .problem_at(
                        &path,
                        format!(
                            "axis {} would have {} points, more than the {most} of {holder}",
                            target.term.along,
                            grid.count()
                        ),
                    )
                    .help("use a larger spacing, or `points`, or `max_residual_um`"),
            );
        }
    }
    if !limited.is_empty() {
        return tables;
    }
    for target in targets {
        let Some(grid) = grids[target.term.along] else {
            continue;
        };
        let (values, grid_residual_um) = tabulate(task, &target, &grid);
        check_limits(task, &target, &grid, &values, problems);
        tables.push(PlannedTable {
            term: target.term,
            direction: target.direction,
            grid,
            curve: target.curve,
            values,
            grid_residual_um,
        });
    }
    tables
}

fn check_limits(
    task: Task<'_>,
    target: &Target,
    grid: &Grid,
    values: &[Deviation],
    problems: &mut Problems,
) {
    let limits = task.job.limits;
    // A limit that is not stated has no line of its own.
    let section = format!("compensation.axes.{}", target.term.along.key());
    let at_limit = |key: &str, message: String| {
        let path = format!("limits.{key}");
        let stated = task.job.source.place_of(&path).is_some();
        let path = if stated { &path } else { &section };
        task.job.problem_at(path, message)
    };
    let place = |index: usize| {
        grid.position(grid.first + i64::try_from(index).unwrap_or(0))
            .mm()
    };
    let largest = values
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.um().abs().total_cmp(&b.1.um().abs()));
    if let Some((index, value)) = largest
        && value.um().abs() > limits.max_correction_um
    {
        let um = value.um();
        let help = if um.abs() > 1000.0 {
            "is the unit of the column right (µm in a column named mm)? else raise `max_correction_um` in [limits]"
        } else {
            "check the measurement; else raise `max_correction_um` in [limits]"
        };
        problems.push(
            at_limit(
                "max_correction_um",
                format!(
                    "{} would need a correction of {:.1} µm at {} mm, the limit is {} µm",
                    target.term,
                    (-*value).um(),
                    place(index),
                    limits.max_correction_um
                ),
            )
            .help(help),
        );
    }
    let spacing = grid.spacing().mm();
    let steepest = values
        .windows(2)
        .map(|pair| ((pair[1] - pair[0]).um() / spacing).abs())
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((index, slope)) = steepest
        && slope > limits.max_slope_um_per_mm
    {
        problems.push(
            at_limit("max_slope_um_per_mm", format!("{} would change by {slope:.3} µm/mm between {} and {} mm, the limit is {} µm/mm", target.term, place(index), place(index + 1), limits.max_slope_um_per_mm))
                .help("check the unit and the measurement there; else raise `max_slope_um_per_mm` in [limits]"),
        );
    }
}

fn backlash(task: Task<'_>, targets: &[TermTargets]) -> PerAxis<Option<f64>> {
    PerAxis::from_fn(|axis| {
        let term = ErrorTerm {
            of: axis,
            along: axis,
        };
        let compensated = targets.iter().any(|t| t.term == term);
        if !compensated || task.job.compensation.backlash != Some(BacklashPolicy::CurveAndParameter)
        {
            return None;
        }
        let reversal = task.model.terms[term].as_ref()?.reversal()?;
        Some((-reversal).um())
    })
}
