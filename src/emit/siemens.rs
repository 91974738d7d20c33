//! What Siemens templates see: `lec`, `cec`, and the switches of both.

use crate::axis::Direction;
use crate::compensation::Compiled;
use crate::controller::{Evidence, SiemensFacts, TableSign};
use crate::emit::fixed;
use crate::plan::Task;
use crate::table::siemens::{CecDirection, SiemensGrid, SiemensTables};
use serde_json::{Value, json};

pub(super) fn context(
    task: Task<'_>,
    compiled: &Compiled,
    tables: &SiemensTables,
    facts: &SiemensFacts,
) -> Value {
    let titles = Titles::of(compiled);
    let lec: Vec<Value> = tables
        .lec
        .iter()
        .map(|table| {
            json!({
                "encoder": table.encoder.to_string(),
                "axis": table.axis,
                "title": titles.of_place(&format!("ENC_COMP[{},{}]", table.encoder, table.axis)),
                "grid": grid(&table.grid, facts),
                "memory": table.values.len().to_string(),
                "points": points(&table.values, &table.grid, facts),
            })
        })
        .collect();
    let cec: Vec<Value> = tables
        .cec
        .iter()
        .map(|table| {
            json!({
                "number": table.number.to_string(),
                "input_axis": table.input_axis,
                "output_axis": table.output_axis,
                "title": titles.of_place(&format!("CEC table {}", table.number)),
                "grid": grid(&table.grid, facts),
                "direction": direction(table.direction),
                "memory": table.values.len().to_string(),
                "points": points(&table.values, &table.grid, facts),
            })
        })
        .collect();
    let mut outputs: Vec<&str> = tables.cec.iter().map(|t| t.output_axis.as_str()).collect();
    outputs.sort_unstable();
    outputs.dedup();
    json!({
        "lec": lec,
        "cec": cec,
        "lec_sense": sense(facts.lec_sign.value),
        "cec_sense": sense(facts.cec_sign.value),
        "lec_sense_evidence": evidence(facts.lec_sign.evidence),
        "cec_sense_evidence": evidence(facts.cec_sign.evidence),
        "cec_outputs": outputs,
        "cec_memory_fixed": if facts.cec_memory_fixed.value { "yes" } else { "no" },
        "controller_reference": reference(task),
    })
}

/// What the numbers of a table mean, in words.
fn sense(sign: TableSign) -> &'static str {
    match sign {
        TableSign::AsError => "error (measured - nominal)",
        TableSign::AsCorrection => "correction (added to the command)",
    }
}

/// How well that is known, as a line for the person who loads the file.
fn evidence(evidence: Evidence) -> &'static str {
    match evidence {
        Evidence::Manual => "sense of the values as in the manual",
        Evidence::Executed => "sense of the values as seen on a control",
        Evidence::Assumed => "sense of the values ASSUMED: prove it with one small bump before use",
    }
}

fn reference(task: Task<'_>) -> String {
    let texts: Vec<String> = task
        .job
        .machine
        .axes
        .iter()
        .filter_map(|(axis, machine)| Some(format!("{axis} {}", machine.as_ref()?.reference.mm())))
        .collect();
    format!("{} mm", texts.join(", "))
}

/// The term of each table, in words, by the place it was put.
struct Titles<'a> {
    compiled: &'a Compiled,
}

impl Titles<'_> {
    fn of(compiled: &Compiled) -> Titles<'_> {
        Titles { compiled }
    }

    fn of_place(&self, place: &str) -> String {
        let placement = self
            .compiled
            .placements
            .iter()
            .find(|p| p.place.split(", ").any(|one| one == place));
        placement.map_or_else(String::new, |p| {
            let travel = match p.direction {
                None => "",
                Some(Direction::Plus) => " while it travels in +",
                Some(Direction::Minus) => " while it travels in -",
            };
            format!(
                "{}: deviation of {} over {}{travel}",
                p.term, p.term.of, p.term.along
            )
        })
    }
}

fn direction(direction: CecDirection) -> &'static str {
    match direction {
        CecDirection::Both => "0",
        CecDirection::Plus => "1",
        CecDirection::Minus => "-1",
    }
}

fn grid(grid: &SiemensGrid, facts: &SiemensFacts) -> Value {
    let decimals = facts.position_decimals.value;
    json!({
        "min": fixed(grid.min, decimals),
        "step": fixed(grid.step, decimals),
        "max": fixed(grid.max, decimals),
    })
}

#[allow(
    clippy::cast_precision_loss,
    reason = "a table has few thousand points"
)]
fn points(values: &[Option<f64>], grid: &SiemensGrid, facts: &SiemensFacts) -> Vec<Value> {
    let of_point = |(index, value): (usize, &Option<f64>)| {
        Some(json!({
            "index": index.to_string(),
            "position": fixed(grid.min + index as f64 * grid.step, facts.position_decimals.value),
            "value": fixed((*value)?, facts.value_decimals.value),
        }))
    };
    values.iter().enumerate().filter_map(of_point).collect()
}
