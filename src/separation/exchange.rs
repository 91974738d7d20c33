//! Two diagonals whose readings stand under each other's name.
//!
//! The four programs are alike, so a file that was saved under another diagonal is complete and
//! plausible. Its readings contradict the nine errors: what one diagonal saw of an axis stands at
//! the other one's places and signs. Where something is in doubt, each of the six exchanges is
//! tried; one is named if it leaves nothing to doubt and is clearly likelier than the names as read
//! (with disturbed readings and ramps of roll left out of these).

use super::campaign::{Campaign, corrected};
use super::closure::{Closure, Known, closure, spread_um};
use super::doubt::of_closure;
use super::increments::Means;
use super::noise::{CorrectedRun, Noise, NoiseSource, known_noise, means, run_counts};
use super::outlier::float;
use super::repeats::repeats;
use super::reversal::separable;
use crate::diagonal::{Diagonal, Run, Volume};
use crate::job::SetUp;
use crate::units::Squared;

/// A closure that no instrument resolves is in no doubt, µm.
const SMALLEST_SPREAD_UM: f64 = 0.02;
/// 2 ln of the odds from which an exchange is named: e¹⁵ to one, whatever the six chances are worth.
const CLEARLY: f64 = 30.0;

/// What the closure of the readings says under the names of the file.
pub(super) struct AsRead<'a> {
    pub(super) closure: &'a Closure,
    /// The readings that were separated.
    pub(super) means: &'a Means,
    pub(super) noise: Option<Noise>,
    pub(super) overrun: Option<bool>,
}

/// The exchange that explains the doubts best, in words; `None` where none does.
pub(super) fn exchanged(
    campaign: &Campaign<'_>,
    runs: &[Run],
    as_read: &AsRead<'_>,
) -> Option<String> {
    let volume = &campaign.measurement.volume;
    if !is_open(as_read, volume) {
        return None;
    }
    let before = spread_um(volume, as_read.means);
    let explains = |pair: &(Diagonal, Diagonal)| {
        let runs = corrected(campaign, &under_names_of(runs, *pair));
        let measured = means(&runs);
        let means = separable(&measured, volume, as_read.overrun == Some(false));
        let after = spread_um(volume, &means);
        let named = after < before && is_explanation(campaign, &runs, &means, as_read);
        named.then_some((*pair, after))
    };
    let pairs = pairs();
    let found = pairs.iter().filter_map(explains);
    let ((one, other), after) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "as if the readings of {one} and {other} were exchanged: under each other's name their closure scatters by {after:.3} µm, not {before:.3} µm, and nothing of it speaks against the nine errors; compare the names in the file with the programs that were run"
    ))
}

/// Whether something is in doubt, or could not be: where no noise is known but that of the closure, a
/// scatter of it raises no doubt. What no instrument resolves beside roll is none.
fn is_open(as_read: &AsRead<'_>, volume: &Volume) -> bool {
    let left_um = as_read.closure.sigma_um().unwrap_or(0.0);
    let doubts = of_closure(as_read.closure, as_read.noise, volume, SetUp::Solve);
    let unknown = as_read
        .noise
        .is_none_or(|noise| noise.source == NoiseSource::Closure);
    left_um > SMALLEST_SPREAD_UM && (unknown || !doubts.is_empty())
}

fn pairs() -> Vec<(Diagonal, Diagonal)> {
    let all = Diagonal::ALL.into_iter().enumerate();
    let with_others = |(index, one)| {
        Diagonal::ALL
            .into_iter()
            .skip(index + 1)
            .map(move |other| (one, other))
    };
    all.flat_map(with_others).collect()
}

fn under_names_of(runs: &[Run], (one, other): (Diagonal, Diagonal)) -> Vec<Run> {
    let mut runs = runs.to_vec();
    for run in &mut runs {
        run.diagonal = match run.diagonal {
            diagonal if diagonal == one => other,
            diagonal if diagonal == other => one,
            diagonal => diagonal,
        };
    }
    runs
}

/// Whether nothing speaks against the nine errors of these runs, and they are so much likelier than
/// the runs as read: 2 ln of the odds is the change of Q/σ², or ν ln of the ratio where σ is that of
/// the closure itself.
fn is_explanation(
    campaign: &Campaign<'_>,
    runs: &[CorrectedRun],
    means: &Means,
    as_read: &AsRead<'_>,
) -> bool {
    let volume = &campaign.measurement.volume;
    let repeats = repeats(runs);
    let stated = known_noise(&campaign.stated, repeats.noise);
    let known = Known {
        noise: stated,
        outliers: &repeats.outliers,
        skip_ends: means.reverse.is_some() && as_read.overrun != Some(true),
    };
    let closure = closure(volume, means, &run_counts(runs), known);
    let noise = stated.or_else(|| closure.noise());
    let before = as_read.closure;
    let gain = match stated {
        Some(noise) => {
            (before.weighted_square - closure.weighted_square) / noise.sigma_um.squared()
        }
        None => float(before.freedom) * (before.weighted_square / closure.weighted_square).ln(),
    };
    gain > CLEARLY && of_closure(&closure, noise, volume, SetUp::Solve).is_empty()
}
