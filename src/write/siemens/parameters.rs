//! What stands beside the tables on a Siemens control: encoder, backlash, value at the reference point,
//! largest sum; and what a person has to see to: switches, memory, limits.

use crate::control::claims::{Assumption, Precondition};
use crate::control::control_state::ControlState;
use crate::control::controller::ControlUnit;
use crate::control::table::siemens::{SiemensTable, SiemensTables};
use crate::inputs::job::ActiveTables;
use crate::quantity::{Axis, Figure, UM_PER_MM, power_of_ten};
use crate::text::joined;
use crate::write::family::backlash_parameter;
use crate::write::task::{Plan, PlannedTable, Task};

/// Whether a planned table goes into ENC_COMP.
pub(crate) fn is_lec(planned: &PlannedTable) -> bool {
    planned.term.is_positioning() && planned.direction.is_none()
}

/// Index of the measuring system of an axis in the files: 0 = the first.
pub(crate) fn encoder(task: Task<'_>, axis: Axis) -> u32 {
    task.settings(axis).and_then(|s| s.measuring_system).unwrap_or(1) - 1
}

/// MD32450 as it is named: four decimals of a millimetre, five of an inch.
pub(super) fn backlash_text(task: Task<'_>, um: f64) -> (String, f64) {
    let unit = task.job.compensation.control_unit;
    let decimals = match unit {
        ControlUnit::Millimetre => 4,
        ControlUnit::Inch => 5,
    };
    let text = format!("{:.decimals$}", Figure(um / task.unit_um()));
    let rounded_um = text.parse::<f64>().unwrap_or(0.0) * unit.in_mm() * UM_PER_MM;
    (format!("{text} {}", unit.word()), rounded_um)
}

/// Largest sum of CEC corrections of any output axis, µm ([`SiemensTables::largest_cec_sum`]).
pub(super) fn largest_sum_um(task: Task<'_>, tables: &SiemensTables) -> f64 {
    let sums = tables.cec_outputs().into_iter().map(|output| tables.largest_cec_sum(&output));
    sums.fold(0.0, f64::max) * task.unit_um()
}

/// What a table holds at the reference point of its base axis, in the unit of the file.
pub(crate) fn at_reference(state: &ControlState, table: &SiemensTable) -> f64 {
    let reference = state.axis(&table.input_axis).map(|axis| axis.reference.mm());
    let position = reference.map(|mm| mm / state.unit.in_mm());
    position.and_then(|position| table.grid.nearest(&table.values, position)).unwrap_or(0.0)
}

const K3: &str = "Function Manual Extended Functions 03/2013, K3";

pub(super) fn assumptions(task: Task<'_>, plan: &Plan, tables: &SiemensTables) -> Vec<Assumption> {
    let mut assumptions = Vec::new();
    let has_lec = |axis: Axis| plan.of_axis(axis).any(is_lec);
    for axis in Axis::ALL {
        if has_lec(axis) && task.settings(axis).is_some_and(|s| s.measuring_system.is_none()) {
            assumptions.push(Assumption::of_job(
                format!("measuring_system_{}", axis.key()),
                "1 (motor encoder)",
                format!("the ENC_COMP table of {axis} would stay without effect where a direct scale is active: state `measuring_system`"),
            ));
        }
    }
    if tables.cec().next().is_some() && task.job.compensation.first_table.is_none() {
        let first = Assumption::of_job(
            "first_table",
            "0",
            "CEC tables already in use from index 0 would be overwritten: state `first_table`",
        );
        assumptions.push(first.undecided());
    }
    assumptions
}

