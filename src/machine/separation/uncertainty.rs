//! Standard uncertainties (k = 1) of the nine curves: what they consist of, and how it reaches the points.
//!
//! Stated contributions of `[measurement.uncertainty]` are straight lines in position: they enter
//! the totals and go through formula (7) with them, see [`Budget::totals`]; slopes from the
//! increments take them as they are.
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

use super::corrections::REFERENCE_C;
use super::curves::noise_gain;
use super::metric::{PerPlane, TotalsUncertainty};
use super::noise::{Noise, coverage_factor, effective_freedom, float};
use super::reversal::Turn;
use crate::inputs::job::{AxisMaterial, Material, StatedUncertainty};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;

/// Uncertainty that weighs totals where neither noise nor a statement gives one, µm/m.
const WEIGHT_UM_PER_M: f64 = 1.0;

/// Which slope a curve has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SlopeFrom {
    /// The separated increments.
    Increments,
    /// Somewhere else; all 0 where the frame sets it to zero.
    Elsewhere(Slope),
}

/// The uncertainty of a slope that is not that of the increments, and what hangs on the readings.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(super) struct Slope {
    /// Standard uncertainty of everything that counts, µm/m.
    pub(super) u_um_per_m: f64,
    /// Change with the total of each diagonal, µm/m for each µm.
    pub(super) by_end: PerDiagonal<f64>,
    /// Standard uncertainty from the noise of a rotation between twin slopes, µm/m.
    pub(super) rotation_um_per_m: f64,
}

/// How well a slope is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeUncertainty {
    /// Standard uncertainty, µm/m.
    pub u_um_per_m: f64,
    /// Its effective degrees of freedom; `None` = unlimited.
    pub freedom: Option<f64>,
}

impl SlopeUncertainty {
    /// U, µm/m: with the coverage factor of its degrees of freedom.
    pub(crate) fn expanded_um_per_m(&self) -> f64 {
        coverage_factor(self.freedom) * self.u_um_per_m
    }
}

