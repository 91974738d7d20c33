//! Siemens: positioning into ENC_COMP, everything else into CEC tables.
//!
//! * A positioning error for both directions goes into `$AA_ENC_COMP` of each physical axis;
//!   with separate tables for the directions into two CEC tables of the axis onto itself
//!   (Function Manual Extended Functions 03/2013, K3 section 4.4.4).
//! * A cross term goes into one CEC table (or two) for each physical output axis.
//! * No product tables are ever made: a misreading of their meaning moves an axis by millimetres.

mod parameters;

pub(crate) use self::parameters::encoder;
use self::parameters::{
    assumptions, at_reference, backlash_text, is_lec, largest_sum_um, preconditions,
};
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, Mechanism, SiemensFacts};
use crate::control::table::Tables;
use crate::control::table::siemens::{
    MachineDatum, MachineValue, Place, SiemensGrid, SiemensTable, SiemensTables,
};
use crate::inputs::job::Compensation;
use crate::quantity::{Axis, Deviation, ErrorTerm, power_of_ten};
use crate::text::Problems;
use crate::write::control_text::{Seen, fixed, seen, trimmed};
use crate::write::family::{Compiled, Family, FileSource, Placement, ProofOf, control_state};
use crate::write::grid::LengthDigit;
use crate::write::refusals;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task, axis_pairs};

impl Family for SiemensFacts {
    fn expected_name(&self, _axis: Axis, name: &str) -> Option<&'static str> {
        let is_capital = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
        let is_right = name.starts_with(|c: char| c.is_ascii_uppercase());
        (!is_right || !name.chars().all(is_capital))
            .then_some("a machine axis name in capitals, e.g. \"AX1\"")
    }

    fn length_digit(&self, unit: ControlUnit) -> LengthDigit {
        LengthDigit { unit, decimals: self.position_decimals.value }
    }

    fn takes_directions(&self, _term: ErrorTerm) -> bool {
        true
    }

    fn budget(&self, compensation: &Compensation) -> Option<TableStock> {
        Some(TableStock {
            tables: self.cec_tables.value,
            used: compensation.first_table.unwrap_or(0),
            resource: "CEC tables",
            key: "first_table",
            takes_pairs: true,
            masters: None,
        })
    }

    fn point_limit(&self, targets: &[&Target]) -> (u32, &'static str) {
        let (lec, cec) = (self.lec_points.value, self.cec_points.value);
        let is_lec = |t: &&Target| t.term.is_positioning() && t.direction.is_none();
        match (targets.iter().all(is_lec), targets.iter().any(is_lec)) {
            (true, _) => (lec, "an ENC_COMP table"),
            (false, true) => (lec.min(cec), "a CEC table"),
            (false, false) => (cec, "a CEC table"),
        }
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let (mut tables, mut placements) = (Vec::new(), Vec::new());
        let mut number = task.job.compensation.first_table.unwrap_or(0);
        let count_um = task.unit_um() / power_of_ten(self.value_decimals.value);
        for planned in &plan.tables {
            let (grid, mut places) = (&planned.grid, Vec::new());
            for output in &plan.names[planned.term.of] {
                let place = match is_lec(planned) {
                    true => {
                        Place::Lec { axis: output.clone(), encoder: encoder(task, planned.term.of) }
                    }
                    false => Place::Cec(number),
                };
                number += u32::from(place.cec().is_some());
                places.push(place.name());
                tables.push(SiemensTable {
                    input_axis: plan.base_of(planned.term, output).to_string(),
                    output_axis: output.clone(),
                    grid: SiemensGrid {
                        min: grid.written(grid.first),
                        step: grid.written_spacing(),
                        max: grid.written(grid.last),
                    },
                    values: values(task, self, &planned.values, &place),
                    direction: planned.direction,
                    multiply_by: 0,
                    modulo: false,
                    place,
                });
            }
            placements.push(Placement::of(planned, places.join(", "), count_um));
        }
        let tables = SiemensTables::of(tables);
        check_sum(task, &tables, self)?;
        let backlash = |um: f64| backlash_text(task, um).1;
        let state = control_state(task, plan, |axis| plan.backlash_um[axis].map_or(0.0, backlash));
        Ok(Compiled {
            assumptions: assumptions(task, plan, &tables),
            preconditions: preconditions(task, plan, &tables),
            ..Compiled::of(Tables::Siemens(tables), placements, state)
        })
    }

    fn context(&self, emitted: &FileSource<'_>) -> Seen {
        let tables: &SiemensTables = emitted.tables.own();
        let FileSource { task, compiled, placements, as_read, .. } = *emitted;
        let of_table = |table| of_table(table, placements, Digits { facts: self, as_read });
        let held = |table| held(&compiled.state, self, table);
        seen! {
            "lec": tables.lec().map(of_table).collect::<Vec<Seen>>(),
            "cec": tables.cec().map(of_table).collect::<Vec<Seen>>(),
            "lec_sense": self.lec_sign.value.words(),
            "cec_sense": self.cec_sign.value.words(),
            "lec_sense_evidence": self.lec_sign.evidence.of_sense(),
            "cec_sense_evidence": self.cec_sign.evidence.of_sense(),
            "cec_outputs": tables.cec_outputs(),
            "stale": compiled.stale.iter().filter_map(|switch| switch.split(' ').next_back()).collect::<Vec<_>>(),
            "cec_memory_fixed": if self.cec_memory_fixed.value { "yes" } else { "no" },
            "controller_reference": task.reference_text(),
            "lec_at_reference": zero_but_for(task, tables.lec().filter_map(held)),
            "cec_at_reference": zero_but_for(task, tables.cec().filter_map(held)),
            "switches": tables.data.iter().map(datum).collect::<Vec<Seen>>(),
        }
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        match mechanism {
            Mechanism::EncComp => is_lec(table),
            Mechanism::Cec => !is_lec(table),
            mechanism => mechanism != Mechanism::CecProducts,
        }
    }

    fn cut_off_um(&self, _task: Task<'_>, table: &PlannedTable) -> f64 {
        if is_lec(table) { f64::INFINITY } else { self.cec_max_sum_um.value }
    }

    /// One place of each table: where it holds most.
    fn displayed(&self, tables: &Tables, state: &ControlState) -> Vec<String> {
        tables.own::<SiemensTables>().tables.iter().map(|table| shown(state, table)).collect()
    }

    /// Every physical axis of the term has the bump, so that the two sides of a gantry move alike; CEC tables
    /// of the term have it in both directions.
    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let kit: &SiemensTables = proof.kit.own();
        let pairs = axis_pairs(&proof.plan.names, proof.term);
        let is_lec = proof.mechanism == Mechanism::EncComp;
        let own = kit.tables.iter().filter(|table| table.place.lec().is_some() == is_lec);
        let with_bump = own.map(|table| {
            let pair = (table.input_axis.as_str(), table.output_axis.as_str());
            let deviations = proof.deviations(pairs.contains(&pair), table.values.len());
            let values = values(proof.task, self, &deviations, &table.place);
            SiemensTable { values, ..table.clone() }
        });
        Some(Tables::Siemens(SiemensTables::of(with_bump.collect())))
    }
}

