//! The nine separated curves with their uncertainties.

use crate::machine::separation::linear_reversal::{LinearReversal, LinearReversals, own_term};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerTerm};

use super::curves::Curve;
use super::line::ReferenceLine;
use super::metric::{PerPlane, Plane};
use super::noise::{Noise, coverage_factor, effective_freedom};
use super::propagation::AlongCurve;
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

/// Sets the two directions of each positioning error apart by its reversal.
pub(super) fn set_apart(errors: &mut NineErrors, reversals: &LinearReversals) {
    for axis in Axis::ALL {
        let term = own_term(axis);
        let (Some(reversal), Some(mean)) = (&reversals[axis], &errors.mean[term]) else {
            continue;
        };
        let (plus, minus) = (reversal.beside(mean, 1.0), reversal.beside(mean, -1.0));
        errors.plus.get_or_insert_default()[term] = Some(plus);
        errors.minus.get_or_insert_default()[term] = Some(minus);
    }
}

impl LinearReversal {
    /// The curve of a direction beside the mean curve, `sign` = +1 or −1.
    fn beside(&self, mean: &Evidence, sign: f64) -> Evidence {
        let start = self.um.first().copied().unwrap_or(0.0);
        let pairs = mean.deviation_um.iter().zip(&self.um);
        let deviation_um = pairs.map(|(mean, b)| mean + (sign * b - start) / 2.0);
        let u_um = mean.u_um.as_ref().zip(self.u_um.as_ref());
        let u_um = u_um.map(|(mean, of_reversal)| {
            let start = of_reversal.first().copied().unwrap_or(0.0);
            let at = |(index, (mean, u)): (usize, (&f64, &f64))| match (index, sign > 0.0) {
                (0, true) => *mean,
                (0, false) => mean.hypot(start),
                _ => mean.hypot(u.hypot(start) / 2.0),
            };
            mean.iter().zip(of_reversal).enumerate().map(at).collect()
        });
        Evidence {
            deviation_um: deviation_um.collect(),
            u_noise_um: mean.u_noise_um.clone().filter(|_| u_um.is_some()),
            u_um,
        }
    }
}
