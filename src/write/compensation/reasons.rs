//! Why a backlash value or two tables are needed.

use crate::inputs::job::{ActiveTables, Job};
use crate::quantity::axis::Axis;

/// Why the backlash parameter of an axis has to be −B.
pub(crate) fn backlash_why(job: &Job, axis: Axis) -> &'static str {
    if counts_as_zero(job, axis) {
        "−B of the measurement, which counts the backlash parameter as 0 while measuring (else state `active_backlash_um`); the table holds the curve of the reference direction"
    } else {
        "−B of the machine without compensation: the parameter that was active while measuring is contained in it; the table holds the curve of the reference direction"
    }
}

/// Why the backlash parameter of an axis with two tables has to be 0.
pub(crate) fn two_tables_why(job: &Job, axis: Axis) -> &'static str {
    if counts_as_zero(job, axis) {
        "the reversal is in the two tables; counted twice it would turn round. The measurement counts the parameter as 0 while measuring (else state `active_backlash_um`)"
    } else {
        "the reversal is in the two tables, with the parameter that was active while measuring; counted twice it would turn round"
    }
}

/// Whether the backlash parameter of an axis counts as 0 while measuring because nothing says what
/// it was. Where files are named it has to be known (`active`).
pub(super) fn counts_as_zero(job: &Job, axis: Axis) -> bool {
    let measurement = &job.measurement;
    let stated = measurement.active_settings.backlash_um[axis];
    !matches!(measurement.active, ActiveTables::Path(_)) && stated.is_none()
}
