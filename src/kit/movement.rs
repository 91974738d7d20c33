//! How the axes move: when the tables of a kit are switched, and at the reference point when the old ones
//! act again.

use super::made::Made;
use crate::judge::before::Before;
use crate::judge::field::{Field, Pair};
use crate::kit::findings::InRollback;
use crate::quantity::{Axis, Direction, ErrorTerm, Millimetres, PerAxis};
use crate::read::emulate::{Emulated, Emulator, Response};
use crate::read::emulator;

/// Largest movement of each physical axis when the tables are switched, all base axes at their
/// worst place: a bound, not a place. Backlash parameters are not switched with the tables, but what a
/// table holds for one direction is (3627 on Fanuc).
pub(super) fn switching(made: &Made<'_>) -> Emulated<Vec<String>> {
    let (names, tables) = (&made.plan.names, &made.plan.tables);
    let mut state = made.compiled.state.clone();
    state.axes.iter_mut().for_each(|axis| axis.backlash_um = 0.0);
    let control = emulator(&made.inputs.profile, &made.compiled.tables, &state)?;
    let has_table = |term: ErrorTerm| tables.iter().any(|table| table.term == term);
    let field = Field::of(names, control.as_ref(), has_table)?;
    let axes = &made.inputs.job.machine.axes;
    let references = PerAxis::from_fn(|axis| axes[axis].map(|own| own.reference));
    let zeros = PerAxis::from_fn(|axis| references[axis].map_or(0.0, Millimetres::mm));
    let line = |of: Axis| {
        let (mut anywhere, mut at_reference) = (0.0, 0.0);
        for along in Axis::ALL {
            let term = ErrorTerm { of, along };
            let ways = Direction::BOTH.into_iter().filter(|_| has_table(term));
            let ways = ways.flat_map(|direction| field.ways(term, direction));
            let ends = ways.map(|way| extremes(way, references[along]));
            let (largest, there) =
                ends.fold((0.0, 0.0), |all, of| (f64::max(all.0, of.0), f64::max(all.1, of.1)));
            anywhere += largest;
            at_reference += there;
        }
        let swing = |at: Option<PerAxis<f64>>| {
            names[of].iter().map(|name| control.swing(name, at).abs()).fold(0.0, f64::max)
        };
        anywhere += swing(None);
        at_reference += swing(Some(zeros));
        format!(
            "{}: at most {at_reference:.3} µm at the reference point, up to {anywhere:.1} µm elsewhere",
            made.axes(of)
        )
    };
    let moved = Axis::ALL.into_iter().filter(|axis| tables.iter().any(|t| t.term.of == *axis));
    Ok(moved.map(line).collect())
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
    let (names, axes) = (&before.plan.names, &before.task.job.machine.axes);
    let field = Field::of(names, control, |term| axes[term.along].is_some())?;
    // What an axis adds to another at its reference, having come from the reference return.
    let added = |(term, pair): (ErrorTerm, &Pair)| {
        let machine = axes[term.along].as_ref()?;
        let tables = pair.way(machine.homing()).tables().iter();
        Some(tables.map(|table| table.correction(machine.reference).um()).sum::<f64>())
    };
    let moved = Axis::ALL.into_iter().flat_map(|of| names[of].iter().map(move |name| (of, name)));
    let moved = moved.filter_map(|(axis, name)| {
        let own = field.pairs().filter(|(term, pair)| term.of == axis && pair.output == *name);
        let um: f64 = own.filter_map(added).sum();
        (um.abs() > NOTHING_UM).then(|| InRollback::MovesAtReference {
            axis,
            name: name.clone(),
            um,
        })
    });
    Ok(moved.collect())
}
