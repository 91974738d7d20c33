//! What Fanuc templates see: `parameters` (one block each, with its segments) and `points`.

use crate::control::controller::FanucFacts;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Clone, Debug, Serialize)]
pub(super) struct FanucContext {
    pub(super) parameters: Vec<Block>,
    pub(super) points: Vec<Point>,
}

/// One parameter with all its axes.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Block {
    number: String,
    identifier: &'static str,
    segments: Vec<Segment>,
}

#[derive(Clone, Debug, Serialize)]
struct Segment {
    axis: String,
    value: String,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Point {
    number: String,
    point: String,
    identifier: &'static str,
    value: String,
}

pub(super) fn context(memory: &FanucMemory, facts: &FanucFacts) -> FanucContext {
    let identifier = |q: &'static str| if facts.q_identifier.value { q } else { "" };
    let mut blocks: BTreeMap<u32, Vec<Segment>> = BTreeMap::new();
    for (ParameterKey { number, axis }, value) in &memory.parameters {
        let axis = axis.map_or_else(String::new, |axis| format!("A{axis}"));
        let segment = Segment {
            axis,
            value: text(*value),
        };
        blocks.entry(*number).or_default().push(segment);
    }
    let parameters = blocks
        .into_iter()
        .map(|(number, segments)| Block {
            number: digits(number, facts),
            identifier: identifier("Q1"),
            segments,
        })
        .collect();
    let points = memory
        .points
        .iter()
        .map(|(point, increment)| Point {
            number: digits(point + facts.point_offset.value, facts),
            point: point.to_string(),
            identifier: identifier("Q0"),
            value: increment.to_string(),
        })
        .collect();
    FanucContext { parameters, points }
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
