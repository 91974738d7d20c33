//! What LinuxCNC adds to a joint that has a table (docs/linuxcnc.md §2).
//!
//! ```text
//!   column (moving up, moving down) → trim at each row, a C float → straight lines between, ends held
//!   motor = position + trim; without a table: BACKLASH
//! ```
//! Seen on a control: every servo cycle of a run is the model of docs/linuxcnc.md §2 within a nanometre. Left
//! out: the ramp of a few milliseconds after a reversal, and the rounding of a slope to a C float, both below
//! what moves an axis while it measures.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::LinuxcncFacts;
use crate::control::table::linuxcnc::{Columns, CompTable, LinuxcncTables, Row};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, Millimetres, UM_PER_MM};
use crate::read::emulate::{Between, CannotEmulate, Emulator, NodeTable, Response};

/// A control with its tables in memory.
#[derive(Clone, Debug)]
pub struct LinuxcncControl {
    joints: Vec<LoadedJoint>,
    state: ControlState,
}

#[derive(Clone, Debug)]
struct LoadedJoint {
    name: String,
    /// While it moves up, and down.
    ways: [Response; 2],
}

impl LinuxcncControl {
    /// A control that holds these tables.
    ///
    /// **unit** `state.unit` is that of the files · **limits** fails if a joint is not one of the control
    pub fn new(
        tables: &LinuxcncTables,
        facts: &LinuxcncFacts,
        state: &ControlState,
    ) -> Result<LinuxcncControl, CannotEmulate> {
        let load = |table: &CompTable| {
            let name = table.joint.to_string();
            known_axis(state, &name)?;
            let way = |column: fn(&Row) -> f64| response(table, facts, state.unit.in_mm(), column);
            let ways = [way(|row| row.forward)?, way(|row| row.reverse)?];
            Ok(LoadedJoint { name, ways })
        };
        Ok(LinuxcncControl {
            joints: tables.joints.iter().map(load).collect::<Result<_, _>>()?,
            state: state.clone(),
        })
    }
}

impl Emulator for LinuxcncControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let pair = |joint: &LoadedJoint| (joint.name.clone(), joint.name.clone());
        self.joints.iter().map(pair).collect()
    }

    /// BACKLASH, counted from the direction of homing, acts on a joint without a table only.
    fn response(
        &self,
        base: &str,
        output: &str,
        direction: Direction,
    ) -> Result<Response, CannotEmulate> {
        if !base.eq_ignore_ascii_case(output) {
            return Ok(Response::default());
        }
        let axis = known_axis(&self.state, base)?;
        let own = self.joints.iter().find(|joint| joint.name == axis.name);
        Ok(match (own, direction) {
            (Some(LoadedJoint { ways: [up, _], .. }), Direction::Plus) => up.clone(),
            (
                Some(LoadedJoint {
                    ways: [_, down], ..
                }),
                Direction::Minus,
            ) => down.clone(),
            (None, _) => Response::new(Vec::new(), axis.backlash(direction)),
        })
    }
}

fn known_axis<'a>(state: &'a ControlState, name: &str) -> Result<&'a AxisState, CannotEmulate> {
    let axis = state.axis(name);
    axis.ok_or_else(|| CannotEmulate(format!("foreign axis: the job has no joint `{name}`")))
}

/// The trim of a row, in the machine unit: a C float.
#[allow(
    clippy::cast_possible_truncation,
    reason = "LinuxCNC holds trims as C floats"
)]
fn trim(columns: Columns, nominal: f64, column: f64) -> f64 {
    let trim = match columns {
        Columns::Reached => nominal - column,
        Columns::Trims => column,
    };
    f64::from(trim as f32)
}

/// One column of a table. Rows at equal distances are one table of nodes; others are a sum of ramps, one for
/// each section, each held at both ends.
fn response(
    table: &CompTable,
    facts: &LinuxcncFacts,
    unit_mm: f64,
    column: fn(&Row) -> f64,
) -> Result<Response, CannotEmulate> {
    let correction = |row: &Row| {
        let trim = trim(table.columns, row.nominal, column(row));
        facts.trim_sign.value.correction(trim * unit_mm * UM_PER_MM)
    };
    let mm: Vec<f64> = table.rows.iter().map(|row| row.nominal * unit_mm).collect();
    let values: Vec<Correction> = table.rows.iter().map(correction).collect();
    let (Some(low), Some(first)) = (mm.first(), values.first()) else {
        return Err(CannotEmulate(format!(
            "the table of {} has no row",
            table.name()
        )));
    };
    let nodes = |low: f64, step: f64, values: &[Correction]| {
        let [low, step] = [low, step].map(Millimetres::new);
        NodeTable::new(low, step, values, Between::Linear)
    };
    let step = step_of(&mm);
    if let Some(equal) = step.and_then(|step| nodes(*low, step, &values)) {
        return Ok(Response::new(vec![equal], Correction::ZERO));
    }
    let sections = mm.windows(2).zip(values.windows(2));
    let ramps = sections.filter_map(|(mm, um)| {
        let rise = Correction::from_um(um[1].um() - um[0].um());
        nodes(mm[0], mm[1] - mm[0], &[Correction::ZERO, rise])
    });
    Ok(Response::new(ramps.collect(), *first))
}

/// The distance of rows that lie at equal distances.
fn step_of(mm: &[f64]) -> Option<f64> {
    const OFF_GRID_MM: f64 = 1e-6;
    let (first, last) = (mm.first()?, mm.last()?);
    let step = (last - first) / (mm.len().checked_sub(1)?) as f64;
    let is_equal =
        |(index, at): (usize, &f64)| (first + step * index as f64 - at).abs() <= OFF_GRID_MM;
    mm.iter().enumerate().all(is_equal).then_some(step)
}

#[cfg(test)]
mod tests;
