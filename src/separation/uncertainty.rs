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
//! Where both ends of a reversal are known from the turn, ψ becomes φ. Stated contributions of
//! `[measurement.uncertainty]` are straight lines in position and are added as squares.

use super::curves::noise_gain;
use super::noise::{Noise, coverage_factor};
use super::reversal::Turn;
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::job::{Material, StatedUncertainty};

/// Which slope a curve has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlopeFrom {
    /// The separated increments.
    Increments,
    /// Somewhere else; all 0 where the frame sets it to zero.
    Elsewhere {
        /// Standard uncertainty, µm/m.
        u_um_per_m: f64,
        /// Its change with the total of each diagonal, µm/m for each µm.
        by_end: PerDiagonal<f64>,
    },
}

/// Which of the curves of a term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side<'a> {
    /// Without regard to direction, or the mean of both.
    Mean,
    /// Moving in one direction, with the reversal of a turn.
    Moving(Direction, Option<&'a Turn>),
}

/// Standard uncertainties (k = 1) along a curve, µm.
#[derive(Clone, Debug, PartialEq)]
pub struct AlongCurve {
    /// Of everything that counts.
    pub u_um: Vec<f64>,
    /// Of the noise of the readings alone.
    pub noise_um: Vec<f64>,
}

/// What the uncertainty of a measurement consists of.
#[derive(Clone, Debug)]
pub struct Budget<'a> {
    /// The measured box.
    pub volume: &'a Volume,
    /// Of a single reading; `None` = not known.
    pub noise: Option<Noise>,
    /// Runs of each pass.
    pub runs: &'a PerDiagonal<[f64; 2]>,
    /// Whether the axes turned without overrun, so that jumps are taken off the reverse passes.
    pub turned: bool,
    /// `[measurement.uncertainty]`.
    pub stated: StatedUncertainty,
    /// Expansion of the scales.
    pub material: Option<Material>,
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
        let variance_um2 = self.noise?.sigma_um.powi(2);
        let point = Points::new(self, term, side, slope, both_ways);
        let stated = self.stated_slope(term);
        let mut found = AlongCurve {
            u_um: Vec::with_capacity(self.volume.steps + 1),
            noise_um: Vec::with_capacity(self.volume.steps + 1),
        };
        let (by_ends, u_slope) = match slope {
            SlopeFrom::Increments => (0.0, 0.0),
            SlopeFrom::Elsewhere { u_um_per_m, by_end } => {
                let part = |d| by_end[d] * by_end[d] * self.end_variance(d, both_ways);
                let by_ends: f64 = Diagonal::ALL.into_iter().map(part).sum();
                (by_ends * variance_um2, u_um_per_m)
            }
        };
        let known = (u_slope * u_slope - by_ends).max(0.0);
        for index in 0..=self.volume.steps {
            let metres = self.volume.along_mm(term.along, index) / 1000.0;
            let readings = variance_um2 * point.variance(index, metres);
            let noise = (readings + metres * metres * by_ends).max(0.0);
            let rest = metres * metres * (known + stated * stated);
            found.noise_um.push(noise.sqrt());
            found.u_um.push((noise + rest + point.left_out).sqrt());
        }
        Some(found)
    }

    /// Weight of a reading in the total of its diagonal (the mean over both passes).
    fn end_weight(&self, pass: Pass, node: usize, both_ways: bool) -> f64 {
        let last = 3 * self.volume.steps;
        let share = if both_ways { 0.5 } else { 1.0 };
        let weights = match (pass, self.turned && both_ways) {
            (Pass::Reverse, _) if !both_ways => return 0.0,
            (_, false) => [(0, -share), (last, share), (last, 0.0)],
            (Pass::Forward, true) => [(0, -0.5), (last - 3, -0.5), (last, 1.0)],
            (Pass::Reverse, true) => [(0, -0.5), (last - 3, 0.5), (last, 0.0)],
        };
        let here = weights.iter().filter(|(at, _)| *at == node);
        here.map(|(_, weight)| weight).sum()
    }

    /// Variance of the total of a diagonal for readings of 1 µm.
    fn end_variance(&self, diagonal: Diagonal, both_ways: bool) -> f64 {
        let last = 3 * self.volume.steps;
        let mut nodes = vec![0, last - 3, last];
        nodes.dedup();
        let of = |pass: Pass| {
            let runs = self.runs[diagonal][usize::from(pass == Pass::Reverse)];
            let part = |node: &usize| self.end_weight(pass, *node, both_ways).powi(2) / runs;
            nodes.iter().map(part).sum::<f64>()
        };
        let passes = if both_ways {
            &Pass::BOTH[..]
        } else {
            &Pass::BOTH[..1]
        };
        passes.iter().map(|pass| of(*pass)).sum()
    }

    /// Stated contributions to the slope of a positioning error, µm/m: scale of the laser,
    /// temperature and coefficient of expansion.
    fn stated_slope(&self, term: ErrorTerm) -> f64 {
        if !term.is_positioning() {
            return 0.0;
        }
        let material = self.material.and_then(|material| material.axes[term.along]);
        let laser = self.stated.laser_ppm.unwrap_or(0.0);
        let temperature = material.zip(self.stated.temperature_k);
        let temperature = temperature.map_or(0.0, |(m, u)| m.alpha_per_k * u * 1e6);
        let warm = material.and_then(|m| m.temperature_c).map(|t| t - 20.0);
        let alpha = warm
            .zip(self.stated.alpha_per_k)
            .map_or(0.0, |(dt, u)| u * dt * 1e6);
        (laser.powi(2) + temperature.powi(2) + alpha.powi(2)).sqrt()
    }

    /// Standard uncertainty of the mean total of a diagonal, µm.
    pub fn u_end_um(&self, both_ways: bool) -> Option<f64> {
        let sigma = self.noise?.sigma_um;
        let of = |d: Diagonal| self.end_variance(d, both_ways);
        let mean: f64 = Diagonal::ALL.into_iter().map(of).sum::<f64>() / 4.0;
        Some(sigma * mean.sqrt())
    }

    /// What counts in the uncertainty and what does not, one sentence each.
    pub fn sentences(&self, angles_given: bool, bow_um_per_urad: &PerAxis<f64>) -> Vec<String> {
        let mut said = Vec::new();
        match self.noise {
            Some(noise) => {
                let k = coverage_factor(noise.freedom_f64());
                let freedom = noise.freedom.map_or_else(String::new, |freedom| {
                    format!(", {freedom} degrees of freedom: k = {k:.2} by Student holds 95 %")
                });
                said.push(format!(
                    "noise of a single reading {:.3} um (k = 1), {}{freedom}",
                    noise.sigma_um,
                    noise.source.words()
                ));
            }
            None => said.push(
                "noise of the readings is not known (one run, no redundancy): no uncertainty is given"
                    .to_string(),
            ),
        }
        let stated = [
            ("laser_ppm", self.stated.laser_ppm),
            ("temperature_k", self.stated.temperature_k),
            ("alpha_per_k", self.stated.alpha_per_k),
        ];
        for (key, value) in stated {
            let needs_material = key != "laser_ppm";
            match value {
                Some(_) if needs_material && self.material.is_none() => said.push(format!(
                    "{key} is stated but not included: the job gives no expansion of the scales ([measurement.step_diagonal.material])"
                )),
                Some(_) => said.push(format!("{key} is included in the positioning errors")),
                None => said.push(format!("{key} is not stated and not included")),
            }
        }
        if !angles_given {
            let bow = |axis: Axis| format!("{axis} {:.3}", bow_um_per_urad[axis]);
            said.push(format!(
                "angular errors are not given and not included: each urad of pitch or yaw between the ends of an axis bends the curves by up to (um) {}; the closure does not show it",
                Axis::ALL.map(bow).join(", ")
            ));
        }
        said
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
                SlopeFrom::Elsewhere { by_end, .. } => {
                    shared(budget, d, term.along, by_end[d], both_ways)
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
        .filter(|(_, both)| both.iter().any(|um| um.abs() > 0.0))
        .collect()
}
