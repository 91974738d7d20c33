//! What a person has to see to on the control: reference, bits, backlash, options.

use crate::control::claims::{Assumption, Precondition};
use crate::control::controller::FanucFacts;
use crate::quantity::{Axis, Direction};
use crate::text::{Problems, joined};
use crate::write::compiled::backlash_parameter;
use crate::write::control_text::trimmed;
use crate::write::fanuc::numbers::{Run, is_four_point};
use crate::write::task::{Plan, Task};

const MEMORY: &str = "parameter manual of the family, from memory";
const LARGEST_BACKLASH: f64 = 9999.0; // 1851, detection units; parameter manual, from memory

/// Backlash parameter of an axis in detection units, and the unit in µm.
pub(super) fn backlash_counts(task: Task<'_>, plan: &Plan, axis: Axis) -> Option<(f64, f64)> {
    let (um, unit_um) = (plan.backlash_um[axis]?, task.detection_unit_um(axis)?);
    Some(((um / unit_um).round() + 0.0, unit_um))
}

pub(super) fn check_backlash(task: Task<'_>, plan: &Plan, problems: &mut Problems) {
    for axis in Axis::ALL {
        if let Some((counts, unit_um)) = backlash_counts(task, plan, axis)
            && counts.abs() > LARGEST_BACKLASH
        {
            let words = format!(
                "axis {axis} would need a backlash parameter of {counts} × {unit_um} µm, the control takes ±{LARGEST_BACKLASH}"
            );
            let problem = task.job.problem_at("compensation.backlash", words);
            problems.push(problem.help("check the measurement and `detection_unit_um`"));
        }
    }
}

pub(super) fn assumptions(task: Task<'_>, plan: &Plan, runs: &[Run]) -> Vec<Assumption> {
    let compensation = &task.job.compensation;
    let is_free = |run: &Run| task.settings(run.axis).is_some_and(|s| s.first_point.is_none());
    let nothing_reserved = compensation.reserved_points.is_none() && runs.iter().any(is_free);
    let reserved = nothing_reserved.then(|| {
        let words =
            "points already used by other axes would be overwritten: state `reserved_points`";
        Assumption::of_job("reserved_points", "none", words)
    });
    let unused = runs.iter().filter(|run| plan.of_axis(run.axis).next().is_none());
    let unused = unused.map(|Run { id, axis, .. }| {
        let words = format!("an existing pitch compensation of axis {id} would be replaced by zeros: compensate E{axis}{axis} in the same job");
        Assumption::of_job(format!("pitch_compensation_of_axis_{id}"), "none in use", words)
    });
    let is_asked = |run: &&Run| {
        let settings = task.settings(run.axis);
        settings.is_none_or(|s| s.interpolated.is_none() && s.parameter_3605.is_none())
    };
    let axes = joined(runs.iter().filter(is_asked).map(|run| run.id));
    let interpolated = (!axes.is_empty()).then(|| {
        let words = format!("between the points the forecast is off by up to one step: read 3605#1 of axis {axes} and leave it as it is; where it is 1 (as on the one control seen), state `interpolated = true` for that axis, else `false`, and generate again");
        Assumption::of_job("interpolated", "false", words)
    });
    let first_set = (plan.has_cross() && compensation.first_set.is_none()).then(|| {
        let words =
            "straightness sets already in use from set 1 would be overwritten: state `first_set`";
        Assumption::of_job("first_set", "1", words)
    });
    let all = reserved.into_iter().chain(unused).chain(interpolated).chain(first_set);
    all.map(Assumption::undecided).collect()
}

pub(super) fn preconditions(
    task: Task<'_>,
    plan: &Plan,
    facts: &FanucFacts,
    runs: &[Run],
) -> Vec<Precondition> {
    let mut list = vec![Precondition::new(
        "option stored pitch error compensation",
        "available (8135#0 = 0 where the control has it)",
        "without it the tables stay without effect",
        "B-64303CM-1/01 section 1.3.1",
    )];
    if plan.has_cross() {
        let name = if is_four_point(facts) {
            "option straightness compensation"
        } else {
            "option 128-point straightness compensation"
        };
        list.push(Precondition::new(name, "available", "the cross terms need it", MEMORY));
    }
    if runs.iter().any(|run| run.minus_first.is_some()) {
        list.push(Precondition::new(
            "option bidirectional pitch error compensation",
            "available",
            "separate tables for travel in + and -",
            "A-77810E/02",
        ));
    }
    let power_on = Precondition::new(
        "the power of the control",
        "switched off and on after loading 3620 to 3627",
        "the parameters act only then (alarm PW0000 or P/S 000)",
        "cnc.wiki, FANUC pitch error compensation; alarm numbers from memory",
    );
    let homed = Precondition::new(
        "every axis concerned",
        "returned to its reference point after power-on",
        "the compensation acts only after the reference return",
        "cnc.wiki, FANUC pitch error compensation",
    );
    list.extend([power_on, homed].map(Precondition::after_loading));
    list.push(Precondition::new("3602#0", "0", "the data are increments, not totals", MEMORY));
    for run in runs {
        list.extend(axis_preconditions(task, plan, run));
    }
    list
}

fn axis_preconditions(task: Task<'_>, plan: &Plan, run: &Run) -> Vec<Precondition> {
    let id = run.id;
    let Some(machine) = task.job.machine.axes[run.axis] else {
        return Vec::new();
    };
    let unit = task.job.compensation.control_unit;
    let mut list = vec![Precondition::new(
        format!("1240 of axis {id}"),
        format!(
            "{} {}",
            trimmed(machine.reference.mm() / unit.in_mm(), 6),
            unit.word()
        ),
        "the points are anchored on the reference position; if it is elsewhere, switching the tables on moves the axis",
        "B-64303CM-1/01 section 1.3.1",
    ).dangerous()];
    let settings = task.settings(run.axis);
    let directed = run.minus_first.is_some();
    if settings.is_none_or(|s| s.parameter_3605.is_none()) {
        list.push(Precondition::new(
            format!("3605#0 of axis {id}"),
            if directed { "1" } else { "0" },
            "bidirectional pitch error compensation; the parameter is not written: it holds other bits, which stay as they are",
            "A-77810E/02",
        ).boxed());
        let stated = settings.and_then(|s| s.interpolated);
        list.extend(stated.map(|on| {
            Precondition::new(
                format!("3605#1 of axis {id}"),
                if on { "1" } else { "0" },
                "interpolated pitch error compensation, as the job states or the files of the control hold it",
                MEMORY,
            )
        }));
    }
    let bit = if machine.homing() == Direction::Plus { "0" } else { "1" };
    list.push(Precondition::new(
        format!("1006#5 of axis {id}"),
        bit,
        format!(
            "reference return in {}; it decides which direction carries the reversal",
            machine.homing()
        ),
        MEMORY,
    ));
    list.extend(backlash(task, plan, run));
    list
}

fn backlash(task: Task<'_>, plan: &Plan, run: &Run) -> Option<Precondition> {
    plan.of_axis(run.axis).next()?;
    let what = format!("1851 and 1852 of axis {}", run.id);
    let named = |_| {
        let (counts, unit_um) = backlash_counts(task, plan, run.axis).unwrap_or_default();
        format!("{counts} (detection units of {unit_um} µm)")
    };
    Some(backlash_parameter(task, plan, run.axis, what, named, MEMORY))
}
