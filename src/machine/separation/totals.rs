//! What the total displacements along the four diagonals say: squareness and the shares of the scales.

use crate::machine::separation::metric::{PerPlane, Plane};
use crate::quantity::diagonal::{Diagonal, PerDiagonal, Volume};

/// What the totals of the four diagonals determine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals {
    /// φ, µm/m.
    pub squareness_um_per_m: PerPlane<f64>,
    /// S = X²p_xx + Y²p_yy + Z²p_zz, µm·mm: the one combination of the scales.
    pub scale_sum_um_mm: f64,
}

/// Formula (4) from the readings at the far ends, µm.
pub(crate) fn totals(volume: &Volume, ends_um: &PerDiagonal<f64>) -> Totals {
    let total = |d: Diagonal| volume.diagonal_mm() * ends_um[d];
    let squareness = |plane: Plane| {
        let (a, b) = plane.axes();
        let part = |d: Diagonal| d.sign(a) * d.sign(b) * total(d);
        let sum: f64 = Diagonal::ALL.into_iter().map(part).sum();
        1000.0 * sum / (4.0 * volume.size[a].mm() * volume.size[b].mm())
    };
    Totals {
        squareness_um_per_m: PerPlane {
            xy: squareness(Plane::Xy),
            xz: squareness(Plane::Xz),
            yz: squareness(Plane::Yz),
        },
        scale_sum_um_mm: Diagonal::ALL.into_iter().map(total).sum::<f64>() / 4.0,
    }
}

/// u(φ) = R/(2 V_j V_k)·u(e_end), µm/m.
pub(crate) fn u_squareness(volume: &Volume, u_end_um: f64) -> PerPlane<f64> {
    let of = |plane: Plane| {
        let (a, b) = plane.axes();
        let area = volume.size[a].mm() * volume.size[b].mm();
        1000.0 * volume.diagonal_mm() / (2.0 * area) * u_end_um
    };
    PerPlane {
        xy: of(Plane::Xy),
        xz: of(Plane::Xz),
        yz: of(Plane::Yz),
    }
}
