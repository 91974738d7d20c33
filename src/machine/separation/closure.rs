//! What is left over: the closure w, its test, and the readings that spoil it (formula 2).
//!
//! Four diagonals give four equations for three unknowns in every interval of every axis, so that
//! one combination w must be zero. A constant on an axis is set-up error or, with a flat mirror,
//! roll; a straight ramp is the roll of an axis that carries others, a doubt only beyond what `angle_urad` states; the rest is noise of the
//! readings or a disturbed reading. w is blind to pitch and yaw and to five of the eight patterns
//! of set-up error: a clean closure proves nothing.
//!
//! A reading takes part in two neighbouring increments, so the w are correlated. With C the
//! covariance of all w for readings of variance 1, and K the patterns that are no noise (the
//! constant of each axis; one for each disturbed reading; the ramps, where they are significant),
//!
//! ```text
//!   Q = min over c of (w − K c)ᵀ C⁻¹ (w − K c)        ~ σ² χ²(ν),  ν = number of w − patterns
//! ```
//! With forward passes only and nothing disturbed ν = 3n − 3. Order of the judgement: disturbed
//! readings are named with the ramps left free, so that a ramp accuses no reading; then the ramps
//! are judged with those readings left out, so that no reading makes a ramp.

use super::curves::{mean, noise_gain};
use super::findings::SeparationFinding as Found;
use super::linear::Model;
use super::noise::{
    FALSE_DOUBT, Noise, NoiseSource, Outlier, UNRESOLVED_UM, chance_of, float, student, tails,
};
use super::patterns::{Patterns, Ramps};
use super::readings::pass_of;
use super::uncertainty::Budget;
use crate::inputs::job::SetUp;
use crate::quantity::{Axis, Diagonal, PerAxis, Squared, Volume};
use crate::text::Finding;

/// More disturbed readings are counted in the doubts; the result lists them.
const NAMED: usize = 3;
/// Largest noise of a laser reading that needs no word, where the job states none (k = 1), µm.
const ASSUMED_NOISE_UM: f64 = 1.0;
/// A stated noise is a round figure: so many times of it count as far above.
const FAR_ABOVE: f64 = 2.0;

/// The closure of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    /// w by axis and machine interval, µm (mean of both directions where there are two).
    pub by_interval: PerAxis<Vec<f64>>,
    /// Its mean over each axis, µm: set-up error or, with a flat mirror, roll.
    pub mean: PerAxis<f64>,
    /// Expected standard deviation of one w of `by_interval` for readings of 1 µm; 2√2 with one run.
    pub scatter: PerAxis<f64>,
    /// Straight ramps of w.
    pub ramps: Option<Ramps>,
    /// Q for readings of 1 µm standard deviation, disturbed readings (and significant ramps) left out.
    pub weighted_square: f64,
    /// ν, degrees of freedom of Q.
    pub freedom: usize,
    /// Disturbed readings: those of single runs first, then those that only the closure shows.
    pub outliers: Vec<Outlier>,
}

/// The scatter of the closure against a noise that is known otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterTest {
    /// Probability of a scatter at least as far off, to either side.
    pub probability: f64,
    /// Whether the scatter is larger than the noise says, not smaller.
    pub larger: bool,
}

impl ScatterTest {
    /// Whether the closure scatters more than the noise explains.
    pub(super) fn is_larger(&self) -> bool {
        self.larger && self.probability < FALSE_DOUBT
    }
}

impl Closure {
    /// The noise of a single reading that the scatter of the closure speaks for; `None` without degrees
    /// of freedom.
    pub fn noise(&self) -> Option<Noise> {
        Noise::of_scatter(self.weighted_square, self.freedom, NoiseSource::Closure)
    }

    /// Its standard deviation, µm.
    pub fn sigma_um(&self) -> Option<f64> {
        self.noise().map(|noise| noise.sigma_um)
    }

    /// Two-sided test against a noise that is known otherwise: χ² where it is stated, F where it
    /// comes from repeated runs. `None` where it comes from this closure, so that nothing is tested.
    pub fn test(&self, noise: &Noise) -> Option<ScatterTest> {
        let is_own = matches!(noise.source, NoiseSource::Closure | NoiseSource::Joined);
        if is_own || noise.sigma_um <= 0.0 {
            return None;
        }
        let ratio = self.weighted_square / noise.sigma_um.squared();
        let (below, above) = tails(ratio, self.freedom, noise.freedom)?;
        Some(ScatterTest { probability: (2.0 * below.min(above)).min(1.0), larger: above < below })
    }

    /// Expected standard deviation of the mean over an axis for a noise, µm.
    pub fn u_mean_um(&self, axis: Axis, sigma_um: f64) -> f64 {
        sigma_um * self.scatter[axis] / float(self.by_interval[axis].len()).sqrt()
    }

