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
use super::findings::SeparationFinding;
use super::noise::{Noise, UNRESOLVED_UM, float};
use super::readings::Means;
use super::reversal::Turn;
use crate::inputs::error_table::ErrorTable;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, PathKind, Volume};
use crate::quantity::units::{Millimetres, Squared};
use crate::text::finding::Finding;

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
    /// B of an axis from a table that covers the box; `None` without both directions.
    pub(super) fn of_table(volume: &Volume, axis: Axis, table: &ErrorTable) -> Option<Self> {
        let nodes = volume.positions(axis);
        let side = |direction: Direction| {
            let mut series = table.series(axis).iter();
            let series = series.find(|series| series.direction == Some(direction))?;
            let values = series.deviations[axis].as_ref()?;
            let values: Vec<f64> = values.iter().map(|value| value.um()).collect();
            let over_box = |values: &[f64]| -> Vec<f64> {
                let node = |node: &Millimetres| at(&series.positions, values, node.mm());
                nodes.iter().map(node).collect()
            };
            let u_um = series.uncertainties_um[axis].as_deref().map(over_box);
            Some((over_box(&values), u_um))
        };
        let ((plus, u_plus), (minus, u_minus)) = (side(Direction::Plus)?, side(Direction::Minus)?);
        let pairs = |a: Vec<f64>, b: Vec<f64>, of: fn(f64, f64) -> f64| {
            a.into_iter().zip(b).map(|(a, b)| of(a, b)).collect()
        };
        Some(LinearReversal {
            um: pairs(plus, minus, |plus, minus| plus - minus),
            u_um: u_plus.zip(u_minus).map(|(a, b)| pairs(a, b, f64::hypot)),
        })
    }

    /// The largest of its uncertainties: its readings may share causes.
    fn u_largest_um(&self) -> Option<f64> {
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

/// Where the turn and the linear measurement of an axis contradict each other by more than six
/// standard deviations: the axes turned otherwise than was stated, or the two were not measured in
/// the same state.
pub(super) fn contradictions(turn: &Turn, reversals: &LinearReversals) -> Vec<Finding> {
    let of_axis = |(axis, linear): (Axis, &Option<LinearReversal>)| {
        let linear = linear.as_ref()?;
        let of_turn = turn.reversal[ErrorTerm::positioning(axis)];
        let (turn_um, linear_um) = (of_turn.um, mean(linear.um.iter().copied()));
        let limit = 6.0 * of_turn.u_um?.hypot(linear.u_largest_um()?);
        let apart = (turn_um - linear_um).abs() > limit.max(UNRESOLVED_UM);
        apart.then(|| {
            Finding::from(SeparationFinding::TurnAgainstLinear { axis, turn_um, linear_um })
        })
    };
    reversals.iter().filter_map(of_axis).collect()
}
