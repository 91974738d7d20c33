//! What generic templates see: `rows`, with every number as finished text.

use crate::axis::Direction;
use crate::table::generic::{GenericRow, GenericTable};
use serde_json::{Value, json};

pub(super) fn context(table: &GenericTable) -> Value {
    let last = table.rows.len().saturating_sub(1);
    let rows: Vec<Value> = table
        .rows
        .iter()
        .enumerate()
        .map(|(index, row)| row_context(row, index == last))
        .collect();
    json!({ "rows": rows })
}

fn row_context(row: &GenericRow, is_last: bool) -> Value {
    let direction = row.direction.map_or("", Direction::symbol);
    let increment = row.increment_um.map(number);
    json!({
        "term": row.term.to_string(),
        "base_axis": row.base_axis,
        "output_axis": row.output_axis,
        "direction": direction,
        "direction_json": if direction.is_empty() { "null".to_string() } else { format!("\"{direction}\"") },
        "index": row.index.to_string(),
        "position_mm": number(row.position_mm),
        "deviation_um": number(row.deviation_um),
        "correction_um": number(row.correction_um),
        "increment_um": increment.clone().unwrap_or_default(),
        "increment_um_json": increment.unwrap_or_else(|| "null".to_string()),
        "comma": if is_last { "" } else { "," },
    })
}

/// The shortest decimal text that reads back as the same number; no exponent, no `-0`.
fn number(value: f64) -> String {
    format!("{}", value + 0.0)
}
