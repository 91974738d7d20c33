//! What the uncertainty of the nine curves consists of: noise of the readings, stated causes, and
//! where the slope of a curve comes from. [`super::propagation`] carries it to the points.
//!
//! Stated contributions of `[measurement.uncertainty]` are straight lines in position: they enter
//! the totals and go through formula (7) with them, see [`Budget::totals`]; slopes from the
//! increments take them as they are.

use super::corrections::REFERENCE_C;
use super::curves::noise_gain;
use super::metric::{PerPlane, TotalsUncertainty};
use super::noise::{Noise, coverage_factor, effective_freedom};
use super::reversal::Turn;
use crate::inputs::job::{AxisMaterial, Material, StatedUncertainty};
use crate::machine::separation::totals::u_squareness;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;

/// Uncertainty that weighs totals where neither noise nor a statement gives one, µm/m.
const WEIGHT_UM_PER_M: f64 = 1.0;

/// Which slope a curve has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlopeFrom {
    /// The separated increments.
    Increments,
    /// Somewhere else; all 0 where the frame sets it to zero.
    Elsewhere(Slope),
}

/// The uncertainty of a slope that is not that of the increments, and what hangs on the readings.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Slope {
    /// Standard uncertainty of everything that counts, µm/m.
    pub u_um_per_m: f64,
    /// Change with the total of each diagonal, µm/m for each µm.
    pub by_end: PerDiagonal<f64>,
    /// Standard uncertainty from the noise of a rotation between twin slopes, µm/m.
    pub rotation_um_per_m: f64,
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side<'a> {
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
    /// Variance of a slope by the noise of the readings alone, (µm/m)².
    pub(crate) fn slope_noise(&self, slope: &Slope, both_ways: bool) -> Option<f64> {
        let part = |d| Some(slope.by_end[d].squared() * self.end_variance_um2(d, both_ways)?);
        let by_ends: Option<f64> = Diagonal::ALL.into_iter().map(part).sum();
        Some(by_ends? + slope.rotation_um_per_m.squared())
    }

    /// Standard uncertainty of a slope with its effective degrees of freedom.
    pub(crate) fn of_slope(&self, slope: &Slope, both_ways: bool) -> Option<SlopeUncertainty> {
        let u_um_per_m = slope.u_um_per_m;
        let noise = self.slope_noise(slope, both_ways)?.sqrt();
        let freedom = effective_freedom(u_um_per_m, noise, self.noise?);
        Some(SlopeUncertainty {
            u_um_per_m,
            freedom,
        })
    }

    /// Weight of a reading in the total of its diagonal (the mean over both passes).
    pub(super) fn end_weight(&self, pass: Pass, node: usize, both_ways: bool) -> f64 {
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
            let part = |node: &usize| self.end_weight(pass, *node, both_ways).squared() / runs;
            nodes.iter().map(part).sum::<f64>()
        };
        let passes = if both_ways {
            &Pass::BOTH[..]
        } else {
            &Pass::BOTH[..1]
        };
        passes.iter().map(|pass| of(*pass)).sum()
    }

    /// Variance of the mean total of a diagonal by the noise of its readings, µm².
    fn end_variance_um2(&self, diagonal: Diagonal, both_ways: bool) -> Option<f64> {
        Some(self.noise?.sigma_um.squared() * self.end_variance(diagonal, both_ways))
    }

    /// Length scale that each set-up has for itself, 10⁻⁶. The beam counts here and among the common
    /// causes: it may lean alike in all set-ups, or in some of them only.
    fn setup_ppm(&self) -> f64 {
        let stated = self.stated.setup_ppm.unwrap_or(0.0);
        stated.hypot(self.stated.beam_ppm())
    }

    /// Stated contributions to a slope of the increments, µm/m.
    pub(super) fn stated_slope(&self, term: ErrorTerm) -> f64 {
        // V_k/(4V_j) Σ_d s_dj s_dk ε_d with independent ε_d.
        let edges = self.volume.size[term.along].mm() / self.volume.size[term.of].mm();
        let setups = edges / 2.0 * self.setup_ppm();
        let common = self.common_um_per_m().into_iter().map(|strain| {
            if term.is_positioning() {
                strain[term.along]
            } else {
                0.0
            }
        });
        let square: f64 = common.map(|strain| strain * strain).sum();
        setups.hypot(square.sqrt())
    }

    /// Causes that act alike in all set-ups, one after the other: the false scale of X, Y, Z that
    /// one standard uncertainty makes, µm/m. Temperature and coefficient of expansion are taken as
    /// wrong by the same amount on all axes, which for the totals is the largest they can do.
    fn common_um_per_m(&self) -> Vec<PerAxis<f64>> {
        let axes = |of: &dyn Fn(AxisMaterial) -> Option<f64>| {
            let axis = |axis| {
                self.material
                    .and_then(|material| material.axes[axis])
                    .and_then(of)
            };
            PerAxis::from_fn(|a| 1e6 * axis(a).unwrap_or(0.0))
        };
        let laser = self.stated.laser_ppm.map(|ppm| PerAxis::from_fn(|_| ppm));
        let temperature = self.stated.temperature_k;
        let temperature = temperature.map(|u| axes(&|m| Some(m.alpha_per_k * u)));
        let alpha = self.stated.alpha_per_k;
        let alpha = alpha.map(|u| axes(&|m| Some(u * (m.temperature_c? - REFERENCE_C))));
        let beam = Some(PerAxis::from_fn(|_| self.stated.beam_ppm()));
        let all = [laser, temperature, alpha, beam].into_iter().flatten();
        all.filter(|strain| Axis::ALL.into_iter().any(|axis| strain[axis] != 0.0))
            .collect()
    }

    /// Uncertainty of the totals by their length, as formula (7) takes it.
    pub fn totals(&self, both_ways: bool) -> TotalsUncertainty {
        let metres = self.volume.diagonal_mm() / 1000.0;
        let setups = self.setup_ppm();
        TotalsUncertainty {
            own_um_per_m: PerDiagonal::from_fn(|d| {
                let noise = self
                    .end_variance_um2(d, both_ways)
                    .map(|square| square.sqrt() / metres);
                noise.unwrap_or(WEIGHT_UM_PER_M).hypot(setups)
            }),
            known: self.noise.is_some(),
            common_um_per_m: self.common_um_per_m(),
        }
    }

    /// u(φ) = R/(4 V_j V_k)·√Σ u²(e_d(end)), µm/m: squareness from the totals as they are, formula (4).
    pub fn u_squareness(&self, both_ways: bool) -> Option<PerPlane<f64>> {
        let setups = self.volume.diagonal_mm() / 1000.0 * self.setup_ppm();
        let ends: Option<Vec<f64>> = Diagonal::ALL
            .into_iter()
            .map(|d| self.end_variance_um2(d, both_ways))
            .collect();
        let mean = ends?.iter().sum::<f64>() / 4.0;
        Some(u_squareness(self.volume, mean.sqrt().hypot(setups)))
    }

    /// Variance of one separated increment of a term without regard to direction, µm².
    fn increment_variance(&self, term: ErrorTerm, both_ways: bool) -> Option<f64> {
        let sigma = self.noise?.sigma_um;
        let gain = noise_gain(self.volume, term.of) / 2.0;
        let of = |d: Diagonal| match self.runs[d] {
            [forward, reverse] if both_ways => (1.0 / forward + 1.0 / reverse) / 4.0,
            [forward, _] => 1.0 / forward,
        };
        let means: f64 = Diagonal::ALL.into_iter().map(of).sum();
        Some(2.0 * gain * gain * sigma * sigma * means)
    }

    /// Half the difference between two twin slopes of the increments: standard uncertainties by
    /// the noise of the readings and by everything, µm/m. The sums behind the twins share their
    /// readings with opposite signs: u² = 3 times that of one.
    pub(crate) fn u_turn(&self, term: ErrorTerm, both_ways: bool) -> Option<(f64, f64)> {
        let metres = self.volume.size[term.along].mm() / 1000.0;
        let noise = self.volume.steps_f64() * self.increment_variance(term, both_ways)?;
        let noise = (3.0 * noise).sqrt() / metres / 2.0;
        // ε_d of the set-ups: V_k/(4V_j) − V_j/(4V_k), the same signs in both.
        let (along, of) = (
            self.volume.size[term.along].mm(),
            self.volume.size[term.of].mm(),
        );
        let setups = (along / of - of / along) / 4.0 * self.setup_ppm();
        Some((noise, noise.hypot(setups)))
    }

    /// Variance of a shape between two positions inside the box; µm².
    pub(crate) fn shape_variance(
        &self,
        term: ErrorTerm,
        both_ways: bool,
        from: f64,
        to: f64,
    ) -> Option<f64> {
        let n = self.volume.steps_f64();
        let steps = (to - from).abs() / self.volume.step_mm(term.along);
        Some((steps - steps * steps / n) * self.increment_variance(term, both_ways)?)
    }
}
