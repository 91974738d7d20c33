//! What a person has to see to on the control: switches, memory, limits, backlash, reference.

use super::{backlash_text, encoder, is_lec, largest_sum_um, reference_text};
use crate::control::claims::{Assumption, Precondition};
use crate::control::controller::LengthUnit;
use crate::control::table::siemens::SiemensTables;
use crate::inputs::job::ActiveTables;
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::units::{Figure, UM_PER_MM, power_of_ten};
use crate::write::compensation::{backlash_why, two_tables_why};
use crate::write::plan::{Plan, PlannedTable, Task};

const K3: &str = "Function Manual Extended Functions 03/2013, K3";

pub(super) fn assumptions(task: Task<'_>, plan: &Plan, tables: &SiemensTables) -> Vec<Assumption> {
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

pub(super) fn preconditions(
    task: Task<'_>,
    plan: &Plan,
    tables: &SiemensTables,
) -> Vec<Precondition> {
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
        list.extend(cec_preconditions(task, tables));
    }
    for axis in Axis::ALL {
        list.extend(backlash_precondition(task, plan, axis));
    }
    list.push(Precondition::new(
        "reference points",
        reference_text(task),
        "the tables are zero there, of two tables for the directions that of the reference return; a table that is not zero at the real reference point moves the axis when it is switched on (MD34100 holds the position where the measuring system is incremental, from memory)",
        format!("{K3} p. 238"),
    ));
    list
}

fn basic_system(task: Task<'_>) -> Precondition {
    Precondition::new(
        "MD10240 $MN_SCALING_SYSTEM_IS_METRIC",
        task.job.compensation.control_unit.as_metric(),
        "positions and values of the tables are in the basic system",
        "802D sl Function Manual 11/2012 p. 222",
    )
}

fn cec_preconditions(task: Task<'_>, tables: &SiemensTables) -> Vec<Precondition> {
    let metric = task.job.compensation.control_unit.as_metric();
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
        max_sum_precondition(task, tables),
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

/// MD32720 must let through what the kit holds and the bump of its sign proof.
fn max_sum_precondition(task: Task<'_>, tables: &SiemensTables) -> Precondition {
    let limits = task.job.limits;
    let bump_um = limits.max_bump_um.min(limits.max_correction_um);
    let sum_um = largest_sum_um(task, tables);
    let unit = task.job.compensation.control_unit;
    // Rounded up, so that the limit lets everything through.
    let decimals = match unit {
        LengthUnit::Millimetre => 3,
        LengthUnit::Inch => 4,
    };
    let digits = power_of_ten(decimals);
    let in_unit = |um: f64| {
        let length = (um / (unit.in_mm() * UM_PER_MM) * digits - 1e-6).ceil() / digits;
        format!("{:.*} {}", decimals as usize, Figure(length), unit.word())
    };
    Precondition::new(
        "MD32720 $MA_CEC_MAX_SUM",
        format!("at least {}", in_unit(sum_um.max(bump_um))),
        format!(
            "the CEC corrections of this kit add up to {} at most, the bump of a sign proof to {}; more than the limit is cut off (alarm 20124)",
            in_unit(sum_um),
            in_unit(bump_um)
        ),
        "from memory, not read in a manual",
    )
}

fn backlash_precondition(task: Task<'_>, plan: &Plan, axis: Axis) -> Vec<Precondition> {
    let term = ErrorTerm {
        of: axis,
        along: axis,
    };
    if !plan.tables.iter().any(|t| t.term == term) {
        return Vec::new();
    }
    let (value, why, entered) = match plan.backlash_um[axis] {
        Some(um) => (
            backlash_text(task, um).0,
            backlash_why(task.job, axis),
            true,
        ),
        None if has_two_tables(plan, axis) => {
            ("0".to_string(), two_tables_why(task.job, axis), true)
        }
        _ => (
            "as during the measurement".to_string(),
            "backlash acts beside the table and adds to it",
            false,
        ),
    };
    let system = encoder(task, axis);
    plan.names[axis]
        .iter()
        .map(|name| Precondition {
            entered,
            ..Precondition::new(
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
