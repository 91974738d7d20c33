//! Which table gets which points and values, within the limits of the job: everything that does not depend on a format.
//!
//! ```text
//!   targets ─→ selection (what the control can hold) ─→ one grid per moving axis
//!           ─→ table values (sample, least squares, minimax) ─→ limits ─→ Plan
//! ```

mod grids;

use crate::control::controller::Profile;
use crate::inputs::error_table::Heading;
use crate::inputs::job::{BacklashPolicy, Job, Limits};
use crate::quantity::{Deviation, ErrorTerm, PerAxis, UM_PER_MM};
use crate::text::{Finding, MOST_POINTS, Problem, Problems, grouped, joined};
use crate::write::control_text::trimmed;
use crate::write::family::family;
use crate::write::findings::TableFinding;
use crate::write::refusals;
use crate::write::selection::{self, Choice, Cost, TableStock};
use crate::write::target::{self, Omission, Target, TermTargets};
use crate::write::task::axis_key;
pub use crate::write::task::{Plan, PlannedTable, Task, axis_pairs};
use grids::{grids, point_limit, tabulate};

/// Makes the plan; all problems are given at once, nothing is rounded yet.
pub fn plan(task: Task<'_>) -> Result<Plan, Problems> {
    let mut problems = Problems::none();
    let names = problems.take(axis_names(task.job, task.profile));
    let targets = problems.take(target::targets(task));
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
    notes.splice(0..0, notes_of(&targets).map(Finding::from));
    omitted.sort_by_key(|omission| ErrorTerm::ALL.iter().position(|term| *term == omission.term));
    let all: Vec<Target> = targets.iter().flat_map(|t| t.targets.clone()).collect();
    let grids = problems.take(grids(task, &all, &mut notes));
    let Some(grids) = grids else {
        return Err(problems);
    };
    let mut plan = Plan {
        tables: Vec::new(),
        grids,
        names,
        backlash_um: backlash(task, &targets),
        omitted,
        notes,
    };
    plan.tables = tables(task, all, &plan, &mut problems);
    problems.or_ok(plan)
}

/// What is to be known of the targets, said once for all terms that it holds for: `EYX, EZX: …`.
fn notes_of(targets: &[TermTargets]) -> impl Iterator<Item = TableFinding> {
    let said = targets.iter().filter_map(|target| Some((target.note.clone()?, target.term)));
    grouped(said).into_iter().map(|(note, terms)| TableFinding::OfTarget { terms, note })
}

/// What the selection decided, on targets, omissions and notes.
fn apply(
    choice: Choice,
    targets: &mut Vec<TermTargets>,
    omitted: &mut Vec<Omission>,
    notes: &mut Vec<Finding>,
) {
    targets.retain(|t| !choice.omitted.iter().any(|o| o.term == t.term));
    for (term, why) in choice.reduced {
        if let Some(own) = targets.iter_mut().find(|t| t.term == term) {
            own.take_mean();
        }
        notes.push(why.into());
    }
    omitted.extend(choice.omitted);
}

/// Nothing is left to put into files.
fn no_table(task: Task<'_>, omitted: &[Omission]) -> Problem {
    let reasons = omitted.iter().map(|own| format!("{}: {}", own.term, own.reason));
    let reasons = reasons.collect::<Vec<_>>().join(" · ");
    task.job.source.at("compensation.controller", refusals::no_table(&task.profile.name, reasons))
}

/// Cost of each term in tables the control has few of, and how many it has.
fn costs(
    task: Task<'_>,
    names: &PerAxis<Vec<String>>,
    targets: &[TermTargets],
) -> Option<(Vec<Cost>, TableStock)> {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let budget = family(task.profile).budget(&task.job.compensation)?;
    let is_limited =
        |t: &&TermTargets| t.term.is_cross() || (budget.takes_pairs && t.targets.len() > 1);
    let cost = |t: &TermTargets| {
        let outputs = names[t.term.of].len();
        // The mean of a positioning error goes into ENC_COMP, of which each axis has its own.
        let mean = if t.term.is_positioning() { 0 } else { outputs };
        Cost {
            term: t.term,
            tables: count(outputs * t.targets.len()),
            mean_tables: t.mean.as_ref().map(|_| count(mean)),
        }
    };
    Some((targets.iter().filter(is_limited).map(cost).collect(), budget))
}

/// `first_table` or `first_set` names one that the control does not have.
fn none_left(task: Task<'_>, budget: TableStock) -> Problem {
    let TableStock { tables, resource, key, .. } = budget;
    let wrong = refusals::none_left(key, tables, resource, &task.profile.name);
    task.job.source.at(&format!("compensation.{key}"), wrong)
}

