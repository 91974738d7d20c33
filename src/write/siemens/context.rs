//! What Siemens templates see: `lec`, `cec`, and the switches of both.

use crate::control::control_state::ControlState;
use crate::control::controller::SiemensFacts;
use crate::control::table::siemens::{Place, SiemensGrid, SiemensTable, SiemensTables};
use crate::write::compiled::Placement;
use crate::write::control_text::{Seen, Switch, fixed, seen};
use crate::write::family::Emitted;
use crate::write::siemens::parameters::at_reference;
use crate::write::task::Task;

pub(super) fn context(emitted: &Emitted<'_>, tables: &SiemensTables, facts: &SiemensFacts) -> Seen {
    let Emitted { task, compiled, placements, as_read, .. } = *emitted;
    let digits = Digits { facts, as_read };
    let of_table = |table| of_table(table, placements, digits);
    let held = |table| held(&compiled.state, facts, table);
    seen! {
        "lec": tables.lec().map(of_table).collect::<Vec<Seen>>(),
        "cec": tables.cec().map(of_table).collect::<Vec<Seen>>(),
        "lec_sense": facts.lec_sign.value.words(),
        "cec_sense": facts.cec_sign.value.words(),
        "lec_sense_evidence": facts.lec_sign.evidence.of_sense(),
        "cec_sense_evidence": facts.cec_sign.evidence.of_sense(),
        "cec_outputs": tables.cec_outputs(),
        "stale": compiled.stale.iter().filter_map(|switch| switch.split(' ').next_back()).collect::<Vec<_>>(),
        "cec_memory_fixed": if facts.cec_memory_fixed.value { "yes" } else { "no" },
        "controller_reference": task.reference_text(),
        "lec_at_reference": zero_but_for(task, tables.lec().filter_map(held)),
        "cec_at_reference": zero_but_for(task, tables.cec().filter_map(held)),
        "switches": emitted.switches.iter().map(Switch::seen).collect::<Vec<Seen>>(),
    }
}

/// What the tables of a file hold at the reference point, where they move an axis when switched.
fn zero_but_for(task: Task<'_>, exceptions: impl Iterator<Item = String>) -> Vec<String> {
    let exceptions: Vec<String> = exceptions.collect();
    let but = if exceptions.is_empty() { "" } else { ", but for" };
    let zero = format!("zero at the reference point {}{but}", task.reference_text());
    std::iter::once(zero).chain(exceptions).collect()
}

/// What a table holds at the reference point of its base axis, if that is not zero.
fn held(state: &ControlState, facts: &SiemensFacts, table: &SiemensTable) -> Option<String> {
    let value = at_reference(state, table);
    let text = fixed(value, facts.value_decimals.value);
    let base = &table.input_axis;
    let way = table.direction.map_or(String::new(), |way| format!(" while {base} moves in {way}"));
    let (name, unit) = (table.place.name(), state.unit.word());
    (value.abs() > 0.0).then(|| format!("  {name}: {text} {unit}{way}"))
}

fn of_table(table: &SiemensTable, placements: &[Placement], digits: Digits<'_>) -> Seen {
    let title = title(placements, &table.place.name());
    let (grid, points) = (digits.grid(&table.grid), digits.points(&table.values, &table.grid));
    let memory = table.values.len().to_string();
    match &table.place {
        Place::Lec { axis, encoder } => seen! {
            "encoder": encoder.to_string(),
            "axis": axis.as_str(),
            "title": title,
            "grid": grid,
            "memory": memory,
            "points": points,
        },
        Place::Cec(number) => seen! {
            "number": number.to_string(),
            "input_axis": table.input_axis.as_str(),
            "output_axis": table.output_axis.as_str(),
            "title": title,
            "grid": grid,
            "direction": table.direction_text(),
            "memory": memory,
            "points": points,
        },
    }
}

/// The term of a table in words, by the place it was put.
fn title(placements: &[Placement], place: &str) -> String {
    let placement = placements.iter().find(|p| p.place.split(", ").any(|one| one == place));
    placement.map_or_else(
        || place.to_string(),
        |p| {
            let travel = p.direction;
            let travel = travel.map_or(String::new(), |way| format!(" while it travels in {way}"));
            format!("{}: deviation of {} over {}{travel}", p.term, p.term.of, p.term.along)
        },
    )
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

    fn grid(self, grid: &SiemensGrid) -> Seen {
        let text = |number: f64| self.text(number, self.facts.position_decimals.value);
        seen! { "min": text(grid.min), "step": text(grid.step), "max": text(grid.max) }
    }

    fn points(self, values: &[Option<f64>], grid: &SiemensGrid) -> Vec<Seen> {
        let of_point = |(index, value): (usize, &Option<f64>)| {
            Some(seen! {
                "index": index.to_string(),
                "position": fixed(grid.position(index), self.facts.position_decimals.value),
                "value": self.text((*value)?, self.facts.value_decimals.value),
            })
        };
        values.iter().enumerate().filter_map(of_point).collect()
    }
}
