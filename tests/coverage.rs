//! Whether ± 2u holds the true value as often as it says, on simulated machines.
#![allow(
    clippy::print_stdout,
    clippy::needless_range_loop,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test may stop at what it did not expect"
)]

#[path = "support/diagonals.rs"]
mod simulated;

use nonius::axis::{Axis, ErrorTerm, PerAxis, PerTerm};
use nonius::diagonal::{Pass, PathKind, PerDiagonal, Run, Volume};
use nonius::job::{AxisMaterial, Frame, Material, SetUp, StatedUncertainty};
use nonius::separation::line::{ReferenceLine, range};
use nonius::separation::metric::Plane;
use nonius::separation::monte_carlo::{Plan, simulate};
use nonius::separation::noise::{NoiseSource, run_counts};
use nonius::separation::uncertainty::Budget;
use nonius::separation::{Line, Separation, separate};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use simulated::{Machine, Readings, curve, float, normal, runs, solved, volume, with_noise};
use std::collections::BTreeMap;

const SIGMA_UM: f64 = 0.3;
const U_LINE_UM_PER_M: f64 = 0.5;
const MACHINES: u64 = 1600;

/// How often an estimate lay within twice its standard uncertainty.
#[derive(Default)]
struct Tally(BTreeMap<String, (usize, usize)>);

impl Tally {
    fn add(&mut self, what: &str, error: f64, u: f64) {
        let count = self.0.entry(what.to_string()).or_default();
        count.0 += usize::from(error.abs() <= 2.0 * u);
        count.1 += 1;
    }

    fn shares(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0
            .iter()
            .map(|(what, (inside, all))| (what.as_str(), float(*inside) / float(*all)))
    }
}

/// One machine, measured with noise: the truth (X primary) and what the separation makes of it.
fn measured(seed: u64, repeats: u32, axes: &[Axis]) -> (Machine, Separation, Vec<Line>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let box_ = volume([900.0, 720.0, 720.0], 30);
    let truth = Machine::random(&box_, &mut random).x_primary();
    let mut leant = truth.clone();
    leant.lean_randomly(1e-4, &mut random);
    let readings = leant.readings(None);
    let walk = |number: u32, random: &mut ChaCha8Rng| {
        runs(
            number,
            Pass::Forward,
            &with_noise(&readings, SIGMA_UM, random),
        )
    };
    let all: Vec<Run> = (1..=repeats)
        .flat_map(|number| walk(number, &mut random))
        .collect();
    let mut lines = truth.lines(axes, Some(U_LINE_UM_PER_M));
    for line in &mut lines {
        line.slope_um_per_m += U_LINE_UM_PER_M * normal(&mut random);
    }
    let separation = solved(&box_, lines.clone(), &all);
    (truth, separation, lines)
}

fn count(tally: &mut Tally, truth: &Machine, found: &Separation) {
    let last = truth.volume.steps;
    for term in ErrorTerm::ALL {
        let evidence = found.errors.mean[term].as_ref().unwrap();
        let u = evidence.u_um.as_ref().unwrap();
        for index in 1..=last {
            let error = evidence.deviation_um[index] - truth.curves[term][index];
            // A slope that the frame sets to zero leaves nothing uncertain at the end.
            if u[index] > 1e-9 {
                tally.add(&format!("points {term}"), error, u[index]);
            }
            if index == last && u[index] > 1e-9 {
                tally.add(&format!("end {term}"), error, u[index]);
            }
        }
    }
    for axis in Axis::ALL {
        let slope = truth.slope(ErrorTerm {
            of: axis,
            along: axis,
        });
        let error = found.metric.scale[axis].unwrap() - slope;
        tally.add(
            &format!("scale {axis}"),
            error,
            found.metric.u_scale(axis).unwrap(),
        );
    }
    for plane in Plane::ALL {
        let (of, along) = plane.axes();
        let error =
            found.squareness_um_per_m.of(plane).unwrap() - truth.slope(ErrorTerm { of, along });
        tally.add(
            &format!("squareness {}", plane.key()),
            error,
            found.metric.u_squareness(plane).unwrap(),
        );
        let u = found.u_squareness_um_per_m.of(plane).unwrap();
        tally.add(&format!("stated squareness {}", plane.key()), error, u);
    }
}

/// Kolmogorov's distance of values from the uniform distribution on 0 … 1.
fn distance_from_uniform(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = float(values.len());
    let far = |(index, value): (usize, &f64)| {
        (value - float(index) / count)
            .abs()
            .max((float(index + 1) / count - value).abs())
    };
    values.iter().enumerate().map(far).fold(0.0, f64::max)
}

/// ± 2u of a normal distribution holds 95.45 %; 1600 machines scatter by 0.5 % about it.
const LOWEST: f64 = 0.93;
const HIGHEST: f64 = 0.97;

