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
use super::noise::float;
use super::separate::Separation;
use crate::quantity::{ErrorTerm, Plane, Squared};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

/// How to simulate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Trials {
    /// Number of trials, at least 2.
    pub trials: usize,
    /// Seed of the generator.
    pub seed: u64,
}

/// How often 95 % intervals held the true value on simulated machines, 0 … 1 (docs/accuracy.md §8): of squareness, and of
/// largest-minus-smallest figures, which are too short: the noise of the readings has moved the extremes already, and the
/// trials move them again.
const HELD: f64 = 0.95;
const HELD_OF_EXTREMES: f64 = 0.887;

/// A figure with what noise does to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// Of what: max − min of a positioning error, straightness of a cross term, squareness.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// From the readings as they are.
    pub estimate: f64,
    /// Mean of the trials less the estimate.
    pub bias: f64,
    /// 95 % interval.
    #[serde(rename = "interval_95")]
    pub interval: [f64; 2],
    /// How often such intervals held the true value on simulated machines.
    #[serde(rename = "interval_coverage_measured")]
    pub measured_coverage: f64,
    /// Standard deviation of the trials.
    pub u: f64,
}

impl Figure {
    fn of(name: String, estimate: f64, mut values: Vec<f64>) -> Figure {
        values.sort_by(f64::total_cmp);
        let mean = mean(values.iter().copied());
        let square: f64 = values.iter().map(|value| (value - mean).squared()).sum();
        let last = float(values.len() - 1);
        let mirrored = |share: f64| 2.0 * estimate - at(&values, share * last);
        Figure {
            name,
            unit: "µm",
            estimate,
            bias: mean - estimate,
            interval: [mirrored(0.975), mirrored(0.025)],
            measured_coverage: HELD_OF_EXTREMES,
            u: (square / last).sqrt(),
        }
    }
}

/// Trials that are computed side by side, in half the time: the sums of one need not wait for those of another.
const TOGETHER: usize = 8;

/// The result of a simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Simulated {
    /// The plan.
    #[serde(flatten)]
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
        let found = found.as_ref().filter(|of| of.u.is_some() || term.is_cross())?;
        let at: Vec<f64> = (0..=volume.steps).map(|at| volume.along_mm(term.along, at)).collect();
        Some((term, found, at))
    });
    let curves: Vec<_> = curves.collect();
    let planes = Plane::ALL.into_iter().filter_map(|plane| {
        let found = separation.metric.squareness(plane);
        Some((plane, found.um_per_m.filter(|_| found.u.is_some())?))
    });
    let planes: Vec<_> = planes.collect();
    // With so much added to what was measured.
    let figures = |noise: &[[f64; TOGETHER]]| -> Vec<[f64; TOGETHER]> {
        let of_curves = curves.iter().map(|(term, found, at)| {
            let moved = found.rows.values_of(noise, found.rows.line.dots(noise));
            std::array::from_fn(|trial| {
                let curve = found.deviation_um.iter().zip(&moved);
                let curve = curve.map(|(um, moved)| um + moved[trial]);
                match term.is_positioning() {
                    true => range(curve),
                    false => {
                        ReferenceLine::LeastSquares.straightness_um(at, &curve.collect::<Vec<_>>())
                    }
                }
            })
        });
        let row = |plane| &separation.metric.squareness(plane).row;
        let of_planes = planes
            .iter()
            .map(|(plane, um_per_m)| row(*plane).dots(noise).map(|moved| um_per_m + moved));
        of_curves.chain(of_planes).collect()
    };
    let sigmas = separation.model.drawn();
    let mut noise = vec![[0.0; TOGETHER]; separation.model.layout.len()];
    let estimates = figures(&noise);
    let mut trials = vec![Vec::with_capacity(plan.trials); estimates.len()];
    for first in (0..plan.trials).step_by(TOGETHER) {
        let together = TOGETHER.min(plan.trials - first);
        for trial in 0..together {
            let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
            random.set_stream((first + trial) as u64);
            for (entry, sigma) in noise.iter_mut().zip(&sigmas) {
                let draw: f64 = StandardNormal.sample(&mut random);
                entry[trial] = sigma * draw;
            }
        }
        let found = trials.iter_mut().zip(figures(&noise));
        found.for_each(|(all, values)| all.extend(&values[..together]));
        (0..together).for_each(|_| progress());
    }
    let mut found = estimates.into_iter().map(|[um, ..]| um).zip(trials);
    let of_curve = |((term, ..), (um, trials)): (&(ErrorTerm, _, _), _)| {
        let what = if term.is_positioning() { "range" } else { "straightness" };
        Figure::of(format!("{what} {term}"), um, trials)
    };
    let mut figures: Vec<Figure> = curves.iter().zip(&mut found).map(of_curve).collect();
    figures.extend(planes.iter().zip(found).map(|((plane, _), (um_per_m, trials))| Figure {
        unit: "µm/m",
        measured_coverage: HELD,
        ..Figure::of(format!("squareness {}", plane.key()), um_per_m, trials)
    }));
    Some(Simulated { plan, figures })
}
