//! Monte Carlo on the readings (GUM Supplement 1): what noise does to figures that are not linear.
//!
//! Ranges and straightness are largest-minus-smallest figures: noise makes them larger. Every
//! trial adds noise to the mean readings, and to linear axes and beams what their uncertainty
//! states, and takes the rows of the [linear model](super::linear) of them: (7) is not solved again. The mean of the trials less the
//! estimate is the bias; the interval is the estimate mirrored in the trials' quantiles
//! (2·estimate − q). How often such intervals hold the true value was measured, see
//! docs/accuracy.md; nothing is promised.
//!
//! Trial number t draws from stream t of the generator, so that neither the number of threads
//! nor their order changes a digit.

use super::campaign::Campaign;
use super::curves::{ReferenceLine, mean, range};
use super::linear::CurveRows;
use super::metric::Plane;
use super::noise::float;
use super::plane::Unknown;
use super::readings::Means;
use super::solved::Solved;
use super::uncertainty::Budget;
use crate::quantity::axis::ErrorTerm;
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
    budget.noise?;
    let solved = Solved::new(campaign, budget, means);
    let linear = Linear::new(&solved);
    let sigmas = solved.model.drawn();
    let still = vec![0.0; solved.z.len()];
    let estimates = linear.figures(&still);
    let trial = |number: usize| -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
        random.set_stream(number as u64);
        let mut noise = still.clone();
        for (entry, sigma) in noise.iter_mut().zip(&sigmas) {
            let draw: f64 = StandardNormal.sample(&mut random);
            *entry = sigma * draw;
        }
        linear.figures(&noise).into_iter().map(|(_, value)| value).collect()
    };
    let trials = in_blocks(plan, &trial, progress);
    let figures = estimates.into_iter().enumerate();
    let figures = figures.map(|(index, (quantity, estimate))| {
        let values = trials.iter().map(|figures| figures[index]);
        Figure::of(quantity, estimate, values.collect())
    });
    Some(Simulated { plan, figures: figures.collect() })
}

/// The simulated figures as far as they are determined, by rows over what was measured.
struct Linear<'a> {
    solved: &'a Solved<'a>,
    /// Curves with the line that turns them at the high end, µm, and their positions, mm.
    curves: Vec<(ErrorTerm, CurveRows, f64, Vec<f64>)>,
    squareness: Vec<(Plane, f64)>,
}

impl<'a> Linear<'a> {
    fn new(solved: &'a Solved<'a>) -> Linear<'a> {
        let volume = solved.budget.volume;
        let curve = |term: ErrorTerm| {
            let at = (0..=volume.steps).map(|index| volume.along_mm(term.along, index));
            Some((term, solved.mean_rows(term), solved.turned_um(term)?, at.collect()))
        };
        let squareness = solved.squareness();
        let plane = |plane: Plane| Some((plane, squareness.of(plane)?));
        Linear {
            solved,
            curves: ErrorTerm::ALL.into_iter().filter_map(curve).collect(),
            squareness: Plane::ALL.into_iter().filter_map(plane).collect(),
        }
    }

    /// The figures with so much added to what was measured.
    fn figures(&self, noise: &[f64]) -> Vec<(Quantity, f64)> {
        let noisy: Vec<f64> = self.solved.z.iter().zip(noise).map(|(z, noise)| z + noise).collect();
        let of_curve = |(term, rows, line_um, at): &(ErrorTerm, CurveRows, f64, Vec<f64>)| {
            let curve = rows.values(&noisy, line_um + rows.line.dot(noise));
            match term.is_positioning() {
                true => (Quantity::Range(*term), range(curve.into_iter())),
                false => {
                    let um = ReferenceLine::LeastSquares.straightness_um(at, &curve);
                    (Quantity::Straightness(*term), um)
                }
            }
        };
        let of_plane = |(plane, um_per_m): &(Plane, f64)| {
            let moved = self.solved.figure_row(Unknown::squareness(*plane)).dot(noise);
            (Quantity::Squareness(*plane), um_per_m + moved)
        };
        self.curves.iter().map(of_curve).chain(self.squareness.iter().map(of_plane)).collect()
    }
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
