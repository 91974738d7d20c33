//! Straightness sets: a moving axis shifts another one.

use crate::control::controller::FanucFacts;
use crate::text::problem::Problems;
use crate::write::compensation::fanuc::form::is_four_point;
use crate::write::compensation::fanuc::numbers::{Run, Space};
use crate::write::compensation::fanuc::{
    Curve, Output, detection_unit, magnify, too_steep, wanted,
};
use crate::write::compensation::four_point::best_fit;
use crate::write::plan::{Plan, PlannedTable, Task};

/// One set: a planned table on one physical output axis.
struct Set<'a> {
    number: u32,
    planned: &'a PlannedTable,
    run: &'a Run,
    output: u32,
}

/// Parameters and data of all sets, from the first free set on.
pub(super) fn write(
    task: Task<'_>,
    plan: &Plan,
    facts: &FanucFacts,
    runs: &[Run],
    space: &mut Space,
    out: &mut Output,
    problems: &mut Problems,
) {
    let mut number = task.job.compensation.first_set.unwrap_or(1);
    for planned in plan.tables.iter().filter(|t| t.term.is_cross()) {
        let Some(run) = runs.iter().find(|run| run.axis == planned.term.along) else {
            continue;
        };
        for output in &plan.names[planned.term.of] {
            let set = Set {
                number,
                planned,
                run,
                output: output.parse().unwrap_or(0),
            };
            out.integer(5710 + number, None, run.id);
            out.integer(5720 + number, None, set.output);
            if is_four_point(facts) {
                four_points(task, facts, &set, out, problems);
            } else {
                per_point(task, facts, &set, space, out, problems);
            }
            number += 1;
        }
    }
}

fn per_point(
    task: Task<'_>,
    facts: &FanucFacts,
    set: &Set<'_>,
    space: &mut Space,
    out: &mut Output,
    problems: &mut Problems,
) {
    let unit_um = detection_unit(task, set.planned.term.of);
    let curve = Curve {
        wanted_um: wanted(set.planned, facts.straightness_sign.value),
        carries_reversal: false,
    };
    let Some((magnification, _, totals)) = magnify(facts, set.run.grid, &[curve], unit_um) else {
        problems.push(too_steep(task, facts, set.planned, unit_um));
        return;
    };
    let Some(first) = take_block(facts, set, space) else {
        problems.push(
            task.job
                .problem_at(
                    "compensation",
                    format!(
                        "there is no room for the {} straightness data of {}",
                        set.run.count, set.planned.term
                    ),
                )
                .help("free `reserved_points`, or use a larger spacing"),
        );
        return;
    };
    out.integer(
        facts.straightness_magnification_parameter.value + set.number - 1,
        None,
        magnification,
    );
    out.integer(
        facts.straightness_start_parameter.value + set.number - 1,
        None,
        first,
    );
    for offset in 0..set.run.count {
        let increment = totals[0].increment(set.run.lowest + i64::from(offset));
        out.memory
            .points
            .insert(first + offset, i32::try_from(increment).unwrap_or(0));
    }
    let place = format!(
        "set {}: axis {} by {}, data {first}…{}",
        set.number,
        set.output,
        set.run.id,
        first + set.run.count - 1
    );
    out.place(
        set.planned,
        place,
        set.run.count,
        unit_um * f64::from(magnification),
        None,
    );
}

/// The block of the set (each set has one of `straightness_axis_points` numbers), or the first
/// free one.
fn take_block(facts: &FanucFacts, set: &Set<'_>, space: &mut Space) -> Option<u32> {
    let blocks = &facts.straightness_points.value;
    let own = blocks.first()?.first + facts.straightness_axis_points.value * (set.number - 1);
    space
        .take_at(blocks, own, set.run.count)
        .or_else(|| space.take(blocks, set.run.count))
}

#[allow(clippy::cast_possible_wrap, reason = "a node of at most a few hundred")]
fn four_points(
    task: Task<'_>,
    facts: &FanucFacts,
    set: &Set<'_>,
    out: &mut Output,
    problems: &mut Problems,
) {
    let unit_um = detection_unit(task, set.planned.term.of);
    let units: Vec<f64> = wanted(set.planned, facts.straightness_sign.value)
        .iter()
        .map(|um| um / unit_um)
        .collect();
    let grid = &set.run.grid;
    let reference = usize::try_from(-grid.first).unwrap_or(0);
    let Some(fit) = best_fit(&units, reference, facts.straightness_amount_max.value) else {
        problems.push(
            task.job
                .problem_at(
                    "limits",
                    format!(
                        "{} needs a straightness amount beyond ±{} detection units",
                        set.planned.term, facts.straightness_amount_max.value
                    ),
                )
                .help("check the measurement and `detection_unit_um`"),
        );
        return;
    };
    let group = 10 * (set.number - 1);
    for (index, (node, amount)) in (0..).zip(fit.nodes.iter().zip(fit.amounts)) {
        out.integer(
            5731 + group + index,
            None,
            set.run.point(grid.first + *node as i64),
        );
        out.integer(5761 + group + index, None, amount);
    }
    let place = format!(
        "set {}: axis {} by {}, four points",
        set.number, set.output, set.run.id
    );
    out.place(set.planned, place, 4, unit_um, Some(fit.residual * unit_um));
}
