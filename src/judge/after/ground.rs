//! Whether both measurements say anything about the same thing: one machine, errors and ranges in common.

use super::measurement::{AfterMeasurement, StraightRuns};
use crate::inputs::job::Job;
use crate::judge::findings::joined;
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::text::problem::{Problem, Problems};

/// Refuses a second job of another machine: serial number, travel, reference point and direction
/// of the reference return have to be those of the first, each shown at both places.
pub fn ensure_same_machine(first: &Job, second: &Job) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for ((key, what, here), (.., there)) in told(first).into_iter().zip(told(second)) {
        if let (Some(here), Some(there)) = (here, there)
            && here != there
        {
            let message = format!(
                "the measurement afterwards is of another machine: {what} is {there}, as found {here}"
            );
            let other = second.problem_at(&key, message);
            problems
                .push(other.help("both jobs describe the same machine in the same coordinates"));
            problems.push(first.problem_at(&key, format!("as found, {what} is {here}")));
        }
    }
    problems.or_ok(())
}

/// What a job says of its machine: key, name, value.
fn told(job: &Job) -> Vec<(String, String, Option<String>)> {
    let serial = job.machine.serial.clone();
    let mut told = vec![(
        "machine.serial".to_string(),
        "the serial number".to_string(),
        serial,
    )];
    for axis in Axis::ALL {
        let own = job.machine.axes[axis];
        let travel = own.map(|a| format!("{} … {} mm", a.low.mm(), a.high.mm()));
        let reference = own.map(|a| format!("{} mm", a.reference.mm()));
        let homing = own.map(|a| a.homing().symbol().to_string());
        let rows = [
            ("travel_mm", "travel", travel),
            ("reference_mm", "reference point", reference),
            (
                "reference_direction",
                "direction of the reference return",
                homing,
            ),
        ];
        told.extend(rows.map(|(key, what, value)| {
            let key = format!("machine.axes.{}.{key}", axis.key());
            (key, format!("the {what} of axis {axis}"), value)
        }));
    }
    told
}

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
    let names = |model: &ErrorModel| joined(model.measured().map(|(term, _)| term));
    let is_common = |(term, _): (ErrorTerm, &_)| before.terms[term].is_some();
    if !model.measured().any(is_common) {
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
            let message = format!(
                "axis {axis} was measured from {} to {} mm as found and from {} to {} mm afterwards: no position in common",
                first.0.mm(),
                first.1.mm(),
                second.0.mm(),
                second.1.mm()
            );
            problems.push(
                Problem::new(message)
                    .help("both files count in machine coordinates; measure the same range again"),
            );
        }
    }
    problems.or_ok(())
}

fn nine_terms_over(before: &ErrorModel, runs: &StraightRuns) -> Result<(), Problems> {
    let mut problems = Problems::none();
    let mut refuse = |names: String, says: &str, help: &str| {
        if !names.is_empty() {
            problems.push(Problem::new(format!("{says}: {names}")).help(help));
        }
    };
    let terms = || ErrorTerm::ALL.into_iter();
    let missing = joined(terms().filter(|term| before.terms[*term].is_none()));
    let is_whole = missing.is_empty();
    refuse(
        missing,
        "straight runs of the body diagonals show all nine errors together, but these were not measured as found",
        "measure the errors of the first measurement again, each by itself",
    );
    for direction in Direction::BOTH.into_iter().filter(|_| is_whole) {
        // Every diagonal moves some axis in either direction; a curve of the other one says nothing.
        let is_unknown = |term: &ErrorTerm| {
            let mut walks = runs.walks.iter();
            let first = before.terms[*term].as_ref();
            walks.any(|w| w.diagonal.travelled(term.along, w.pass) == direction)
                && first.is_some_and(|m| m.measured.curve(direction).is_none())
        };
        refuse(
            joined(terms().filter(is_unknown)),
            &format!(
                "the straight runs move the axes in both directions, but moving in {direction} these were not measured as found"
            ),
            "measure the errors of the first measurement in both directions, or give the second one as an error table of the direction that was measured",
        );
    }
    for axis in Axis::ALL.into_iter().filter(|_| is_whole) {
        problems.extend(outside(before, runs, axis).map_or_else(Problems::none, Problems::from));
    }
    problems.or_ok(())
}

/// A box of the diagonals that passes the range that was measured first.
fn outside(before: &ErrorModel, runs: &StraightRuns, axis: Axis) -> Option<Problem> {
    /// Targets may miss the end of a range by this much (rounding of inch positions), mm.
    const NEAR_MM: f64 = 0.01;
    let low = runs.volume.start[axis].mm();
    let high = low + runs.volume.size[axis].mm();
    let (first, last) = before.ranges[axis]?;
    let (first, last) = (first.mm(), last.mm());
    (low < first - NEAR_MM || high > last + NEAR_MM).then(|| {
        Problem::new(format!(
            "the box of the diagonals reaches from {low} to {high} mm of axis {axis}, as found only {first} to {last} mm were measured"
        ))
        .help("walk diagonals inside the box that was measured first")
    })
}
