//! Point numbers: which axis gets which, without overlap.

use crate::control::controller::{FanucFacts, NumberRange, StraightnessForm};
use crate::quantity::Axis;
use crate::text::{Problem, Problems, joined};
use crate::write::grid::Grid;
use crate::write::refusals;
use crate::write::task::{Plan, Task, axis_key};

/// The pitch points of one physical axis.
pub(super) struct Run {
    /// The axis of the machine.
    pub(super) axis: Axis,
    /// Number of the controlled axis.
    pub(super) id: u32,
    /// Its grid.
    pub(super) grid: Grid,
    /// Node of the first point (point `first` is the section that ends at this node).
    pub(super) lowest: i64,
    /// Number of points.
    pub(super) count: u32,
    /// First point number (3621).
    pub(super) first: u32,
    /// First point number of the table for travel in − (3626).
    pub(super) minus_first: Option<u32>,
}

impl Run {
    /// Last point number (3622).
    pub(super) fn last(&self) -> u32 {
        self.first + self.count - 1
    }

    /// Point number of the section that ends at a node.
    pub(super) fn point(&self, node: i64) -> u32 {
        u32::try_from(i64::from(self.first) + node - self.lowest).unwrap_or(u32::MAX)
    }
}

/// Whether the straightness of this control goes through four points.
pub(super) fn is_four_point(facts: &FanucFacts) -> bool {
    facts.straightness_form.value == StraightnessForm::FourPoint
}

/// How many per-point sets have straightness data of their own: more would lie among those of sets in use.
pub(super) fn blocks_of_sets(facts: &FanucFacts) -> u32 {
    let of_a_set = facts.straightness_axis_points.value.max(1);
    facts.straightness_points.value.iter().map(|b| (b.last - b.first + 1) / of_a_set).sum()
}

/// Point numbers in use.
pub(super) struct Space {
    used: Vec<NumberRange>,
}

impl Space {
    fn is_free(&self, range: NumberRange) -> bool {
        !self.used.iter().any(|used| used.overlaps(range))
    }

    /// Takes `count` numbers from `first`, if they lie in one of the blocks and are free.
    pub(super) fn take_at(
        &mut self,
        blocks: &[NumberRange],
        first: u32,
        count: u32,
    ) -> Option<u32> {
        let range = NumberRange { first, last: first.checked_add(count - 1)? };
        (range.lies_in(blocks) && self.is_free(range)).then(|| {
            self.used.push(range);
            first
        })
    }

    /// Takes the first free `count` numbers, beginning at a multiple of ten if there are such.
    pub(super) fn take(&mut self, blocks: &[NumberRange], count: u32) -> Option<u32> {
        [10, 1].into_iter().find_map(|multiple| {
            blocks.iter().find_map(|block| {
                let mut first = block.first.next_multiple_of(multiple);
                while block.contains(first) {
                    if let Some(first) = self.take_at(&[*block], first, count) {
                        return Some(first);
                    }
                    first += multiple;
                }
                None
            })
        })
    }
}

/// The runs of all physical axes that need pitch points, and what is free beside them; stated numbers are
/// placed first.
pub(super) fn runs(
    task: Task<'_>,
    plan: &Plan,
    facts: &FanucFacts,
    problems: &mut Problems,
) -> (Vec<Run>, Space) {
    let reserved = task.job.compensation.reserved_points.as_deref().unwrap_or_default();
    let used = reserved.iter().map(|[first, last]| NumberRange { first: *first, last: *last });
    let mut space = Space { used: used.collect() };
    let mut runs = needed(plan, facts);
    let blocks = &facts.pitch_points.value;
    let stated = |run: &Run| {
        let first_axis = plan.names[run.axis].first()?;
        task.settings(run.axis)?.first_point.filter(|_| *first_axis == run.id.to_string())
    };
    for run in &mut runs {
        let Some(first) = stated(run) else { continue };
        match space.take_at(blocks, first, run.count) {
            Some(first) => run.first = first,
            None => {
                let last = first.saturating_add(run.count - 1);
                let wrong = refusals::points_taken(first, last, run.axis, blocks_text(blocks));
                problems.push(task.job.source.at(&axis_key(run.axis, ".first_point"), wrong));
            }
        }
    }
    for run in runs.iter_mut().filter(|run| stated(run).is_none()) {
        match space.take(blocks, run.count) {
            Some(first) => run.first = first,
            None => problems.push(no_room(task, run, blocks)),
        }
    }
    for run in runs.iter_mut().filter(|run| plan.has_two_tables(run.axis)) {
        run.minus_first = space.take(&facts.minus_points.value, run.count);
        if run.minus_first.is_none() {
            problems.push(no_room(task, run, &facts.minus_points.value));
        }
    }
    (runs, space)
}

fn no_room(task: Task<'_>, run: &Run, blocks: &[NumberRange]) -> Problem {
    let wrong = refusals::no_room(run.count, run.axis, run.id, blocks_text(blocks));
    task.job.source.at(&axis_key(run.axis, ""), wrong)
}

fn blocks_text(blocks: &[NumberRange]) -> String {
    joined(blocks.iter().map(|b| format!("points {}…{}", b.first, b.last)))
}

fn needed(plan: &Plan, facts: &FanucFacts) -> Vec<Run> {
    let mut runs = Vec::new();
    for axis in Axis::ALL {
        let Some(grid) = plan.grids[axis] else {
            continue;
        };
        let own = plan.of_axis(axis).next().is_some();
        let crosses = plan.tables.iter().any(|t| t.term.is_cross() && t.term.along == axis);
        for (index, name) in plan.names[axis].iter().enumerate() {
            let moves_others = crosses && index == 0;
            if !own && !moves_others {
                continue;
            }
            // Four-point amounts stand at point numbers; the lowest node needs one of its own.
            let lowest = if moves_others && is_four_point(facts) {
                grid.first.min(0)
            } else {
                (grid.first + 1).min(0)
            };
            runs.push(Run {
                axis,
                id: name.parse().unwrap_or(0),
                grid,
                lowest,
                count: u32::try_from(grid.last.max(1) - lowest + 1).unwrap_or(u32::MAX),
                first: 0,
                minus_first: None,
            });
        }
    }
    runs
}
