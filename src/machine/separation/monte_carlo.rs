//! Monte Carlo on the readings (GUM Supplement 1): what noise does to figures that are not linear.
//!
//! Ranges and straightness are largest-minus-smallest figures: noise makes them larger. Every
//! trial adds noise to the mean readings, and to linear axes and beams what their uncertainty
//! states, and separates again. The mean of the trials less the
//! estimate is the bias; the interval is the estimate mirrored in the trials' quantiles
//! (2·estimate − q). How often such intervals hold the true value was measured, see
//! docs/accuracy.md; nothing is promised.
//!
//! Trial number t draws from stream t of the generator, so that neither the number of threads
//! nor their order changes a digit.

use super::campaign::Campaign;
use super::evidence::NineErrors;
use super::increments::{Means, PassMeans};
use super::line::{ReferenceLine, range};
use super::linear_reversal::LinearReversals;
use super::metric::{PerPlane, Plane};
use super::separate::curves_of;
use super::uncertainty::Budget;
use crate::quantity::diagonal::{Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Trials that are added up together: the same blocks whatever the number of threads.
const BLOCK: usize = 64;

/// How to simulate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Number of trials, at least 2.
    pub trials: usize,
    /// Seed of the generator.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

/// A figure with what noise does to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name, e.g. `range EXX`.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// From the readings as they are.
    pub estimate: f64,
    /// Mean of the trials less the estimate.
    pub bias: f64,
    /// 95 % interval.
    pub interval: [f64; 2],
    /// Standard deviation of the trials.
    pub u: f64,
}

/// How often the 95 % interval of a figure held the true value on simulated machines, 0 … 1
/// (docs/accuracy.md §8). The intervals of largest-minus-smallest figures are too short: the noise
/// of the readings has moved the extremes already, and the trials move them again.
pub fn measured_coverage(figure: &Figure) -> f64 {
    match figure.unit {
        "µm/m" => 0.95,
        _ => 0.887,
    }
}

/// The result of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// The plan.
    pub plan: Plan,
    /// Figures.
    pub figures: Vec<Figure>,
}

/// Figures of a block of trials, one list for each.
type Block = Vec<Vec<f64>>;

/// Runs the trials on mean readings as measured. `budget.noise` must be known, else `None`. `progress` hears of finished trials.
pub fn simulate(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
    plan: Plan,
    progress: &(dyn Fn(usize) + Sync),
) -> Option<Simulated> {
    let sigma_um = budget.noise?.sigma_um;
    let estimate = curves_of(campaign, budget, means);
    let names = names(budget.volume, &estimate.0, &estimate.1);
    let trial = |number: usize| {
        let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
        random.set_stream(number as u64);
        let noisy = with_noise(means, budget.runs, sigma_um, &mut random);
        curves_of(&with_other_lines(campaign, &mut random), budget, &noisy)
    };
    let blocks = plan.trials.div_ceil(BLOCK);
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= blocks {
                return done;
            }
            let numbers = index * BLOCK..((index + 1) * BLOCK).min(plan.trials);
            let count = numbers.len();
            done.push((index, block(budget.volume, numbers, trial)));
            progress(count);
        }
    };
    let mut done: Vec<(usize, Block)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (1..plan.threads.max(1))
            .map(|_| scope.spawn(work))
            .collect();
        let mut done = work();
        for thread in threads {
            done.extend(thread.join().unwrap_or_default());
        }
        done
    });
    done.sort_by_key(|(index, _)| *index);
    Some(summary(plan, names, &done))
}

fn block(
    volume: &Volume,
    numbers: std::ops::Range<usize>,
    trial: impl Fn(usize) -> (NineErrors, PerPlane<Option<f64>>),
) -> Block {
    let figures = |number: usize| {
        let (errors, squareness) = trial(number);
        let figures = names(volume, &errors, &squareness);
        figures.into_iter().map(|(_, _, value)| value).collect()
    };
    numbers.map(figures).collect()
}

