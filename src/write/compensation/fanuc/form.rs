//! Forms of a table: detection unit, four points.

use crate::control::controller::{FanucFacts, StraightnessForm};
use crate::quantity::axis::Axis;
use crate::write::plan::Task;

/// Detection unit of an axis, µm; the plan has checked that it is stated.
pub(super) fn detection_unit(task: Task<'_>, axis: Axis) -> f64 {
    let settings = task.job.compensation.axes[axis].as_ref();
    settings
        .and_then(|s| s.detection_unit_um)
        .unwrap_or(f64::NAN)
}

/// Whether the straightness of this control goes through four points.
pub(super) fn is_four_point(facts: &FanucFacts) -> bool {
    facts.straightness_form.value == StraightnessForm::FourPoint
}
