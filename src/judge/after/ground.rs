//! Whether both measurements say anything about the same thing.

use super::{AfterMeasurement, StraightRuns};
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::text::problem::{Problem, Problems};

/// Targets may miss the end of a range by this much (rounding of inch positions), mm.
const NEAR_MM: f64 = 0.01;

/// Refuses two measurements without a term, direction or range in common.
pub(super) fn ensure_common_ground(
    before: &ErrorModel,
    after: &AfterMeasurement,
) -> Result<(), Problems> {
    match after {
        AfterMeasurement::Errors(model) => common_terms(before, model),
        AfterMeasurement::Diagonals(runs) => nine_terms_over(before, runs),
    }
}

fn common_terms(before: &ErrorModel, model: &ErrorModel) -> Result<(), Problems> {
    let names = |model: &ErrorModel| {
        let names: Vec<String> = model.measured().map(|(term, _)| term.to_string()).collect();
        names.join(", ")
    };
    if !model
        .measured()
        .any(|(term, _)| before.terms[term].is_some())
    {
        return Err(Problem::new(format!(
            "both measurements have no error in common: as found {}, afterwards {}",
            names(before),
            names(model)
        ))
        .help("measure the same errors again with the tables active")
        .into());
    }
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        let (Some(first), Some(second)) = (before.ranges[axis], model.ranges[axis]) else {
            continue;
        };
        if second.1 <= first.0 || second.0 >= first.1 {
            problems.push(
                Problem::new(format!(
                    "axis {axis} was measured from {} to {} mm as found and from {} to {} mm afterwards: no position in common",
                    first.0.mm(), first.1.mm(), second.0.mm(), second.1.mm()
                ))
                .help("both files count in machine coordinates; measure the same range again"),
            );
        }
    }
    problems.or_ok(())
}

fn nine_terms_over(before: &ErrorModel, runs: &StraightRuns) -> Result<(), Problems> {
    let missing = names_of(|term| before.terms[term].is_none());
    if !missing.is_empty() {
        return Err(Problem::new(format!(
            "straight runs of the body diagonals show all nine errors together, but these were not measured as found: {missing}"
        ))
        .help("measure the errors of the first measurement again, each by itself")
        .into());
    }
    let mut problems = Problems::none();
    for direction in Direction::BOTH {
        check_direction(before, runs, direction, &mut problems);
    }
    for axis in Axis::ALL {
        check_box(before, runs, axis, &mut problems);
    }
    problems.or_ok(())
}

fn names_of(wanted: impl Fn(ErrorTerm) -> bool) -> String {
    let terms = ErrorTerm::ALL.into_iter().filter(|term| wanted(*term));
    let names: Vec<String> = terms.map(|term| term.to_string()).collect();
    names.join(", ")
}

/// Every diagonal moves some axis in either direction; a curve of the other one says nothing.
fn check_direction(
    before: &ErrorModel,
    runs: &StraightRuns,
    direction: Direction,
    problems: &mut Problems,
) {
    let unknown = names_of(|term| {
        let mut walks = runs.walks.iter();
        let walked = walks.any(|w| w.diagonal.travelled(term.along, w.pass) == direction);
        let first = before.terms[term].as_ref();
        walked && first.is_some_and(|m| m.measured.curve(direction).is_none())
    });
    if !unknown.is_empty() {
        problems.push(
            Problem::new(format!(
                "the straight runs move the axes in both directions, but moving in {direction} these were not measured as found: {unknown}"
            ))
            .help("measure the errors of the first measurement in both directions, or give the second one as an error table of the direction that was measured"),
        );
    }
}

fn check_box(before: &ErrorModel, runs: &StraightRuns, axis: Axis, problems: &mut Problems) {
    let (low, high) = runs.range_mm(axis);
    let Some((first, last)) = before.ranges[axis] else {
        return;
    };
    if low < first.mm() - NEAR_MM || high > last.mm() + NEAR_MM {
        problems.push(
            Problem::new(format!(
                "the box of the diagonals reaches from {low} to {high} mm of axis {axis}, as found only {} to {} mm were measured",
                first.mm(), last.mm()
            ))
            .help("walk diagonals inside the box that was measured first"),
        );
    }
}
