//! One value of a run, as it is written.

use crate::inputs::target_runs::Values;
use crate::quantity::axis::Direction;
use crate::quantity::units::UM_PER_MM;
use crate::text::delimited::{LengthUnit, Line};

/// One value of a run, with the cell it stands in.
pub(super) struct Reading<'a> {
    pub(super) line: Line<'a>,
    pub(super) cell: usize,
    pub(super) direction: Direction,
    pub(super) run: u32,
    pub(super) target: Length,
    pub(super) value: Length,
}

impl Reading<'_> {
    pub(super) fn target_mm(&self) -> f64 {
        self.target.um() / UM_PER_MM
    }

    /// x_ij = P_ij − P_i. In one unit the subtraction comes first: it is exact for numbers that
    /// are near to each other.
    pub(super) fn deviation_um(&self, values: Values) -> f64 {
        let (value, target) = (self.value, self.target);
        match values {
            Values::Deviations => value.um(),
            Values::Positions if value.unit == target.unit => {
                (value.number - target.number) * target.unit.um()
            }
            Values::Positions => value.um() - target.um(),
        }
    }
}

/// A length in the unit of its column.
#[derive(Clone, Copy)]
pub(super) struct Length {
    pub(super) number: f64,
    pub(super) unit: LengthUnit,
}

impl Length {
    fn um(self) -> f64 {
        self.number * self.unit.um()
    }
}
