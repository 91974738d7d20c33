//! The numbers of points and sets in the memory of a Fanuc control.

use super::case::{Case, whole};
use nonius::control::controller::{Dialect, NumberRange, StraightnessForm};
use nonius::control::table::fanuc::{FanucMemory, ParameterValue};

/// (h) Numbers of points: in order, apart, none reserved, none left over; increments legal.
pub(crate) fn numbers_are_legal(case: &Case<'_>, memory: &FanucMemory) {
    let Dialect::Fanuc(facts) = &case.profile.dialect else {
        panic!("a memory of another control");
    };
    let mut runs: Vec<(String, NumberRange)> = Vec::new();
    let axes: Vec<u32> =
        memory.parameters.keys().filter(|k| k.number == 3620).map(|k| k.axis.unwrap()).collect();
    let count = |axis: u32| whole(memory, 3622, Some(axis)) - whole(memory, 3621, Some(axis)) + 1;
    for axis in &axes {
        let [reference, first, last] = [3620, 3621, 3622].map(|n| whole(memory, n, Some(*axis)));
        assert!(first <= reference && reference < last, "{first} {reference} {last}");
        let run = NumberRange { first, last };
        assert!(
            facts.pitch_points.value.iter().any(|b| b.contains(first) && b.contains(last)),
            "{run:?}"
        );
        runs.push((format!("axis {axis}"), run));
        if memory.parameter(3626, Some(*axis)).is_some() {
            let first = whole(memory, 3626, Some(*axis));
            let last = first + count(*axis) - 1;
            assert!(facts.minus_points.value.iter().any(|b| b.contains(first) && b.contains(last)));
            runs.push((format!("axis {axis}, -"), NumberRange { first, last }));
        }
    }
    for set in 0..6 {
        let Some(ParameterValue::Integer(moving)) = memory.parameter(5711 + set, None) else {
            continue;
        };
        if facts.straightness_form.value == StraightnessForm::PerPoint {
            let first = whole(memory, 13391 + set, None);
            let last = first + count(u32::try_from(moving).unwrap()) - 1;
            assert!(
                facts
                    .straightness_points
                    .value
                    .iter()
                    .any(|b| b.contains(first) && b.contains(last))
            );
            runs.push((format!("set {set}"), NumberRange { first, last }));
        }
    }
    for (index, (name, run)) in runs.iter().enumerate() {
        for (other, run_of_other) in &runs[index + 1..] {
            assert!(!run.overlaps(*run_of_other), "{name} and {other} share points");
        }
        for [first, last] in &case.machine.reserved {
            let reserved = NumberRange { first: *first, last: *last };
            assert!(!run.overlaps(reserved), "{name} uses reserved points");
        }
    }
    for (point, value) in &memory.points {
        assert!((-7..=7).contains(value), "point {point} is {value}");
        assert!(
            runs.iter().any(|(_, run)| run.contains(*point)),
            "point {point} belongs to nobody"
        );
    }
    let owned: u32 = runs.iter().map(|(_, run)| run.last - run.first + 1).sum();
    assert_eq!(memory.points.len(), owned as usize, "every point is written");
}
