//! How the differences of all pairs of error vectors are distributed.
//!
//! Up to [`EXACT_PAIRS`] pairs every one is counted; beyond, see [`sample`](super::sample).

use super::cloud;
use super::grid_map::Vector;
use super::processor::{BINS, Cloud, Tally, bin, count};
use std::ops::Range;

/// Pairs that are counted one by one: a grid of 41 nodes an axis, about a second.
pub const EXACT_PAIRS: u64 = 3_000_000_000;

/// Rounding of single precision in units of the largest coordinate, see [`prepared`].
const ROUGH: f64 = 40.0 / 16_777_216.0;

/// Doubt above which rough distances decide nothing, bins.
const DOUBTFUL: f64 = 0.2;

/// Number of pairs of `count` vectors.
pub fn pairs(count: usize) -> u64 {
    let count = count as u64;
    count * count.saturating_sub(1) / 2
}

/// Counts all pairs of vectors: bin n holds the differences from n·`bin_um` up to, not
/// including, (n + 1)·`bin_um`. The last bin holds the largest difference.
///
/// limits `None` where there is no vector or one is not finite, `bin_um` is not positive, there
///        are more than [`EXACT_PAIRS`] pairs, or 4095 bins do not reach the largest difference
pub fn exact(vectors: &[Vector], bin_um: f64, threads: usize) -> Option<Vec<u64>> {
    if bin_um.is_nan() || bin_um <= 0.0 || pairs(vectors.len()) > EXACT_PAIRS {
        return None;
    }
    let [p, q] = cloud::longest(vectors)?.pair;
    let last = bin(&vectors[p], &vectors[q], bin_um);
    if last >= BINS - 1 {
        return None;
    }
    let tallies = match prepared(vectors, bin_um) {
        Some(cloud) => in_threads(&cloud, threads),
        None => return Some(one_by_one(vectors, bin_um, last)),
    };
    let of_bin = |bin: usize| tallies.iter().map(|tally| tally.of(bin)).sum();
    Some((0..=last).map(of_bin).collect())
}

/// Rough coordinates in bins from the middle; `None` where they are too rough.
///
/// With |coordinate| ≤ R bins a rounded coordinate is wrong by R·2⁻²⁴ at most, a distance by
/// 2·√3 times that; differences, squares, sum and root add less than 6·2⁻²⁴ of a distance of at
/// most 2·√3·R, the comparison with the edge another 2⁻²⁴. 40·R·2⁻²⁴ is more than all of it.
pub(super) fn prepared(vectors: &[Vector], bin_um: f64) -> Option<Cloud<'_>> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for vector in vectors {
        for c in 0..3 {
            low[c] = low[c].min(vector[c]);
            high[c] = high[c].max(vector[c]);
        }
    }
    let largest = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max) / 2.0 / bin_um;
    let doubt = ROUGH * largest.max(1.0);
    if doubt > DOUBTFUL {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "rough on purpose")]
    let rough = [0, 1, 2].map(|c| {
        let middle = low[c] + (high[c] - low[c]) / 2.0;
        let inside = vectors.iter().map(|vector| (vector[c] - middle) / bin_um);
        inside.map(|v| v as f32).collect()
    });
    #[expect(clippy::cast_possible_truncation, reason = "a bound with room")]
    let doubt = doubt as f32;
    Some(Cloud {
        exact: vectors,
        rough,
        bin_um,
        doubt,
    })
}

/// Integers add up to the same sum however the work is divided.
fn in_threads(cloud: &Cloud<'_>, threads: usize) -> Vec<Tally> {
    let parts = parts(cloud.exact.len(), threads.max(1));
    let work = |part: Range<usize>| {
        let mut tally = Tally::new();
        count(cloud, part, &mut tally);
        tally
    };
    if let [whole] = parts.as_slice() {
        return vec![work(whole.clone())];
    }
    std::thread::scope(|scope| {
        let work = &work;
        let running: Vec<_> = parts
            .into_iter()
            .map(|part| scope.spawn(move || work(part)))
            .collect();
        let joined = running.into_iter().map(|thread| match thread.join() {
            Ok(tally) => tally,
            Err(reason) => std::panic::resume_unwind(reason),
        });
        joined.collect()
    })
}

/// Ranges of vectors with about as many pairs with those that follow.
fn parts(count: usize, threads: usize) -> Vec<Range<usize>> {
    let share = pairs(count) / threads as u64 + 1;
    let mut parts = Vec::new();
    let (mut start, mut sum) = (0, 0);
    for one in 0..count {
        sum += (count - 1 - one) as u64;
        if sum >= share || one + 1 == count {
            parts.push(start..one + 1);
            (start, sum) = (one + 1, 0);
        }
    }
    parts
}

fn one_by_one(vectors: &[Vector], bin_um: f64, last: usize) -> Vec<u64> {
    let mut counts = vec![0; last + 1];
    for (n, p) in vectors.iter().enumerate() {
        for q in &vectors[n + 1..] {
            counts[bin(p, q, bin_um)] += 1;
        }
    }
    counts
}
