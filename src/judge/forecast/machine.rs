//! The machine with its control, as a forecast sees it.

use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::Millimetres;

/// One machine, before and without compensation. Both are the same model where no table was
/// active while measuring.
#[derive(Clone, Copy, Debug)]
pub struct Machine<'a> {
    /// As it was measured: what the forecast compares with, and the range that is known.
    pub as_measured: &'a ErrorModel,
    /// Without any table: what corrections are added to.
    pub uncompensated: &'a ErrorModel,
}

impl<'a> Machine<'a> {
    /// A machine that was measured without any table.
    pub fn alone(model: &'a ErrorModel) -> Machine<'a> {
        Machine {
            as_measured: model,
            uncompensated: model,
        }
    }

    /// Whether tables were active while measuring.
    pub(super) fn was_under_tables(self) -> bool {
        !std::ptr::eq(self.as_measured, self.uncompensated)
    }

    /// The curves of a term in a direction: as measured, and without tables.
    pub(super) fn curves(
        self,
        term: ErrorTerm,
        direction: Direction,
    ) -> Option<(&'a ErrorCurve, &'a ErrorCurve)> {
        let of = |model: &'a ErrorModel| model.terms[term].as_ref()?.measured.curve(direction);
        Some((of(self.as_measured)?, of(self.uncompensated)?))
    }
}

/// What two ranges have in common; the first where there is no second.
pub(super) fn within(
    (from, to): (Millimetres, Millimetres),
    other: Option<(Millimetres, Millimetres)>,
) -> (Millimetres, Millimetres) {
    let (low, high) = other.unwrap_or((from, to));
    let from = if low > from { low } else { from };
    let to = if high < to { high } else { to };
    (from, to)
}
