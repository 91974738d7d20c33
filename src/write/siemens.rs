//! Siemens: positioning into ENC_COMP, everything else into CEC tables.
//!
//! * A positioning error for both directions goes into `$AA_ENC_COMP` of each physical axis;
//!   with separate tables for the directions into two CEC tables of the axis onto itself
//!   (Function Manual Extended Functions 03/2013, K3 section 4.4.4).
//! * A cross term goes into one CEC table (or two) for each physical output axis.
//! * No product tables are ever made: a misreading of their meaning moves an axis by millimetres.

mod context;
mod parameters;

pub(crate) use self::parameters::encoder;

use self::parameters::{
    assumptions, at_reference, backlash_text, is_lec, largest_sum_um, preconditions,
};
use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, Mechanism, SiemensFacts};
use crate::control::table::Tables;
use crate::control::table::siemens::{Place, SiemensGrid, SiemensTable, SiemensTables};
use crate::inputs::job::Compensation;
use crate::quantity::{Deviation, ErrorTerm, power_of_ten};
use crate::text::Problems;
use crate::write::compiled::{Compiled, Placement, control_state};
use crate::write::control_text::{Seen, trimmed};
use crate::write::family::{Emitted, Family, ProofOf};
use crate::write::grid::{Grid, LengthDigit};
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task, axis_pairs};

impl Family for SiemensFacts {
    fn expected_name(&self, name: &str) -> Option<&'static str> {
        let is_capital = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
        let is_right = name.starts_with(|c: char| c.is_ascii_uppercase());
        (!is_right || !name.chars().all(is_capital))
            .then_some("a machine axis name in capitals, e.g. \"AX1\"")
    }

    fn length_digit(&self, unit: ControlUnit) -> LengthDigit {
        let decimals = self.position_decimals.value;
        LengthDigit { unit, decimals }
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
            let mut places = Vec::new();
            for output in &plan.names[planned.term.of] {
                let place = match is_lec(planned) {
                    true => {
                        let encoder = encoder(task, planned.term.of);
                        Place::Lec { axis: output.clone(), encoder }
                    }
                    false => Place::Cec(number),
                };
                number += u32::from(place.cec().is_some());
                places.push(place.name());
                tables.push(SiemensTable {
                    input_axis: plan.base_of(planned.term, output).to_string(),
                    output_axis: output.clone(),
                    grid: siemens_grid(&planned.grid),
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
        Ok(Compiled {
            assumptions: assumptions(task, plan, &tables),
            preconditions: preconditions(task, plan, &tables),
            stale: Vec::new(),
            notes: Vec::new(),
            state: control_state(task, plan, |axis| plan.backlash_um[axis].map_or(0.0, backlash)),
            tables: Tables::Siemens(tables),
            placements,
        })
    }

    fn uses(&self, mechanism: Mechanism, _plan: &Plan, tables: &Tables) -> bool {
        let Tables::Siemens(tables) = tables else {
            return true;
        };
        match mechanism {
            Mechanism::EncComp => tables.lec().next().is_some(),
            Mechanism::Cec => tables.cec().next().is_some(),
            Mechanism::CecProducts => tables.tables.iter().any(|table| table.multiply_by != 0),
            _ => true,
        }
    }

    fn context(&self, emitted: &Emitted<'_>) -> Option<Seen> {
        let tables: &SiemensTables = emitted.tables.own()?;
        Some(context::context(emitted, tables, self))
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        is_lec(table) == (mechanism == Mechanism::EncComp)
    }

    fn cut_off_um(&self, _task: Task<'_>, table: &PlannedTable) -> f64 {
        match is_lec(table) {
            true => f64::INFINITY,
            false => self.cec_max_sum_um.value,
        }
    }

    /// One place of each table: where it holds most.
    fn displayed(&self, tables: &Tables, state: &ControlState) -> Vec<String> {
        let Tables::Siemens(tables) = tables else {
            return Vec::new();
        };
        tables.tables.iter().map(|table| shown(state, table)).collect()
    }

    /// Every physical axis of the term has the bump, so that the two sides of a gantry move alike; CEC tables
    /// of the term have it in both directions.
    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let kit: &SiemensTables = proof.kit.own()?;
        let pairs = axis_pairs(&proof.plan.names, proof.term);
        let is_lec = proof.mechanism == Mechanism::EncComp;
        let own = kit.tables.iter().filter(|table| table.place.lec().is_some() == is_lec);
        let with_bump = own.map(|table| {
            let pair = (table.input_axis.as_str(), table.output_axis.as_str());
            let deviations = proof.deviations(pairs.contains(&pair), table.values.len());
            let values = values(proof.task, self, &deviations, &table.place);
            SiemensTable { values, ..table.clone() }
        });
        Some(Tables::Siemens(SiemensTables { tables: with_bump.collect() }))
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
    let written = values.iter().enumerate();
    let written = written.filter_map(|(i, v)| Some((i, (*v)?)));
    // The last point may lie behind the end of the travel: the axis cannot go there.
    let mm = |index: usize| grid.position(index) * state.unit.in_mm();
    let is_reached = |index: usize| {
        let travel = state.axis(base).map(|own| own.travel);
        travel.is_none_or(|(low, high)| {
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

/// MIN, STEP and MAX in the control's unit, from whole last digits so that (MAX − MIN)/STEP is a
/// whole number.
fn siemens_grid(grid: &Grid) -> SiemensGrid {
    SiemensGrid {
        min: grid.written(grid.first),
        step: grid.written_spacing(),
        max: grid.written(grid.last),
    }
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
    let words = format!(
        "CEC corrections may add up to {sum:.0} µm, more than the {limit} µm at which the control cuts off (MD32720)"
    );
    let help = "check the measurement; a control with another MD32720 needs a profile with its own `cec_max_sum_um`";
    Err(task.job.problem_at("compensation.controller", words).help(help).into())
}
