//! The generic table: deviation, correction and increment of every point (contract §4.1).
//! Unrounded, unless the corrected axis has a detection unit.

mod sheet;

use crate::control::claims::Precondition;
use crate::control::controller::{ControlUnit, GenericFacts, TypedValue};
use crate::control::table::Tables;
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::inputs::job::Compensation;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::units::{self, Deviation};
use crate::text::problem::Problems;
use crate::write::compiled::{
    Compiled, Placement, backlash_parameter, backlash_text, control_state,
};
use crate::write::family::{Emitted, Family};
use crate::write::grid::LengthDigit;
use crate::write::seen::{Seen, seen};
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};
use sheet::{POSITION_DECIMALS, number};

impl Family for GenericFacts {
    fn expected_name(&self, _name: &str) -> Option<&'static str> {
        None
    }

    fn names_reach_axes(&self) -> bool {
        false
    }

    /// Positions are in mm whatever the control is in.
    fn length_digit(&self, _unit: ControlUnit) -> LengthDigit {
        LengthDigit { unit: ControlUnit::Millimetre, decimals: POSITION_DECIMALS }
    }

    /// Increments are zero at the reference and do not hold what a second table has there.
    fn takes_directions(&self, _term: ErrorTerm) -> bool {
        self.typed_value.value != TypedValue::Increment
    }

    fn budget(&self, _compensation: &Compensation) -> Option<TableStock> {
        TableStock::of_cross_terms(self.cross_terms.value)
    }

    fn point_limit(&self, _targets: &[&Target]) -> (u32, &'static str) {
        (self.points.value, "a table")
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let mut rows = Vec::new();
        let mut placements = Vec::new();
        for planned in &plan.tables {
            let unit_um = task.detection_unit_um(planned.term.of);
            for output in &plan.names[planned.term.of] {
                rows.extend(table_rows(plan, planned, output, unit_um));
            }
            let count_um = unit_um.unwrap_or(0.0);
            placements.push(Placement::of(planned, "rows".to_string(), count_um));
        }
        let backlash = |um: f64| backlash_text(um).1;
        Ok(Compiled {
            tables: Tables::Generic(GenericTable { rows }),
            placements,
            state: control_state(task, plan, |axis| plan.backlash_um[axis].map_or(0.0, backlash)),
            assumptions: Vec::new(),
            preconditions: preconditions(task, plan),
            stale: Vec::new(),
            notes: Vec::new(),
        })
    }

    fn context(&self, emitted: &Emitted<'_>) -> Option<Seen> {
        let table: &GenericTable = emitted.tables.own()?;
        let is_rounded = |row: &GenericRow| emitted.task.detection_unit_um(row.term.of).is_some();
        let sheet = match table.rows.iter().all(is_rounded) {
            true => sheet::blocks(table, self, &emitted.compiled.state),
            false => Vec::new(), // nobody types nine decimals
        };
        Some(seen! { "sheet": sheet, "typed": sheet::typed_words(self), "rows": context(table) })
    }
}

fn table_rows(
    plan: &Plan,
    planned: &PlannedTable,
    output: &str,
    unit_um: Option<f64>,
) -> Vec<GenericRow> {
    let base = plan.base_of(planned.term, output);
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
            position_mm: units::rounded(planned.grid.position(at).mm(), POSITION_DECIMALS),
            deviation_um: deviation.um() + 0.0,
            correction_um,
            increment_um: before.map(|b| increment(correction_um - b, unit_um)),
        });
        before = Some(correction_um);
    }
    rows
}

/// Multiples of a detection unit are freed from binary dust at a femtometre.
const DUST_DECIMALS: u32 = 9;

fn rounded(value: Deviation, unit_um: Option<f64>) -> Deviation {
    match unit_um {
        Some(unit) => {
            Deviation::from_um(units::rounded((value.um() / unit).round() * unit, DUST_DECIMALS))
        }
        None => value,
    }
}

fn increment(um: f64, unit_um: Option<f64>) -> f64 {
    match unit_um {
        Some(_) => units::rounded(um, DUST_DECIMALS),
        None => um + 0.0,
    }
}

fn preconditions(task: Task<'_>, plan: &Plan) -> Vec<Precondition> {
    let named = |um| backlash_text(um).0;
    let axes = plan.backlash_um.iter().filter(|(_, um)| um.is_some());
    axes.map(|(axis, _)| {
        let what = format!("backlash parameter of {axis}");
        let source = "contract of the generic table";
        backlash_parameter(task, plan, axis, what, named, source)
    })
    .collect()
}

/// The rows that the templates see, with every number as finished text.
fn context(table: &GenericTable) -> Vec<Seen> {
    let last = table.rows.len().saturating_sub(1);
    let rows = table.rows.iter().enumerate();
    rows.map(|(index, row)| seen_row(row, index == last)).collect()
}

fn seen_row(row: &GenericRow, is_last: bool) -> Seen {
    let increment = row.increment_um.map(number);
    seen! {
        "term": row.term.to_string(),
        "base_axis": row.base_axis.as_str(),
        "output_axis": row.output_axis.as_str(),
        "direction": row.direction.map_or("", Direction::symbol),
        "direction_json": match row.direction {
            None => "null",
            Some(Direction::Plus) => "\"+\"",
            Some(Direction::Minus) => "\"-\"",
        },
        "index": row.index.to_string(),
        "position_mm": number(row.position_mm),
        "deviation_um": number(row.deviation_um),
        "correction_um": number(row.correction_um),
        "increment_um": increment.clone().unwrap_or_default(),
        "increment_um_json": increment.as_deref().unwrap_or("null"),
        "comma": if is_last { "" } else { "," },
    }
}
