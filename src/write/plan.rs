//! Which table gets which points and values: everything that does not depend on a format.
//!
//! ```text
//!   targets ─→ selection (what the control can hold) ─→ one grid per moving axis
//!           ─→ table values (sample, least squares, minimax) ─→ limits ─→ Plan
//! ```

mod grids;
mod limits;
mod names;
mod task;

pub use self::task::{PlannedTable, Task};

pub use names::{axis_names, axis_pairs};

use crate::control::controller::Dialect;
use crate::inputs::job::BacklashPolicy;
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis};
use crate::text::document::MOST_ROWS;
use crate::text::problem::{Problem, Problems};
use crate::write::grid::Grid;
use crate::write::selection::{self, Budget, Choice, Cost};
use crate::write::target::{self, Omission, Target, TermTargets};
use grids::{grids, point_limit, tabulate};
use names::default_names;

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
    pub(crate) fn sets_backlash(&self, axis: Axis) -> bool {
        let two_tables = |t: &PlannedTable| {
            t.term.is_positioning() && t.term.of == axis && t.direction.is_some()
        };
        self.backlash_um[axis].is_some() || self.tables.iter().any(two_tables)
    }
}

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
    refuse_too_many_rows(task, &all, &names, &grids)?;
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
        tables.push(PlannedTable {
            term: target.term,
            direction: target.direction,
            grid,
            curve: target.curve,
            values,
            grid_residual_um,
        });
    }
    limits::check(task, &tables, problems);
    tables
}

/// A generic table with more rows than its reader takes is not written.
fn refuse_too_many_rows(
    task: Task<'_>,
    targets: &[Target],
    names: &PerAxis<Vec<String>>,
    grids: &PerAxis<Option<Grid>>,
) -> Result<(), Problem> {
    let Dialect::Generic(_) = &task.profile.dialect else {
        return Ok(());
    };
    let rows_of = |target: &Target| {
        let points = grids[target.term.along].map_or(0, |grid| grid.count());
        points * names[target.term.of].len()
    };
    let rows: usize = targets.iter().map(rows_of).sum();
    if rows <= MOST_ROWS {
        return Ok(());
    }
    let words = format!("the table would have {rows} rows, expected at most {MOST_ROWS}");
    Err(task
        .job
        .problem_at("compensation.axes", words)
        .help("use a larger spacing, or `points`, or `max_residual_um`"))
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