/// Which of the curves of a term.
#[derive(Clone, Copy, Debug)]
pub(super) enum Side<'a> {
    /// Without regard to direction, or the mean of both.
    Mean,
    /// Moving in one direction, with the reversal of a turn.
    Moving(Direction, Option<&'a Turn>),
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
    /// The passes that every diagonal was walked in.
    fn passes(&self) -> &'static [Pass] {
        let back = self.runs.iter().all(|(_, runs)| runs[1] > 0.0);
        if back { &Pass::BOTH } else { &Pass::BOTH[..1] }
    }

    pub(super) fn both_ways(&self) -> bool {
        self.passes().len() == 2
    }

    /// Variance of a slope by the noise of the readings alone, (µm/m)².
    fn slope_noise(&self, slope: &Slope) -> Option<f64> {
        let part = |d| Some(slope.by_end[d].squared() * self.end_variance_um2(d)?);
        let by_ends: Option<f64> = Diagonal::ALL.into_iter().map(part).sum();
        Some(by_ends? + slope.rotation_um_per_m.squared())
    }

    /// Standard uncertainty of a slope with its effective degrees of freedom.
    pub(super) fn of_slope(&self, slope: &Slope) -> Option<SlopeUncertainty> {
        let u_um_per_m = slope.u_um_per_m;
        let noise = self.slope_noise(slope)?.sqrt();
        let freedom = effective_freedom(u_um_per_m, noise, self.noise?);
        Some(SlopeUncertainty { u_um_per_m, freedom })
    }

    /// Weight of a reading in the total of its diagonal (the mean over both passes).
    fn end_weight(&self, pass: Pass, node: usize) -> f64 {
        let last = 3 * self.volume.steps;
        let share = if self.both_ways() { 0.5 } else { 1.0 };
        let weights = match (pass, self.turned && self.both_ways()) {
            (Pass::Reverse, _) if !self.both_ways() => return 0.0,
            (_, false) => [(0, -share), (last, share), (last, 0.0)],
            (Pass::Forward, true) => [(0, -0.5), (last - 3, -0.5), (last, 1.0)],
            (Pass::Reverse, true) => [(0, -0.5), (last - 3, 0.5), (last, 0.0)],
        };
        let here = weights.iter().filter(|(at, _)| *at == node);
        here.map(|(_, weight)| weight).sum()
    }

    /// Variance of the mean total of a diagonal by the noise of its readings, µm².
    fn end_variance_um2(&self, diagonal: Diagonal) -> Option<f64> {
        let last = 3 * self.volume.steps;
        let mut nodes = vec![0, last - 3, last];
        nodes.dedup();
        let of = |pass: &Pass| {
            let runs = self.runs[diagonal][usize::from(*pass == Pass::Reverse)];
            let part = |node: &usize| self.end_weight(*pass, *node).squared() / runs;
            nodes.iter().map(part).sum::<f64>()
        };
        let variance: f64 = self.passes().iter().map(of).sum();
        Some(self.noise?.sigma_um.squared() * variance)
    }

    /// Length scale that each set-up has for itself, 10⁻⁶. The beam counts here and among the common
    /// causes: it may lean alike in all set-ups, or in some of them only.
    fn setup_ppm(&self) -> f64 {
        let stated = self.stated.setup_ppm.unwrap_or(0.0);
        stated.hypot(self.stated.beam_ppm())
    }

    /// Stated contributions to a slope of the increments, µm/m.
    fn stated_slope(&self, term: ErrorTerm) -> f64 {
        // V_k/(4V_j) Σ_d s_dj s_dk ε_d with independent ε_d.
        let edges = self.volume.size[term.along].mm() / self.volume.size[term.of].mm();
        let setups = edges / 2.0 * self.setup_ppm();
        let own_scale = f64::from(term.is_positioning());
        let common = self.common_um_per_m().into_iter();
        let square: f64 = common.map(|strain| (own_scale * strain[term.along]).squared()).sum();
        setups.hypot(square.sqrt())
    }

    /// Causes that act alike in all set-ups, one after the other: the false scale of X, Y, Z that
    /// one standard uncertainty makes, µm/m. Temperature and coefficient of expansion are taken as
    /// wrong by the same amount on all axes, which for the totals is the largest they can do.
    fn common_um_per_m(&self) -> Vec<PerAxis<f64>> {
        let strain = |of: &dyn Fn(AxisMaterial) -> Option<f64>| {
            let material = |axis| self.material.and_then(|material| material.axes[axis]);
            PerAxis::from_fn(|axis| 1e6 * material(axis).and_then(of).unwrap_or(0.0))
        };
        let stated = self.stated;
        let alike = |ppm| PerAxis::from_fn(|_| ppm);
        let of_temperature = |u: f64| strain(&|m| Some(m.alpha_per_k * u));
        let of_alpha = |u: f64| strain(&|m| Some(u * (m.temperature_c? - REFERENCE_C)));
        let all = [
            stated.laser_ppm.map(alike),
            stated.temperature_k.map(of_temperature),
            stated.alpha_per_k.map(of_alpha),
            Some(alike(stated.beam_ppm())),
        ];
        let acts = |strain: &PerAxis<f64>| strain.iter().any(|(_, um_per_m)| um_per_m.abs() > 0.0);
        all.into_iter().flatten().filter(acts).collect()
    }

    /// Standard uncertainty of a length along an axis by this laser in one set-up, without the noise of
    /// the readings, 10⁻⁶.
    pub(super) fn of_length_ppm(&self, axis: Axis) -> f64 {
        let common = self.common_um_per_m().into_iter();
        let own = self.stated.setup_ppm.unwrap_or(0.0);
        common.fold(own, |all, strain| all.hypot(strain[axis]))
    }

    /// Uncertainty of the totals by their length, as formula (7) takes it.
    pub(super) fn totals(&self) -> TotalsUncertainty {
        let metres = self.volume.diagonal_mm() / 1000.0;
        TotalsUncertainty {
            own_um_per_m: PerDiagonal::from_fn(|d| {
                let noise = self.end_variance_um2(d);
                let noise = noise.map_or(WEIGHT_UM_PER_M, |square| square.sqrt() / metres);
                noise.hypot(self.setup_ppm())
            }),
            known: self.noise.is_some(),
            common_um_per_m: self.common_um_per_m(),
        }
    }

    /// u(φ) = R/(4 V_j V_k)·√Σ u²(e_d(end)), µm/m: squareness from the totals as they are, formula (4).
    pub(super) fn u_squareness(&self) -> Option<PerPlane<f64>> {
        let setups = self.volume.diagonal_mm() / 1000.0 * self.setup_ppm();
        let ends = Diagonal::ALL.map(|d| self.end_variance_um2(d));
        let mean = ends.into_iter().sum::<Option<f64>>()? / 4.0;
        Some(u_squareness(self.volume, mean.sqrt().hypot(setups)))
    }

    /// Variance of one separated increment of a term without regard to direction, µm².
    fn increment_variance(&self, term: ErrorTerm) -> Option<f64> {
        let sigma = self.noise?.sigma_um;
        let gain = noise_gain(self.volume, term.of) / 2.0;
        let of = |d: Diagonal| match self.runs[d] {
            [forward, reverse] if self.both_ways() => (1.0 / forward + 1.0 / reverse) / 4.0,
            [forward, _] => 1.0 / forward,
        };
        let means: f64 = Diagonal::ALL.into_iter().map(of).sum();
        Some(2.0 * gain * gain * sigma * sigma * means)
    }

    /// Half the difference between two twin slopes of the increments: standard uncertainties by
    /// the noise of the readings and by everything, µm/m. The sums behind the twins share their
    /// readings with opposite signs: u² = 3 times that of one.
    pub(super) fn u_turn(&self, term: ErrorTerm) -> Option<(f64, f64)> {
        let along = self.volume.size[term.along].mm();
        let of = self.volume.size[term.of].mm();
        let noise = self.volume.steps_f64() * self.increment_variance(term)?;
        let noise = (3.0 * noise).sqrt() / (along / 1000.0) / 2.0;
        // ε_d of the set-ups: V_k/(4V_j) − V_j/(4V_k), the same signs in both.
        let setups = (along / of - of / along) / 4.0 * self.setup_ppm();
        Some((noise, noise.hypot(setups)))
    }

    /// Variance of a shape between two positions inside the box, mm; µm².
    pub(super) fn shape_variance(&self, term: ErrorTerm, from: f64, to: f64) -> Option<f64> {
        let n = self.volume.steps_f64();
        let steps = (to - from).abs() / self.volume.step_mm(term.along);
        Some((steps - steps * steps / n) * self.increment_variance(term)?)
    }

    /// Standard uncertainties of a curve, by interval end, µm: of everything that counts, and of the
    /// noise of the readings alone; `None` where that noise is not known.
    pub(super) fn curve(
        &self,
        term: ErrorTerm,
        side: Side<'_>,
        slope: SlopeFrom,
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let variance_um2 = self.noise?.sigma_um.squared();
        let points = Points::new(self, term, side, slope);
        // What comes from elsewhere brings the stated contributions with it.
        let (of_noise, all) = match slope {
            SlopeFrom::Increments => (0.0, self.stated_slope(term).squared()),
            SlopeFrom::Elsewhere(slope) => (self.slope_noise(&slope)?, slope.u_um_per_m.squared()),
        };
        let known = (all - of_noise).max(0.0);
        let at = |index: usize| {
            let metres = self.volume.along_mm(term.along, index) / 1000.0;
            let readings = variance_um2 * points.variance(index, metres);
            let noise = (readings + metres * metres * of_noise).max(0.0);
            let square = noise + metres * metres * known + points.left_out;
            (square.sqrt(), noise.sqrt())
        };
        Some((0..=self.volume.steps).map(at).unzip())
    }
}

