//! Means over runs, their repeatability, and what a noise of the readings is.

use super::increments::{Means, PassMeans};
use crate::inputs::job::StatedUncertainty;
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal};
use crate::quantity::units::Squared;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

/// Share of a normal distribution within two standard deviations: what U stands for.
const COVERAGE: f64 = 0.954_499_736_103_642;
/// From here on Student's distribution is the normal one in every digit that is printed.
const MANY: f64 = 1e6;

/// One corrected run, µm, by node.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrectedRun {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Number of the run, as in the file.
    pub number: u32,
    /// Forward or reverse.
    pub pass: Pass,
    /// Reading errors, µm.
    pub readings_um: Vec<f64>,
}

/// Where the standard deviation of a reading comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseSource {
    /// Scatter of repeated runs.
    Repeats,
    /// Scatter of the closure.
    Closure,
    /// Stated in the job (`noise_um`).
    Stated,
}

impl NoiseSource {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            NoiseSource::Repeats => "from the scatter of repeated runs",
            NoiseSource::Closure => "from the scatter of the closure",
            NoiseSource::Stated => "as stated in the job (noise_um)",
        }
    }
}

/// Standard deviation of a single reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// σ, µm.
    pub sigma_um: f64,
    /// Degrees of freedom; `None` where it is stated.
    pub freedom: Option<usize>,
    /// Where it comes from.
    pub source: NoiseSource,
}

impl Noise {
    /// Degrees of freedom as a number; `None` = as good as known.
    pub fn freedom_f64(self) -> Option<f64> {
        #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 readings")]
        self.freedom.map(|freedom| freedom as f64)
    }
}

/// k with which U = k·u holds the true value in 95.45 % of all cases: 2 for a known standard
/// deviation, more by Student where it was estimated from few (GUM, annex G).
pub fn coverage_factor(freedom: Option<f64>) -> f64 {
    match freedom {
        Some(freedom) if freedom < MANY => coverage_factor_for(0.5 + COVERAGE / 2.0, Some(freedom)),
        _ => 2.0,
    }
}

/// Quantile of Student's distribution; of the normal one where the freedom is not limited.
pub(super) fn coverage_factor_for(share: f64, freedom: Option<f64>) -> f64 {
    let freedom = freedom.unwrap_or(MANY).clamp(1.0, MANY);
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |spread| spread.inverse_cdf(share))
}

/// Effective degrees of freedom of u, of which `u_noise` comes from the noise of the readings and
/// the rest is known (Welch and Satterthwaite, GUM G.4.1); `None` = unlimited.
pub(crate) fn effective_freedom(u: f64, u_noise: f64, noise: Noise) -> Option<f64> {
    let share = if u > 0.0 { u_noise / u } else { 0.0 };
    noise
        .freedom_f64()
        .map(|freedom| freedom / share.squared().squared())
        .filter(|freedom| *freedom < MANY)
}

/// Probability of a sum of `count` squares of normal deviates by their variance at least as large
/// as `square`; F where the variance is an estimate. `None` where `count` is 0.
pub(super) fn chance_of(square: f64, count: usize, freedom: Option<usize>) -> Option<f64> {
    #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 readings")]
    let (many, freedom) = (count as f64, freedom.map(|freedom| freedom as f64));
    match freedom {
        Some(freedom) => Some(FisherSnedecor::new(many, freedom).ok()?.sf(square / many)),
        None => Some(ChiSquared::new(many).ok()?.sf(square)),
    }
}

/// Mean of the runs of each pass. The reverse pass counts only if every diagonal has it.
pub fn means(runs: &[CorrectedRun]) -> Means {
    let walked_back = Diagonal::ALL
        .into_iter()
        .all(|diagonal| of(runs, diagonal, Pass::Reverse).next().is_some());
    Means {
        forward: pass_means(runs, Pass::Forward),
        reverse: walked_back.then(|| pass_means(runs, Pass::Reverse)),
    }
}

/// How many runs each pass along each diagonal has: forward, reverse.
pub fn run_counts(runs: &[CorrectedRun]) -> PerDiagonal<[f64; 2]> {
    PerDiagonal::from_fn(|diagonal| {
        Pass::BOTH.map(|pass| of(runs, diagonal, pass).map(|_| 1.0).sum())
    })
}

fn of(
    runs: &[CorrectedRun],
    diagonal: Diagonal,
    pass: Pass,
) -> impl Iterator<Item = &CorrectedRun> {
    runs.iter()
        .filter(move |run| run.diagonal == diagonal && run.pass == pass)
}

fn pass_means(runs: &[CorrectedRun], pass: Pass) -> PassMeans {
    PerDiagonal::from_fn(|diagonal| {
        let (mut sum, mut count): (Vec<f64>, f64) = (Vec::new(), 0.0);
        for run in of(runs, diagonal, pass) {
            sum.resize(run.readings_um.len(), 0.0);
            for (sum, reading) in sum.iter_mut().zip(&run.readings_um) {
                *sum += reading;
            }
            count += 1.0;
        }
        sum.iter().map(|sum| sum / count).collect()
    })
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Repeatability of a pass along a diagonal as in ISO 230-2: R = 4 s, the largest over its nodes,
/// µm; `None` with fewer than two runs. Each run counts from its own zero, as it was read.
pub(crate) fn repeatability_um(
    runs: &[CorrectedRun],
    diagonal: Diagonal,
    pass: Pass,
) -> Option<f64> {
    let runs: Vec<&CorrectedRun> = of(runs, diagonal, pass).collect();
    let nodes = runs.first().map_or(0, |run| run.readings_um.len());
    let deviation = |node: usize| {
        let at = || runs.iter().map(|run| run.readings_um[node]);
        let middle = mean(at());
        let square: f64 = at().map(|reading| (reading - middle).squared()).sum();
        #[allow(clippy::cast_precision_loss, reason = "a handful of runs")]
        let freedom = (runs.len() - 1) as f64;
        (square / freedom).sqrt()
    };
    (runs.len() > 1).then(|| 4.0 * (0..nodes).map(deviation).fold(0.0, f64::max))
}

/// Repeats say most; a stated noise comes next; a single run is left with its closure.
pub(super) fn known_noise(stated: &StatedUncertainty, repeats: Option<Noise>) -> Option<Noise> {
    let stated = stated.noise_um.map(|sigma_um| Noise {
        sigma_um,
        freedom: None,
        source: NoiseSource::Stated,
    });
    repeats.or(stated)
}
