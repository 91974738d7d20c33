//! What the slopes of the nine curves are made of, and how they change with the readings.
//!
//! ```text
//!   slope(term) = share · figure + a · (separated slope) + b · (separated slope of the twin)
//!   figure      = a scale or a squareness: of (7), or of the totals where the set-up is assumed (4)
//! ```
//! Whatever falsifies readings reaches the figures through the totals E_d and the separated slopes,
//! as far as they are linear: p(term) = Σ_d G_d E_d + a·… + b·…, of first order in the tilt of the
//! mirror: a slope of 10 µm/m that meets a tilt of 1 mrad is off by 0.01 µm/m. A beam over a part of the
//! travel holds shapes of curves; that is neglected.

use super::metric::ByTotals;
use super::plane::{PerPlane, Plane, Unknown};
use crate::inputs::job::{Frame, SetUp};
use crate::quantity::axis::{ErrorTerm, PerTerm};
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
pub(super) fn totals(volume: &Volume, ends_um: &PerDiagonal<f64>) -> Totals {
    let total = |d: Diagonal| volume.diagonal_mm() * ends_um[d];
    let squareness = |plane: Plane| {
        let (a, b) = plane.axes();
        let part = |d: Diagonal| d.sign(a) * d.sign(b) * total(d);
        let sum: f64 = Diagonal::ALL.into_iter().map(part).sum();
        1000.0 * sum / (4.0 * volume.size[a].mm() * volume.size[b].mm())
    };
    Totals {
        squareness_um_per_m: PerPlane::from_fn(squareness),
        scale_sum_um_mm: Diagonal::ALL.into_iter().map(total).sum::<f64>() / 4.0,
    }
}

/// What the slope of a term is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rule {
    /// A scale or a squareness, and its share.
    pub(super) figure: Option<(Unknown, f64)>,
    /// Share of the separated slope of the term.
    pub(super) own: f64,
    /// Share of the separated slope of its twin.
    pub(super) of_twin: f64,
}

impl Rule {
    pub(super) fn of(setup: SetUp, frame: Frame, term: ErrorTerm) -> Rule {
        let part =
            |share: f64| Rule { figure: Some((Unknown::of(term), share)), ..Rule::default() };
        match (setup, frame) {
            (SetUp::Solve, _) if term.is_positioning() => part(1.0),
            // The rotation is that of the separated slopes, their sum that of the totals.
            (SetUp::Solve, Frame::AsMeasured) => Rule { own: 0.5, of_twin: -0.5, ..part(0.5) },
            (SetUp::AssumePerfect, frame)
                if term.is_positioning() || frame == Frame::AsMeasured =>
            {
                Rule { own: 1.0, ..Rule::default() }
            }
            // EXY, EXZ and EYZ carry the squareness of their plane.
            _ if term.of < term.along => part(1.0),
            _ => Rule::default(),
        }
    }

    /// Whether the slope is that of the increments, with the tilt of the mirror.
    pub(super) fn keeps_separated_slope(&self) -> bool {
        self.figure.is_none() && self.own > 0.0
    }
}

/// How slopes and squareness change with the readings.
#[derive(Clone, Debug)]
pub(super) struct SlopeGains {
    pub(super) rules: PerTerm<Rule>,
    pub(super) by_total: ByTotals,
    /// Whether the cross terms carry true slopes of their own; else EXY, EXZ, EYZ carry the
    /// squareness and their twins none.
    pub(super) own_slopes: bool,
}

impl SlopeGains {
    /// Where there are no curves: scales and squareness alone.
    pub(super) fn without_curves(by_total: ByTotals) -> SlopeGains {
        SlopeGains { rules: PerTerm::default(), by_total, own_slopes: false }
    }

    /// Change of a scale or a squareness with each total, µm/m for each µm.
    pub(super) fn by_end(&self, unknown: Unknown) -> PerDiagonal<f64> {
        self.by_total.of(unknown)
    }

    /// Change of a slope, µm/m, by changes of the totals (µm) and of the separated slopes (µm/m).
    pub(super) fn slope(
        &self,
        term: ErrorTerm,
        ends_um: &PerDiagonal<f64>,
        separated: &PerTerm<f64>,
    ) -> f64 {
        let rule = &self.rules[term];
        let figure =
            rule.figure.map_or(0.0, |(unknown, share)| share * self.of_figure(unknown, ends_um));
        figure + rule.own * separated[term] + rule.of_twin * separated[term.twin()]
    }

    /// Change of a scale or a squareness, µm/m, by changes of the totals, µm.
    pub(super) fn of_figure(&self, unknown: Unknown, ends_um: &PerDiagonal<f64>) -> f64 {
        let gains = self.by_end(unknown);
        let all = Diagonal::ALL.into_iter();
        all.map(|d| gains[d] * ends_um[d]).sum()
    }

    /// A slope of the machine, µm/m, in the frame of the solution.
    pub(super) fn in_frame(&self, term: ErrorTerm, slopes: &PerTerm<f64>) -> f64 {
        if self.own_slopes || term.is_positioning() {
            slopes[term]
        } else if term.of < term.along {
            slopes[term] + slopes[term.twin()]
        } else {
            0.0
        }
    }

    /// Standard uncertainty (k = 1) that 1 mrad between beam and mirror makes at the far end of a
    /// curve, µm; it grows with the square of the angle.
    pub(super) fn of_beam_um(&self, volume: &Volume, term: ErrorTerm) -> f64 {
        let metres = volume.diagonal_mm() / 1000.0;
        // V_k/(4V_j)·s_dj s_dk, see formula (1).
        let separated = |d: Diagonal| {
            PerTerm::from_fn(|term| {
                let edges = volume.size[term.along].mm() / volume.size[term.of].mm();
                edges / 4.0 * d.sign(term.along) * d.sign(term.of)
            })
        };
        let by_strain = PerDiagonal::from_fn(|d| {
            let ends_um = PerDiagonal::from_fn(|other| if other == d { metres } else { 0.0 });
            self.slope(term, &ends_um, &separated(d))
        });
        of_beam(&by_strain) * volume.size[term.along].mm() / 1000.0
    }

    /// The same for φ, µm/m.
    pub(super) fn squareness_of_beam(&self, volume: &Volume, plane: Plane) -> f64 {
        let gains = self.by_end(Unknown::Squareness(plane));
        let metres = volume.diagonal_mm() / 1000.0;
        of_beam(&PerDiagonal::from_fn(|d| metres * gains[d]))
    }
}

/// 1 mrad takes 0.5·10⁻⁶ off each diagonal: off all alike, and off each for itself.
fn of_beam(by_strain: &PerDiagonal<f64>) -> f64 {
    let all: f64 = by_strain.iter().map(|(_, gain)| gain).sum();
    let squares: f64 = by_strain.iter().map(|(_, gain)| gain * gain).sum();
    0.5 * all.hypot(squares.sqrt())
}
