//! What `separate` prints of the closure and of disturbed readings.

use super::words::{list, signed};
use crate::machine::separation::Separation;
use crate::machine::separation::closure::{Closure, Ramps};
use crate::machine::separation::noise::{Noise, NoiseSource};
use crate::machine::separation::outlier::{FALSE_DOUBT, Outlier};
use crate::quantity::axis::Axis;

pub(super) fn closure(separation: &Separation) -> String {
    let closure = &separation.closure;
    let mut lines = vec![format!(
        "Closure: mean over each axis (µm) {}",
        means(separation)
    )];
    lines.push(
        "  a constant is set-up error or, with a flat mirror, roll of an axis that carries others"
            .into(),
    );
    if let Some(noise) = separation.noise {
        lines.push(scatter(closure, noise));
    }
    lines.extend(
        closure
            .ramps
            .as_ref()
            .map(|ramps| self::ramps(ramps, separation.noise)),
    );
    lines.push(test(closure, separation.noise));
    lines.push("a clean closure proves nothing about pitch, yaw and five of eight patterns of set-up error".into());
    lines.join("\n")
}

/// Each with its expected standard deviation.
fn means(separation: &Separation) -> String {
    let closure = &separation.closure;
    let mean = |axis: Axis| match separation.noise {
        Some(noise) => format!(
            "{axis} {} (expected scatter {:.3})",
            signed(closure.mean[axis]),
            closure.u_mean_um(axis, noise.sigma_um)
        ),
        None => format!("{axis} {}", signed(closure.mean[axis])),
    };
    Axis::ALL.map(mean).join(", ")
}

fn scatter(closure: &Closure, noise: Noise) -> String {
    let expected =
        Axis::ALL.map(|axis| format!("{axis} {:.3}", closure.scatter[axis] * noise.sigma_um));
    let found = closure.sigma_um().map_or_else(String::new, |sigma| {
        format!(
            "; the closure speaks for {sigma:.3} µm of a single reading ({} degrees of freedom)",
            closure.freedom
        )
    });
    format!(
        "expected standard deviation of a single w (2 sqrt(2) sigma with one run, µm): {}{found}",
        expected.join(", ")
    )
}

fn ramps(ramps: &Ramps, noise: Option<Noise>) -> String {
    let sigma = noise.map_or(0.0, |noise| noise.sigma_um);
    let each = Axis::ALL.map(|axis| {
        format!(
            "{axis} {} (expected scatter {:.3})",
            signed(ramps.change_um[axis]),
            ramps.u[axis] * sigma
        )
    });
    let verdict = if ramps.is_roll() {
        "ROLL of an axis that carries others; the ramps are left out of the scatter"
    } else if ramps.probability < FALSE_DOUBT {
        "smaller than an instrument resolves"
    } else {
        "no roll is seen"
    };
    format!(
        "ramps over each axis, end to end (µm): {}: probability {:.3}, {verdict}",
        each.join(", "),
        ramps.probability
    )
}

fn test(closure: &Closure, noise: Option<Noise>) -> String {
    let Some(noise) = noise else {
        return "no test of the scatter: the readings leave nothing over".into();
    };
    let Some(test) = closure.test(&noise) else {
        return "no chi-squared test: the only noise known is that of this closure; repeat the runs or state `noise_um`".into();
    };
    let verdict = match (test.probability < FALSE_DOUBT, test.larger) {
        (false, _) => "in keeping with that noise",
        (true, true) => {
            "LARGER than that noise explains: the nine errors do not describe the readings (roll, drift, disturbed readings)"
        }
        (true, false) => {
            "SMALLER than that noise: single runs differ by what the closure does not see, or the noise is stated too large"
        }
    };
    let kind = match noise.source {
        NoiseSource::Repeats => "F test",
        NoiseSource::Stated | NoiseSource::Closure => "chi-squared test",
    };
    format!(
        "{kind} of the scatter against {:.3} µm {}, two-sided: probability {:.3}, {verdict}",
        noise.sigma_um,
        noise.source.words(),
        test.probability
    )
}

pub(super) fn outliers(outliers: &[Outlier]) -> String {
    let lines: Vec<String> = outliers.iter().map(Outlier::words).collect();
    list(
        "Disturbed readings (they stay in the result: repeat the run):",
        &lines,
    )
}
