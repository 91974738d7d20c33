//! What LinuxCNC adds to a joint that has a table (docs/linuxcnc.md §2).
//!
//! ```text
//!   column (moving up, moving down) → trim at each row, a C float → straight lines between, ends held
//!   motor = position + trim; without a table: BACKLASH
//! ```
//! One joint by another: the curves of a HAL file, in C doubles, their sum at the points of all of them.
//!
//! Seen on a control: every servo cycle of a run is the model of docs/linuxcnc.md §2 within a nanometre. Left
//! out: the ramp of a few milliseconds after a reversal, and the rounding of a slope to a C float, both below
//! what moves an axis while it measures.

use crate::control::control_state::ControlState;
use crate::control::controller::LinuxcncFacts;
use crate::control::table::linuxcnc::{Columns, CompTable, CrossTable, LinuxcncTables, Point, Row};
use crate::quantity::units::{Correction, UM_PER_MM};
use crate::read::emulate::{CannotEmulate, Emulated, Response};
use crate::read::pairs::{Pair, PairControl};

/// A control that holds these tables. BACKLASH, counted from the direction of homing, acts on a joint without a
/// table only.
///
/// **unit** `state.unit` is that of the files · **limits** fails if a joint is not one of the control
pub(super) fn control(
    tables: &LinuxcncTables,
    facts: &LinuxcncFacts,
    state: &ControlState,
) -> Emulated<PairControl> {
    let unit_mm = state.unit.in_mm();
    let own = |table: &CompTable| {
        let way = |column: fn(&Row) -> f64| response(table, facts, unit_mm, column);
        let ways = [way(|row| row.forward)?, way(|row| row.reverse)?];
        Ok(pair(table.joint, table.joint, ways))
    };
    let cross = |table: &CrossTable| {
        let response = cross_response(table, facts, unit_mm)?;
        let ways = [response.clone(), response];
        Ok(pair(table.base, table.output, ways))
    };
    let pairs = tables.joints.iter().map(own);
    let pairs = pairs.chain(tables.cross.iter().map(cross));
    PairControl::new(pairs.collect::<Result<_, _>>()?, true, state)
}

fn pair(base: u32, output: u32, ways: [Response; 2]) -> Pair {
    let [base, output] = [base, output].map(|joint| joint.to_string());
    Pair { base, output, ways }
}

/// The trim of a row, in the machine unit: a C float.
#[allow(clippy::cast_possible_truncation, reason = "LinuxCNC holds trims as C floats")]
fn trim(columns: Columns, nominal: f64, column: f64) -> f64 {
    let trim = match columns {
        Columns::Reached => nominal - column,
        Columns::Trims => column,
    };
    f64::from(trim as f32)
}

/// One column of a table.
fn response(
    table: &CompTable,
    facts: &LinuxcncFacts,
    unit_mm: f64,
    column: fn(&Row) -> f64,
) -> Emulated<Response> {
    let correction = |row: &Row| {
        let trim = trim(table.columns, row.nominal, column(row));
        facts.trim_sign.value.correction(trim * unit_mm * UM_PER_MM)
    };
    let mm: Vec<f64> = table.rows.iter().map(|row| row.nominal * unit_mm).collect();
    let values: Vec<Correction> = table.rows.iter().map(correction).collect();
    let none = || CannotEmulate(format!("the table of {} has no row", table.name()));
    Response::straight(&mm, &values).ok_or_else(none)
}

/// The curves of one joint by another, which add up.
fn cross_response(table: &CrossTable, facts: &LinuxcncFacts, unit_mm: f64) -> Emulated<Response> {
    let points = table.pieces.iter().flatten();
    let mut places: Vec<f64> = points.map(|point| point.position).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let correction = |place: &f64| {
        let value: f64 = table.pieces.iter().map(|piece| at(piece, *place)).sum();
        facts.sum_sign.value.correction(value * unit_mm * UM_PER_MM)
    };
    let mm: Vec<f64> = places.iter().map(|place| place * unit_mm).collect();
    let values: Vec<Correction> = places.iter().map(correction).collect();
    let none = || CannotEmulate(format!("the curves of {} have no point", table.name()));
    Response::straight(&mm, &values).ok_or_else(none)
}

/// The value of a curve: straight between its points, held outside.
fn at(points: &[Point], place: f64) -> f64 {
    let above = points.partition_point(|point| point.position <= place);
    let (below, above) = (above.checked_sub(1).map(|below| points[below]), points.get(above));
    match (below, above) {
        (Some(low), Some(high)) => {
            let share = (place - low.position) / (high.position - low.position);
            low.value + share * (high.value - low.value)
        }
        (Some(end), None) => end.value,
        (None, first) => first.map_or(0.0, |first| first.value),
    }
}

#[cfg(test)]
mod tests;