/// The figures of nine curves: name, unit, value.
fn names(
    volume: &Volume,
    errors: &NineErrors,
    squareness: &PerPlane<Option<f64>>,
) -> Vec<(String, &'static str, f64)> {
    let mut figures = Vec::new();
    for (term, evidence) in errors.mean.iter() {
        let Some(evidence) = evidence else { continue };
        let curve = &evidence.deviation_um;
        if term.is_positioning() {
            let value = range(curve.iter().copied());
            figures.push((format!("range {term}"), "µm", value));
        } else {
            let positions: Vec<f64> = (0..=volume.steps)
                .map(|index| volume.along_mm(term.along, index))
                .collect();
            let value = ReferenceLine::LeastSquares.straightness_um(&positions, curve);
            figures.push((format!("straightness {term}"), "µm", value));
        }
    }
    for plane in Plane::ALL {
        if let Some(value) = squareness.of(plane) {
            figures.push((format!("squareness {}", plane.key()), "µm/m", value));
        }
    }
    figures
}

fn with_noise(
    means: &Means,
    runs: &PerDiagonal<[f64; 2]>,
    sigma_um: f64,
    random: &mut ChaCha8Rng,
) -> Means {
    let mut pass = |pass: Pass, readings: &PassMeans| {
        PerDiagonal::from_fn(|diagonal| {
            let runs = runs[diagonal][usize::from(pass == Pass::Reverse)];
            let sigma = sigma_um / runs.sqrt();
            let noisy = |reading: &f64| {
                let draw: f64 = StandardNormal.sample(random);
                reading + sigma * draw
            };
            readings[diagonal].iter().map(noisy).collect()
        })
    };
    let forward = pass(Pass::Forward, &means.forward);
    let reverse = means.reverse.as_ref().map(|r| pass(Pass::Reverse, r));
    Means { forward, reverse }
}

/// Linear axes and beams within their stated uncertainties. The readings are corrected already.
fn with_other_lines<'a>(campaign: &Campaign<'a>, random: &mut ChaCha8Rng) -> Campaign<'a> {
    let mut lines = campaign.lines.clone();
    for line in &mut lines {
        let draw: f64 = StandardNormal.sample(random);
        line.slope_um_per_m += line.u_um_per_m.unwrap_or(0.0) * draw;
    }
    Campaign {
        measurement: campaign.measurement,
        stated: campaign.stated,
        lines,
        reversals: LinearReversals::default(),
        angles: None,
        reverse_zero_known: campaign.reverse_zero_known,
    }
}

fn summary(
    plan: Plan,
    names: Vec<(String, &'static str, f64)>,
    done: &[(usize, Block)],
) -> Simulated {
    #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 trials")]
    let count = plan.trials as f64;
    let figures = names
        .into_iter()
        .enumerate()
        .map(|(index, (name, unit, estimate))| {
            let all = done.iter().flat_map(|(_, block)| block);
            let mut values: Vec<f64> = all.map(|figures| figures[index]).collect();
            values.sort_by(f64::total_cmp);
            let mean = values.iter().sum::<f64>() / count;
            let square: f64 = values.iter().map(|value| (value - mean).squared()).sum();
            Figure {
                name,
                unit,
                estimate,
                bias: mean - estimate,
                interval: [
                    2.0 * estimate - quantile(&values, 0.975),
                    2.0 * estimate - quantile(&values, 0.025),
                ],
                u: (square / (count - 1.0)).sqrt(),
            }
        })
        .collect();
    Simulated { plan, figures }
}

/// Quantile of sorted values by straight lines between them.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place in a list"
    )]
    let (place, below) = {
        let place = share * sorted.len().saturating_sub(1) as f64;
        (place, place.floor() as usize)
    };
    let low = sorted.get(below).copied().unwrap_or(0.0);
    let high = sorted.get(below + 1).copied().unwrap_or(low);
    low + (high - low) * place.fract()
}