/// u(φ) = R/(2 V_j V_k)·u(e_end), µm/m.
pub(super) fn u_squareness(volume: &Volume, u_end_um: f64) -> PerPlane<f64> {
    PerPlane::from_fn(|plane| {
        let (a, b) = plane.axes();
        let area = volume.size[a].mm() * volume.size[b].mm();
        1000.0 * volume.diagonal_mm() / (2.0 * area) * u_end_um
    })
}

/// How the points of one curve hang on the readings.
struct Points {
    both_ways: bool,
    /// +1, −1 for the curves of a direction, 0 for the mean.
    side: f64,
    slope_is_measured: bool,
    /// Both ends of the reversal are known.
    pinned: bool,
    steps: usize,
    parts: [Part; 4],
    /// Variance of a reversal that was not told from its noise and left out, µm².
    left_out: f64,
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

impl Points {
    fn new(budget: &Budget<'_>, term: ErrorTerm, side: Side<'_>, slope: SlopeFrom) -> Points {
        let (side, turn) = match side {
            Side::Mean => (0.0, None),
            Side::Moving(Direction::Plus, turn) => (1.0, turn),
            Side::Moving(Direction::Minus, turn) => (-1.0, turn),
        };
        let (volume, both_ways) = (budget.volume, budget.both_ways());
        let dropped = turn.filter(|turn| side < 0.0 && !turn.in_curves[term]);
        let left_out = dropped.and_then(|turn| turn.reversal[term].u_um);
        let part = |d: Diagonal| Part {
            runs: budget.runs[d],
            gain: noise_gain(volume, term.of) / 2.0 * d.sign(term.along) * d.sign(term.of),
            way: d.sign(term.along),
            turn: (budget.turned && both_ways)
                .then(|| volume.interval(d, term.along, volume.steps - 1)),
            jump: turn.map_or((0.0, 0.0), |turn| turn.shares(term, d)),
            shared: match slope {
                SlopeFrom::Increments => Vec::new(),
                SlopeFrom::Elsewhere(slope) => shared(budget, d, term.along, slope.by_end[d]),
            },
        };
        Points {
            both_ways,
            side,
            slope_is_measured: slope == SlopeFrom::Increments,
            pinned: turn.is_some() && term.is_positioning(),
            steps: volume.steps,
            parts: Diagonal::ALL.map(part),
            left_out: left_out.map_or(0.0, |u| u * u),
        }
    }

