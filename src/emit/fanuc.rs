//! What Fanuc templates see: `parameters` (one block each, with its segments) and `points`.

use crate::controller::FanucFacts;
use crate::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use serde_json::{Value, json};
use std::collections::BTreeMap;

pub(super) fn context(memory: &FanucMemory, facts: &FanucFacts) -> Value {
    let mut blocks: BTreeMap<u32, Vec<Value>> = BTreeMap::new();
    for (ParameterKey { number, axis }, value) in &memory.parameters {
        let axis = axis.map_or_else(String::new, |axis| format!("A{axis}"));
        blocks
            .entry(*number)
            .or_default()
            .push(json!({ "axis": axis, "value": text(*value) }));
    }
    let parameters: Vec<Value> = blocks
        .into_iter()
        .map(|(number, segments)| {
            json!({
                "number": digits(number, facts),
                "identifier": if facts.q_identifier.value { "Q1" } else { "" },
                "segments": segments,
            })
        })
        .collect();
    let points: Vec<Value> = memory
        .points
        .iter()
        .map(|(point, increment)| {
            json!({
                "number": digits(point + facts.point_offset.value, facts),
                "point": point.to_string(),
                "identifier": if facts.q_identifier.value { "Q0" } else { "" },
                "value": increment.to_string(),
            })
        })
        .collect();
    json!({ "parameters": parameters, "points": points })
}

fn digits(number: u32, facts: &FanucFacts) -> String {
    format!(
        "{number:0width$}",
        width = facts.number_digits.value as usize
    )
}

fn text(value: ParameterValue) -> String {
    match value {
        ParameterValue::Integer(whole) => whole.to_string(),
        ParameterValue::Bits(bits) => format!("{bits:08b}"),
        ParameterValue::Real(real) => {
            let text = format!("{}", real + 0.0);
            if text.contains('.') {
                text
            } else {
                format!("{text}.0")
            }
        }
    }
}
