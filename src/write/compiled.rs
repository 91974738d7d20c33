//! The tables as they are written, what the control remembers with them and why it has to, and the bump of a
//! sign proof.

use crate::control::claims::{Assumption, Precondition, SeenTo};
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::Proof;
use crate::control::table::Tables;
use crate::inputs::job::{ActiveTables, AxisSettings, BacklashPolicy, Job};
use crate::quantity::{Axis, Deviation, Direction, ErrorTerm, Millimetres, PerAxis, rounded};
use crate::text::Finding;
use crate::write::grid::{Grid, as_number, whole};
use crate::write::task::{Plan, PlannedTable, Task};
use serde::Serialize;

/// Where one planned table went and how coarse it is there.
#[derive(Clone, Debug, PartialEq, Serialize)]
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

impl Placement {
    /// A planned table at its place, without a residual of the control's form.
    pub(crate) fn of(planned: &PlannedTable, place: String, count_um: f64) -> Placement {
        Placement {
            term: planned.term,
            direction: planned.direction,
            place,
            points: planned.grid.count(),
            count_um,
            grid_residual_um: planned.grid_residual_um,
            fit_residual_um: None,
        }
    }
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
    /// What switches old tables on that no file overwrites: the disable file, where there is one, sets it to 0.
    pub stale: Vec<String>,
    /// What the user should know.
    pub notes: Vec<Finding>,
}

/// The state of the control that the job states: one entry for each physical axis.
/// `backlash_um` is what the backlash parameter will hold, −B rounded as it is named.
pub(crate) fn control_state(
    task: Task<'_>,
    plan: &Plan,
    backlash_um: impl Fn(Axis) -> f64,
) -> ControlState {
    let is_bidirectional = |axis| plan.has_two_tables(axis);
    stated_control(task.job, &plan.names, backlash_um, is_bidirectional)
}

/// The same, of axes with these names.
pub(crate) fn stated_control(
    job: &Job,
    names: &PerAxis<Vec<String>>,
    backlash_um: impl Fn(Axis) -> f64,
    is_bidirectional: impl Fn(Axis) -> bool,
) -> ControlState {
    let mut axes = Vec::new();
    let rest = job.measurement.levers.origin(&job.machine.axes);
    for (axis, names) in names.iter() {
        let Some(machine) = job.machine.axes[axis] else {
            continue;
        };
        let settings = job.compensation.axes[axis].as_ref();
        axes.extend(names.iter().map(|name| AxisState {
            name: name.clone(),
            reference: machine.reference,
            reference_direction: machine.homing(),
            detection_unit_um: settings.and_then(|s| s.detection_unit_um),
            backlash_um: backlash_um(axis),
            bidirectional: is_bidirectional(axis),
            interpolated: settings.is_some_and(AxisSettings::is_interpolated),
            travel: machine.reach(),
            ends: (machine.low, machine.high),
            rest: Millimetres::new(rest[axis]),
        }));
    }
    ControlState { unit: job.compensation.control_unit, axes }
}

/// The deviations that a column for one direction cancels: the table for its direction, and for an axis whose
/// table stands in place of its backlash parameter the reversal that the policy leaves to that.
pub(crate) fn column(
    plan: &Plan,
    term: ErrorTerm,
    replaced: Option<&AxisState>,
    direction: Direction,
) -> Vec<Deviation> {
    let acts = |table: &&PlannedTable| {
        table.term == term && table.direction.is_none_or(|own| own == direction)
    };
    let parameter = replaced.map(|axis| AxisState {
        backlash_um: plan.backlash_um[term.of].unwrap_or(0.0),
        ..axis.clone()
    });
    let by_parameter = parameter.map_or(Deviation::ZERO, |axis| -axis.backlash(direction));
    let values = plan.tables.iter().find(acts).map(|table| table.values.iter());
    let values = values.into_iter().flatten();
    values.map(|value| Deviation::from_um(value.um() + by_parameter.um())).collect()
}

