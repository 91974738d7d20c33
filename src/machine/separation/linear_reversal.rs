//! Reversal of each axis from linear measurements, and reversal that the diagonals show and no curve holds.
//!
//! Where the axes ran past the end point, and with forward runs alone, a linear measurement of an axis in
//! both directions, which the job names, tells its reversal at every place:
//!
//! ```text
//!   B(x) = E+(x) − E−(x)      u²(B) = u²(E+) + u²(E−)
//!   + curve  E(x) + (B(x) − B(x0))/2        − curve  E(x) − (B(x) + B(x0))/2
//! ```
//! E is the mean curve of the separation, x0 the low end of the box. The cross terms of that axis
//! hold the mean of both directions: nothing tells their reversal.

use super::curves::{at, mean};
use super::noise::{Noise, UNRESOLVED_UM, float};
use super::readings::Means;
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{Diagonal, PathKind, Volume};
use crate::quantity::units::{Millimetres, Squared};

/// A linear measurement of an axis in a direction at the interval ends of the box, lowest first: values, µm, and standard
/// uncertainties (k = 1); `None` = the table gives none.
pub(super) type Way = (Option<Direction>, Vec<f64>, Option<Vec<f64>>);

/// B of a positioning error at the interval ends of the box, from a linear measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearReversal {
    /// Moving + minus moving −, lowest place first, µm.
    pub um: Vec<f64>,
    /// Standard uncertainties (k = 1), µm; `None` = the table gives none.
    pub u_um: Option<Vec<f64>>,
}

/// The linear measurements in both directions, by axis; `None` = there is none.
pub type LinearReversals = PerAxis<Option<LinearReversal>>;

impl LinearReversal {
    /// Of a linear measurement, each direction with its values and their uncertainties at the interval ends; `None`
    /// without both.
    pub(super) fn of(ways: &[Way]) -> Option<Self> {
        let way = |direction| ways.iter().find(|(way, ..)| *way == Some(direction));
        let ((_, plus, u_plus), (_, minus, u_minus)) =
            (way(Direction::Plus)?, way(Direction::Minus)?);
        let pairs = |a: &[f64], b: &[f64], of: fn(f64, f64) -> f64| {
            a.iter().zip(b).map(|(a, b)| of(*a, *b)).collect()
        };
        let u_um = u_plus.as_ref().zip(u_minus.as_ref());
        Some(LinearReversal {
            um: pairs(plus, minus, |plus, minus| plus - minus),
            u_um: u_um.map(|(a, b)| pairs(a, b, f64::hypot)),
        })
    }

    /// The largest of its uncertainties: its readings may share causes.
    pub(super) fn u_largest_um(&self) -> Option<f64> {
        Some(self.u_um.as_ref()?.iter().copied().fold(0.0, f64::max))
    }
}

/// Reversal along the diagonals that passes with overrun show: the largest B at a cell end, µm;
/// `None` where the mean of forward minus reverse readings is within their noise. The reversal of
/// a single axis is hidden in it, so that no curve holds it. What linear measurements tell of
/// single axes, Σ_k (V_k/R) B_k at each place, is taken off.
pub(super) fn hidden_reversal_um(
    means: &Means,
    noise: Option<Noise>,
    volume: &Volume,
    known: &LinearReversals,
) -> Option<f64> {
    let reverse = means.reverse.as_ref()?;
    let known = known.iter().filter_map(|(axis, b)| Some((axis, b.as_ref()?)));
    let known: Vec<(Axis, &LinearReversal, Vec<Millimetres>)> =
        known.map(|(axis, b)| (axis, b, volume.positions(axis))).collect();
    let beside = |d: Diagonal| -> Vec<f64> {
        let of_known = |node: usize| -> f64 {
            let place = volume.place(d, PathKind::Step, node);
            let b = known.iter().map(|(axis, b, positions)| {
                volume.cosine(*axis) * at(positions, &b.um, place[*axis].mm())
            });
            b.sum()
        };
        let pairs = means.forward[d].iter().zip(&reverse[d]).enumerate();
        pairs.map(|(node, (forward, back))| forward - back - of_known(node)).collect()
    };
    let sigma = noise.map_or(0.0, |noise| noise.sigma_um);
    let u_known = known
        .iter()
        .filter_map(|(axis, b, _)| Some((volume.cosine(*axis) * b.u_largest_um()?).squared()));
    let u_known = u_known.sum::<f64>().sqrt();
    let shown = |b: &Vec<f64>| {
        // Six standard deviations of a mean difference.
        let of_noise = std::f64::consts::SQRT_2 * sigma / float(b.len()).sqrt();
        mean(b.iter().copied()).abs() > (6.0 * of_noise.hypot(u_known)).max(UNRESOLVED_UM)
    };
    let shown = Diagonal::ALL.map(beside).into_iter().filter(shown);
    let largest = |b: Vec<f64>| b.iter().step_by(3).fold(0.0, |most: f64, um| most.max(um.abs()));
    shown.map(largest).reduce(f64::max)
}
