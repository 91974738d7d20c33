//! Why a result is doubtful, in words: what the readings themselves say against it.

use crate::machine::separation::linear_reversal::SMALLEST_REVERSAL_UM;

use super::closure::Closure;
use super::curves::noise_gain;
use super::increments::Means;
use super::linear_reversal::{LinearReversals, along_diagonal_um, u_along_diagonal_um};
use super::noise::{Noise, NoiseSource, chance_of};
use super::outlier::{FALSE_DOUBT, Outlier, float};
use crate::inputs::job::SetUp;
use crate::quantity::axis::Axis;
use crate::quantity::diagonal::{Diagonal, Volume};
use crate::quantity::units::{Figure, Squared};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// More disturbed readings are counted here; the result lists them.
const NAMED: usize = 3;
/// A mean closure that no instrument resolves contradicts nothing, µm.
const SMALLEST_MEAN_UM: f64 = 0.02;
/// Largest noise of a laser reading that needs no word, where the job states none (k = 1), µm.
const ASSUMED_NOISE_UM: f64 = 1.0;
/// A stated noise is a round figure: so many times of it count as far above.
const FAR_ABOVE: f64 = 2.0;

/// What the closure says against the nine errors.
pub(crate) fn of_closure(
    closure: &Closure,
    noise: Option<Noise>,
    volume: &Volume,
    setup: SetUp,
) -> Vec<String> {
    let mut doubts: Vec<String> = closure
        .outliers
        .iter()
        .take(NAMED)
        .map(|o| disturbed(o, volume))
        .collect();
    if closure.outliers.len() > NAMED {
        let more = closure.outliers.len() - NAMED;
        doubts.push(format!("{more} more disturbed readings stay in the result"));
    }
    doubts.extend(roll(closure));
    let test = noise.and_then(|noise| closure.test(&noise));
    if let Some(test) = test.filter(|test| test.larger && test.probability < FALSE_DOUBT) {
        doubts.push(format!(
            "the closure scatters more than the noise explains (probability {:.4}): the nine errors do not describe these readings",
            test.probability
        ));
    }
    if setup == SetUp::AssumePerfect {
        doubts.extend(noise.and_then(|noise| set_up(closure, noise)));
    }
    doubts
}

/// A scatter that was found and is far above what was to be expected: one-sided, χ² = ν σ²/σ₀² at
/// one in a thousand, with σ₀ = twice the stated `noise_um`, or 1 µm where none is stated. With few
/// steps no reading stands out of such a scatter, however far it is off: it makes the scatter.
pub(crate) fn of_noise(noise: Option<Noise>, stated_um: Option<f64>) -> Option<String> {
    let found = noise.filter(|noise| noise.source != NoiseSource::Stated)?;
    let freedom = found.freedom?;
    let limit_um = stated_um.map_or(ASSUMED_NOISE_UM, |um| FAR_ABOVE * um);
    let square = float(freedom) * (found.sigma_um / limit_um).squared();
    if chance_of(square, freedom, None)? >= FALSE_DOUBT {
        return None;
    }
    let (expected, remedy) = match stated_um {
        Some(um) => (
            format!("more than {FAR_ABOVE} times the {um} µm that `noise_um` states"),
            "correct",
        ),
        None => (
            format!(
                "above the {ASSUMED_NOISE_UM} µm that are assumed where `noise_um` is not stated"
            ),
            "state",
        ),
    };
    Some(format!(
        "noise of a single reading {:.3} µm, {}: {expected}; a disturbed reading of any size may sit in it; repeat the runs, or {remedy} `noise_um`",
        found.sigma_um,
        found.source.words()
    ))
}

/// A disturbed reading, and how far it moves the curves: one increment too long, the next too short.
fn disturbed(outlier: &Outlier, volume: &Volume) -> String {
    let gain = |of: Axis| noise_gain(volume, of) / 2.0;
    let gain = Axis::ALL.map(gain).into_iter().fold(0.0, f64::max);
    format!(
        "disturbed reading, which stays in the curves and moves them by up to {:.3} µm that U does not hold: {}; repeat that run",
        gain * outlier.of_mean_um.abs(),
        outlier.words()
    )
}

fn roll(closure: &Closure) -> Option<String> {
    let ramps = closure.ramps.as_ref().filter(|ramps| ramps.is_roll())?;
    let changes = Axis::ALL.map(|axis| format!("{axis} {:+.3}", Figure(ramps.change_um[axis])));
    Some(format!(
        "the closure runs in straight ramps over the axes ({} µm from end to end): roll of an axis that carries others, which the nine errors do not hold; measure the roll and give it as `angles`",
        changes.join(", ")
    ))
}

/// A closure whose mean is not zero contradicts a perfect set-up.
fn set_up(closure: &Closure, noise: Noise) -> Option<String> {
    let freedom = noise.freedom.map_or(1e5, float);
    let spread = StudentsT::new(0.0, 1.0, freedom).ok()?;
    let limit = spread.inverse_cdf(1.0 - FALSE_DOUBT / 2.0 / 3.0);
    let off = |axis: &Axis| {
        let mean = closure.mean[*axis].abs();
        mean > SMALLEST_MEAN_UM && mean > limit * closure.u_mean_um(*axis, noise.sigma_um)
    };
    let off: Vec<String> = Axis::ALL
        .into_iter()
        .filter(off)
        .map(|axis| format!("{axis} {:+.3}", Figure(closure.mean[axis])))
        .collect();
    (!off.is_empty()).then(|| {
        format!(
            "the set-up is assumed perfect, but the mean of the closure is not zero ({} µm): tilt of the mirror, or roll; solve for the set-up",
            off.join(", ")
        )
    })
}

/// Reversal along the diagonals that passes with overrun show: the largest B at a cell end, µm;
/// `None` where the mean of forward minus reverse readings is within their noise. The reversal of
/// a single axis is hidden in it, so that no curve holds it. What linear measurements tell of
/// single axes is taken off.
pub(crate) fn hidden_reversal_um(
    means: &Means,
    noise: Option<Noise>,
    volume: &Volume,
    known: &LinearReversals,
) -> Option<f64> {
    let reverse = means.reverse.as_ref()?;
    let beside = |d: Diagonal| {
        let pairs = means.forward[d].iter().zip(&reverse[d]).enumerate();
        let left = |(node, (forward, back)): (usize, (&f64, &f64))| {
            forward - back - along_diagonal_um(known, volume, d, node)
        };
        pairs.map(left).collect::<Vec<f64>>()
    };
    let sigma = noise.map_or(0.0, |noise| noise.sigma_um);
    let of_known = u_along_diagonal_um(known, volume);
    let shown = |b: &Vec<f64>| {
        let count = float(b.len());
        // Six standard deviations of a mean difference.
        let limit = 6.0 * (std::f64::consts::SQRT_2 * sigma / count.sqrt()).hypot(of_known);
        (b.iter().sum::<f64>() / count).abs() > limit.max(SMALLEST_REVERSAL_UM)
    };
    let shown = Diagonal::ALL.map(beside).into_iter().filter(shown);
    let largest = shown.map(|b| {
        b.iter()
            .step_by(3)
            .fold(0.0, |most: f64, um| most.max(um.abs()))
    });
    largest.reduce(f64::max)
}
