//! Standard uncertainties (k = 1) of the nine curves, propagated from the readings.
//!
//! Readings are independent with standard deviation σ; a run mean of r runs has σ/√r. Steps of
//! one axis along one diagonal share no reading, so with v = Σ_d (R/4V_j)²·2σ²/r_d
//!
//! ```text
//!   sum of increments (slopes as separated)     u²(i) = i v
//!   beside the line through the ends            u²(i) = i (n − i)/n · v
//!   slope p from totals, linear axes, beams     u²(i) += u²(p) (x_i − x_0)²
//! ```
//! Neglected: that the first and last reading of a diagonal serve both shape and total (a share
//! of order 1/n; the coverage in docs/accuracy.md was measured with it). Stated contributions of
//! `[measurement.uncertainty]` are straight lines in position and are added as squares.

use super::curves::noise_gain;
use super::increments::Group;
use super::noise::Noise;
use crate::axis::ErrorTerm;
use crate::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::job::{Material, StatedUncertainty};

/// Which slope a curve has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlopeFrom {
    /// The separated increments.
    Increments,
    /// Somewhere else, with this standard uncertainty, µm/m; 0 where the frame sets it to zero.
    Elsewhere {
        /// µm/m.
        u_um_per_m: f64,
    },
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
    /// `[measurement.uncertainty]`.
    pub stated: StatedUncertainty,
    /// Expansion of the scales.
    pub material: Option<Material>,
}

impl Budget<'_> {
    /// v: variance of one separated increment of a term in a group, µm².
    fn increment_variance(&self, term: ErrorTerm, group: Group, sigma_um: f64) -> f64 {
        let gain = noise_gain(self.volume, term.of) / 2.0;
        let of = |d: Diagonal| {
            let pass = group.pass(d, term.along);
            let runs = self.runs[d][usize::from(pass == Pass::Reverse)];
            2.0 * sigma_um * sigma_um / runs
        };
        gain * gain * Diagonal::ALL.into_iter().map(of).sum::<f64>()
    }

    /// Standard uncertainty of a curve that is the mean of `groups`, by interval end, µm; `None`
    /// where the noise of a reading is not known.
    pub fn mean_curve(
        &self,
        term: ErrorTerm,
        groups: &[Group],
        slope: SlopeFrom,
    ) -> Option<Vec<f64>> {
        let v = self.mean_variance(term, groups)?;
        Some(self.curve(
            term,
            |i, n| match slope {
                SlopeFrom::Increments => i * v,
                SlopeFrom::Elsewhere { .. } => i * (n - i) / n * v,
            },
            slope,
        ))
    }

    /// The same of the curve of one of two directions: the mean curve and half of the difference,
    /// whose slope is never that of the mirror. `from_turn`: the curve holds the reversal of a turn,
    /// the difference of two measured increments, u² = 4 v.
    pub fn directed_curve(
        &self,
        term: ErrorTerm,
        groups: &[Group],
        slope: SlopeFrom,
        from_turn: bool,
    ) -> Option<Vec<f64>> {
        let v = self.mean_variance(term, groups)?;
        Some(self.curve(
            term,
            |i, n| {
                let shape = match slope {
                    SlopeFrom::Increments => 2.0 * i,
                    SlopeFrom::Elsewhere { .. } => i * (n - i) / n + i,
                };
                (shape + if from_turn { 4.0 } else { 0.0 }) * v
            },
            slope,
        ))
    }

    fn mean_variance(&self, term: ErrorTerm, groups: &[Group]) -> Option<f64> {
        let sigma = self.noise?.sigma_um;
        let sum: f64 = groups
            .iter()
            .map(|group| self.increment_variance(term, *group, sigma))
            .sum();
        #[allow(clippy::cast_precision_loss, reason = "two directions at most")]
        let count = groups.len() as f64;
        Some(sum / (count * count))
    }

    fn curve(
        &self,
        term: ErrorTerm,
        noise: impl Fn(f64, f64) -> f64,
        slope: SlopeFrom,
    ) -> Vec<f64> {
        let n = self.volume.steps_f64();
        let u_slope = match slope {
            SlopeFrom::Increments => 0.0,
            SlopeFrom::Elsewhere { u_um_per_m } => u_um_per_m,
        };
        let stated = self.stated_slope(term);
        let mut curve = Vec::with_capacity(self.volume.steps + 1);
        for index in 0..=self.volume.steps {
            let metres = self.volume.along_mm(term.along, index) / 1000.0;
            #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 steps")]
            let i = index as f64;
            let square = noise(i, n) + metres * metres * (u_slope * u_slope + stated * stated);
            curve.push(square.sqrt());
        }
        curve
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
    pub fn u_end_um(&self, passes: usize) -> Option<f64> {
        let sigma = self.noise?.sigma_um;
        let of = |d: Diagonal| {
            let runs = self.runs[d].iter().take(passes);
            let sum: f64 = runs.map(|runs| 2.0 * sigma * sigma / runs).sum();
            #[allow(clippy::cast_precision_loss, reason = "two passes at most")]
            let count = passes as f64;
            sum / (count * count)
        };
        let mean: f64 = Diagonal::ALL.into_iter().map(of).sum::<f64>() / 4.0;
        Some(mean.sqrt())
    }

    /// What counts in the uncertainty and what does not, one sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let mut said = Vec::new();
        match self.noise {
            Some(noise) => {
                let freedom = noise.freedom.map_or_else(String::new, |freedom| {
                    format!(", {freedom} degrees of freedom")
                });
                said.push(format!(
                    "noise of a single reading {:.3} µm (k = 1), {}{freedom}",
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
        said
    }
}
