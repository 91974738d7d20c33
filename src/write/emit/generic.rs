//! What generic templates see: `rows`, with every number as finished text.

use crate::control::table::generic::{GenericRow, GenericTable};
use crate::quantity::axis::Direction;
use serde::Serialize;

#[derive(Clone, Debug, Serialize)]
pub(super) struct GenericContext {
    pub(super) rows: Vec<Row>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    term: String,
    base_axis: String,
    output_axis: String,
    direction: &'static str,
    direction_json: &'static str,
    index: String,
    position_mm: String,
    deviation_um: String,
    correction_um: String,
    increment_um: String,
    increment_um_json: String,
    comma: &'static str,
}

pub(super) fn context(table: &GenericTable) -> GenericContext {
    let last = table.rows.len().saturating_sub(1);
    let rows = table.rows.iter().enumerate();
    GenericContext {
        rows: rows
            .map(|(index, row)| row_context(row, index == last))
            .collect(),
    }
}

fn row_context(row: &GenericRow, is_last: bool) -> Row {
    let increment = row.increment_um.map(number);
    Row {
        term: format!("{}", row.term),
        base_axis: row.base_axis.clone(),
        output_axis: row.output_axis.clone(),
        direction: row.direction.map_or("", Direction::symbol),
        direction_json: match row.direction {
            None => "null",
            Some(Direction::Plus) => "\"+\"",
            Some(Direction::Minus) => "\"-\"",
        },
        index: row.index.to_string(),
        position_mm: number(row.position_mm),
        deviation_um: number(row.deviation_um),
        correction_um: number(row.correction_um),
        increment_um: increment.clone().unwrap_or_default(),
        increment_um_json: increment.unwrap_or_else(|| "null".into()),
        comma: if is_last { "" } else { "," },
    }
}

/// The shortest decimal text that reads back as the same number; no exponent, no `-0`.
fn number(value: f64) -> String {
    format!("{}", value + 0.0)
}
