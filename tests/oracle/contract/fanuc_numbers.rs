//! The numbers of points and sets in the memory of a Fanuc control.

use super::case::{Case, whole};
use nonius::control::controller::{Dialect, NumberRange, StraightnessForm};
use nonius::control::table::fanuc::FanucMemory;

/// (h) Numbers of points: in order, apart, none reserved, none left over; increments legal.
pub(crate) fn numbers_are_legal(case: &Case<'_>, memory: &FanucMemory) {
    let Dialect::Fanuc(facts) = &case.profile.dialect else {
        panic!("a memory of another control")
    };
    let mut runs: Vec<(String, NumberRange)> = Vec::new();
    let mut add = |name: String, run: NumberRange, blocks: &[NumberRange]| {
        let lies_in = |block: &NumberRange| block.contains(run.first) && block.contains(run.last);
        assert!(blocks.iter().any(lies_in), "{name}: {run:?}");
        runs.push((name, run));
    };
    let of = |axis: u32, number| whole(memory, number, Some(axis));
    let as_long_as = |axis: u32, first: u32| NumberRange {
        first,
        last: first + of(axis, 3622) - of(axis, 3621),
    };
    for key in memory.parameters.keys().filter(|k| k.number == 3620) {
        let axis = key.axis.unwrap();
        let [reference, first, last] = [3620, 3621, 3622].map(|number| of(axis, number));
        assert!(first <= reference && reference < last, "{first} {reference} {last}");
        add(format!("axis {axis}"), NumberRange { first, last }, &facts.pitch_points.value);
        if memory.parameter(3626, Some(axis)).is_some() {
            let run = as_long_as(axis, of(axis, 3626));
            add(format!("axis {axis}, -"), run, &facts.minus_points.value);
        }
    }
    for set in 0..6 {
        let moving = memory.parameter(5711 + set, None).is_some();
        if moving && facts.straightness_form.value == StraightnessForm::PerPoint {
            let first = whole(memory, 13391 + set, None);
            let run = as_long_as(whole(memory, 5711 + set, None), first);
            add(format!("set {set}"), run, &facts.straightness_points.value);
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
        let is_owned = runs.iter().any(|(_, run)| run.contains(*point));
        assert!(is_owned, "point {point} belongs to nobody");
    }
    let owned: u32 = runs.iter().map(|(_, run)| run.last - run.first + 1).sum();
    assert_eq!(memory.points.len(), owned as usize, "every point is written");
}
