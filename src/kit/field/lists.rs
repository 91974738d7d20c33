//! Lists of a checklist: what is overwritten, what has to be set, what the display shows.

use super::Made;
use super::reading::trimmed;
use crate::control::claims::shared;
use crate::control::table::Tables;
use crate::control::table::siemens::{CecDirection, SiemensGrid};
use crate::write::compensation::Compiled;
use crate::write::compensation::siemens::at_reference;

/// Where each term goes: what is overwritten.
pub(super) fn places(made: &Made<'_>) -> Vec<String> {
    let placements = made.compiled.placements.iter();
    placements
        .map(|p| format!("{}: {} ({} points)", p.term, p.place, p.points))
        .collect()
}

pub(super) fn preconditions(compiled: &Compiled) -> Vec<String> {
    let list = shared(&compiled.preconditions).into_iter();
    list.map(|(what, p)| format!("{what} must be {}: {} *({})*", p.value, p.why, p.source))
        .collect()
}

/// What is assumed of the control and matters for this kit.
pub(super) fn assumptions(compiled: &Compiled) -> Vec<String> {
    let list = compiled.assumptions.iter();
    list.filter(|a| a.without_effect.is_none())
        .map(|a| format!("{} = {}; if wrong: {}", a.fact, a.value, a.consequence))
        .collect()
}

/// One place of each table with what the file holds there: where that is largest. Siemens only,
/// no display of another control is known.
pub(super) fn display(made: &Made<'_>) -> Vec<String> {
    let Tables::Siemens(tables) = &made.read.tables else {
        return Vec::new();
    };
    let lec = tables.lec.iter().map(|table| {
        let values = shown(made, &table.axis, &table.grid, &table.values, "");
        format!("ENC_COMP[{},{}]: {values}", table.encoder, table.axis)
    });
    let cec = tables.cec.iter().map(|table| {
        let way = match table.direction {
            CecDirection::Both => "",
            CecDirection::Plus => ", having come there in +",
            CecDirection::Minus => ", having come there in -",
        };
        let values = shown(made, &table.input_axis, &table.grid, &table.values, way);
        format!(
            "CEC table {} on {}: {values}",
            table.number, table.output_axis
        )
    });
    lec.chain(cec).collect()
}

/// `0.018 mm with AX1 at 900 mm; 0 mm with AX1 at its reference point`.
fn shown(
    made: &Made<'_>,
    base: &str,
    grid: &SiemensGrid,
    values: &[Option<f64>],
    way: &str,
) -> String {
    let unit = made.inputs.job.compensation.control_unit.word();
    let written = values
        .iter()
        .enumerate()
        .filter_map(|(i, v)| Some((i, (*v)?)));
    let larger = |a: (usize, f64), b: (usize, f64)| if b.1.abs() > a.1.abs() { b } else { a };
    let (index, largest) = written.reduce(larger).unwrap_or_default();
    format!(
        "{} {unit} with {base} at {} {unit}{way}; {} {unit} with {base} at its reference point{way}",
        trimmed(largest),
        trimmed(grid.position(index)),
        trimmed(at_reference(&made.compiled.state, base, grid, values))
    )
}
