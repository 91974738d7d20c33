//! The tables as they are written, and what the control remembers with them.

use crate::control::claims::{Assumption, Precondition};
use crate::control::control_state::{AxisState, ControlState};
use crate::control::table::Tables;
use crate::inputs::job::AxisSettings;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::write::plan::{Plan, Task};

/// Where one planned table went and how coarse it is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Which error.
    pub term: ErrorTerm,
    /// Direction of the moving axis it acts in; `None` = both.
    pub direction: Option<Direction>,
    /// The place in the control's words, e.g. `ENC_COMP[0,AX1]` or `points 0…30`.
    pub place: String,
    /// Number of points.
    pub points: usize,
    /// The smallest step the table can express, µm (contract §1, count).
    pub count_um: f64,
    /// Largest difference of curve and unrounded table over the whole axis, µm.
    pub grid_residual_um: f64,
    /// What the form of the control leaves at its points beyond rounding, µm (four-point
    /// straightness only).
    pub fit_residual_um: Option<f64>,
}

/// A kit before it becomes text.
#[derive(Clone, Debug, PartialEq)]
pub struct Compiled {
    /// What the files will write.
    pub tables: Tables,
    /// Where each planned table went.
    pub placements: Vec<Placement>,
    /// The state of the control that the job states or requires.
    pub state: ControlState,
    /// What is assumed.
    pub assumptions: Vec<Assumption>,
    /// What a person has to see to.
    pub preconditions: Vec<Precondition>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// The state of the control that the job states: one entry for each physical axis.
/// `backlash_um` is what the backlash parameter will hold, −B rounded as it is named.
pub(super) fn control_state(
    task: Task<'_>,
    plan: &Plan,
    backlash_um: impl Fn(Axis) -> f64,
) -> ControlState {
    let mut axes = Vec::new();
    for (axis, names) in plan.names.iter() {
        let Some(machine) = task.job.machine.axes[axis] else {
            continue;
        };
        let settings = task.job.compensation.axes[axis].as_ref();
        let own = |directed: bool| {
            plan.tables.iter().any(|t| {
                t.term.is_positioning() && t.term.of == axis && t.direction.is_some() == directed
            })
        };
        for name in names {
            axes.push(AxisState {
                name: name.clone(),
                reference: machine.reference,
                reference_direction: machine.homing(),
                detection_unit_um: settings.and_then(|s| s.detection_unit_um),
                backlash_um: backlash_um(axis),
                bidirectional: own(true),
                interpolated: settings.is_some_and(AxisSettings::is_interpolated),
            });
        }
    }
    ControlState {
        unit: task.job.compensation.control_unit,
        axes,
    }
}