fn tables(
    task: Task<'_>,
    targets: Vec<Target>,
    plan: &Plan,
    problems: &mut Problems,
) -> Vec<PlannedTable> {
    refuse_too_many_points(task, &targets, plan, problems);
    if !problems.is_empty() {
        return Vec::new();
    }
    let planned = targets.into_iter().filter_map(|target| {
        let grid = plan.grids[target.term.along]?;
        let (values, grid_residual_um) = tabulate(task, &target, &grid);
        Some(PlannedTable {
            term: target.term,
            direction: target.direction,
            grid,
            curve: target.curve,
            values,
            grid_residual_um,
        })
    });
    let tables: Vec<PlannedTable> = planned.collect();
    check_limits(task, &tables, problems);
    tables
}

/// Told once for each moving axis; and so many points together that no memory would be enough, whatever the
/// control takes.
fn refuse_too_many_points(
    task: Task<'_>,
    targets: &[Target],
    plan: &Plan,
    problems: &mut Problems,
) {
    for (axis, grid) in plan.grids.iter() {
        let Some(count) = grid.map(|grid| grid.count()) else {
            continue;
        };
        let along = targets.iter().filter(|target| target.term.along == axis);
        let mut limits = along.map(|target| point_limit(task.profile, &[target]));
        if let Some((most, holder)) = limits.find(|(most, _)| count > *most as usize) {
            let wrong = refusals::many_points(axis, count, most, holder);
            problems.push(task.job.source.at(&axis_key(axis, ""), wrong));
        }
    }
    let points_of = |target: &Target| {
        let points = plan.grids[target.term.along].map_or(0, |grid| grid.count());
        points * plan.names[target.term.of].len()
    };
    let points: usize = targets.iter().map(points_of).sum();
    if points > MOST_POINTS && problems.is_empty() {
        let wrong = refusals::many_points_in_all(points, MOST_POINTS);
        problems.push(task.job.source.at("compensation.axes", wrong));
    }
}

fn backlash(task: Task<'_>, targets: &[TermTargets]) -> PerAxis<Option<f64>> {
    PerAxis::from_fn(|axis| {
        let term = ErrorTerm::positioning(axis);
        let own = targets.iter().find(|t| t.term == term)?;
        let measured = task.model.terms[term].as_ref()?;
        let replaced = replaces_backlash(task.profile).then_some(0.0);
        match task.job.compensation.backlash[axis] {
            Some(BacklashPolicy::CurveAndParameter) => {
                measured.reversal().map(|b| (-b).um() + 0.0).or(replaced)
            }
            // One table for two that are equal supposes, as they do, that the parameter is 0.
            Some(BacklashPolicy::TwoTables)
                if own.targets.len() == 1 && target::are_equal(&measured.measured) =>
            {
                Some(0.0)
            }
            _ => replaced,
        }
    })
}

/// Whether a table stands in place of the backlash parameter of its axis.
pub(crate) fn replaces_backlash(profile: &Profile) -> bool {
    family(profile).replaces_backlash()
}

/// How the control names the physical axes: as the job states, else the profile's default. An axis
/// that the machine of the job does not have has no name: what the control calls so is another's.
pub fn axis_names(job: &Job, profile: &Profile) -> Result<PerAxis<Vec<String>>, Problems> {
    let defaults = &profile.axis_names.value;
    let mut problems = Problems::none();
    let names = PerAxis::from_fn(|axis| {
        let stated =
            job.compensation.axes[axis].as_ref().map(|s| s.ids.clone()).unwrap_or_default();
        if job.machine.axes[axis].is_none() {
            if !stated.is_empty() {
                let path = axis_key(axis, "");
                problems.push(job.source.at(&path, refusals::no_such_axis(&path)));
            }
            Vec::new()
        } else if stated.is_empty() {
            vec![defaults[axis as usize].clone()]
        } else {
            stated
        }
    });
    check_names(job, profile, &names, &mut problems);
    problems.or_ok(names)
}

fn check_names(
    job: &Job,
    profile: &Profile,
    names: &PerAxis<Vec<String>>,
    problems: &mut Problems,
) {
    let mut seen: Vec<&String> = Vec::new();
    for (axis, of_axis) in names.iter() {
        for name in of_axis {
            let at_id = |wrong| job.source.at(&axis_key(axis, ".id"), wrong);
            if let Some(expected) = family(profile).expected_name(axis, name) {
                let usual = &profile.axis_names.value[axis as usize];
                problems.push(at_id(refusals::no_axis_name(name, expected, usual)));
            }
            if seen.iter().any(|other| other.eq_ignore_ascii_case(name)) {
                problems.push(at_id(refusals::two_axes(name, axis)));
            }
            seen.push(name);
        }
    }
}

// Corrections and slopes against `[limits]` of the job.
//
// A column whose unit slipped (micrometres under a heading in mm) passes both limits in every
// table; that is one cause, told once, at the heading.

/// No machine tool is off by more, µm: beyond it the unit of the column is the likelier cause.
const NO_MACHINE_UM: f64 = UM_PER_MM;

/// What is asked of a table's steepest and largest value.
struct Extent {
    /// Index of the largest value, and the value.
    largest: (usize, Deviation),
    /// Index of the node before the steepest section, and its slope, µm/mm.
    steepest: (usize, f64),
}