#[test]
fn twice_the_uncertainty_holds_the_true_value_95_times_in_100() {
    for (repeats, source) in [(1, NoiseSource::Closure), (3, NoiseSource::Repeats)] {
        for axes in [&[Axis::X, Axis::Y][..], &Axis::ALL] {
            let mut tally = Tally::default();
            let (mut chances, mut refuted) = (Vec::new(), 0);
            for seed in 0..MACHINES {
                let (truth, found, _) = measured(seed, repeats, axes);
                assert_eq!(found.noise.unwrap().source, source);
                if found.contradiction().is_some() {
                    refuted += 1;
                } else {
                    count(&mut tally, &truth, &found);
                }
                let sigma = SIGMA_UM;
                chances.extend(found.closure.probability(sigma));
            }
            // One in a hundred true machines by chance, where there is a redundancy.
            let share = 100.0 * float(refuted) / float(usize::try_from(MACHINES).unwrap());
            println!("linear axes refuted by chance: {share:.2} %");
            match axes.len() {
                3 => assert!((0.4..=1.8).contains(&share), "{share}"),
                _ => assert_eq!(refuted, 0),
            }
            let distance = distance_from_uniform(chances);
            println!(
                "{repeats} run(s), {} linear axes; p-values {distance:.3} from uniform",
                axes.len()
            );
            for (what, share) in tally.shares() {
                println!("  {what}: {:.1} %", 100.0 * share);
            }
            for (what, share) in tally.shares() {
                assert!((LOWEST..=HIGHEST).contains(&share), "{what}: {share}");
            }
            let pooled: Vec<f64> = tally.shares().map(|(_, share)| share).collect();
            let mean = pooled.iter().sum::<f64>() / float(pooled.len());
            assert!((0.945..=0.965).contains(&mean), "all figures: {mean}");
            // Kolmogorov's 1 % limit.
            assert!(
                distance < 1.63 / float(usize::try_from(MACHINES).unwrap()).sqrt(),
                "{distance}"
            );
        }
    }
}

/// Standard uncertainties of the simulated causes; the scales are 7 K warm.
const STATED: StatedUncertainty = StatedUncertainty {
    noise_um: None,
    laser_ppm: Some(1.0),
    temperature_k: Some(0.3),
    alpha_per_k: Some(0.5e-6),
    setup_ppm: Some(0.7),
};
const ALPHA_PER_K: f64 = 11.5e-6;
const WARM_K: f64 = 7.0;

/// Readings whose length scale is wrong by a strain of its own in every set-up.
fn strained(box_: &Volume, readings: &Readings, strain: &PerDiagonal<f64>) -> Readings {
    PerDiagonal::from_fn(|d| {
        let nominal = |node: usize| 1000.0 * box_.nominal_mm(d, PathKind::Step, node);
        let values = readings[d].iter().enumerate();
        values
            .map(|(node, um)| um + strain[d] * nominal(node))
            .collect()
    })
}

fn with_stated_causes(seed: u64, setup: SetUp, frame: Frame) -> (Machine, Separation) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let box_ = volume([900.0, 720.0, 500.0], 20);
    let truth = Machine::random(&box_, &mut random).x_primary();
    let mut leant = truth.clone();
    if setup == SetUp::Solve {
        leant.lean_randomly(1e-4, &mut random);
    }
    let mut draw = |u: f64| u * normal(&mut random);
    let laser = draw(STATED.laser_ppm.unwrap() * 1e-6);
    let temperature = draw(STATED.temperature_k.unwrap()) * ALPHA_PER_K;
    let alpha = draw(STATED.alpha_per_k.unwrap()) * WARM_K;
    let setups = PerDiagonal::from_fn(|_| draw(STATED.setup_ppm.unwrap() * 1e-6));
    let strain = PerDiagonal::from_fn(|d| laser + temperature + alpha + setups[d]);
    let readings = strained(&box_, &leant.readings(None), &strain);
    let noisy = with_noise(&readings, SIGMA_UM, &mut random);
    let mut lines = truth.lines(&[Axis::X, Axis::Y], Some(U_LINE_UM_PER_M));
    for line in &mut lines {
        line.slope_um_per_m += U_LINE_UM_PER_M * normal(&mut random);
    }
    let mut measurement = simulated::measurement(&box_, setup, frame);
    let axis = AxisMaterial {
        alpha_per_k: ALPHA_PER_K,
        temperature_c: Some(20.0 + WARM_K),
    };
    measurement.material = Some(Material {
        material_corrected: true,
        air_corrected: true,
        axes: PerAxis::from_fn(|_| Some(axis)),
    });
    let mut campaign = simulated::campaign(&measurement, lines);
    campaign.stated = STATED;
    let found = separate(&campaign, &runs(1, Pass::Forward, &noisy));
    (truth, found)
}

