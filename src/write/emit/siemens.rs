//! What Siemens templates see: `lec`, `cec`, and the switches of both.

use crate::control::control_state::ControlState;
use crate::control::controller::{Evidence, SiemensFacts, TableSign};
use crate::control::table::siemens::{
    CecDirection, CecTable, LecTable, SiemensGrid, SiemensTables,
};
use crate::quantity::axis::Direction;
use crate::write::compensation::Placement;
use crate::write::compensation::siemens::{at_reference, reference_text};
use crate::write::emit::{Switch, fixed};
use crate::write::plan::Task;
use serde::Serialize;

#[derive(Clone, Debug, Serialize)]
pub(super) struct SiemensContext {
    pub(super) lec: Vec<Lec>,
    pub(super) cec: Vec<Cec>,
    lec_sense: &'static str,
    cec_sense: &'static str,
    lec_sense_evidence: &'static str,
    cec_sense_evidence: &'static str,
    cec_outputs: Vec<String>,
    cec_memory_fixed: &'static str,
    controller_reference: String,
    lec_at_reference: Vec<String>,
    cec_at_reference: Vec<String>,
    pub(super) switches: Vec<Switch>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Lec {
    encoder: String,
    axis: String,
    title: String,
    grid: Grid,
    memory: String,
    points: Vec<Point>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Cec {
    number: String,
    input_axis: String,
    output_axis: String,
    title: String,
    grid: Grid,
    direction: &'static str,
    memory: String,
    points: Vec<Point>,
}

#[derive(Clone, Debug, Serialize)]
struct Grid {
    min: String,
    step: String,
    max: String,
}

#[derive(Clone, Debug, Serialize)]
struct Point {
    index: String,
    position: String,
    value: String,
}

pub(super) fn context(
    task: Task<'_>,
    placements: &[Placement],
    tables: &SiemensTables,
    facts: &SiemensFacts,
    state: &ControlState,
    as_read: bool,
) -> SiemensContext {
    let digits = Digits { facts, as_read };
    let mut cec_outputs: Vec<String> = tables.cec.iter().map(|t| t.output_axis.clone()).collect();
    cec_outputs.sort_unstable();
    cec_outputs.dedup();
    let at_reference = |exceptions: Vec<String>| zero_but_for(task, exceptions);
    SiemensContext {
        lec_at_reference: at_reference(
            tables
                .lec
                .iter()
                .filter_map(|t| lec_held(t, facts, state))
                .collect(),
        ),
        cec_at_reference: at_reference(
            tables
                .cec
                .iter()
                .filter_map(|t| cec_held(t, facts, state))
                .collect(),
        ),
        lec: tables
            .lec
            .iter()
            .map(|table| lec(table, placements, digits))
            .collect(),
        cec: tables
            .cec
            .iter()
            .map(|table| cec(table, placements, digits))
            .collect(),
        lec_sense: sense(facts.lec_sign.value),
        cec_sense: sense(facts.cec_sign.value),
        lec_sense_evidence: evidence(facts.lec_sign.evidence),
        cec_sense_evidence: evidence(facts.cec_sign.evidence),
        cec_outputs,
        cec_memory_fixed: if facts.cec_memory_fixed.value {
            "yes"
        } else {
            "no"
        },
        controller_reference: reference_text(task),
        switches: Vec::new(),
    }
}

/// What the tables of a file hold at the reference point, where they move an axis when switched.
fn zero_but_for(task: Task<'_>, exceptions: Vec<String>) -> Vec<String> {
    let but = if exceptions.is_empty() {
        ""
    } else {
        ", but for"
    };
    let zero = format!("zero at the reference point {}{but}", reference_text(task));
    std::iter::once(zero).chain(exceptions).collect()
}

/// What a table holds at the reference point of its base axis, if that is not zero.
fn held(
    state: &ControlState,
    facts: &SiemensFacts,
    base: &str,
    (grid, values): (&SiemensGrid, &[Option<f64>]),
) -> Option<String> {
    let value = at_reference(state, base, grid, values);
    let text = fixed(value, facts.value_decimals.value);
    (value.abs() > 0.0).then(|| format!("{text} {}", state.unit.word()))
}

fn lec_held(table: &LecTable, facts: &SiemensFacts, state: &ControlState) -> Option<String> {
    let text = held(state, facts, &table.axis, (&table.grid, &table.values))?;
    Some(format!(
        "  ENC_COMP[{},{}]: {text}",
        table.encoder, table.axis
    ))
}

fn cec_held(table: &CecTable, facts: &SiemensFacts, state: &ControlState) -> Option<String> {
    let base = &table.input_axis;
    let text = held(state, facts, base, (&table.grid, &table.values))?;
    let way = match table.direction {
        CecDirection::Both => String::new(),
        CecDirection::Plus => format!(" while {base} moves in +"),
        CecDirection::Minus => format!(" while {base} moves in -"),
    };
    Some(format!("  CEC table {}: {text}{way}", table.number))
}

fn lec(table: &LecTable, placements: &[Placement], digits: Digits<'_>) -> Lec {
    Lec {
        encoder: table.encoder.to_string(),
        axis: table.axis.clone(),
        title: title(
            placements,
            &format!("ENC_COMP[{},{}]", table.encoder, table.axis),
        ),
        grid: digits.grid(&table.grid),
        memory: table.values.len().to_string(),
        points: digits.points(&table.values, &table.grid),
    }
}

fn cec(table: &CecTable, placements: &[Placement], digits: Digits<'_>) -> Cec {
    Cec {
        number: table.number.to_string(),
        input_axis: table.input_axis.clone(),
        output_axis: table.output_axis.clone(),
        title: title(placements, &format!("CEC table {}", table.number)),
        grid: digits.grid(&table.grid),
        direction: direction(table.direction),
        memory: table.values.len().to_string(),
        points: digits.points(&table.values, &table.grid),
    }
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

/// The term of a table in words, by the place it was put.
fn title(placements: &[Placement], place: &str) -> String {
    let placement = placements
        .iter()
        .find(|p| p.place.split(", ").any(|one| one == place));
    placement.map_or_else(
        || place.to_string(),
        |p| {
            let travel = match p.direction {
                None => "",
                Some(Direction::Plus) => " while it travels in +",
                Some(Direction::Minus) => " while it travels in -",
            };
            format!(
                "{}: deviation of {} over {}{travel}",
                p.term, p.term.of, p.term.along
            )
        },
    )
}

fn direction(direction: CecDirection) -> &'static str {
    match direction {
        CecDirection::Both => "0",
        CecDirection::Plus => "1",
        CecDirection::Minus => "-1",
    }
}

/// How numbers become text.
#[derive(Clone, Copy)]
struct Digits<'a> {
    facts: &'a SiemensFacts,
    /// All digits of a number that has more than the profile writes.
    as_read: bool,
}

impl Digits<'_> {
    fn text(self, number: f64, decimals: u32) -> String {
        let text = fixed(number, decimals);
        if self.as_read && text.parse() != Ok(number) {
            return format!("{number}");
        }
        text
    }

    fn grid(self, grid: &SiemensGrid) -> Grid {
        let decimals = self.facts.position_decimals.value;
        Grid {
            min: self.text(grid.min, decimals),
            step: self.text(grid.step, decimals),
            max: self.text(grid.max, decimals),
        }
    }

    fn points(self, values: &[Option<f64>], grid: &SiemensGrid) -> Vec<Point> {
        let of_point = |(index, value): (usize, &Option<f64>)| {
            Some(Point {
                index: index.to_string(),
                position: fixed(grid.position(index), self.facts.position_decimals.value),
                value: self.text((*value)?, self.facts.value_decimals.value),
            })
        };
        values.iter().enumerate().filter_map(of_point).collect()
    }
}
