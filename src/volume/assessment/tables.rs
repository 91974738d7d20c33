//! The machine as the tables of a control leave it.

use crate::machine::model::ErrorModel;
use crate::quantity::{
    Deviation, Direction, ErrorCurve, Interpolation, JUMP_MM, Millimetres, Rotation,
};
use crate::read::emulate::{Emulated, Emulator, Response, Stretch};
use crate::volume::volume_model::VolumeModel;
use crate::write::plan::{Plan, axis_pairs};

/// Places of jumps count on a raster of a picometre, so those of several tables are one.
const PER_MM: f64 = 1e9;
/// Corrections and jumps below it are none: rounding, µm.
const NOTHING_UM: f64 = 1e-9;

/// The machine as the tables of a control leave it: each deviation with what the emulated control
/// adds, everywhere. Angles stay, unless the control takes off what they do through the positions of
/// the axes; what they do at a tool stays.
///
/// `volume`: the machine as it was measured. `uncompensated`: its errors without the tables that
/// were active meanwhile, which is what the new corrections are added to; the measured errors
/// themselves where none were.
pub(crate) fn with_tables(
    volume: &VolumeModel,
    uncompensated: &ErrorModel,
    plan: &Plan,
    control: &dyn Emulator,
) -> Emulated<VolumeModel> {
    let mut left = volume.with_errors_of(uncompensated);
    for (term, measured) in uncompensated.measured() {
        let Some((base, output)) = axis_pairs(&plan.names, term).first().copied() else {
            continue;
        };
        let mut responses = Vec::new();
        // Both directions, if nothing is said of them.
        let is_measured = |way: &Direction| measured.measured.curve(*way).is_some();
        for direction in Direction::BOTH.into_iter().filter(is_measured) {
            responses.push((direction, control.response(base, output, direction)?));
        }
        // Beyond the measured range with that of the tables both are held.
        let tables = responses.iter().flat_map(|(_, response)| tables(response));
        let all = tables.chain([measured.measured.mean().measured_range()]);
        let Some((from, to)) = reach(all) else { continue };
        let curve = |(_, r): &(Direction, Response)| correction(&r.stretches(from, to));
        let corrections: Vec<ErrorCurve> = responses.iter().map(curve).collect();
        if let Some(mean) = mean(&corrections).filter(acts) {
            let homing = left.homing(term.along);
            let there = homing.and_then(|homing| at_reference(&responses, homing));
            left.correct(term, &mean, there);
        }
    }
    for rotation in Rotation::all() {
        let base = plan.names[rotation.along].first();
        let own = base.and_then(|base| control.rotation(base, rotation.about));
        let ends = own.as_ref().and_then(|response| reach(tables(response)));
        if let Some((response, (from, to))) = own.zip(ends) {
            left.correct_rotation(rotation, &correction(&response.stretches(from, to)));
        }
    }
    Ok(left)
}

/// What is added at the reference where an axis came there as it homes.
fn at_reference(
    responses: &[(Direction, Response)],
    (reference, homing): (Millimetres, Direction),
) -> Option<Deviation> {
    let (_, response) = responses.iter().find(|(direction, _)| *direction == homing)?;
    Some(Deviation::from_um(response.correction(reference).um()))
}

/// From where to where each table of a response goes.
fn tables(response: &Response) -> impl Iterator<Item = (Millimetres, Millimetres)> {
    response.tables().iter().map(|table| (table.first(), table.last()))
}

/// From the first beginning to the last end.
fn reach(
    ranges: impl Iterator<Item = (Millimetres, Millimetres)>,
) -> Option<(Millimetres, Millimetres)> {
    ranges.reduce(|(low, high), (from, to)| {
        (if from < low { from } else { low }, if to > high { to } else { high })
    })
}

/// The stretches of a correction as one curve, a jump between two as a line over [`JUMP_MM`].
fn correction(stretches: &[Stretch]) -> ErrorCurve {
    let long = |[from, to]: &&Stretch| (to.0 - from.0).mm() >= 2.0 * JUMP_MM;
    let stretches: Vec<&Stretch> = stretches.iter().filter(long).collect();
    let raster = |at: Millimetres| (at.mm() * PER_MM).round() / PER_MM;
    let mut points: Vec<(f64, f64)> = Vec::with_capacity(2 * stretches.len() + 1);
    for (index, [(from, start), _]) in stretches.iter().enumerate() {
        let before = index.checked_sub(1).map(|i| stretches[i][1].1.um());
        let (at, um) = (raster(*from), start.um());
        if let Some(before) = before.filter(|before| (before - um).abs() > NOTHING_UM) {
            points.push((at - JUMP_MM, before));
        }
        points.push((at, um));
    }
    points.extend(stretches.last().map(|[_, (to, end)]| (raster(*to), end.um())));
    let point = |(mm, um): (f64, f64)| (Millimetres::new(mm), Deviation::from_um(um));
    let (places, values): (Vec<_>, Vec<_>) = points.into_iter().map(point).unzip();
    ErrorCurve::through(&places, &values, Interpolation::Linear)
}

/// The mean of the corrections of both directions, or the one there is.
fn mean(corrections: &[ErrorCurve]) -> Option<ErrorCurve> {
    match corrections {
        [one] => Some(one.clone()),
        [plus, minus] => plus.mean_with(minus),
        _ => None,
    }
}

/// Whether anything is added.
fn acts(correction: &ErrorCurve) -> bool {
    let (from, to) = correction.measured_range();
    correction.largest_magnitude(from, to) > NOTHING_UM
}