#[test]
fn stated_causes_go_through_the_solution() {
    for setup in [SetUp::Solve, SetUp::AssumePerfect] {
        let mut tally = Tally::default();
        for seed in 0..MACHINES {
            let (truth, found) = with_stated_causes(seed, setup, Frame::XPrimary);
            for term in ErrorTerm::ALL {
                let evidence = found.errors.mean[term].as_ref().unwrap();
                let u = evidence.u_um.as_ref().unwrap();
                for index in [10, 20] {
                    let error = evidence.deviation_um[index] - truth.curves[term][index];
                    if u[index] > 1e-9 {
                        tally.add(&format!("{term} {index}"), error, u[index]);
                    }
                }
            }
            for plane in Plane::ALL {
                let (of, along) = plane.axes();
                let error = found.squareness_um_per_m.of(plane).unwrap()
                    - truth.slope(ErrorTerm { of, along });
                let u = found.u_squareness_um_per_m.of(plane).unwrap();
                tally.add(&format!("squareness {}", plane.key()), error, u);
            }
        }
        for (what, share) in tally.shares() {
            println!("{setup:?} {what}: {:.1} %", 100.0 * share);
        }
        for (what, share) in tally.shares() {
            assert!((LOWEST..=HIGHEST).contains(&share), "{what}: {share}");
        }
    }
}

/// As measured, the rotation between twins is noise of the increments: it is covered, too.
#[test]
fn the_noise_of_the_rotation_is_covered_as_measured() {
    let box_ = volume([900.0, 720.0, 500.0], 20);
    let measurement = simulated::measurement(&box_, SetUp::Solve, Frame::AsMeasured);
    let mut tally = Tally::default();
    for seed in 0..MACHINES {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let truth = Machine::random(&box_, &mut random);
        let noisy = with_noise(&truth.readings(None), SIGMA_UM, &mut random);
        let lines = truth.lines(&[Axis::X, Axis::Y], Some(1e-3));
        let campaign = simulated::campaign(&measurement, lines);
        let found = separate(&campaign, &runs(1, Pass::Forward, &noisy));
        for term in ErrorTerm::ALL {
            let evidence = found.errors.mean[term].as_ref().unwrap();
            let (deviation, u) = (
                &evidence.deviation_um[20],
                evidence.u_um.as_ref().unwrap()[20],
            );
            if term.is_cross() {
                tally.add(&term.to_string(), deviation - truth.curves[term][20], u);
            }
        }
    }
    for (what, share) in tally.shares() {
        println!("as measured {what}: {:.1} %", 100.0 * share);
        assert!((LOWEST..=HIGHEST).contains(&share), "{what}: {share}");
    }
}

/// Ranges of the positioning errors and straightness about the least squares line.
fn figures(machine: &Machine, curves: &PerTerm<Vec<f64>>) -> Vec<f64> {
    let value = |term: ErrorTerm| {
        let curve = &curves[term];
        if term.is_positioning() {
            return range(curve.iter().copied());
        }
        let positions: Vec<f64> = (0..curve.len())
            .map(|i| machine.volume.along_mm(term.along, i))
            .collect();
        ReferenceLine::LeastSquares.straightness_um(&positions, curve)
    };
    ErrorTerm::ALL.map(value).into()
}

/// Measured and printed, not promised: see docs/accuracy.md.
#[test]
fn intervals_of_ranges_are_measured() {
    let axes = [Axis::X, Axis::Y, Axis::Z];
    let (mut inside, mut bias, mut told, mut all) = ([0; 2], [0.0; 2], [0.0; 2], [0; 2]);
    for seed in 0..100 {
        let (truth, found, lines) = measured(10_000 + seed, 1, &axes);
        let measurement = simulated::measurement(
            &truth.volume,
            nonius::job::SetUp::Solve,
            nonius::job::Frame::XPrimary,
        );
        let campaign = simulated::campaign(&measurement, lines);
        let counts = run_counts(&found.runs);
        let budget = Budget {
            volume: &truth.volume,
            noise: found.noise,
            runs: &counts,
            stated: campaign.stated,
            material: None,
        };
        let plan = Plan {
            trials: 400,
            seed: 7,
            threads: 1,
        };
        let simulated = simulate(&campaign, &budget, &found.means, plan, &|_| {}).unwrap();
        let estimates = PerTerm::from_fn(|term| curve(&found, term).to_vec());
        let (wanted, found) = (figures(&truth, &truth.curves), figures(&truth, &estimates));
        for (index, term) in ErrorTerm::ALL.into_iter().enumerate() {
            let kind = usize::from(!term.is_positioning());
            let figure = &simulated.figures[index];
            let [low, high] = figure.interval;
            inside[kind] += usize::from((low..=high).contains(&wanted[index]));
            bias[kind] += found[index] - wanted[index];
            told[kind] += figure.bias;
            all[kind] += 1;
        }
    }
    for (kind, name) in ["range", "straightness"].into_iter().enumerate() {
        let count = float(all[kind]);
        println!(
            "{name}: interval holds the truth {:.1} %, estimate too large by {:.3} um, bias told {:.3} um",
            100.0 * float(inside[kind]) / count,
            bias[kind] / count,
            told[kind] / count
        );
    }
}
