//! Two diagonals whose readings stand under each other's name.
//!
//! The four programs are alike, so a file that was saved under another diagonal is complete and
//! plausible. Its readings contradict the nine errors: what one diagonal saw of an axis stands at
//! the other one's places and signs. Where a closure is in doubt, each of the six exchanges is
//! tried; one is named if it leaves nothing to doubt and its closure scatters so much less that
//! chance does not explain it.

use super::campaign::{Campaign, corrected};
use super::closure::{Closure, Known, closure};
use super::doubt::of_closure;
use super::noise::{known_noise, means, run_counts};
use super::outlier::{FALSE_DOUBT, float};
use super::repeats::repeats;
use super::reversal::separable;
use crate::axis::Axis;
use crate::diagonal::{Diagonal, Run};
use crate::job::SetUp;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// A closure that no instrument resolves is in no doubt, µm.
const SMALLEST_SPREAD_UM: f64 = 0.02;

/// The exchange that explains the doubts best, in words; `None` where none does.
pub(super) fn exchanged(
    campaign: &Campaign<'_>,
    runs: &[Run],
    as_read: &Closure,
    overrun: Option<bool>,
) -> Option<String> {
    let before = spread_um(as_read);
    if before < SMALLEST_SPREAD_UM {
        return None;
    }
    let explains = |pair: &(Diagonal, Diagonal)| {
        let after = spread_without_doubt(campaign, &under_names_of(runs, *pair), overrun)?;
        is_clear(before, after, as_read.freedom).then_some((*pair, after))
    };
    let pairs = pairs();
    let found = pairs.iter().filter_map(explains);
    let ((one, other), after) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "as if the readings of {one} and {other} were exchanged: under each other's name their closure scatters by {after:.3} µm, not {before:.3} µm, and nothing of it speaks against the nine errors; compare the names in the file with the programs that were run"
    ))
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

/// Scatter of the closure of these runs, µm; `None` where something speaks against them.
fn spread_without_doubt(
    campaign: &Campaign<'_>,
    runs: &[Run],
    overrun: Option<bool>,
) -> Option<f64> {
    let volume = &campaign.measurement.volume;
    let runs = corrected(campaign, runs);
    let repeats = repeats(&runs);
    let noise = known_noise(&campaign.stated, repeats.noise);
    let measured = means(&runs);
    let means = separable(&measured, volume, overrun == Some(false));
    let known = Known {
        noise,
        outliers: &repeats.outliers,
        skip_ends: means.reverse.is_some() && overrun != Some(true),
    };
    let closure = closure(volume, &means, &run_counts(&runs), known);
    let noise = noise.or_else(|| closure.noise());
    let doubts = of_closure(&closure, noise, volume, SetUp::Solve);
    doubts.is_empty().then(|| spread_um(&closure))
}

/// Root mean square of w beside the mean of its axis, µm.
fn spread_um(closure: &Closure) -> f64 {
    let beside = |axis: Axis| {
        let w = closure.by_interval[axis].iter();
        w.map(move |w| (w - closure.mean[axis]).powi(2))
    };
    let squares: Vec<f64> = Axis::ALL.into_iter().flat_map(beside).collect();
    (squares.iter().sum::<f64>() / float(squares.len().max(1))).sqrt()
}

/// Whether chance makes one scatter so much larger than the other; neighbouring w share readings,
/// so that half of the degrees of freedom are counted.
fn is_clear(before_um: f64, after_um: f64, freedom: usize) -> bool {
    let half = float(freedom) / 2.0;
    let Ok(spread) = FisherSnedecor::new(half, half) else {
        return false;
    };
    let ratio = (before_um / after_um).powi(2);
    // Six exchanges are tried.
    spread.sf(ratio.min(f64::MAX)) < FALSE_DOUBT / 6.0
}
