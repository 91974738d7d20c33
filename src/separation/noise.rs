//! Means over runs, their repeatability, and what a noise of the readings is.

use super::increments::{Means, PassMeans};
use crate::diagonal::{Diagonal, Pass, PerDiagonal};

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
/// µm; `None` with fewer than two runs.
pub fn repeatability_um(runs: &[CorrectedRun], diagonal: Diagonal, pass: Pass) -> Option<f64> {
    let runs: Vec<&CorrectedRun> = of(runs, diagonal, pass).collect();
    let nodes = runs.first().map_or(0, |run| run.readings_um.len());
    let deviation = |node: usize| {
        let at = || runs.iter().map(|run| run.readings_um[node]);
        let middle = mean(at());
        let square: f64 = at().map(|reading| (reading - middle).powi(2)).sum();
        #[allow(clippy::cast_precision_loss, reason = "a handful of runs")]
        let freedom = (runs.len() - 1) as f64;
        (square / freedom).sqrt()
    };
    (runs.len() > 1).then(|| 4.0 * (0..nodes).map(deviation).fold(0.0, f64::max))
}
