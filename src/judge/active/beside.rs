//! The old tables and the new ones in one control: what would be overwritten though it belongs to
//! others, and what would stay and act a second time.

use super::{ActiveControl, problem};
use crate::control::claims::Precondition;
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterValue};
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::control::table::siemens::SiemensTables;
use crate::inputs::job::Job;
use crate::text::problem::Problems;

/// New tables at places that others own; all of them at once.
pub fn collisions(job: &Job, active: &ActiveControl, new: &Tables) -> Result<(), Problems> {
    let mut problems = Problems::none();
    let mut refuse = |what: String, help: &str| {
        let message = format!(
            "{what} is in use in the read-out, for axes that the job does not have or switched off: it would be overwritten"
        );
        problems.push(problem(job, message, help));
    };
    match new {
        Tables::Siemens(new) => {
            for table in new
                .cec
                .iter()
                .filter(|t| active.others.cec_tables.contains(&t.number))
            {
                refuse(
                    format!("CEC table {}", table.number),
                    "state a `first_table` behind it in [compensation]",
                );
            }
        }
        Tables::Fanuc(new) => {
            for set in &active.others.sets {
                if number(new, 5710 + set, None) != 0 {
                    refuse(
                        format!("straightness set {set}"),
                        "state a `first_set` behind it in [compensation]",
                    );
                }
            }
            for range in &active.others.points {
                if new.points.range(range.first..=range.last).next().is_some() {
                    refuse(
                        format!("the block of points {} to {}", range.first, range.last),
                        "name it in `reserved_points` of [compensation], or move `first_point`",
                    );
                }
            }
        }
        Tables::Generic(_) => {}
    }
    problems.or_ok(())
}

const WHY: &str = "an old table that the new files do not overwrite would act beside them";
const SOURCE: &str = "the active tables that the job names";

/// Old tables that the new files leave in the control: each has to be switched off.
pub fn left_over(active: &ActiveControl, new: &Tables) -> Vec<Precondition> {
    let stale = |what: String, value: &str| Precondition::new(what, value, WHY, SOURCE);
    match (&active.tables, new) {
        (Tables::Siemens(old), Tables::Siemens(new)) => left_over_siemens(old, new)
            .into_iter()
            .map(|what| stale(what, "0"))
            .collect(),
        (Tables::Fanuc(old), Tables::Fanuc(new)) => left_over_fanuc(old, new)
            .into_iter()
            .map(|what| stale(what, "0"))
            .collect(),
        (Tables::Generic(old), Tables::Generic(new)) => left_over_generic(old, new)
            .into_iter()
            .map(|what| stale(what, "removed"))
            .collect(),
        _ => Vec::new(),
    }
}

fn left_over_siemens(old: &SiemensTables, new: &SiemensTables) -> Vec<String> {
    let lec = old
        .lec
        .iter()
        .filter(|table| {
            let same = |n: &crate::control::table::siemens::LecTable| {
                n.axis == table.axis && n.encoder == table.encoder
            };
            !new.lec.iter().any(same)
        })
        .map(|table| {
            format!(
                "MD32700 $MA_ENC_COMP_ENABLE[{},{}]",
                table.encoder, table.axis
            )
        });
    let cec = old
        .cec
        .iter()
        .filter(|table| !new.cec.iter().any(|n| n.number == table.number))
        .map(|table| format!("SD41300 $SN_CEC_TABLE_ENABLE[{}]", table.number));
    lec.chain(cec).collect()
}

fn left_over_fanuc(old: &FanucMemory, new: &FanucMemory) -> Vec<String> {
    let pitch = old.parameters.keys().filter(|key| {
        let axis = key.axis;
        key.number == 3623 && number(old, 3623, axis) != 0 && new.parameter(3623, axis).is_none()
    });
    let pitch = pitch.filter_map(|key| Some(format!("3623 of axis {}", key.axis?)));
    let sets = (5711..=5716)
        .filter(|set| number(old, *set, None) != 0 && new.parameter(*set, None).is_none())
        .map(|set| set.to_string());
    pitch.chain(sets).collect()
}

fn left_over_generic(old: &GenericTable, new: &GenericTable) -> Vec<String> {
    let same = |a: &GenericRow, b: &GenericRow| {
        a.term == b.term && a.output_axis == b.output_axis && a.direction == b.direction
    };
    let gone = |row: &&GenericRow| row.index == 0 && !new.rows.iter().any(|n| same(row, n));
    old.rows
        .iter()
        .filter(gone)
        .map(|row| format!("the old table {} of {}", row.term, row.output_axis))
        .collect()
}

fn number(memory: &FanucMemory, parameter: u32, axis: Option<u32>) -> i64 {
    match memory.parameter(parameter, axis) {
        Some(ParameterValue::Integer(value)) => value,
        _ => 0,
    }
}
