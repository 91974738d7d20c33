//! How the control names the physical axes.

use super::Task;
use crate::control::controller::{Dialect, Profile};
use crate::inputs::job::Job;
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis};
use crate::text::problem::Problems;

/// How the control names the physical axes: as the job states, else the profile's default. An axis
/// that the machine of the job does not have has no name: what the control calls so is another's.
pub fn axis_names(job: &Job, profile: &Profile) -> Result<PerAxis<Vec<String>>, Problems> {
    let defaults = &profile.axis_names.value;
    let mut problems = Problems::none();
    let names = PerAxis::from_fn(|axis| {
        let stated = job.compensation.axes[axis]
            .as_ref()
            .map(|s| s.ids.clone())
            .unwrap_or_default();
        if job.machine.axes[axis].is_none() {
            if !stated.is_empty() {
                problems.push(
                    job.problem_at(
                        &format!("compensation.axes.{}", axis.key()),
                        format!(
                            "[compensation.axes.{}] names an axis that [machine] does not have",
                            axis.key()
                        ),
                    )
                    .help("add it to [machine.axes], or take it out here"),
                );
            }
            Vec::new()
        } else if stated.is_empty() {
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
/// corrected, the first one is looked up. None where the machine lacks one of the two axes.
pub fn axis_pairs(names: &PerAxis<Vec<String>>, term: ErrorTerm) -> Vec<(&str, &str)> {
    names[term.of]
        .iter()
        .filter_map(|output| {
            let base = if term.is_positioning() {
                output
            } else {
                names[term.along].first()?
            };
            Some((base.as_str(), output.as_str()))
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

pub(super) fn default_names(task: Task<'_>, names: &PerAxis<Vec<String>>) -> Vec<Axis> {
    let is_default = |axis: Axis| {
        task.job.compensation.axes[axis]
            .as_ref()
            .is_none_or(|s| s.ids.is_empty())
    };
    names
        .iter()
        .map(|(axis, _)| axis)
        .filter(|axis| !names[*axis].is_empty() && is_default(*axis))
        .collect()
}
