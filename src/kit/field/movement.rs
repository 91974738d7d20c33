//! How far the axes can move when the tables are switched.

use super::Made;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::units::Millimetres;
use crate::read::emulate::{CannotEmulate, Emulator, Response};
use crate::read::emulator;
use crate::write::plan::axis_pairs;

/// Largest movement of each physical axis when the tables are switched, all base axes at their
/// worst place: a bound, not a place.
pub(super) fn movement(made: &Made<'_>) -> Result<Vec<String>, CannotEmulate> {
    let control = switched(made)?;
    let has_tables = |axis: &Axis| made.plan.tables.iter().any(|t| t.term.of == *axis);
    let line = |axis: Axis| {
        let (mut anywhere, mut at_reference) = (0.0, 0.0);
        for along in Axis::ALL {
            let term = ErrorTerm { of: axis, along };
            let (largest, there) = of_term(made, control.as_ref(), term)?;
            anywhere += largest;
            at_reference += there;
        }
        Ok(format!(
            "{}: at most {at_reference:.3} µm at the reference point, up to {anywhere:.1} µm elsewhere",
            made.axes(axis)
        ))
    };
    let axes = Axis::ALL.into_iter().filter(has_tables);
    axes.map(line).collect()
}

/// The control without its backlash parameters: they are not switched with the tables, but what a
/// table holds for one direction is (3627 on Fanuc).
fn switched(made: &Made<'_>) -> Result<Box<dyn Emulator>, CannotEmulate> {
    let mut state = made.compiled.state.clone();
    for axis in &mut state.axes {
        axis.backlash_um = 0.0;
    }
    emulator(&made.inputs.profile, &made.read.tables, &state)
}

/// Largest correction of one axis by another, anywhere and at the reference, µm.
fn of_term(
    made: &Made<'_>,
    control: &dyn Emulator,
    term: ErrorTerm,
) -> Result<(f64, f64), CannotEmulate> {
    if !made.plan.tables.iter().any(|table| table.term == term) {
        return Ok((0.0, 0.0));
    }
    let reference = made.inputs.job.machine.axes[term.along].map(|axis| axis.reference);
    let (mut anywhere, mut there) = (0.0_f64, 0.0_f64);
    for (base, output) in axis_pairs(&made.plan.names, term) {
        for direction in Direction::BOTH {
            let response = control.response(base, output, direction)?;
            let (largest, at_reference) = extremes(&response, reference);
            anywhere = anywhere.max(largest);
            there = there.max(at_reference);
        }
    }
    Ok((anywhere, there))
}

/// Largest |correction| at the nodes of all tables, between which it is no larger, and at the
/// reference.
fn extremes(response: &Response, reference: Option<Millimetres>) -> (f64, f64) {
    let at = |place: Millimetres| response.correction(place).um().abs();
    let there = reference.map_or(0.0, at);
    let nodes = response.tables().iter().flat_map(|table| table.nodes());
    let largest = nodes.map(|(place, _)| at(place)).fold(there, f64::max);
    (largest, there)
}