impl Extent {
    fn of(table: &PlannedTable) -> Extent {
        let spacing = table.grid.spacing().mm();
        let slopes = table.values.windows(2).map(|pair| ((pair[1] - pair[0]).um() / spacing).abs());
        let values = table.values.iter().copied().enumerate();
        let largest = values.max_by(|a, b| a.1.um().abs().total_cmp(&b.1.um().abs()));
        Extent {
            largest: largest.unwrap_or((0, Deviation::ZERO)),
            steepest: slopes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0)),
        }
    }

    fn largest_um(&self) -> f64 {
        self.largest.1.um().abs()
    }

    /// Whether values that are `share` of these keep the limits.
    fn keeps(&self, limits: Limits, share: f64) -> bool {
        self.largest_um() * share <= limits.max_correction_um
            && self.steepest.1 * share <= limits.max_slope_um_per_mm
    }
}

/// Refuses tables beyond the limits of the job: a slip of a column's unit once for each file, all
/// else table by table.
fn check_limits(task: Task<'_>, tables: &[PlannedTable], problems: &mut Problems) {
    let limits = task.job.limits;
    let extents = tables.iter().map(|table| (table, Extent::of(table)));
    let beyond: Vec<(&PlannedTable, Extent)> =
        extents.filter(|(_, extent)| !extent.keeps(limits, 1.0)).collect();
    let no_machine = |(_, extent): &&(_, Extent)| extent.largest_um() > NO_MACHINE_UM;
    let is_likely = beyond.iter().any(|each| no_machine(&each));
    let mut slipped: Vec<(&String, (&Heading, &Extent))> = Vec::new();
    for (table, extent) in &beyond {
        match heading(task, table, extent).filter(|_| is_likely) {
            Some(heading) => slipped.push((&heading.place.file, (heading, extent))),
            None => check_table(task, table, extent, problems),
        }
    }
    for (_, own) in grouped(slipped) {
        problems.push(unit_slip(limits, own));
    }
}

/// The heading of a table's values, where they would keep the limits if its unit were the micrometre.
fn heading<'a>(task: Task<'a>, table: &PlannedTable, extent: &Extent) -> Option<&'a Heading> {
    let heading = task.model.headings[table.term].as_ref()?;
    let is_slip = heading.to_um > 1.0 && extent.keeps(task.job.limits, 1.0 / heading.to_um);
    is_slip.then_some(heading)
}

/// One sentence for all columns of a file.
fn unit_slip(limits: Limits, slipped: Vec<(&Heading, &Extent)>) -> Problem {
    let mut headings: Vec<&Heading> = slipped.iter().map(|(heading, _)| *heading).collect();
    headings.sort_by_key(|heading| heading.place.column);
    headings.dedup_by_key(|heading| heading.place.column);
    let names = |name: &dyn Fn(&Heading) -> String| {
        joined(headings.iter().map(|heading| format!("`{}`", name(heading))))
    };
    let largest = |a: &f64, b: &f64| a.total_cmp(b);
    let corrections = slipped.iter().map(|(_, e)| e.largest_um());
    let slopes = slipped.iter().map(|(_, e)| e.steepest.1);
    let (um, slope) =
        (corrections.max_by(largest).unwrap_or(0.0), slopes.max_by(largest).unwrap_or(0.0));
    let Limits { max_correction_um: most_um, max_slope_um_per_mm: steepest, .. } = limits;
    let (own, in_um) = (names(&|own| own.name.clone()), names(&Heading::in_micrometres));
    let mut problem = refusals::slip_of_unit(own, um, slope, most_um, steepest, in_um);
    problem.place = headings.first().map(|first| first.place.clone());
    problem
}

fn check_table(task: Task<'_>, table: &PlannedTable, extent: &Extent, problems: &mut Problems) {
    let limits = task.job.limits;
    // A limit that is not stated has no line of its own.
    let section = axis_key(table.term.along, "");
    let at_limit = |key: &str, wrong| {
        let path = format!("limits.{key}");
        let stated = task.job.source.place_of(&path).is_some();
        task.job.source.at(if stated { &path } else { &section }, wrong)
    };
    let place = |index: usize| {
        let grid = &table.grid;
        let index = grid.first + i64::try_from(index).unwrap_or(0);
        trimmed(grid.position(index).mm(), 6)
    };
    let (index, value) = extent.largest;
    if extent.largest_um() > limits.max_correction_um {
        let first = match extent.largest_um() > NO_MACHINE_UM {
            true => "is the unit of the column right?",
            false => "check the measurement;",
        };
        let (um, most_um) = ((-value).um(), limits.max_correction_um);
        let wrong = refusals::large_correction(table.term, um, place(index), most_um, first);
        problems.push(at_limit("max_correction_um", wrong));
    }
    let (index, slope) = extent.steepest;
    if slope > limits.max_slope_um_per_mm {
        let (from, to, most) = (place(index), place(index + 1), limits.max_slope_um_per_mm);
        let wrong = refusals::large_slope(table.term, slope, from, to, most);
        problems.push(at_limit("max_slope_um_per_mm", wrong));
    }
}