    /// Variance of a point for readings of 1 µm, without that of the slope: increments, and what
    /// they share with the totals.
    fn variance(&self, index: usize, metres: f64) -> f64 {
        let share = float(index) / float(self.steps);
        let mut sum = 0.0;
        for part in &self.parts {
            let product = |[f, r]: [f64; 2], [forward, reverse]: [f64; 2]| {
                let back = if self.both_ways { r * reverse / part.runs[1] } else { 0.0 };
                2.0 * (f * forward / part.runs[0] + back)
            };
            let square = |weights| product(weights, weights);
            let (mut below, mut beyond) = (index, self.steps - index);
            if let Some(turn) = part.turn {
                let side = if turn < index { &mut below } else { &mut beyond };
                *side -= 1;
                sum += square(self.weights(part, turn, index, share));
            }
            sum += float(below) * square(self.plain(part, true, share));
            sum += float(beyond) * square(self.plain(part, false, share));
            for (interval, of_total) in &part.shared {
                let weights = self.weights(part, *interval, index, share);
                sum += metres * product(weights, *of_total);
            }
        }
        sum
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
        [phi + apart, phi - apart].map(|weight| part.gain * weight / 2.0)
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
) -> Vec<(usize, [f64; 2])> {
    let steps = budget.volume.steps;
    let mut near = vec![0, steps.saturating_sub(2), steps - 1];
    near.dedup();
    let found = near.into_iter().map(|step| {
        let node = budget.volume.node_after(along, step);
        let difference =
            |pass: Pass| gain * (budget.end_weight(pass, node) - budget.end_weight(pass, node - 1));
        let interval = budget.volume.interval(diagonal, along, step);
        (interval, Pass::BOTH.map(difference))
    });
    let counts = |(_, both): &(usize, [f64; 2])| both.iter().any(|weight| weight.abs() > 0.0);
    found.filter(counts).collect()
}
