//! Standard uncertainties (k = 1) of the nine curves, propagated from the readings.
//!
//! Readings are independent with standard deviation σ; a run mean of r runs has σ/√r. Every point
//! of every curve is a linear function of the mean readings. Steps of one axis along one diagonal
//! share no reading, so with x the weights of the increments of the axis, e those of the readings
//! in the totals E_d, and p the slope of (7) with its gains G_d = ∂p/∂E_d
//!
//! ```text
//!   u²(point) = Σ x² 2σ²/r + 2 (x_i − x_0) Σ_d G_d cov(increments, E_d) + (x_i − x_0)² u²(p)
//! ```
//! Weights of an increment, g = R/4V_j with its sign, φ = 1 − i/n up to the point and −i/n beyond
//! it (1 and 0 where the slope is that of the increments), ψ = 1 up to the point and 0 beyond:
//!
//! ```text
//!   forward passes only            g φ
//!   mean of two directions         g φ/2 in each pass
//!   + or − curve                   g (φ ± ψ)/2 in the pass in which the axis moves so, g (φ ∓ ψ)/2 in the other
//!   cell of a turn without overrun g φ in the forward pass, whose increment stands for both
//!   reversal of a turn             less the forward, plus the reverse increment of that cell, by their share
//! ```
//! What of u²(p) does not come from the readings (lines, stated causes) is added as it is.
//! Where both ends of a reversal are known from the turn, ψ becomes φ. Neglected: that a beam
//! over a part of the travel, and the rotation of `as-measured`, hold increments of the curve itself.

use super::curves::noise_gain;
use super::uncertainty::{Budget, Side, SlopeFrom};
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::diagonal::{Diagonal, Pass};
use crate::quantity::units::Squared;

/// Standard uncertainties (k = 1) along a curve, µm.
#[derive(Clone, Debug, PartialEq)]
pub struct AlongCurve {
    /// Of everything that counts.
    pub u_um: Vec<f64>,
    /// Of the noise of the readings alone.
    pub noise_um: Vec<f64>,
}

impl Budget<'_> {
    /// Standard uncertainties of a curve, by interval end; `None` where the noise of a reading is
    /// not known.
    pub fn curve(
        &self,
        term: ErrorTerm,
        side: Side<'_>,
        slope: SlopeFrom,
        both_ways: bool,
    ) -> Option<AlongCurve> {
        let variance_um2 = self.noise?.sigma_um.squared();
        let point = Points::new(self, term, side, slope, both_ways);
        let mut found = AlongCurve {
            u_um: Vec::with_capacity(self.volume.steps + 1),
            noise_um: Vec::with_capacity(self.volume.steps + 1),
        };
        // What comes from elsewhere brings the stated contributions with it.
        let (of_noise, all) = match slope {
            SlopeFrom::Increments => (0.0, self.stated_slope(term).squared()),
            SlopeFrom::Elsewhere(slope) => (
                self.slope_noise(&slope, both_ways)?,
                slope.u_um_per_m.squared(),
            ),
        };
        let known = (all - of_noise).max(0.0);
        for index in 0..=self.volume.steps {
            let metres = self.volume.along_mm(term.along, index) / 1000.0;
            let readings = variance_um2 * point.variance(index, metres);
            let noise = (readings + metres * metres * of_noise).max(0.0);
            found.noise_um.push(noise.sqrt());
            let square = noise + metres * metres * known + point.left_out;
            found.u_um.push(square.sqrt());
        }
        Some(found)
    }
}

/// How the points of one curve hang on the readings.
struct Points<'a> {
    both_ways: bool,
    /// +1, −1 for the curves of a direction, 0 for the mean.
    side: f64,
    slope_is_measured: bool,
    /// Both ends of the reversal are known.
    pinned: bool,
    steps: usize,
    parts: Vec<Part>,
    /// Variance of a reversal that was not told from its noise and left out, µm².
    left_out: f64,
    budget: &'a Budget<'a>,
}

/// The share of one diagonal.
struct Part {
    runs: [f64; 2],
    /// R/(4 V_j) with its sign.
    gain: f64,
    /// + where the forward pass moves the axis in +.
    way: f64,
    /// Interval of the turn.
    turn: Option<usize>,
    /// Shares of the jump in the reversal at the low end and in its growth.
    jump: (f64, f64),
    /// Intervals that share readings with the total: which, and G·(difference of weights) by pass.
    shared: Vec<(usize, [f64; 2])>,
}

