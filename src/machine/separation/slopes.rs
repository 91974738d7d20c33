//! What the slopes of the nine curves are made of.
//!
//! ```text
//!   slope(term) = share · figure + a · (separated slope) + b · (separated slope of the twin)
//!   figure      = a scale or a squareness: of (7), or of the totals where the set-up is assumed (4)
//! ```

use super::plane::{PerPlane, Plane, Unknown};
use crate::inputs::job::{Frame, SetUp};
use crate::quantity::axis::ErrorTerm;
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
