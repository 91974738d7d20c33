//! Monte Carlo on the readings (GUM Supplement 1): what noise does to figures that are not linear.
//!
//! Ranges and straightness are largest-minus-smallest figures: noise makes them larger. Every
//! trial adds noise to the mean readings, and to linear axes and beams what their uncertainty
//! states, by the rows of the [linear model](super::linear): (7) is not solved again. The mean of the trials less the
//! estimate is the bias; the interval is the estimate mirrored in the trials' quantiles
//! (2·estimate − q). How often such intervals hold the true value was measured, see
//! docs/accuracy.md; nothing is promised.
//!
//! Trial number t draws from stream t of the generator, so that more trials begin with the same ones.

use super::curves::{ReferenceLine, mean, range};
use super::joint::at;
use super::metric::Plane;
use super::noise::float;
use super::plane::Unknown;
use super::separate::Separation;
use crate::quantity::axis::ErrorTerm;
use crate::quantity::units::Squared;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::fmt;

/// How to simulate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trials {
    /// Number of trials, at least 2.
    pub trials: usize,
    /// Seed of the generator.
    pub seed: u64,
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
        let last = float(values.len() - 1);
        let mirrored = |share: f64| 2.0 * estimate - at(&values, share * last);
        Figure {
            quantity,
            estimate,
            bias: mean - estimate,
            interval: [mirrored(0.975), mirrored(0.025)],
            u: (square / last).sqrt(),
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

/// Runs the trials, of the figures whose uncertainty is known: a simulation knows no more of them. `None` where the noise
/// of the readings is not known. `progress` hears of each finished trial.
pub fn simulate(
    separation: &Separation,
    plan: Trials,
    mut progress: impl FnMut(),
) -> Option<Simulated> {
    separation.noise?;
    let volume = &separation.volume;
    let curves = separation.errors.mean.iter().filter_map(|(term, found)| {
        let found = found.as_ref().filter(|of| of.u_um.is_some() || term.is_cross())?;
        let at: Vec<f64> = (0..=volume.steps).map(|at| volume.along_mm(term.along, at)).collect();
        Some((term, found, at))
    });
    let curves: Vec<_> = curves.collect();
    let planes = Plane::ALL.into_iter().filter_map(|plane| {
        separation.u_squareness.of(plane)?;
        Some((plane, separation.squareness_um_per_m.of(plane)?))
    });
    let planes: Vec<_> = planes.collect();
    // With so much added to what was measured.
    let figures = |noise: &[f64]| -> Vec<f64> {
        let of_curves = curves.iter().map(|(term, found, at)| {
            let moved = found.rows.values(noise, found.rows.line.dot(noise));
            let curve = found.deviation_um.iter().zip(moved).map(|(um, moved)| um + moved);
            match term.is_positioning() {
                true => range(curve),
                false => {
                    ReferenceLine::LeastSquares.straightness_um(at, &curve.collect::<Vec<_>>())
                }
            }
        });
        let row = |plane| &separation.figures[Unknown::squareness(plane).0];
        let of_planes = planes.iter().map(|(plane, um_per_m)| um_per_m + row(*plane).dot(noise));
        of_curves.chain(of_planes).collect()
    };
    let sigmas = separation.model.drawn();
    let mut noise = vec![0.0; separation.model.layout.len()];
    let estimates = figures(&noise);
    let mut trials = vec![Vec::with_capacity(plan.trials); estimates.len()];
    for number in 0..plan.trials {
        let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
        random.set_stream(number as u64);
        for (entry, sigma) in noise.iter_mut().zip(&sigmas) {
            let draw: f64 = StandardNormal.sample(&mut random);
            *entry = sigma * draw;
        }
        trials.iter_mut().zip(figures(&noise)).for_each(|(all, value)| all.push(value));
        progress();
    }
    let of_curves = curves.iter().map(|(term, ..)| match term.is_positioning() {
        true => Quantity::Range(*term),
        false => Quantity::Straightness(*term),
    });
    let quantities = of_curves.chain(planes.iter().map(|(plane, _)| Quantity::Squareness(*plane)));
    let found = quantities.zip(estimates).zip(trials);
    let found = found.map(|((quantity, um), trials)| Figure::of(quantity, um, trials));
    Some(Simulated { plan, figures: found.collect() })
}
