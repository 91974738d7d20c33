//! The tilt of the mirror in each set-up, for the operator to correct.

use super::metric::{Metric, Plane};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{PerDiagonal, Volume};
use crate::quantity::units::Squared;

/// Seconds of arc in one radian.
const ARCSEC_PER_RADIAN: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// Tilt of the mirror's normal against the nominal diagonal, in the machine's X-primary frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// Its size, seconds of arc.
    pub arcsec: f64,
    /// Unit vector into which the normal leans (machine axes); perpendicular to the diagonal.
    pub direction: PerAxis<f64>,
}

/// η_d = q_d − Aᵀ u_d with the slopes of the X-primary frame; `None` where scales or squareness
/// are not determined, because then the tilts are not either.
pub fn tilts(
    volume: &Volume,
    ratios: &PerDiagonal<PerAxis<f64>>,
    metric: &Metric,
) -> Option<PerDiagonal<Tilt>> {
    let scale = PerAxis {
        x: metric.scale.x?,
        y: metric.scale.y?,
        z: metric.scale.z?,
    };
    let xy = metric.squareness.of(Plane::Xy)?;
    let xz = metric.squareness.of(Plane::Xz)?;
    let yz = metric.squareness.of(Plane::Yz)?;
    Some(PerDiagonal::from_fn(|diagonal| {
        let u = volume.laser(diagonal);
        let q = &ratios[diagonal];
        // X primary: EXY, EXZ and EYZ carry the squareness (p_xy = φxy …), so Aᵀu has these parts.
        let expected = PerAxis {
            x: u.x + 1e-6 * (scale.x * u.x),
            y: u.y + 1e-6 * (xy * u.x + scale.y * u.y),
            z: u.z + 1e-6 * (xz * u.x + yz * u.y + scale.z * u.z),
        };
        tilt(&PerAxis::from_fn(|axis| q[axis] - expected[axis]))
    }))
}

fn tilt(eta: &PerAxis<f64>) -> Tilt {
    let square: f64 = Axis::ALL.into_iter().map(|axis| eta[axis].squared()).sum();
    let size = square.sqrt();
    Tilt {
        arcsec: size * ARCSEC_PER_RADIAN,
        direction: PerAxis::from_fn(|axis| if size > 0.0 { eta[axis] / size } else { 0.0 }),
    }
}
