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
//! `[measurement.uncertainty]` are straight lines in position: they enter the totals and go through
//! formula (7) with them, see [`Budget::totals`]; slopes from the increments take them as they are.

use super::corrections::REFERENCE_C;
use super::curves::noise_gain;
use super::increments::Group;
use super::metric::{PerPlane, Plane, TotalsUncertainty};
use super::noise::Noise;
use super::straight::u_squareness;
use crate::axis::{Axis, ErrorTerm, PerAxis};
use crate::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::job::{AxisMaterial, Material, StatedUncertainty};

/// Uncertainty that weighs totals and lines where neither noise nor a statement gives one, µm/m.
const WEIGHT_UM_PER_M: f64 = 1.0;

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
        // What comes from elsewhere brings the stated contributions with it.
        let stated = match slope {
            SlopeFrom::Increments => self.stated_slope(term),
            SlopeFrom::Elsewhere { .. } => 0.0,
        };
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

    /// Stated contributions to a slope of the increments, µm/m.
    fn stated_slope(&self, term: ErrorTerm) -> f64 {
        // V_k/(4V_j) Σ_d s_dj s_dk ε_d with independent ε_d.
        let edges = self.volume.size[term.along].mm() / self.volume.size[term.of].mm();
        let setups = edges / 2.0 * self.stated.setup_ppm.unwrap_or(0.0);
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
        let all = [laser, temperature, alpha].into_iter().flatten();
        all.filter(|strain| Axis::ALL.into_iter().any(|axis| strain[axis] != 0.0))
            .collect()
    }

    /// Uncertainty of the totals by their length, as formula (7) takes it.
    pub fn totals(&self, passes: usize) -> TotalsUncertainty {
        let metres = self.volume.diagonal_mm() / 1000.0;
        let setups = self.stated.setup_ppm.unwrap_or(0.0);
        TotalsUncertainty {
            own_um_per_m: PerDiagonal::from_fn(|d| {
                let noise = self
                    .end_variance(passes, d)
                    .map(|square| square.sqrt() / metres);
                noise.unwrap_or(WEIGHT_UM_PER_M).hypot(setups)
            }),
            known: self.noise.is_some(),
            common_um_per_m: self.common_um_per_m(),
        }
    }

    /// Variance of the mean total of a diagonal by the noise of its readings, µm².
    fn end_variance(&self, passes: usize, diagonal: Diagonal) -> Option<f64> {
        let sigma = self.noise?.sigma_um;
        let runs = self.runs[diagonal].iter().take(passes);
        let sum: f64 = runs.map(|runs| 2.0 * sigma * sigma / runs).sum();
        #[allow(clippy::cast_precision_loss, reason = "two passes at most")]
        let count = passes as f64;
        Some(sum / (count * count))
    }

    /// u(φ) = R/(4 V_j V_k)·√Σ u²(e_d(end)), µm/m: squareness from the totals as they are, formula (4).
    pub fn u_squareness(&self, passes: usize) -> Option<PerPlane<f64>> {
        let setups = self.volume.diagonal_mm() / 1000.0 * self.stated.setup_ppm.unwrap_or(0.0);
        let ends: Option<Vec<f64>> = Diagonal::ALL
            .into_iter()
            .map(|d| self.end_variance(passes, d))
            .collect();
        let mean = ends?.iter().sum::<f64>() / 4.0;
        Some(u_squareness(self.volume, mean.sqrt().hypot(setups)))
    }

    /// Standard uncertainty of half the difference between two twin slopes of the increments, µm/m.
    /// The sums behind the twins share their readings with opposite signs: u² = 3 times that of one.
    pub fn u_turn(&self, term: ErrorTerm, groups: &[Group]) -> Option<f64> {
        let metres = self.volume.size[term.along].mm() / 1000.0;
        let noise = self.volume.steps_f64() * self.mean_variance(term, groups)?;
        // ε_d of the set-ups: V_k/(4V_j) − V_j/(4V_k), the same signs in both.
        let (along, of) = (
            self.volume.size[term.along].mm(),
            self.volume.size[term.of].mm(),
        );
        let setups = (along / of - of / along) / 2.0 * self.stated.setup_ppm.unwrap_or(0.0);
        Some(((3.0 * noise).sqrt() / metres).hypot(setups) / 2.0)
    }

    /// Variance of a shape between two positions inside the box, mm from its low corner; µm².
    pub fn shape_variance(
        &self,
        term: ErrorTerm,
        groups: &[Group],
        from: f64,
        to: f64,
    ) -> Option<f64> {
        let n = self.volume.steps_f64();
        let steps = (to - from).abs() / self.volume.step_mm(term.along);
        Some((steps - steps * steps / n) * self.mean_variance(term, groups)?)
    }

    /// What counts in the uncertainty and what does not, one sentence each.
    pub fn sentences(&self, angles_given: bool, bow_um_per_urad: &PerAxis<f64>) -> Vec<String> {
        let mut said = Vec::new();
        match self.noise {
            Some(noise) => {
                let freedom = noise.freedom.map_or_else(String::new, |freedom| {
                    format!(", {freedom} degrees of freedom")
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
        said.extend(self.stated_sentences());
        if !angles_given {
            let bow = |axis: Axis| format!("{axis} {:.3}", bow_um_per_urad[axis]);
            said.push(format!(
                "angular errors are not given and not included: each urad of pitch or yaw between the ends of an axis bends the curves by up to (um) {}; the closure does not show it",
                Axis::ALL.map(bow).join(", ")
            ));
        }
        said
    }
    /// What of `[measurement.uncertainty]` counts, and for which axes.
    fn stated_sentences(&self) -> Vec<String> {
        let material = |axis: Axis| self.material.and_then(|material| material.axes[axis]);
        let alpha = |axis: Axis| material(axis).map(|_| ());
        let warm = |axis: Axis| material(axis)?.temperature_c.map(|_| ());
        let mut said = vec![match self.stated.laser_ppm {
            Some(_) => {
                "laser_ppm is included in the scales, as an error that all four set-ups share"
                    .into()
            }
            None => "laser_ppm is not stated and not included".into(),
        }];
        said.push(by_axis(
            "temperature_k",
            self.stated.temperature_k,
            alpha,
            "alpha_per_k",
        ));
        said.push(by_axis(
            "alpha_per_k",
            self.stated.alpha_per_k,
            warm,
            "alpha_per_k and temperature_c, or a column of temperatures",
        ));
        let each = u_squareness(self.volume, self.volume.diagonal_mm() / 1000.0);
        let each = Plane::ALL.map(|plane| format!("{} {:.2}", plane.key(), each.of(plane)));
        let each = each.join(", ");
        said.push(match self.stated.setup_ppm {
            Some(ppm) => format!("setup_ppm ({ppm}) is included: laser, air and scales change so much from one set-up to the next; each ppm makes um/m of squareness: {each}"),
            None => format!("setup_ppm is not stated: changes of laser, air and scale temperature between the four set-ups are not included; each ppm (0.09 K of steel) makes um/m of squareness: {each}"),
        });
        let s = self.stated;
        let any = [s.laser_ppm, s.temperature_k, s.alpha_per_k, s.setup_ppm];
        if any.iter().any(Option::is_some) {
            said.push("simulated intervals hold the noise of the readings and of the linear axes, not these".into());
        }
        said
    }
}

/// Whether a stated contribution that needs the material of an axis is included, by axis.
fn by_axis(
    key: &str,
    stated: Option<f64>,
    known: impl Fn(Axis) -> Option<()>,
    needs: &str,
) -> String {
    if stated.is_none() {
        return format!("{key} is not stated and not included");
    }
    let names = |wanted: bool| {
        let axes = Axis::ALL
            .into_iter()
            .filter(|axis| known(*axis).is_some() == wanted);
        axes.map(|axis| axis.to_string())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let (with, without) = (names(true), names(false));
    let missing = format!("the job gives no {needs} of it ([measurement.step_diagonal.material])");
    match (with.as_str(), without.as_str()) {
        (_, "") => format!("{key} is included in the scales, the same error on all axes"),
        ("", _) => format!(
            "{key} is stated but not included for any axis: {}",
            missing.replace(" of it", "")
        ),
        _ => format!(
            "{key} is included in the scales for {with}, the same error on them, but not for {without}: {missing}"
        ),
    }
}