impl<'a> Points<'a> {
    fn new(
        budget: &'a Budget<'a>,
        term: ErrorTerm,
        side: Side<'_>,
        slope: SlopeFrom,
        both_ways: bool,
    ) -> Points<'a> {
        let (side, turn) = match side {
            Side::Mean => (0.0, None),
            Side::Moving(Direction::Plus, turn) => (1.0, turn),
            Side::Moving(Direction::Minus, turn) => (-1.0, turn),
        };
        let dropped = turn.filter(|turn| side < 0.0 && !turn.in_curves[term]);
        let left_out = dropped.and_then(|turn| turn.reversal[term].u_um);
        let part = |d: Diagonal| Part {
            runs: budget.runs[d],
            gain: noise_gain(budget.volume, term.of) / 2.0 * d.sign(term.along) * d.sign(term.of),
            way: d.sign(term.along),
            turn: (budget.turned && both_ways).then(|| {
                let last = budget.volume.steps - 1;
                budget.volume.interval(d, term.along, last)
            }),
            jump: turn.map_or((0.0, 0.0), |turn| turn.shares(term, d)),
            shared: match slope {
                SlopeFrom::Increments => Vec::new(),
                SlopeFrom::Elsewhere(slope) => {
                    shared(budget, d, term.along, slope.by_end[d], both_ways)
                }
            },
        };
        Points {
            both_ways,
            side,
            slope_is_measured: slope == SlopeFrom::Increments,
            pinned: turn.is_some() && term.is_positioning(),
            steps: budget.volume.steps,
            parts: Diagonal::ALL.map(part).into(),
            left_out: left_out.map_or(0.0, |u| u * u),
            budget,
        }
    }

    /// Variance of a point for readings of 1 µm, without that of the slope: increments, and what
    /// they share with the totals.
    fn variance(&self, index: usize, metres: f64) -> f64 {
        let share = self.share(index);
        let count = |many: usize| {
            #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 steps")]
            let many = many as f64;
            many
        };
        let mut sum = 0.0;
        for part in &self.parts {
            let square = |[forward, reverse]: [f64; 2]| {
                let back = if self.both_ways {
                    reverse * reverse / part.runs[1]
                } else {
                    0.0
                };
                2.0 * (forward * forward / part.runs[0] + back)
            };
            let (mut below, mut beyond) = (index, self.steps - index);
            if let Some(turn) = part.turn {
                *(if turn < index {
                    &mut below
                } else {
                    &mut beyond
                }) -= 1;
                sum += square(self.weights(part, turn, index, share));
            }
            sum += count(below) * square(self.plain(part, true, share));
            sum += count(beyond) * square(self.plain(part, false, share));
            for (interval, [forward, reverse]) in &part.shared {
                let [f, r] = self.weights(part, *interval, index, share);
                let back = if self.both_ways {
                    r * reverse / part.runs[1]
                } else {
                    0.0
                };
                sum += 2.0 * metres * (f * forward / part.runs[0] + back);
            }
        }
        sum
    }

    /// i/n.
    fn share(&self, index: usize) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 steps")]
        let index = index as f64;
        index / self.budget.volume.steps_f64()
    }

    /// φ and ψ of an interval up to the point or beyond it.
    fn line(&self, below: bool, share: f64) -> (f64, f64) {
        let step = f64::from(below);
        let beside = step - share;
        let phi = if self.slope_is_measured { step } else { beside };
        (phi, if self.pinned { beside } else { step })
    }

    /// Weights of the increments of both passes over an ordinary interval.
    fn plain(&self, part: &Part, below: bool, share: f64) -> [f64; 2] {
        let (phi, psi) = self.line(below, share);
        if !self.both_ways {
            return [part.gain * phi, 0.0];
        }
        let apart = self.side * part.way * psi;
        [
            part.gain * (phi + apart) / 2.0,
            part.gain * (phi - apart) / 2.0,
        ]
    }

    /// The same over any interval.
    fn weights(&self, part: &Part, interval: usize, index: usize, share: f64) -> [f64; 2] {
        let below = interval < index;
        if part.turn != Some(interval) {
            return self.plain(part, below, share);
        }
        let (low, growth) = part.jump;
        let offset = if self.side < 0.0 { low } else { 0.0 };
        let jump = self.side * share / 2.0 * growth - offset;
        [part.gain * self.line(below, share).0 - jump, jump]
    }
}

/// Intervals of an axis whose readings stand in the total of a diagonal, too.
fn shared(
    budget: &Budget<'_>,
    diagonal: Diagonal,
    along: Axis,
    gain: f64,
    both_ways: bool,
) -> Vec<(usize, [f64; 2])> {
    let steps = budget.volume.steps;
    let mut near = vec![0, steps.saturating_sub(2), steps - 1];
    near.dedup();
    let difference = |step: usize| {
        let node = budget.volume.node_after(along, step);
        Pass::BOTH.map(|pass| {
            let weight = |node: usize| budget.end_weight(pass, node, both_ways);
            gain * (weight(node) - weight(node - 1))
        })
    };
    let found = near.into_iter().map(|step| {
        let interval = budget.volume.interval(diagonal, along, step);
        (interval, difference(step))
    });
    found
        .filter(|(_, both)| both.iter().any(|weight| weight.abs() > 0.0))
        .collect()
}
