//! Siemens: positioning into ENC_COMP, everything else into CEC tables.
//!
//! * A positioning error for both directions goes into `$AA_ENC_COMP` of each physical axis;
//!   with separate tables for the directions into two CEC tables of the axis onto itself
//!   (Function Manual Extended Functions 03/2013, K3 section 4.4.4).
//! * A cross term goes into one CEC table (or two) for each physical output axis.
//! * No product tables are ever made: a misreading of their meaning moves an axis by millimetres.

use crate::axis::{Axis, Direction, ErrorTerm};
use crate::claims::{Assumption, Precondition};
use crate::compensation::{Compiled, Placement, backlash_why, control_state, two_tables_why};
use crate::controller::{SiemensFacts, TableSign};
use crate::grid::Grid;
use crate::job::ActiveTables;
use crate::plan::{Plan, PlannedTable, Task};
use crate::problem::Problems;
use crate::table::Tables;
use crate::table::siemens::{CecDirection, CecTable, LecTable, SiemensGrid, SiemensTables};
use crate::units::{Deviation, UM_PER_MM};

const K3: &str = "Function Manual Extended Functions 03/2013, K3";

/// Puts a plan into ENC_COMP and CEC tables.
pub fn compile(task: Task<'_>, plan: &Plan, facts: &SiemensFacts) -> Result<Compiled, Problems> {
    check_sum(task, plan, facts)?;
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
    let state = control_state(task, plan, |axis| {
        backlash_um(task, plan, axis).unwrap_or(0.0)
    });
    Ok(Compiled {
        assumptions: assumptions(task, plan, &tables),
        preconditions: preconditions(task, plan, &tables),
        notes: Vec::new(),
        tables: Tables::Siemens(tables),
        placements,
        state,
    })
}

/// Whether a planned table goes into ENC_COMP.
pub(crate) fn is_lec(planned: &PlannedTable) -> bool {
    planned.term.is_positioning() && planned.direction.is_none()
}

/// Index of the measuring system of an axis in the files: 0 = the first.
pub(crate) fn encoder(task: Task<'_>, axis: Axis) -> u32 {
    let system = task.job.compensation.axes[axis]
        .as_ref()
        .and_then(|s| s.measuring_system);
    system.unwrap_or(1) - 1
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
    let per_unit = 10_f64.powi(i32::try_from(facts.value_decimals.value).unwrap_or(0));
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
    let per_unit = 10_f64.powi(i32::try_from(facts.value_decimals.value).unwrap_or(0));
    task.job.compensation.control_unit.in_mm() * UM_PER_MM / per_unit
}

/// MD32450 as it is named: four decimals of a millimetre, five of an inch.
fn backlash_text(task: Task<'_>, um: f64) -> (String, f64) {
    let unit = task.job.compensation.control_unit;
    let decimals = match unit {
        crate::controller::LengthUnit::Millimetre => 4,
        crate::controller::LengthUnit::Inch => 5,
    };
    let text = format!("{:.decimals$}", um / (unit.in_mm() * UM_PER_MM) + 0.0);
    let rounded_um = text.parse::<f64>().unwrap_or(0.0) * unit.in_mm() * UM_PER_MM;
    (format!("{text} {}", unit.word()), rounded_um)
}

fn backlash_um(task: Task<'_>, plan: &Plan, axis: Axis) -> Option<f64> {
    plan.backlash_um[axis].map(|um| backlash_text(task, um).1)
}

fn assumptions(task: Task<'_>, plan: &Plan, tables: &SiemensTables) -> Vec<Assumption> {
    let mut assumptions = Vec::new();
    let has_lec = |axis: Axis| plan.tables.iter().any(|t| is_lec(t) && t.term.of == axis);
    for axis in Axis::ALL {
        let settings = task.job.compensation.axes[axis].as_ref();
        if has_lec(axis) && settings.is_some_and(|s| s.measuring_system.is_none()) {
            assumptions.push(Assumption::of_job(
                format!("measuring_system_{}", axis.key()),
                "1 (motor encoder)",
                format!("the ENC_COMP table of {axis} would stay without effect where a direct scale is active: state `measuring_system`"),
            ));
        }
    }
    if !tables.cec.is_empty() && task.job.compensation.first_table.is_none() {
        assumptions.push(Assumption::of_job(
            "first_table",
            "0",
            "CEC tables already in use from index 0 would be overwritten: state `first_table`",
        ));
    }
    assumptions
}

