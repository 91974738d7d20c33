//! Siemens: positioning into ENC_COMP, everything else into CEC tables.
//!
//! * A positioning error for both directions goes into `$AA_ENC_COMP` of each physical axis;
//!   with separate tables for the directions into two CEC tables of the axis onto itself
//!   (Function Manual Extended Functions 03/2013, K3 section 4.4.4).
//! * A cross term goes into one CEC table (or two) for each physical output axis.
//! * No product tables are ever made: a misreading of their meaning moves an axis by millimetres.

mod parameters;
mod requirements;

pub(crate) use self::parameters::{at_reference, encoder, is_lec, reference_text};
use self::parameters::{backlash_text, largest_sum_um};

use crate::control::controller::{SiemensFacts, TableSign};
use crate::control::table::Tables;
use crate::control::table::siemens::{
    CecDirection, CecTable, LecTable, SiemensGrid, SiemensTables,
};
use crate::quantity::axis::{Axis, Direction};
use crate::quantity::units::{Deviation, UM_PER_MM, power_of_ten};
use crate::text::problem::Problems;
use crate::write::compensation::compiled::control_state;
use crate::write::compensation::{Compiled, Placement};
use crate::write::grid::Grid;
use crate::write::plan::{Plan, PlannedTable, Task};

/// Puts a plan into ENC_COMP and CEC tables.
pub fn compile(task: Task<'_>, plan: &Plan, facts: &SiemensFacts) -> Result<Compiled, Problems> {
    let mut tables = SiemensTables::default();
    let mut placements = Vec::new();
    let mut number = task.job.compensation.first_table.unwrap_or(0);
    for planned in &plan.tables {
        let mut places = Vec::new();
        for output in &plan.names[planned.term.of] {
            if is_lec(planned) {
                let table = lec_table(task, facts, planned, output);
                places.push(format!("ENC_COMP[{},{}]", table.encoder, table.axis));
                tables.lec.push(table);
            } else {
                places.push(format!("CEC table {number}"));
                tables
                    .cec
                    .push(cec_table(task, plan, facts, planned, output, number));
                number += 1;
            }
        }
        placements.push(Placement {
            term: planned.term,
            direction: planned.direction,
            place: places.join(", "),
            points: planned.grid.count(),
            count_um: count_um(task, facts),
            grid_residual_um: planned.grid_residual_um,
            fit_residual_um: None,
        });
    }
    tables
        .lec
        .sort_by(|a, b| (&a.axis, a.encoder).cmp(&(&b.axis, b.encoder)));
    check_sum(task, &tables, facts)?;
    let state = control_state(task, plan, |axis| {
        backlash_um(task, plan, axis).unwrap_or(0.0)
    });
    Ok(Compiled {
        assumptions: requirements::assumptions(task, plan, &tables),
        preconditions: requirements::preconditions(task, plan, &tables),
        notes: Vec::new(),
        tables: Tables::Siemens(tables),
        placements,
        state,
    })
}

fn lec_table(task: Task<'_>, facts: &SiemensFacts, planned: &PlannedTable, axis: &str) -> LecTable {
    LecTable {
        encoder: encoder(task, planned.term.of),
        axis: axis.to_string(),
        grid: siemens_grid(&planned.grid),
        values: values(task, facts, &planned.values, facts.lec_sign.value),
        modulo: false,
    }
}

fn cec_table(
    task: Task<'_>,
    plan: &Plan,
    facts: &SiemensFacts,
    planned: &PlannedTable,
    output: &str,
    number: u32,
) -> CecTable {
    // An axis that corrects itself is its own base, also each axis of a gantry; otherwise the
    // first physical axis of the moving axis is the base.
    let input = if planned.term.is_positioning() {
        output
    } else {
        &plan.names[planned.term.along][0]
    };
    CecTable {
        number,
        input_axis: input.to_string(),
        output_axis: output.to_string(),
        grid: siemens_grid(&planned.grid),
        values: values(task, facts, &planned.values, facts.cec_sign.value),
        direction: match planned.direction {
            None => CecDirection::Both,
            Some(Direction::Plus) => CecDirection::Plus,
            Some(Direction::Minus) => CecDirection::Minus,
        },
        multiply_by: 0,
        modulo: false,
    }
}

/// MIN, STEP and MAX in the control's unit, from whole last digits so that (MAX − MIN)/STEP is a
/// whole number.
#[allow(
    clippy::cast_precision_loss,
    reason = "lengths are far below 2^52 last digits"
)]
fn siemens_grid(grid: &Grid) -> SiemensGrid {
    let per_unit = grid.digit.per_unit();
    let reference = (grid.reference.mm() / grid.digit.mm()).round();
    let at = |index: i64| (reference + (index * grid.spacing_digits) as f64) / per_unit + 0.0;
    SiemensGrid {
        min: at(grid.first),
        step: grid.spacing_digits as f64 / per_unit,
        max: at(grid.last),
    }
}

/// Table values in the control's unit, rounded to its last decimal.
pub(crate) fn values(
    task: Task<'_>,
    facts: &SiemensFacts,
    deviations: &[Deviation],
    sign: TableSign,
) -> Vec<Option<f64>> {
    let per_unit = power_of_ten(facts.value_decimals.value);
    let um_per_unit = task.job.compensation.control_unit.in_mm() * UM_PER_MM;
    deviations
        .iter()
        .map(|deviation| {
            let counts = (sign.table_um(*deviation) / um_per_unit * per_unit).round();
            Some(counts / per_unit + 0.0) // + 0.0 turns −0 into 0
        })
        .collect()
}

fn count_um(task: Task<'_>, facts: &SiemensFacts) -> f64 {
    let per_unit = power_of_ten(facts.value_decimals.value);
    task.job.compensation.control_unit.in_mm() * UM_PER_MM / per_unit
}

fn backlash_um(task: Task<'_>, plan: &Plan, axis: Axis) -> Option<f64> {
    plan.backlash_um[axis].map(|um| backlash_text(task, um).1)
}

/// What the control would cut off is refused before it is written.
fn check_sum(task: Task<'_>, tables: &SiemensTables, facts: &SiemensFacts) -> Result<(), Problems> {
    let (sum, limit) = (largest_sum_um(task, tables), facts.cec_max_sum_um.value);
    if sum <= limit {
        return Ok(());
    }
    Err(task
        .job
        .problem_at(
            "compensation.controller",
            format!("CEC corrections may add up to {sum:.0} µm, more than the {limit} µm at which the control cuts off (MD32720)"),
        )
        .help("check the measurement; a control with another MD32720 needs a profile with its own `cec_max_sum_um`")
        .into())
}
