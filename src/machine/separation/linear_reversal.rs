//! Reversal of an axis from its linear measurement in both directions.
//!
//! Runs of the diagonals that go over the far end, and forward runs alone, do not determine the
//! reversal of a single axis. A linear measurement of it that the job names does, at every place:
//!
//! ```text
//!   B(x) = E+(x) − E−(x)      u²(B) = u²(E+) + u²(E−)
//!   + curve  E(x) + (B(x) − B(x0))/2        − curve  E(x) − (B(x) + B(x0))/2
//! ```
//! E is the mean curve of the separation, x0 the low end of the box. The cross terms of that axis
//! hold the mean of both directions: nothing tells their reversal.

use super::lookup::at;
use super::outlier::float;
use super::reversal::Turn;
use crate::inputs::error_table::ErrorTable;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, PathKind, Volume};
use crate::quantity::units::Figure;

/// B of a positioning error at the interval ends of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearReversal {
    /// Moving + minus moving −, lowest place first, µm.
    pub um: Vec<f64>,
    /// Standard uncertainties (k = 1), µm; `None` = the table gives none.
    pub u_um: Option<Vec<f64>>,
}

/// The linear measurements in both directions, by axis; `None` = there is none.
pub type LinearReversals = PerAxis<Option<LinearReversal>>;

/// B of an axis from a table that covers the box; `None` without both directions.
pub(super) fn of_table(volume: &Volume, axis: Axis, table: &ErrorTable) -> Option<LinearReversal> {
    let side = |direction: Direction| {
        let mut series = table.series(axis).iter();
        let series = series.find(|series| series.direction == Some(direction))?;
        let values = series.deviations[axis].as_ref()?;
        let values: Vec<f64> = values.iter().map(|value| value.um()).collect();
        let nodes = volume.positions(axis);
        let over_box = |values: &[f64]| -> Vec<f64> {
            let node = |node: &crate::quantity::units::Millimetres| {
                at(&series.positions, values, node.mm())
            };
            nodes.iter().map(node).collect()
        };
        let u_um = series.uncertainties_um[axis].as_deref().map(over_box);
        Some((over_box(&values), u_um))
    };
    let ((plus, u_plus), (minus, u_minus)) = (side(Direction::Plus)?, side(Direction::Minus)?);
    let u_um = u_plus.zip(u_minus).map(|(plus, minus)| {
        let pairs = plus.iter().zip(minus);
        pairs.map(|(plus, minus)| plus.hypot(minus)).collect()
    });
    let um = plus.iter().zip(minus).map(|(plus, minus)| plus - minus);
    Some(LinearReversal {
        um: um.collect(),
        u_um,
    })
}

/// What the known reversals make of the forward less the reverse reading of a node, µm:
/// Σ_k (V_k/R) B_k at that place.
pub(super) fn along_diagonal_um(
    reversals: &LinearReversals,
    volume: &Volume,
    diagonal: Diagonal,
    node: usize,
) -> f64 {
    let place = volume.place(diagonal, PathKind::Step, node);
    let of_axis = |axis: Axis| {
        let reversal = reversals[axis].as_ref()?;
        let b = at(&volume.positions(axis), &reversal.um, place[axis].mm());
        Some(volume.cosine(axis) * b)
    };
    Axis::ALL.into_iter().filter_map(of_axis).sum()
}

/// Standard uncertainty of that, µm, with the largest of each axis: its readings may share causes.
pub(super) fn u_along_diagonal_um(reversals: &LinearReversals, volume: &Volume) -> f64 {
    let of_axis = |axis: Axis| {
        let u_um = reversals[axis].as_ref()?.u_um.as_ref()?;
        Some(volume.cosine(axis) * u_um.iter().copied().fold(0.0, f64::max))
    };
    let squares = Axis::ALL.into_iter().filter_map(of_axis).map(|u| u * u);
    squares.sum::<f64>().sqrt()
}

/// Where the turn and the linear measurement of an axis contradict each other by more than six
/// standard deviations, one sentence each: the axes turned otherwise than was stated, or the two were
/// not measured in the same state.
pub(super) fn contradictions(turn: &Turn, reversals: &LinearReversals) -> Vec<String> {
    let of_axis = |axis: Axis| {
        let linear = reversals[axis].as_ref()?;
        let of_turn = turn.reversal[own_term(axis)];
        let um = mean(&linear.um);
        let u_um = linear.u_um.as_ref()?.iter().copied().fold(0.0, f64::max);
        let limit = 6.0 * of_turn.u_um?.hypot(u_um);
        ((of_turn.um - um).abs() > limit.max(SMALLEST_REVERSAL_UM)).then(|| {
            format!(
                "the reversal of {axis} is {:.3} µm by the turn, {um:.3} µm by its linear measurement: check `overrun`, and whether both were measured in the same state",
                of_turn.um
            )
        })
    };
    Axis::ALL.into_iter().filter_map(of_axis).collect()
}

pub(super) const fn own_term(axis: Axis) -> ErrorTerm {
    ErrorTerm {
        of: axis,
        along: axis,
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / float(values.len().max(1))
}

/// Where the reversals come from and what they leave open, in words; `None` without any.
pub(super) fn label(reversals: &LinearReversals, forward_only: bool) -> Option<String> {
    let found: Vec<String> = reversals
        .iter()
        .filter_map(|(axis, reversal)| Some((axis, reversal.as_ref()?)))
        .map(|(axis, reversal)| {
            let (low, high) = ends_of(&reversal.um);
            let (low, high) = (Figure(low), Figure(high));
            format!("{axis} {low:+.3} to {high:+.3}")
        })
        .collect();
    let mixed = if forward_only {
        "; as far as it changes along the axis it is mixed into the curves of forward runs"
    } else {
        ""
    };
    (!found.is_empty()).then(|| {
        format!(
            "reversal of single axes from their linear measurements in both directions (smallest to largest B, µm: {}){mixed}; their cross terms hold the mean of both directions, because nothing tells the reversal of those",
            found.join(", ")
        )
    })
}

fn ends_of(values: &[f64]) -> (f64, f64) {
    values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        })
}

/// A reversal that no instrument resolves is none, µm.
pub(super) const SMALLEST_REVERSAL_UM: f64 = 0.02;
