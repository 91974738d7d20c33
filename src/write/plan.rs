//! Which table gets which points and values: everything that does not depend on a format.
//!
//! ```text
//!   targets ─→ selection (what the control can hold) ─→ one grid per moving axis
//!           ─→ table values (sample, least squares, minimax) ─→ limits ─→ Plan
//! ```

mod grids;
mod limits;

pub use crate::write::task::{Plan, PlannedTable, Task, axis_pairs};

use crate::control::controller::Profile;
use crate::inputs::job::{BacklashPolicy, Job};
use crate::quantity::{Axis, ErrorTerm, PerAxis};
use crate::text::{Finding, MOST_POINTS, Problem, Problems, grouped};
use crate::write::family::family;
use crate::write::findings::TableFinding;
use crate::write::selection::{self, Choice, Cost, TableStock};
use crate::write::target::{self, Omission, Target, TermTargets};
use crate::write::task::axis_key;
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
        default_names: default_names(task, &names),
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
    let words = format!(
        "no measured term gets a table on {}, so there is nothing to write ({})",
        task.profile.name,
        reasons.collect::<Vec<_>>().join(" · ")
    );
    let problem = task.job.problem_at("compensation.controller", words);
    problem.help("free tables on the control, or compensate terms that need none of them")
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
    limits::check(task, &tables, problems);
    tables
}

const FEWER_POINTS: &str = "use a larger spacing, or `points`, or `max_residual_um`";

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
            let words =
                format!("axis {axis} would have {count} points, more than the {most} of {holder}");
            problems.push(task.job.problem_at(&axis_key(axis, ""), words).help(FEWER_POINTS));
        }
    }
    let points_of = |target: &Target| {
        let points = plan.grids[target.term.along].map_or(0, |grid| grid.count());
        points * plan.names[target.term.of].len()
    };
    let points: usize = targets.iter().map(points_of).sum();
    if points > MOST_POINTS && problems.is_empty() {
        let words =
            format!("the tables would have {points} points, expected at most {MOST_POINTS}");
        problems.push(task.job.problem_at("compensation.axes", words).help(FEWER_POINTS));
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
                let reversal = measured.reversal();
                reversal.map(|b| (-b).um() + 0.0).or(replaced)
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
                let words = format!("[{path}] names an axis that [machine] does not have");
                let problem = job.problem_at(&path, words);
                problems.push(problem.help("add it to [machine.axes], or take it out here"));
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
            let at_id = |words: String| job.problem_at(&axis_key(axis, ".id"), words);
            if let Some(expected) = family(profile).expected_name(name) {
                let words = format!("`{name}` is no axis of this control, expected {expected}");
                problems.push(at_id(words).help("write it as the control shows it"));
            }
            if seen.iter().any(|other| other.eq_ignore_ascii_case(name)) {
                let words =
                    format!("`{name}` names two axes, expected a name of its own for {axis}");
                problems.push(at_id(words).help("correct `id` or `ids`"));
            }
            seen.push(name);
        }
    }
}

fn default_names(task: Task<'_>, names: &PerAxis<Vec<String>>) -> Vec<Axis> {
    let is_default = |axis: &Axis| {
        !names[*axis].is_empty() && task.settings(*axis).is_none_or(|s| s.ids.is_empty())
    };
    Axis::ALL.into_iter().filter(is_default).collect()
}