    /// What it says against the nine errors.
    pub(super) fn doubts(
        &self,
        noise: Option<Noise>,
        volume: &Volume,
        setup: SetUp,
    ) -> Vec<Finding> {
        // How far a disturbed reading moves the curves: one increment too long, the next too short.
        let gain = Axis::ALL.map(|of| noise_gain(volume, of) / 2.0);
        let gain = gain.into_iter().fold(0.0, f64::max);
        let named = self.outliers.iter().take(NAMED).map(|outlier| {
            let um = gain * outlier.of_mean_um.abs();
            Found::Disturbed { um, which: outlier.words() }
        });
        let more = self.outliers.len().saturating_sub(NAMED);
        let more = (more > 0).then_some(Found::MoreDisturbed { more });
        let roll = self.ramps.as_ref().filter(|ramps| ramps.is_roll());
        let roll = roll.map(|ramps| Found::Roll { changes: ramps.change_um });
        let perfect = noise.filter(|_| setup == SetUp::AssumePerfect);
        let tilted = perfect.and_then(|noise| self.against_perfect(noise));
        named.chain(more).chain(roll).chain(tilted).map(Finding::from).collect()
    }

    /// A closure whose mean is not zero contradicts a perfect set-up.
    fn against_perfect(&self, noise: Noise) -> Option<Found> {
        let limit = student(1.0 - FALSE_DOUBT / 2.0 / 3.0, noise.freedom_f64());
        let is_off = |axis: &Axis| {
            let mean = self.mean[*axis].abs();
            mean > UNRESOLVED_UM && mean > limit * self.u_mean_um(*axis, noise.sigma_um)
        };
        let off: Vec<Axis> = Axis::ALL.into_iter().filter(is_off).collect();
        (!off.is_empty()).then_some(Found::SetUpNotPerfect { means: self.mean, off })
    }
}

/// A scatter that was found and is far above what was to be expected: one-sided, χ² = ν σ²/σ₀² at
/// one in a thousand, with σ₀ = twice the stated `noise_um`, or 1 µm where none is stated. With few
/// steps no reading stands out of such a scatter, however far it is off: it makes the scatter.
pub(super) fn large_noise(noise: Option<Noise>, stated_um: Option<f64>) -> Option<Finding> {
    let is_found = |source| matches!(source, NoiseSource::Repeats | NoiseSource::Closure);
    let found = noise.filter(|noise| is_found(noise.source))?;
    let freedom = found.freedom?;
    let limit_um = stated_um.map_or(ASSUMED_NOISE_UM, |um| FAR_ABOVE * um);
    let square = float(freedom) * (found.sigma_um / limit_um).squared();
    let doubt = match stated_um {
        Some(stated_um) => Found::NoiseFar { noise: found, times: FAR_ABOVE, stated_um },
        None => Found::NoiseLarge { noise: found, assumed_um: ASSUMED_NOISE_UM },
    };
    (chance_of(square, freedom, None)? < FALSE_DOUBT).then(|| doubt.into())
}

/// The closure of mean readings, without the first and last intervals where a missing overrun spoils them; `causes`:
/// what stated angles do to the readings. And its least-squares problem; `None` where that is singular.
pub(super) fn closure(budget: &Budget<'_>, causes: Option<&Model>) -> (Closure, Option<Patterns>) {
    let start = budget.start;
    let (z, counts) = (start.means(), start.counts());
    let w = |axis, at| budget.mean(|group| budget.closure(group, axis, at)).dot(&z);
    let by_interval: PerAxis<Vec<f64>> =
        PerAxis::from_fn(|axis| (0..budget.volume().steps).map(|at| w(axis, at)).collect());
    let mut closure = Closure {
        mean: PerAxis::from_fn(|axis| mean(by_interval[axis].iter().copied())),
        by_interval,
        scatter: PerAxis::from_fn(|axis| scatter(budget, &counts, axis)),
        ramps: None,
        weighted_square: 0.0,
        freedom: 0,
        outliers: start.outliers.clone(),
    };
    let Some(mut patterns) = Patterns::new(budget) else {
        return (closure, None);
    };
    closure.outliers.extend(patterns.name_outliers(start.noise.map(|noise| noise.sigma_um)));
    closure.ramps = patterns.ramps(start.noise, causes);
    if closure.ramps.as_ref().is_some_and(Ramps::is_no_noise) {
        patterns.leave_out_ramps();
    }
    (closure.weighted_square, closure.freedom) = patterns.scatter();
    (closure, Some(patterns))
}

/// Standard deviation of one w, mean of the groups, for readings of 1 µm.
fn scatter(budget: &Budget<'_>, counts: &[f64], axis: Axis) -> f64 {
    let groups = budget.groups();
    let walks =
        groups.iter().flat_map(|group| Diagonal::ALL.map(|d| (d, pass_of(*group, d, axis))));
    let variances = walks.map(|(d, pass)| 2.0 / counts[budget.layout().reading(pass, d, 0)]);
    variances.sum::<f64>().sqrt() / float(groups.len())
}
