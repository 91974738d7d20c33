//! How the axes move at the reference point when the old tables act again.

use super::Before;
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::units::Millimetres;
use crate::read::emulate::{CannotEmulate, Emulator};
use crate::read::emulator;
use crate::write::plan::axis_pairs;

/// Movements below it are none, µm.
const NOTHING_UM: f64 = 1e-3;

/// One sentence for each physical axis that the old tables hold off zero at the reference point.
///
/// unit   µm, with the side it moves to · limits all axes at the reference point; the tables that
///        acted, not those that were switched off
pub(super) fn at_reference(before: &Before<'_>) -> Vec<String> {
    let (profile, active) = (before.task.profile, before.active);
    let moved = emulator(profile, &active.tables, &active.state)
        .and_then(|control| moved(before, control.as_ref()));
    match moved {
        Ok(sentences) => sentences,
        Err(reason) => vec![format!(
            "what moves at the reference point when the old tables act again cannot be told: {}",
            reason.0
        )],
    }
}

fn moved(before: &Before<'_>, control: &dyn Emulator) -> Result<Vec<String>, CannotEmulate> {
    let names = &before.plan.names;
    let mut sentences = Vec::new();
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
                let side = if um > 0.0 { "+" } else { "−" };
                sentences.push(format!(
                    "at the reference point {of} ({name}) moves by {:.3} µm towards {side}{of} when the old tables act again: they are not zero there",
                    um.abs()
                ));
            }
        }
    }
    Ok(sentences)
}

/// What an axis adds to another at its reference, having come from the reference return.
fn at_place(
    before: &Before<'_>,
    control: &dyn Emulator,
    (base, output): (&str, &str),
    along: Axis,
) -> Result<f64, CannotEmulate> {
    let Some(machine) = before.task.job.machine.axes[along] else {
        return Ok(0.0);
    };
    let place: Millimetres = machine.reference;
    let response = control.response(base, output, machine.homing())?;
    let tables = response.tables().iter();
    Ok(tables.map(|table| table.correction(place).um()).sum())
}
