//! How the axes move: when the tables of a kit are switched, and at the reference point when the old ones
//! act again.

use super::made::Made;
use crate::judge::before::Before;
use crate::kit::findings::InRollback;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::units::Millimetres;
use crate::read::emulate::{Emulated, Emulator, Response};
use crate::read::emulator;
use crate::write::plan::axis_pairs;

/// Largest movement of each physical axis when the tables are switched, all base axes at their
/// worst place: a bound, not a place.
pub(super) fn switching(made: &Made<'_>) -> Emulated<Vec<String>> {
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
        let swing = |at: Option<PerAxis<f64>>| {
            let names = made.plan.names[axis].iter();
            names.map(|name| control.swing(name, at).abs()).fold(0.0, f64::max)
        };
        anywhere += swing(None);
        at_reference += swing(Some(references(made)));
        Ok(format!(
            "{}: at most {at_reference:.3} µm at the reference point, up to {anywhere:.1} µm elsewhere",
            made.axes(axis)
        ))
    };
    let axes = Axis::ALL.into_iter().filter(has_tables);
    axes.map(line).collect()
}

/// Where all axes stand at their reference point, mm.
fn references(made: &Made<'_>) -> PerAxis<f64> {
    let axes = &made.inputs.job.machine.axes;
    PerAxis::from_fn(|axis| axes[axis].map_or(0.0, |own| own.reference.mm()))
}

/// The control without its backlash parameters: they are not switched with the tables, but what a
/// table holds for one direction is (3627 on Fanuc).
fn switched(made: &Made<'_>) -> Emulated<Box<dyn Emulator>> {
    let mut state = made.compiled.state.clone();
    for axis in &mut state.axes {
        axis.backlash_um = 0.0;
    }
    emulator(&made.inputs.profile, &made.tables, &state)
}

/// Largest correction of one axis by another, anywhere and at the reference, µm.
fn of_term(made: &Made<'_>, control: &dyn Emulator, term: ErrorTerm) -> Emulated<(f64, f64)> {
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

/// Movements below it are none, µm.
const NOTHING_UM: f64 = 1e-3;

/// Each physical axis that the old tables hold off zero at the reference point.
///
/// unit   µm, with the side it moves to · limits all axes at the reference point; the tables that
///        acted, not those that were switched off
pub(super) fn way_back(before: &Before<'_>) -> Vec<InRollback> {
    let (profile, active) = (before.task.profile, before.active);
    let moved = emulator(profile, &active.tables, &active.state)
        .and_then(|control| moved(before, control.as_ref()));
    moved.unwrap_or_else(|reason| vec![InRollback::MovementUnknown { reason: reason.0 }])
}

fn moved(before: &Before<'_>, control: &dyn Emulator) -> Emulated<Vec<InRollback>> {
    let names = &before.plan.names;
    let mut moved = Vec::new();
    for of in Axis::ALL {
        for name in &names[of] {
            let mut um = 0.0;
            for along in Axis::ALL {
                let pairs = axis_pairs(names, ErrorTerm { of, along });
                for (base, output) in pairs.iter().filter(|(_, output)| output == name) {
                    um += at_place(before, control, (*base, *output), along)?;
                }
            }
            if um.abs() > NOTHING_UM {
                let (axis, name) = (of, name.clone());
                moved.push(InRollback::MovesAtReference { axis, name, um });
            }
        }
    }
    Ok(moved)
}

/// What an axis adds to another at its reference, having come from the reference return.
fn at_place(
    before: &Before<'_>,
    control: &dyn Emulator,
    (base, output): (&str, &str),
    along: Axis,
) -> Emulated<f64> {
    let Some(machine) = before.task.job.machine.axes[along] else {
        return Ok(0.0);
    };
    let place: Millimetres = machine.reference;
    let response = control.response(base, output, machine.homing())?;
    let tables = response.tables().iter();
    Ok(tables.map(|table| table.correction(place).um()).sum())
}
