//! Reversal of each axis from the turn at the end of the diagonals.
//!
//! Where the axes do not run over the far end before the reverse pass, the last node is the same
//! place without any motion, and each of the three first moves back takes up the lost motion of
//! its axis. The jump of forward minus reverse readings over that move is, for axis k,
//!
//! ```text
//!   J_dk = Σ_j s_dk s_dj (V_j/R) B_jk          → B_jk by formula (1); B_kk = (R/V_k) J_dk alone if
//!                                                nothing but axis k itself reverses
//! ```
//! With overrun all axes have reversed before the first reading back, and only Σ_k (V_k/R) B_kk
//! and three combinations of cross terms can be seen: the reversal of a single axis is not
//! determined.

use super::increments::Means;
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::diagonal::{Diagonal, PerDiagonal, Volume};

/// Reversal at the turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// B of each term at the low end of its axis, µm: moving + minus moving −.
    pub reversal_um: PerTerm<f64>,
    /// B of each axis from each diagonal alone, µm: they should agree.
    pub by_diagonal_um: PerDiagonal<PerAxis<f64>>,
}

/// Forward minus reverse reading of each diagonal at its last node, µm.
fn step_at_turn(means: &Means, volume: &Volume) -> Option<PerDiagonal<f64>> {
    let reverse = means.reverse.as_ref()?;
    let last = 3 * volume.steps;
    Some(PerDiagonal::from_fn(|d| {
        means.forward[d][last] - reverse[d][last]
    }))
}

/// Whether the axes ran over the far end, judged from the readings: without overrun forward and
/// reverse readings of the last node are one place read twice. `sigma_um`: standard deviation of
/// a single reading, so that means are judged tolerantly. `None` where there is no reverse pass.
pub fn ran_over(means: &Means, volume: &Volume, sigma_um: f64) -> Option<bool> {
    let at_turn = step_at_turn(means, volume)?;
    let reverse = means.reverse.as_ref()?;
    // Six standard deviations of a difference, and never less than the last digit of an instrument.
    let limit = (6.0 * std::f64::consts::SQRT_2 * sigma_um).max(0.01);
    let before = 3 * volume.steps - 3;
    let same_place = at_turn.iter().all(|(_, step)| step.abs() < limit);
    let differs = Diagonal::ALL
        .into_iter()
        .any(|d| (means.forward[d][before] - reverse[d][before]).abs() > limit);
    Some(!(same_place && differs))
}

/// The reversals of a turn without overrun. `change_um`: Δ of each term, the + curve less the −
/// curve at the high end when both are zero at the low end.
pub fn turn(means: &Means, volume: &Volume, change_um: &PerTerm<f64>) -> Option<Turn> {
    let reverse = means.reverse.as_ref()?;
    let jump = |diagonal: Diagonal, along: Axis| {
        let node = volume.node_after(along, volume.steps - 1);
        let beside = |node: usize| means.forward[diagonal][node] - reverse[diagonal][node];
        let at_high_end = diagonal.forward(along) == Direction::Plus;
        let part =
            |of: Axis| diagonal.sign(of) * volume.cosine(of) * change_um[ErrorTerm { of, along }];
        let change: f64 = Axis::ALL.into_iter().map(part).sum();
        beside(node - 1) - beside(node) - if at_high_end { change } else { 0.0 }
    };
    let reversal_um = PerTerm::from_fn(|term| {
        let part = |d: Diagonal| d.sign(term.along) * d.sign(term.of) * jump(d, term.along);
        let sum: f64 = Diagonal::ALL.into_iter().map(part).sum();
        sum / (4.0 * volume.cosine(term.of))
    });
    let by_diagonal_um = PerDiagonal::from_fn(|diagonal| {
        PerAxis::from_fn(|axis| jump(diagonal, axis) / volume.cosine(axis))
    });
    Some(Turn {
        reversal_um,
        by_diagonal_um,
    })
}

/// The means with the turn's jumps taken off the reverse pass, so that its last cell carries the
/// same increments as the forward pass: those of the lost motion are no error of the interval.
pub fn without_jumps(means: &Means, volume: &Volume) -> Means {
    let Some(reverse) = &means.reverse else {
        return means.clone();
    };
    let corner = 3 * volume.steps - 3;
    let reverse = PerDiagonal::from_fn(|diagonal| {
        let forward = &means.forward[diagonal];
        let mut readings = reverse[diagonal].clone();
        let offset = readings[corner] - forward[corner];
        for node in corner + 1..readings.len() {
            readings[node] = forward[node] + offset;
        }
        readings
    });
    Means {
        forward: means.forward.clone(),
        reverse: Some(reverse),
    }
}
