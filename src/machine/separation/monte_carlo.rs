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
use super::curves::{Curve, ReferenceLine, mean, range};
use super::linear_reversal::LinearReversals;
use super::metric::{PerPlane, Plane};
use super::noise::float;
use super::readings::{Means, PassMeans, RunCounts};
use super::separate::curves_of;
use super::uncertainty::Budget;
use crate::quantity::axis::{ErrorTerm, PerTerm};
use crate::quantity::diagonal::{Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Trials that are added up together: the same blocks whatever the number of threads.
const BLOCK: usize = 64;

/// How to simulate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trials {
    /// Number of trials, at least 2.
    pub trials: usize,
    /// Seed of the generator.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

/// What is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Max − min of a positioning error, µm.
    Range(ErrorTerm),
    /// Straightness of a cross term, µm.
    Straightness(ErrorTerm),
    /// Squareness, µm/m.
    Squareness(Plane),
}

impl Quantity {
    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Range(_) | Quantity::Straightness(_) => "µm",
            Quantity::Squareness(_) => "µm/m",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::Range(term) => write!(out, "range {term}"),
            Quantity::Straightness(term) => write!(out, "straightness {term}"),
            Quantity::Squareness(plane) => write!(out, "squareness {}", plane.key()),
        }
    }
}

/// A figure with what noise does to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Of what.
    pub quantity: Quantity,
    /// From the readings as they are.
    pub estimate: f64,
    /// Mean of the trials less the estimate.
    pub bias: f64,
    /// 95 % interval.
    pub interval: [f64; 2],
    /// Standard deviation of the trials.
    pub u: f64,
}

impl Figure {
    fn of(quantity: Quantity, estimate: f64, mut values: Vec<f64>) -> Figure {
        values.sort_by(f64::total_cmp);
        let mean = mean(values.iter().copied());
        let square: f64 = values.iter().map(|value| (value - mean).squared()).sum();
        let mirrored = |share| 2.0 * estimate - quantile(&values, share);
        Figure {
            quantity,
            estimate,
            bias: mean - estimate,
            interval: [mirrored(0.975), mirrored(0.025)],
            u: (square / (float(values.len()) - 1.0)).sqrt(),
        }
    }

    /// How often such 95 % intervals held the true value on simulated machines, 0 … 1
    /// (docs/accuracy.md §8). Those of largest-minus-smallest figures are too short: the noise of the
    /// readings has moved the extremes already, and the trials move them again.
    pub fn measured_coverage(&self) -> f64 {
        match self.quantity {
            Quantity::Squareness(_) => 0.95,
            Quantity::Range(_) | Quantity::Straightness(_) => 0.887,
        }
    }
}

/// The result of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// The plan.
    pub plan: Trials,
    /// Figures.
    pub figures: Vec<Figure>,
}

/// Runs the trials on mean readings as measured. `budget.noise` must be known, else `None`. `progress` hears of finished trials.
pub fn simulate(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
    plan: Trials,
    progress: &(dyn Fn(usize) + Sync),
) -> Option<Simulated> {
    let sigma_um = budget.noise?.sigma_um;
    let (curves, squareness) = curves_of(campaign, budget, means);
    let estimates = figures(budget.volume, &curves, &squareness);
    let trial = |number: usize| -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
        random.set_stream(number as u64);
        let noisy = with_noise(means, budget.runs, sigma_um, &mut random);
        let campaign = with_other_lines(campaign, &mut random);
        let (curves, squareness) = curves_of(&campaign, budget, &noisy);
        let figures = figures(budget.volume, &curves, &squareness).into_iter();
        figures.map(|(_, value)| value).collect()
    };
    let trials = in_blocks(plan, &trial, progress);
    let figures = estimates.into_iter().enumerate();
    let figures = figures.map(|(index, (quantity, estimate))| {
        let values = trials.iter().map(|figures| figures[index]);
        Figure::of(quantity, estimate, values.collect())
    });
    Some(Simulated { plan, figures: figures.collect() })
}

/// What each trial gives, in their order, however many threads work.
fn in_blocks(
    plan: Trials,
    trial: &(dyn Fn(usize) -> Vec<f64> + Sync),
    progress: &(dyn Fn(usize) + Sync),
) -> Vec<Vec<f64>> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let numbers = index * BLOCK..((index + 1) * BLOCK).min(plan.trials);
            let count = numbers.len();
            if count == 0 {
                return done;
            }
            done.push((index, numbers.map(trial).collect()));
            progress(count);
        }
    };
    let mut done: Vec<(usize, Vec<Vec<f64>>)> = std::thread::scope(|scope| {
        let threads = (1..plan.threads.max(1)).map(|_| scope.spawn(work));
        let threads: Vec<_> = threads.collect();
        let mut done = work();
        for thread in threads {
            done.extend(thread.join().unwrap_or_default());
        }
        done
    });
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().flat_map(|(_, block)| block).collect()
}

/// The figures of nine curves.
fn figures(
    volume: &Volume,
    curves: &PerTerm<Option<Curve>>,
    squareness: &PerPlane<Option<f64>>,
) -> Vec<(Quantity, f64)> {
    let of_curve = |(term, curve): (ErrorTerm, &Option<Curve>)| {
        let curve = curve.as_ref()?;
        if term.is_positioning() {
            return Some((Quantity::Range(term), range(curve.iter().copied())));
        }
        let positions = (0..=volume.steps).map(|index| volume.along_mm(term.along, index));
        let positions: Vec<f64> = positions.collect();
        let value = ReferenceLine::LeastSquares.straightness_um(&positions, curve);
        Some((Quantity::Straightness(term), value))
    };
    let planes = Plane::ALL.into_iter();
    let planes = planes.filter_map(|p| Some((Quantity::Squareness(p), squareness.of(p)?)));
    curves.iter().filter_map(of_curve).chain(planes).collect()
}

fn with_noise(means: &Means, runs: &RunCounts, sigma_um: f64, random: &mut ChaCha8Rng) -> Means {
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
        ..*campaign
    }
}

/// Quantile of sorted values by straight lines between them.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    #[allow(clippy::cast_possible_truncation, reason = "a place in a list")]
    let (place, below) = {
        let place = share * sorted.len().saturating_sub(1) as f64;
        (place, place.floor() as usize)
    };
    let low = sorted.get(below).copied().unwrap_or(0.0);
    let high = sorted.get(below + 1).copied().unwrap_or(low);
    low + (high - low) * place.fract()
}
