//! What a plan is made from, and a table of it.

use crate::control::controller::{Dialect, Profile};
use crate::inputs::job::{AxisSettings, Job, MachineAxis};
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::Deviation;
use crate::write::grid::{Grid, LengthDigit};

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

impl Task<'_> {
    /// Settings and machine data of an axis that moves or is corrected.
    pub fn axis(&self, axis: Axis) -> Option<(MachineAxis, &AxisSettings)> {
        Some((
            self.job.machine.axes[axis]?,
            self.job.compensation.axes[axis].as_ref()?,
        ))
    }

    /// The last digit of positions and spacings in the control's files.
    pub(crate) fn length_digit(&self) -> LengthDigit {
        let unit = self.job.compensation.control_unit;
        let decimals = match &self.profile.dialect {
            Dialect::Siemens(facts) => facts.position_decimals.value,
            Dialect::Fanuc(facts) => match unit {
                crate::control::controller::LengthUnit::Millimetre => {
                    facts.interval_decimals_mm.value
                }
                crate::control::controller::LengthUnit::Inch => facts.interval_decimals_inch.value,
            },
            Dialect::Generic(_) => GENERIC_POSITION_DECIMALS,
        };
        let unit = match &self.profile.dialect {
            Dialect::Generic(_) => crate::control::controller::LengthUnit::Millimetre,
            _ => unit,
        };
        LengthDigit { unit, decimals }
    }
}

/// The generic table has positions in mm with nanometres.
const GENERIC_POSITION_DECIMALS: u32 = 6;