fn preconditions(task: Task<'_>, plan: &Plan, tables: &SiemensTables) -> Vec<Precondition> {
    let mut list = vec![basic_system(task)];
    for table in &tables.lec {
        list.push(Precondition::new(
            format!(
                "MD32700 $MA_ENC_COMP_ENABLE[{},{}]",
                table.encoder, table.axis
            ),
            "0 while the tables are loaded",
            "1 write-protects the table (alarm 17070)",
            format!("808D Function Manual 01/2017 p. 109; {K3} p. 237"),
        ));
    }
    if !tables.cec.is_empty() {
        list.extend(cec_preconditions(task, plan, tables));
    }
    for axis in Axis::ALL {
        list.extend(backlash_precondition(task, plan, axis));
    }
    list.push(Precondition::new(
        "reference points",
        reference_text(task),
        "the tables are zero there; a table that is not zero at the real reference point moves the axis when it is switched on",
        format!("{K3} p. 238"),
    ));
    list
}

fn basic_system(task: Task<'_>) -> Precondition {
    let value = match task.job.compensation.control_unit {
        crate::controller::LengthUnit::Millimetre => "1 (metric)",
        crate::controller::LengthUnit::Inch => "0 (inch)",
    };
    Precondition::new(
        "MD10240 $MN_SCALING_SYSTEM_IS_METRIC",
        value,
        "positions and values of the tables are in the basic system",
        "802D sl Function Manual 11/2012 p. 222",
    )
}

fn cec_preconditions(task: Task<'_>, plan: &Plan, tables: &SiemensTables) -> Vec<Precondition> {
    let metric = match task.job.compensation.control_unit {
        crate::controller::LengthUnit::Millimetre => "1 (metric)",
        crate::controller::LengthUnit::Inch => "0 (inch)",
    };
    let numbers: Vec<String> = tables.cec.iter().map(|t| t.number.to_string()).collect();
    let mut outputs: Vec<&str> = tables.cec.iter().map(|t| t.output_axis.as_str()).collect();
    outputs.sort_unstable();
    outputs.dedup();
    vec![
        Precondition::new(
            "option sag compensation (CEC)",
            "active",
            "without it the tables stay without effect (alarm 8040 or 8081)",
            "802D sl Function Manual 11/2012 p. 214",
        ),
        Precondition::new(
            "MD32711 $MA_CEC_SCALING_SYSTEM_METRIC",
            metric,
            "unit system of the CEC data where MD10260 = 1",
            "802D sl Function Manual 11/2012 p. 222",
        ),
        Precondition::new(
            "MD32720 $MA_CEC_MAX_SUM",
            format!(
                "at least {:.3} mm",
                (largest_sum_um(plan) / UM_PER_MM * 1000.0).ceil() / 1000.0
            ),
            "the largest sum of CEC corrections of this kit; a larger one than the limit is cut off (alarm 20124)",
            "from memory, not read in a manual",
        ),
        Precondition::new(
            format!("MD32710 $MA_CEC_ENABLE[{}]", outputs.join(", ")),
            "0 while the tables are loaded",
            "tables can only be loaded while CEC is off",
            format!("{K3} p. 237"),
        ),
        Precondition::new(
            format!("other CEC tables of {}", outputs.join(", ")),
            "absent, or meant to act",
            "MD32710 in the enable and disable files switches every CEC table of an axis",
            format!("{K3} p. 245"),
        ),
        Precondition::new(
            format!("SD41310 $SN_CEC_TABLE_WEIGHT[{}]", numbers.join(", ")),
            "1",
            "a factor on each table",
            "a real archive holds 1 everywhere",
        ),
        Precondition::new(
            format!("CEC tables {}", numbers.join(", ")),
            match task.job.measurement.active {
                ActiveTables::Path(_) => {
                    "free (not in use), or held by the tables that were active"
                }
                _ => "free (not in use)",
            },
            "existing tables of these numbers are overwritten",
            "`first_table` of the job",
        ),
    ]
}

