//! Monte Carlo on the readings (GUM Supplement 1): what noise does to figures that are not linear.
//!
//! Ranges and straightness are largest-minus-smallest figures: noise makes them larger. Every
//! trial adds noise to the mean readings, and to linear axes and beams what their uncertainty
//! states, by the rows of the [linear model](nonius_numerics::rows): (7) is not solved again. The mean of the trials less the
//! estimate is the bias; the interval is the estimate mirrored in the trials' quantiles
//! (2·estimate − q). How often such intervals hold the true value was measured, see
//! docs/accuracy.md; nothing is promised.
//!
//! Trial number t draws from stream t of the generator, so that more trials begin with the same ones.

use super::Separation;
use super::curves::{ReferenceLine, mean, range};
use super::joint::between;
use super::readings::float;
use crate::quantity::{Plane, Squared};
use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
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
    fn of(
        (name, unit, measured_coverage): (String, &'static str, f64),
        estimate: f64,
        mut values: Vec<f64>,
    ) -> Figure {
        values.sort_by(f64::total_cmp);
        let mean = mean(values.iter().copied());
        let square: f64 = values.iter().map(|value| (value - mean).squared()).sum();
        let last = float(values.len() - 1);
        let mirrored = |share: f64| 2.0 * estimate - between(&values, share * last);
        Figure {
            name,
            unit,
            estimate,
            bias: mean - estimate,
            interval: [mirrored(0.975), mirrored(0.025)],
            measured_coverage,
            u: (square / last).sqrt(),
        }
    }
}

/// The result of a simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Simulated {
    /// The plan.
    #[serde(flatten)]
    pub plan: Trials,
    /// Figures.
    pub figures: Vec<Figure>,
}

/// A figure of the readings with so much added to each entry of z.
type Simulates<'a> = Box<dyn Fn(&[f64]) -> f64 + 'a>;

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
        let curve = |noise: &[f64]| {
            let moved = found.rows.values(noise, found.rows.line.dot(noise)).into_iter();
            moved.zip(&found.deviation_um).map(|(moved, um)| um + moved).collect::<Vec<f64>>()
        };
        let at: Vec<f64> = (0..=volume.steps).map(|at| volume.along_mm(term.along, at)).collect();
        let straightness = ReferenceLine::LeastSquares;
        let (what, of): (_, Simulates<'_>) = match term.is_positioning() {
            true => ("range", Box::new(move |noise| range(curve(noise).into_iter()))),
            false => (
                "straightness",
                Box::new(move |noise| straightness.straightness_um(&at, &curve(noise))),
            ),
        };
        Some((format!("{what} {term}"), "µm", HELD_OF_EXTREMES, of))
    });
    let planes = Plane::ALL.into_iter().filter_map(|plane| {
        let found = separation.metric.squareness(plane);
        let um_per_m = found.um_per_m.filter(|_| found.u.is_some())?;
        let of: Simulates<'_> = Box::new(move |noise| um_per_m + found.row.dot(noise));
        Some((format!("squareness {}", plane.key()), "µm/m", HELD, of))
    });
    let all: Vec<_> = curves.chain(planes).collect();
    let sigmas = separation.model.drawn();
    let mut noise = vec![0.0; separation.model.layout.entries()];
    let estimates: Vec<f64> = all.iter().map(|(.., of)| of(&noise)).collect();
    let mut trials = vec![Vec::with_capacity(plan.trials); all.len()];
    for trial in 0..plan.trials {
        let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
        random.set_stream(trial as u64);
        for (entry, sigma) in noise.iter_mut().zip(&sigmas) {
            let draw: f64 = StandardNormal.sample(&mut random);
            *entry = sigma * draw;
        }
        trials.iter_mut().zip(&all).for_each(|(trials, (.., of))| trials.push(of(&noise)));
        progress();
    }
    let figures = all.into_iter().zip(estimates).zip(trials);
    let figures = figures.map(|(((name, unit, held, _), estimate), values)| {
        Figure::of((name, unit, held), estimate, values)
    });
    Some(Simulated { plan, figures: figures.collect() })
}