pub(super) fn preconditions(
    task: Task<'_>,
    plan: &Plan,
    tables: &SiemensTables,
) -> Vec<Precondition> {
    let mut list = vec![Precondition::new(
        "MD10240 $MN_SCALING_SYSTEM_IS_METRIC",
        task.job.compensation.control_unit.as_metric(),
        "positions and values of the tables are in the basic system; in the other one every movement is 25.4 times as large or as small",
        "802D sl Function Manual 11/2012 p. 222",
    ).dangerous()];
    for table in tables.lec() {
        list.push(Precondition::new(
            format!("MD32700 $MA_ENC_COMP_ENABLE[{}]", table.place.index()),
            "0 while the tables are loaded",
            "1 write-protects the table (alarm 17070)",
            format!("808D Function Manual 01/2017 p. 109; {K3} p. 237"),
        ));
    }
    if tables.cec().next().is_some() {
        list.extend(cec_preconditions(task, tables));
    }
    for axis in Axis::ALL {
        list.extend(backlash_precondition(task, plan, axis));
    }
    list.push(Precondition::new(
        "reference points",
        task.reference_text(),
        "the tables are zero there, of two tables for the directions that of the reference return; a table that is not zero at the real reference point moves the axis when it is switched on (MD34100 holds the position where the measuring system is incremental, from memory)",
        format!("{K3} p. 238"),
    ).dangerous());
    list
}

fn cec_preconditions(task: Task<'_>, tables: &SiemensTables) -> Vec<Precondition> {
    let metric = task.job.compensation.control_unit.as_metric();
    let numbers = joined(tables.cec().map(|t| t.place.index()));
    let outputs = tables.cec_outputs().join(", ");
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
        )
        .dangerous(),
        max_sum_precondition(task, tables),
        Precondition::new(
            format!("MD32710 $MA_CEC_ENABLE[{outputs}]"),
            "0 while the tables are loaded",
            "tables can only be loaded while CEC is off",
            format!("{K3} p. 237"),
        ),
        Precondition::new(
            format!("other CEC tables of {outputs}"),
            "absent, or meant to act",
            "MD32710 in the enable and disable files switches every CEC table of an axis",
            format!("{K3} p. 245"),
        )
        .dangerous(),
        Precondition::new(
            format!("SD41310 $SN_CEC_TABLE_WEIGHT[{numbers}]"),
            "1",
            "a factor on each table",
            "a real archive holds 1 everywhere",
        ),
        Precondition::new(
            format!("CEC tables {numbers}"),
            match task.job.measurement.active {
                ActiveTables::Path(_) => {
                    "free (not in use), or held by the tables that were active"
                }
                _ => "free (not in use)",
            },
            "existing tables of these numbers are overwritten",
            "`first_table` of the job",
        )
        .dangerous(),
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
        ControlUnit::Millimetre => 3,
        ControlUnit::Inch => 4,
    };
    let digits = power_of_ten(decimals);
    let in_unit = |um: f64| {
        let length = (um / task.unit_um() * digits - 1e-6).ceil() / digits;
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
    if plan.of_axis(axis).next().is_none() {
        return Vec::new();
    }
    let system = encoder(task, axis);
    let names = plan.names[axis].iter();
    let backlash = names.clone().map(|name| {
        let what = format!("MD32450 $MA_BACKLASH[{system},{name}]");
        let source = format!("{K3} p. 277 (sum in the service display)");
        backlash_parameter(task, plan, axis, what, |um| backlash_text(task, um).0, &source)
    });
    let no_second_table = names.map(|name| {
        let (what, value, why) = match plan.has_two_tables(axis) {
            true => (
                format!("MD32700 $MA_ENC_COMP_ENABLE[0,{name}] and [1,{name}]"),
                "0",
                "the positioning error is in CEC tables; an ENC_COMP table with the same error would correct it twice",
            ),
            false => (
                format!("SD41300 $SN_CEC_TABLE_ENABLE of every CEC table from an axis to itself, {name}"),
                "0, or no such table exists",
                "the positioning error is in ENC_COMP; CEC tables with the same error (an earlier kit with `two-tables`) would correct it twice",
            ),
        };
        Precondition::new(what, value, why, format!("{K3} section 4.4.4"))
    });
    backlash.chain(no_second_table).collect()
}