fn backlash_precondition(task: Task<'_>, plan: &Plan, axis: Axis) -> Vec<Precondition> {
    let term = ErrorTerm {
        of: axis,
        along: axis,
    };
    if !plan.tables.iter().any(|t| t.term == term) {
        return Vec::new();
    }
    let (value, why) = match plan.backlash_um[axis] {
        Some(um) => (backlash_text(task, um).0, backlash_why(task.job, axis)),
        None if has_two_tables(plan, axis) => ("0".to_string(), two_tables_why(task.job, axis)),
        _ => (
            "as during the measurement".to_string(),
            "backlash acts beside the table and adds to it",
        ),
    };
    let system = encoder(task, axis);
    plan.names[axis]
        .iter()
        .map(|name| {
            Precondition::new(
                format!("MD32450 $MA_BACKLASH[{system},{name}]"),
                value.clone(),
                why,
                format!("{K3} p. 277 (sum in the service display)"),
            )
        })
        .chain(no_second_table(plan, axis))
        .collect()
}

fn has_two_tables(plan: &Plan, axis: Axis) -> bool {
    let own = |t: &&PlannedTable| t.term.is_positioning() && t.term.of == axis;
    plan.tables
        .iter()
        .filter(own)
        .any(|t| t.direction.is_some())
}

fn no_second_table(plan: &Plan, axis: Axis) -> Vec<Precondition> {
    if !has_two_tables(plan, axis) {
        return Vec::new();
    }
    plan.names[axis]
        .iter()
        .map(|name| {
            Precondition::new(
                format!("MD32700 $MA_ENC_COMP_ENABLE[0,{name}] and [1,{name}]"),
                "0",
                "the positioning error is in CEC tables; an ENC_COMP table with the same error would correct it twice",
                format!("{K3} section 4.4.4"),
            )
        })
        .collect()
}

/// Largest sum of CEC corrections of an output axis, µm: the largest value of each table, the
/// worse direction of each base axis, added up over the base axes. A bound, not a place.
fn largest_sum_um(plan: &Plan) -> f64 {
    let of_term = |term: ErrorTerm| {
        let tables = plan.tables.iter().filter(|t| t.term == term && !is_lec(t));
        tables
            .flat_map(|t| &t.values)
            .map(|value| value.um().abs())
            .fold(0.0, f64::max)
    };
    let of_output = |of: Axis| {
        Axis::ALL
            .iter()
            .map(|along| of_term(ErrorTerm { of, along: *along }))
            .sum::<f64>()
    };
    Axis::ALL.into_iter().map(of_output).fold(0.0, f64::max)
}

/// What the control would cut off is refused before it is written.
fn check_sum(task: Task<'_>, plan: &Plan, facts: &SiemensFacts) -> Result<(), Problems> {
    let (sum, limit) = (largest_sum_um(plan), facts.cec_max_sum_um.value);
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

/// Machine coordinates of the reference points, as they stand in files and preconditions.
pub(crate) fn reference_text(task: Task<'_>) -> String {
    let texts: Vec<String> = task
        .job
        .machine
        .axes
        .iter()
        .filter_map(|(axis, machine)| {
            let text = format!("{:.6}", machine.as_ref()?.reference.mm() + 0.0);
            let text = text.trim_end_matches('0').trim_end_matches('.');
            Some(format!("{axis} {text} mm"))
        })
        .collect();
    texts.join(", ")
}
