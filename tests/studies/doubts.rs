//! How often sound readings are doubted, and that what the closure sums up scatters as it says.
use crate::support::diagonals::*;
use crate::support::share;
use nonius::quantity::{Axis, Pass};

#[test]
fn sound_readings_are_rarely_doubted() {
    let trials = share(4000, 20);
    for count in [1, 3] {
        let is_doubted = |seed: &u64| {
            let mut random = seeded(5000 + seed);
            let readings = Machine::random(&box_of(30), &mut random).readings(None);
            let mut noisy =
                |run| runs(run, Pass::Forward, &with_noise(&readings, SIGMA_UM, &mut random));
            let all: Vec<_> = (1..=count).flat_map(&mut noisy).collect();
            // Frame and set-up are right, so only the tests of noise can speak.
            !naive(&box_of(30), &all).doubts.is_empty()
        };
        let doubted = (0..trials).filter(is_doubted).count() as u64;
        assert!(doubted <= trials / 20, "{doubted} of {trials} with {count} run(s)");
    }
}

#[test]
fn means_and_single_w_scatter_as_expected() {
    let volume = box_of(30);
    let perfect = Machine::perfect(&volume).readings(None);
    let mut random = seeded(12);
    let (mut single, mut mean, mut ramp, mut count) = (0.0, 0.0, 0.0, 0.0);
    let mut last = None;
    for _ in 0..share(4000, 50) {
        let readings = with_noise(&perfect, SIGMA_UM, &mut random);
        let found = naive(&volume, &runs(1, Pass::Forward, &readings));
        for axis in Axis::ALL {
            single += found.closure.by_interval[axis][7].powi(2);
            mean += found.closure.mean[axis].powi(2);
            ramp += found.closure.ramps.as_ref().unwrap().change_um[axis].powi(2);
            count += 1.0;
        }
        last = Some(found.closure);
    }
    let closure = last.unwrap();
    let expected = 2.0 * std::f64::consts::SQRT_2;
    assert!((closure.scatter.x - expected).abs() < 1e-12);
    // A tenth where there are 600, three and a half times what a root of mean squares scatters by.
    let tolerance = 0.1 * (600.0_f64 / count).sqrt();
    let near = |sum: f64, wanted: f64, what: &str| {
        let found = (sum / count).sqrt();
        assert!((found / wanted - 1.0).abs() < tolerance, "{what}: {found}, expected {wanted}");
    };
    near(single, expected * SIGMA_UM, "w");
    near(mean, closure.u_mean_um(Axis::X, SIGMA_UM), "mean");
    let u: f64 = closure.ramps.unwrap().u.iter().map(|(_, u)| u * u).sum();
    near(ramp, SIGMA_UM * (u / 3.0).sqrt(), "ramp");
}