/// What the backlash parameter of an axis has to be: −B as `named`, 0 beside two tables, or as it was.
pub(crate) fn backlash_parameter(
    task: Task<'_>,
    plan: &Plan,
    axis: Axis,
    what: String,
    named: impl Fn(f64) -> String,
    source: &str,
) -> Precondition {
    let equal = task.job.compensation.backlash[axis] == Some(BacklashPolicy::TwoTables);
    let (value, why) = match (plan.backlash_um[axis], counts_as_zero(task.job, axis)) {
        (Some(um), true) if equal => (
            named(um),
            "both directions are equal, so one table holds the error and no reversal is left for the parameter. The measurement counts the parameter as 0 while measuring (else state `active_backlash_um`)",
        ),
        (Some(um), false) if equal => (
            named(um),
            "both directions of the machine without compensation are equal (the parameter that was active while measuring is taken off), so one table holds the error and no reversal is left for the parameter",
        ),
        (Some(um), true) => (
            named(um),
            "−B of the measurement, which counts the backlash parameter as 0 while measuring (else state `active_backlash_um`); the table holds the curve of the reference direction",
        ),
        (Some(um), false) => (
            named(um),
            "−B of the machine without compensation: the parameter that was active while measuring is contained in it; the table holds the curve of the reference direction",
        ),
        (None, true) if plan.has_two_tables(axis) => (
            "0".into(),
            "the reversal is in the two tables; counted twice it would turn round. The measurement counts the parameter as 0 while measuring (else state `active_backlash_um`)",
        ),
        (None, false) if plan.has_two_tables(axis) => (
            "0".into(),
            "the reversal is in the two tables, with the parameter that was active while measuring; counted twice it would turn round",
        ),
        (None, _) => {
            let why = "backlash acts in addition to the table and adds to it";
            return Precondition::new(what, "as during the measurement", why, source);
        }
    };
    let when = SeenTo::Entered;
    Precondition { when, ..Precondition::new(what, value, why, source) }
}

/// A backlash parameter in micrometres as it is named: to a tenth of one.
pub(crate) fn backlash_text(um: f64) -> (String, f64) {
    const DECIMALS: u32 = 1;
    let um = rounded(um, DECIMALS);
    (format!("{um:.1} µm"), um)
}

/// Whether the backlash parameter of an axis counts as 0 while measuring because nothing says what
/// it was. Where files are named it has to be known (`active`).
pub(crate) fn counts_as_zero(job: &Job, axis: Axis) -> bool {
    let measurement = &job.measurement;
    let stated = measurement.active_settings.backlash_um[axis];
    !matches!(measurement.active, ActiveTables::Path(_)) && stated.is_none()
}

/// One bump of one mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct SignProof {
    /// What it proves the sign of.
    pub of: &'static Proof,
    /// The term whose table holds the bump.
    pub term: ErrorTerm,
    /// Its place and size.
    pub bump: Bump,
    /// Everything that the file writes.
    pub tables: Tables,
}

/// A bump on the grid of a moving axis: it rises over some sections and falls over as many.
///
/// **unit** whole counts of the table · **limits** at most `limits.max_bump_um`; at least one
/// section away from the reference; inside the travel; at most `limits.max_slope_um_per_mm` and,
/// on Fanuc, the largest increment in each section (four points: where there is room for that)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    pub(crate) grid: Grid,
    pub(crate) peak: i64,
    pub(crate) rise: i64,
    pub(crate) counts: i64,
    pub(crate) count_um: f64,
    /// A straight line from the reference through its peak.
    pub(crate) is_slope: bool,
}

impl Bump {
    /// Where it begins, is highest, and ends, machine coordinates; a slope has no end, only its beginning.
    pub fn places(&self) -> [Millimetres; 3] {
        let (from, to) = match self.is_slope {
            true => (0, 0),
            false => (self.peak - self.rise, self.peak + self.rise),
        };
        [from, self.peak, to].map(|n| self.grid.position(n))
    }

    /// The deviation that the table pretends at the peak.
    pub(crate) fn height(&self) -> Deviation {
        Deviation::from_um(as_number(self.counts) * self.count_um)
    }

    /// Counts at a node, counted from the reference; a half is rounded up.
    pub(crate) fn counts_at(&self, node: i64) -> i64 {
        let inside = (self.rise - (node - self.peak).abs()).max(0);
        (2 * self.counts * inside + self.rise) / (2 * self.rise)
    }

    /// The deviations that a table of this grid pretends.
    pub(crate) fn deviations(&self) -> Vec<Deviation> {
        (self.grid.first..=self.grid.last)
            .map(|node| Deviation::from_um(as_number(self.counts_at(node)) * self.count_um))
            .collect()
    }
}

/// The largest whole number that is not above a number, but for floating point.
pub(crate) fn whole_below(number: f64) -> i64 {
    const DUST: f64 = 1e-9;
    whole((number + DUST).floor())
}
