//! What a kit is made from, and what is planned before it is put into a control's numbers.

use crate::control::controller::Profile;
use crate::inputs::job::{AxisSettings, Job, MachineAxis};
use crate::machine::model::ErrorModel;
use crate::quantity::{Axis, Deviation, Direction, ErrorCurve, ErrorTerm, PerAxis, UM_PER_MM};
use crate::text::{Finding, joined};
use crate::write::control_text::trimmed;
use crate::write::grid::Grid;
use serde::Serialize;

/// What a plan is made from.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The job.
    pub job: &'a Job,
    /// The control.
    pub profile: &'a Profile,
    /// The measured errors.
    pub model: &'a ErrorModel,
}

/// The section of an axis in `[compensation.axes]`, or a key (`.points`) of it.
pub(crate) fn axis_key(axis: Axis, key: &str) -> String {
    format!("compensation.axes.{}{key}", axis.key())
}

impl<'a> Task<'a> {
    /// Settings and machine data of an axis that moves or is corrected.
    pub fn axis(&self, axis: Axis) -> Option<(MachineAxis, &'a AxisSettings)> {
        Some((self.job.machine.axes[axis]?, self.settings(axis)?))
    }

    /// The settings of an axis, where the job has any.
    pub(crate) fn settings(&self, axis: Axis) -> Option<&'a AxisSettings> {
        self.job.compensation.axes[axis].as_ref()
    }

    /// One unit of length of the control, µm.
    pub(crate) fn unit_um(&self) -> f64 {
        self.job.compensation.control_unit.in_mm() * UM_PER_MM
    }

    /// The detection unit of an axis, µm, where it is stated.
    pub(crate) fn detection_unit_um(&self, axis: Axis) -> Option<f64> {
        self.settings(axis)?.detection_unit_um
    }

    /// Machine coordinates of the reference points, as they stand in files and preconditions.
    pub(crate) fn reference_text(&self) -> String {
        let text = |(axis, machine): (Axis, &Option<MachineAxis>)| {
            Some(format!("{axis} {} mm", trimmed(machine.as_ref()?.reference.mm(), 6)))
        };
        joined(self.job.machine.axes.iter().filter_map(text))
    }
}

/// One table's worth: a term, the direction of its moving axis the table acts in, the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Which error.
    pub term: ErrorTerm,
    /// `None` = both directions.
    pub direction: Option<Direction>,
    /// The deviation to cancel.
    pub curve: ErrorCurve,
}

/// The targets of one term.
#[derive(Clone, Debug, PartialEq)]
pub struct TermTargets {
    /// Which error.
    pub term: ErrorTerm,
    /// One for both directions, or one for each.
    pub targets: Vec<Target>,
    /// The mean of both directions, which can stand in for two tables where the control has few.
    pub mean: Option<ErrorCurve>,
    /// What the user should know about the choice, without the name of the term.
    pub note: Option<String>,
}

impl TermTargets {
    /// The curve that the tables cancel while the moving axis travels in `direction`.
    pub fn curve(&self, direction: Direction) -> Option<&ErrorCurve> {
        self.targets
            .iter()
            .find(|target| target.direction.is_none_or(|d| d == direction))
            .map(|target| &target.curve)
    }

    /// One table with the mean of both directions instead of two tables.
    pub(crate) fn take_mean(&mut self) {
        if let Some(curve) = self.mean.take() {
            self.targets = vec![Target { term: self.term, direction: None, curve }];
        }
    }
}

/// A term that gets no table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Omission {
    /// Which error.
    pub term: ErrorTerm,
    /// Why.
    pub reason: String,
}

/// One table, before it is put into a control's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedTable {
    /// Which error.
    pub term: ErrorTerm,
    /// Direction of the moving axis it acts in; `None` = both.
    pub direction: Option<Direction>,
    /// Its points.
    pub grid: Grid,
    /// The deviation to cancel.
    pub curve: ErrorCurve,
    /// The deviation that each point of the table stands for, unrounded.
    pub values: Vec<Deviation>,
    /// Largest difference of curve and unrounded table over the whole axis, µm.
    pub grid_residual_um: f64,
}

/// All tables of a kit, before they are put into a control's numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// The tables, in the contract's order of terms.
    pub tables: Vec<PlannedTable>,
    /// The points of each moving axis.
    pub grids: PerAxis<Option<Grid>>,
    /// The control's names of the physical axes.
    pub names: PerAxis<Vec<String>>,
    /// Value of the backlash parameter (−B) of each axis, µm, where the policy names one.
    pub backlash_um: PerAxis<Option<f64>>,
    /// Terms that get no table: not wanted, not determined, or beyond what the control holds.
    pub omitted: Vec<Omission>,
    /// What the user should know.
    pub notes: Vec<Finding>,
}

impl Plan {
    /// The tables of an axis that corrects itself.
    pub(crate) fn of_axis(&self, axis: Axis) -> impl Iterator<Item = &PlannedTable> {
        let is_own = move |t: &&PlannedTable| t.term.is_positioning() && t.term.of == axis;
        self.tables.iter().filter(is_own)
    }

    /// The physical axis by which a table is looked up: an axis that corrects itself is its own base, also each
    /// axis of a gantry; otherwise it is the first physical axis of the moving axis.
    pub(crate) fn base_of<'a>(&'a self, term: ErrorTerm, output: &'a str) -> &'a str {
        self.names[term.along].first().filter(|_| term.is_cross()).map_or(output, String::as_str)
    }

    /// Whether an axis corrects itself by a table for each direction.
    pub(crate) fn has_two_tables(&self, axis: Axis) -> bool {
        self.of_axis(axis).any(|table| table.direction.is_some())
    }

    /// Whether an axis moves another one.
    pub(crate) fn has_cross(&self) -> bool {
        self.tables.iter().any(|table| table.term.is_cross())
    }

    /// Whether the tables name the backlash parameter of an axis: 0 with two tables, else −B.
    pub(crate) fn sets_backlash(&self, axis: Axis) -> bool {
        self.backlash_um[axis].is_some() || self.has_two_tables(axis)
    }
}

/// The pairs (base, output) of physical axes that a term concerns: each axis of a gantry is
/// corrected, the first one is looked up. None where the machine lacks one of the two axes.
pub fn axis_pairs(names: &PerAxis<Vec<String>>, term: ErrorTerm) -> Vec<(&str, &str)> {
    names[term.of]
        .iter()
        .filter_map(|output| {
            let base = if term.is_positioning() { output } else { names[term.along].first()? };
            Some((base.as_str(), output.as_str()))
        })
        .collect()
}
