//! The slopes of a solution as linear functions of what they come from: the totals of the
//! diagonals and the separated slopes. Whatever falsifies readings reaches the figures this way.
//!
//! ```text
//!   p(term) = Σ_d G_d E_d + a·(separated slope) + b·(separated slope of the twin)
//! ```
//! Of first order in the tilt of the mirror: a slope of 10 µm/m that meets a tilt of 1 mrad is
//! off by 0.01 µm/m. A beam over a part of the travel holds shapes of curves; that is neglected.

use super::metric::{PerPlane, Plane};
use crate::quantity::axis::{ErrorTerm, PerTerm};
use crate::quantity::diagonal::{Diagonal, PerDiagonal, Volume};

/// How slopes and squareness change with the readings.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct SlopeGains {
    /// Change of the slope of a curve with each total, µm/m for each µm.
    pub by_end: PerTerm<PerDiagonal<f64>>,
    /// Shares of the separated slopes of the term and of its twin in the slope.
    pub by_separated: PerTerm<[f64; 2]>,
    /// Change of φ with each total, µm/m for each µm.
    pub squareness: PerPlane<PerDiagonal<f64>>,
    /// Whether the cross terms carry true slopes of their own; else EXY, EXZ, EYZ carry the
    /// squareness and their twins none.
    pub own_slopes: bool,
}

impl SlopeGains {
    /// Change of a slope, µm/m, by changes of the totals (µm) and of the separated slopes (µm/m).
    pub fn slope(
        &self,
        term: ErrorTerm,
        ends_um: &PerDiagonal<f64>,
        separated: &PerTerm<f64>,
    ) -> f64 {
        let [own, of_twin] = self.by_separated[term];
        along(&self.by_end[term], ends_um) + own * separated[term] + of_twin * separated[twin(term)]
    }

    /// Change of φ, µm/m, by changes of the totals, µm.
    pub(crate) fn of_squareness(&self, plane: Plane, ends_um: &PerDiagonal<f64>) -> f64 {
        along(&self.squareness.of(plane), ends_um)
    }

    /// A slope of the machine, µm/m, in the frame of the solution.
    pub(crate) fn in_frame(&self, term: ErrorTerm, slopes: &PerTerm<f64>) -> f64 {
        if self.own_slopes || term.is_positioning() {
            slopes[term]
        } else if term.of < term.along {
            slopes[term] + slopes[twin(term)]
        } else {
            0.0
        }
    }

    /// Standard uncertainty (k = 1) that 1 mrad between beam and mirror makes at the far end of a
    /// curve, µm; it grows with the square of the angle.
    pub(crate) fn of_beam_um(&self, volume: &Volume, term: ErrorTerm) -> f64 {
        let metres = volume.diagonal_mm() / 1000.0;
        // V_k/(4V_j)·s_dj s_dk, see formula (1).
        let separated = |d: Diagonal, term: ErrorTerm| {
            let edges = volume.size[term.along].mm() / volume.size[term.of].mm();
            edges / 4.0 * d.sign(term.along) * d.sign(term.of)
        };
        let [own, of_twin] = self.by_separated[term];
        let by_strain = PerDiagonal::from_fn(|d| {
            metres * self.by_end[term][d]
                + own * separated(d, term)
                + of_twin * separated(d, twin(term))
        });
        of_beam(&by_strain) * volume.size[term.along].mm() / 1000.0
    }

    /// The same for φ, µm/m.
    pub(crate) fn squareness_of_beam(&self, volume: &Volume) -> PerPlane<f64> {
        let metres = volume.diagonal_mm() / 1000.0;
        let by_strain = |gains: PerDiagonal<f64>| PerDiagonal::from_fn(|d| metres * gains[d]);
        self.squareness.map(|gains| of_beam(&by_strain(gains)))
    }
}

/// 1 mrad takes 0.5·10⁻⁶ off each diagonal: off all alike, and off each for itself.
fn of_beam(by_strain: &PerDiagonal<f64>) -> f64 {
    let all: f64 = by_strain.iter().map(|(_, gain)| gain).sum();
    let squares: f64 = by_strain.iter().map(|(_, gain)| gain * gain).sum();
    0.5 * all.hypot(squares.sqrt())
}

fn along(gains: &PerDiagonal<f64>, ends_um: &PerDiagonal<f64>) -> f64 {
    let all = Diagonal::ALL.into_iter();
    all.map(|d| gains[d] * ends_um[d]).sum()
}

/// The term of the same plane with its axes exchanged.
fn twin(term: ErrorTerm) -> ErrorTerm {
    ErrorTerm {
        of: term.along,
        along: term.of,
    }
}
