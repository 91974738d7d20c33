//! The generic table: deviation, correction and increment of every point (contract §4.1).
//! Unrounded, unless the corrected axis has a detection unit.

use crate::control::claims::Precondition;
use crate::control::table::Tables;
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::quantity::axis::Axis;
use crate::quantity::units::{Deviation, power_of_ten};
use crate::write::compensation::compiled::control_state;
use crate::write::compensation::{Compiled, Placement, backlash_why};
use crate::write::plan::{Plan, PlannedTable, Task};

/// Puts a plan into rows.
pub fn compile(task: Task<'_>, plan: &Plan) -> Compiled {
    let mut rows = Vec::new();
    let mut placements = Vec::new();
    for planned in &plan.tables {
        let unit_um = detection_unit(task, planned.term.of);
        for output in &plan.names[planned.term.of] {
            rows.extend(table_rows(plan, planned, output, unit_um));
        }
        placements.push(Placement {
            term: planned.term,
            direction: planned.direction,
            place: "rows".to_string(),
            points: planned.grid.count(),
            count_um: unit_um.unwrap_or(0.0),
            grid_residual_um: planned.grid_residual_um,
            fit_residual_um: None,
        });
    }
    Compiled {
        tables: Tables::Generic(GenericTable { rows }),
        placements,
        state: control_state(task, plan, |axis| {
            plan.backlash_um[axis].map_or(0.0, tenth_of_a_micron)
        }),
        assumptions: Vec::new(),
        preconditions: backlash(task, plan),
        notes: Vec::new(),
    }
}

fn detection_unit(task: Task<'_>, axis: Axis) -> Option<f64> {
    task.job.compensation.axes[axis].as_ref()?.detection_unit_um
}

fn table_rows(
    plan: &Plan,
    planned: &PlannedTable,
    output: &str,
    unit_um: Option<f64>,
) -> Vec<GenericRow> {
    let base = if planned.term.is_positioning() {
        output
    } else {
        &plan.names[planned.term.along][0]
    };
    let mut before: Option<f64> = None;
    let mut rows = Vec::new();
    for (index, value) in planned.values.iter().enumerate() {
        let deviation = rounded(*value, unit_um);
        let correction_um = (-deviation).um() + 0.0;
        let at = planned.grid.first + i64::try_from(index).unwrap_or(0);
        rows.push(GenericRow {
            term: planned.term,
            base_axis: base.into(),
            output_axis: output.into(),
            direction: planned.direction,
            index: u32::try_from(index).unwrap_or(u32::MAX),
            position_mm: decimals(planned.grid.position(at).mm(), POSITION_DECIMALS),
            deviation_um: deviation.um() + 0.0,
            correction_um,
            increment_um: before.map(|b| increment(correction_um - b, unit_um)),
        });
        before = Some(correction_um);
    }
    rows
}

/// Positions are written to the nanometre.
const POSITION_DECIMALS: u32 = 6;
/// Multiples of a detection unit are freed from binary dust at a femtometre.
const DUST_DECIMALS: u32 = 9;

fn rounded(value: Deviation, unit_um: Option<f64>) -> Deviation {
    match unit_um {
        Some(unit) => {
            Deviation::from_um(decimals((value.um() / unit).round() * unit, DUST_DECIMALS))
        }
        None => value,
    }
}

fn increment(um: f64, unit_um: Option<f64>) -> f64 {
    match unit_um {
        Some(_) => decimals(um, DUST_DECIMALS),
        None => um + 0.0,
    }
}

fn decimals(number: f64, decimals: u32) -> f64 {
    let scale = power_of_ten(decimals);
    (number * scale).round() / scale + 0.0
}

fn tenth_of_a_micron(um: f64) -> f64 {
    decimals(um, 1)
}

fn backlash(task: Task<'_>, plan: &Plan) -> Vec<Precondition> {
    plan.backlash_um
        .iter()
        .filter_map(|(axis, um)| {
            Some(Precondition {
                entered: true,
                ..Precondition::new(
                    format!("backlash parameter of {axis}"),
                    format!("{:.1} µm", tenth_of_a_micron((*um)?)),
                    backlash_why(task.job, axis),
                    "contract of the generic table",
                )
            })
        })
        .collect()
}
