//! Why a result is doubtful, in words: what the readings themselves say against it.

use super::closure::Closure;
use super::increments::Means;
use super::noise::Noise;
use crate::diagonal::Diagonal;

/// What the closure says against the nine errors.
pub fn of_closure(closure: &Closure, _noise: Option<Noise>) -> Vec<String> {
    let outliers = closure.outliers.iter();
    outliers
        .map(|outlier| {
            format!(
                "disturbed reading, which stays in the result: {}; repeat that run",
                outlier.words()
            )
        })
        .collect()
}

/// What no instrument is held to, µm.
const SMALLEST_REVERSAL_UM: f64 = 0.02;

/// Reversal along the diagonals that passes with overrun show: the largest mean over a diagonal of
/// forward minus reverse readings, µm; `None` where it is within their noise. The reversal of a
/// single axis is hidden in it, so that no curve holds it.
pub fn hidden_reversal_um(means: &Means, noise: Option<Noise>) -> Option<f64> {
    let reverse = means.reverse.as_ref()?;
    let of = |d: Diagonal| {
        let pairs = means.forward[d].iter().zip(&reverse[d]);
        let (sum, count) = pairs.fold((0.0_f64, 0.0), |(sum, count), (forward, back)| {
            (sum + forward - back, count + 1.0)
        });
        (sum.abs() / count, count)
    };
    let sigma = noise.map_or(0.0, |noise| noise.sigma_um);
    let shown = Diagonal::ALL.map(of).into_iter().filter(|(um, count)| {
        // Six standard deviations of a mean difference.
        *um > (6.0 * std::f64::consts::SQRT_2 * sigma / count.sqrt()).max(SMALLEST_REVERSAL_UM)
    });
    shown.map(|(um, _)| um).reduce(f64::max)
}
