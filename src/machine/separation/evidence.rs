//! The nine separated curves with their uncertainties.

use super::curves::Curve;
use super::line::ReferenceLine;
use super::metric::{PerPlane, Plane};
use super::noise::{Noise, coverage_factor, effective_freedom};
use super::propagation::AlongCurve;
use crate::quantity::axis::{Direction, ErrorTerm, PerTerm};
use crate::quantity::diagonal::Volume;

/// One separated curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// Deviations at the interval ends, lowest first, µm; the first is 0 (a − curve: the reversal).
    pub deviation_um: Curve,
    /// Standard uncertainties (k = 1) against the first position, µm; `None` = not known.
    pub u_um: Option<Vec<f64>>,
    /// The part of them that comes from the noise of the readings, µm.
    pub u_noise_um: Option<Vec<f64>>,
}

impl Evidence {
    pub(super) fn new(deviation_um: Curve, along: Option<AlongCurve>) -> Evidence {
        let (u_um, u_noise_um) = along.map(|along| (along.u_um, along.noise_um)).unzip();
        Evidence {
            deviation_um,
            u_um,
            u_noise_um,
        }
    }

    /// Effective degrees of freedom of a point's uncertainty; `None` = unlimited.
    pub fn freedom(&self, index: usize, noise: Option<Noise>) -> Option<f64> {
        let u = *self.u_um.as_ref()?.get(index)?;
        effective_freedom(u, *self.u_noise_um.as_ref()?.get(index)?, noise?)
    }

    /// U of a point, µm: its uncertainty with the coverage factor of its degrees of freedom.
    pub fn expanded_um(&self, index: usize, noise: Option<Noise>) -> Option<f64> {
        let u = *self.u_um.as_ref()?.get(index)?;
        Some(u * coverage_factor(self.freedom(index, noise)))
    }
}

/// The nine errors; `None` = not determined.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct NineErrors {
    /// Without regard to direction, or the mean of both.
    pub mean: PerTerm<Option<Evidence>>,
    /// Moving in +, with two directions.
    pub plus: Option<PerTerm<Option<Evidence>>>,
    /// Moving in −. Where the reversal is not determined it starts at 0, too.
    pub minus: Option<PerTerm<Option<Evidence>>>,
}

impl NineErrors {
    /// The curves of a direction.
    pub fn directed(&self, direction: Direction) -> Option<&PerTerm<Option<Evidence>>> {
        match direction {
            Direction::Plus => self.plus.as_ref(),
            Direction::Minus => self.minus.as_ref(),
        }
    }
}

/// φ of least squares lines through the separated curves, µm/m.
pub(super) fn least_squares_squareness(
    volume: &Volume,
    errors: &PerTerm<Option<Evidence>>,
) -> PerPlane<Option<f64>> {
    let slope = |term: ErrorTerm| {
        let positions: Vec<f64> = volume
            .positions(term.along)
            .iter()
            .map(|p| p.mm())
            .collect();
        let curve = &errors[term].as_ref()?.deviation_um;
        Some(ReferenceLine::LeastSquares.slope_um_per_m(&positions, curve))
    };
    let of = |plane: Plane| {
        let (a, b) = plane.axes();
        Some(slope(ErrorTerm { of: a, along: b })? + slope(ErrorTerm { of: b, along: a })?)
    };
    PerPlane {
        xy: of(Plane::Xy),
        xz: of(Plane::Xz),
        yz: of(Plane::Yz),
    }
}