/// Positions in inch are rounded to six decimals.
const ROUNDING_MM: f64 = 1e-3;

/// `CEC table 3 on AX2: 0.018 mm with AX1 at 900 mm; 0 mm with AX1 at its reference point`.
fn shown(state: &ControlState, table: &SiemensTable) -> String {
    let SiemensTable { place, input_axis: base, grid, values, .. } = table;
    let on = place.cec().map_or(String::new(), |_| format!(" on {}", table.output_axis));
    let way = table.direction.map_or(String::new(), |way| format!(", having come there in {way}"));
    let unit = state.unit.word();
    let written = values.iter().enumerate().filter_map(|(i, v)| Some((i, (*v)?)));
    // The last point may lie behind the end of the travel: the axis cannot go there.
    let mm = |index: usize| grid.position(index) * state.unit.in_mm();
    let is_reached = |index: usize| {
        state.axis(base).map(AxisState::travel).is_none_or(|[low, high]| {
            (low.mm() - ROUNDING_MM..=high.mm() + ROUNDING_MM).contains(&mm(index))
        })
    };
    let written = written.filter(|(index, _)| is_reached(*index));
    let larger = |a: (usize, f64), b: (usize, f64)| if b.1.abs() > a.1.abs() { b } else { a };
    let (index, largest) = written.reduce(larger).unwrap_or_default();
    let zero = at_reference(state, table);
    let [largest, at, zero] =
        [largest, grid.position(index), zero].map(|number| trimmed(number, 6));
    format!(
        "{}{on}: {largest} {unit} with {base} at {at} {unit}{way}; {zero} {unit} with {base} at its reference point{way}",
        place.name()
    )
}

/// Table values in the control's unit, rounded to its last decimal.
fn values(
    task: Task<'_>,
    facts: &SiemensFacts,
    deviations: &[Deviation],
    place: &Place,
) -> Vec<Option<f64>> {
    let (sign, _) = facts.of_place(place);
    let per_unit = power_of_ten(facts.value_decimals.value);
    let value = |deviation: &Deviation| {
        let counts = (sign.table_um(*deviation) / task.unit_um() * per_unit).round();
        Some(counts / per_unit + 0.0) // + 0.0 turns −0 into 0
    };
    deviations.iter().map(value).collect()
}

/// What the control would cut off is refused before it is written.
fn check_sum(task: Task<'_>, tables: &SiemensTables, facts: &SiemensFacts) -> Result<(), Problems> {
    let (sum, limit) = (largest_sum_um(task, tables), facts.cec_max_sum_um.value);
    if sum <= limit {
        return Ok(());
    }
    Err(task.job.source.at("compensation.controller", refusals::cut_off(sum, limit)).into())
}

// What Siemens templates see: `lec`, `cec`, and the switches of both.

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

/// A machine or setting datum that a rollback restores: name without `$`, what stands in brackets, value.
fn datum(datum: &MachineDatum) -> Seen {
    let (name, indices) = datum.variable.split_once('[').unwrap_or((&*datum.variable, ""));
    let value = match &datum.value {
        MachineValue::Number(number) => number.to_string(),
        MachineValue::Text(text) => format!("({text})"),
    };
    seen! {
        "name": name.trim_start_matches('$'),
        "indices": indices.trim_end_matches(']'),
        "value": value,
    }
}

/// The term of a table in words, by the place it was put.
fn title(placements: &[Placement], place: &str) -> String {
    placements.iter().find(|p| p.place.split(", ").any(|one| one == place)).map_or_else(
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
