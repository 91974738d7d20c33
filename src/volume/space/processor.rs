//! The one loop that takes time: distances of one vector to many, put into bins, in a form that the
//! compiler turns into instructions for many numbers at once.
//!
//! The numbers are single precision and only sort: a distance that is not clearly inside a bin
//! is computed again by [`square`](super::pair::square). So the counts do not depend on the
//! processor.

use super::grid_map::Vector;
use super::pair::square;
use std::ops::Range;

/// Pairs done together.
const LANES: usize = 16;

/// Counters of a bin: neighbouring pairs often fall into the same bin, and one counter would
/// have to wait for itself.
const COUNTERS: usize = 8;

/// Vectors that stay in the nearest cache while others pass.
const BLOCK: usize = 2048;

/// Bins at most. The last one takes what is not clear.
pub(super) const BINS: usize = 4096;

const UNCLEAR: u32 = 4095;

/// Added to a number below 2²² in size, leaves its nearest integer in the last bits.
const INTEGER: f32 = 12_582_912.0;

/// Vectors for counting.
pub(super) struct Cloud<'a> {
    /// As they are.
    pub(super) exact: &'a [Vector],
    /// In bins, from the middle: x, y, z.
    pub(super) rough: [Vec<f32>; 3],
    /// Width of a bin, µm.
    pub(super) bin_um: f64,
    /// What a rough distance may be wrong by, in bins.
    pub(super) doubt: f32,
}

/// Counts of bins, with a few counters for each.
pub(super) struct Tally(Box<[[u32; COUNTERS]; BINS]>);

impl Tally {
    pub(super) fn new() -> Self {
        Tally(Box::new([[0; COUNTERS]; BINS]))
    }

    /// Count of a bin.
    pub(super) fn of(&self, bin: usize) -> u64 {
        self.0[bin].iter().map(|count| u64::from(*count)).sum()
    }
}

/// Bin of a distance, by the routine that decides.
#[inline]
pub(super) fn bin(p: &Vector, q: &Vector, bin_um: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a quotient of lengths; the caller has bounded it"
    )]
    let bin = (square(p, q).sqrt() / bin_um) as usize;
    bin
}

/// Counts the pairs of the vectors `these` with all that follow them.
pub(super) fn count(cloud: &Cloud<'_>, these: Range<usize>, tally: &mut Tally) {
    let all = cloud.exact.len();
    let mut block = these.start;
    while block < all {
        let end = all.min(block + BLOCK);
        for one in these.start..these.end.min(end) {
            count_block(cloud, one, block.max(one + 1)..end, tally);
        }
        block = end;
    }
}

#[inline(always)]
fn count_block(cloud: &Cloud<'_>, one: usize, others: Range<usize>, tally: &mut Tally) {
    let lanes = |c: usize| cloud.rough[c][others.clone()].as_chunks::<LANES>().0;
    let from = [0, 1, 2].map(|c| cloud.rough[c][one]);
    let mut place = others.start;
    for ((x, y), z) in lanes(0).iter().zip(lanes(1)).zip(lanes(2)) {
        let (bins, unclear) = rough_bins(from, [x, y, z], cloud.doubt);
        for (lane, bin) in bins.iter().enumerate() {
            tally.0[*bin as usize & (BINS - 1)][lane % COUNTERS] += 1;
        }
        if unclear {
            count_unclear(cloud, one, place, &bins, tally);
        }
        place += LANES;
    }
    for other in place..others.end {
        let bin = bin(&cloud.exact[one], &cloud.exact[other], cloud.bin_um);
        tally.0[bin & (BINS - 1)][0] += 1;
    }
}

/// Bins of a vector and 16 others; where a distance is near the edge of a bin, [`UNCLEAR`].
#[inline(always)]
fn rough_bins(from: [f32; 3], [x, y, z]: [&[f32; LANES]; 3], doubt: f32) -> ([u32; LANES], bool) {
    let mut bins = [0; LANES];
    let mut unclear = 0;
    for lane in 0..LANES {
        let (dx, dy, dz) = (x[lane] - from[0], y[lane] - from[1], z[lane] - from[2]);
        let distance = (dx * dx + dy * dy + dz * dz).sqrt() - 0.5;
        let low = ((distance - doubt) + INTEGER).to_bits();
        let high = ((distance + doubt) + INTEGER).to_bits();
        let edge = u32::from(low != high);
        unclear |= edge;
        bins[lane] = if edge == 0 {
            low.wrapping_sub(INTEGER.to_bits())
        } else {
            UNCLEAR
        };
    }
    (bins, unclear != 0)
}

#[cold]
#[inline(never)]
fn count_unclear(
    cloud: &Cloud<'_>,
    one: usize,
    place: usize,
    bins: &[u32; LANES],
    tally: &mut Tally,
) {
    for (lane, rough) in bins.iter().enumerate() {
        if *rough == UNCLEAR {
            let bin = bin(&cloud.exact[one], &cloud.exact[place + lane], cloud.bin_um);
            tally.0[bin & (BINS - 1)][lane % COUNTERS] += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::space::histogram::prepared;

    #[test]
    fn rough_distances_are_counted_as_exact_ones() {
        let wave = |n: usize, turn: f64| (n as f64 * turn).sin() * 40.0;
        let exact: Vec<Vector> = (0..700)
            .map(|n| [wave(n, 0.7), wave(n, 1.3) * 0.5, wave(n, 2.9) * 0.1])
            .collect();
        let cloud = prepared(&exact, 0.25).expect("few bins");
        let mut expected = vec![0; BINS - 1];
        for (n, p) in exact.iter().enumerate() {
            for q in &exact[n + 1..] {
                expected[bin(p, q, 0.25)] += 1;
            }
        }
        let mut tally = Tally::new();
        count(&cloud, 0..300, &mut tally);
        count(&cloud, 300..700, &mut tally);
        let counts: Vec<u64> = (0..BINS - 1).map(|bin| tally.of(bin)).collect();
        assert_eq!(counts, expected);
    }
}
