//! What stands beside the tables: encoder, backlash, value at the reference point, largest sum.

use crate::control::control_state::ControlState;
use crate::control::table::siemens::{SiemensGrid, SiemensTables};
use crate::quantity::axis::Axis;
use crate::quantity::units::{Figure, UM_PER_MM};
use crate::write::plan::{PlannedTable, Task};

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

/// MD32450 as it is named: four decimals of a millimetre, five of an inch.
pub(super) fn backlash_text(task: Task<'_>, um: f64) -> (String, f64) {
    let unit = task.job.compensation.control_unit;
    let decimals = match unit {
        crate::control::controller::LengthUnit::Millimetre => 4,
        crate::control::controller::LengthUnit::Inch => 5,
    };
    let text = format!("{:.decimals$}", um / (unit.in_mm() * UM_PER_MM) + 0.0);
    let rounded_um = text.parse::<f64>().unwrap_or(0.0) * unit.in_mm() * UM_PER_MM;
    (format!("{text} {}", unit.word()), rounded_um)
}

/// Largest sum of CEC corrections of any output axis, µm ([`SiemensTables::largest_cec_sum`]).
pub(super) fn largest_sum_um(task: Task<'_>, tables: &SiemensTables) -> f64 {
    let um_per_unit = task.job.compensation.control_unit.in_mm() * UM_PER_MM;
    let outputs = tables.cec.iter().map(|table| table.output_axis.as_str());
    let sums = outputs.map(|output| tables.largest_cec_sum(output));
    sums.fold(0.0, f64::max) * um_per_unit
}

/// What a table holds at the reference point of its base axis, in the unit of the file.
pub(crate) fn at_reference(
    state: &ControlState,
    base: &str,
    grid: &SiemensGrid,
    values: &[Option<f64>],
) -> f64 {
    let reference = state.axis(base).map(|axis| axis.reference.mm());
    let position = reference.map(|mm| mm / state.unit.in_mm());
    let held = position.and_then(|position| grid.nearest(values, position));
    held.unwrap_or(0.0)
}

/// Machine coordinates of the reference points, as they stand in files and preconditions.
pub(crate) fn reference_text(task: Task<'_>) -> String {
    let texts: Vec<String> = task
        .job
        .machine
        .axes
        .iter()
        .filter_map(|(axis, machine)| {
            let text = format!("{:.6}", Figure(machine.as_ref()?.reference.mm()));
            let text = text.trim_end_matches('0').trim_end_matches('.');
            Some(format!("{axis} {text} mm"))
        })
        .collect();
    texts.join(", ")
}
