//! How the differences of all pairs of error vectors are distributed.
//!
//! Up to [`EXACT_PAIRS`] pairs every one is counted; beyond, [`estimate`] draws some of them.
//!
//! The one loop that takes time: distances of one vector to many, put into bins, in a form that the
//! compiler turns into instructions for many numbers at once.
//!
//! The numbers are single precision and only sort: a distance that is not clearly inside a bin
//! is computed again by [`square`](super::pair::square). So the counts do not depend on the
//! processor.

use crate::space::grid_map::{GridMap, Node, Vector, node};
use crate::space::pair::{Ends, Longest, NumberedVector, dot, square};
use crate::space::{diameter, pair};
use crate::threads::of_parts;
use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use serde::Serialize;
use std::ops::Range;

/// Pairs that are counted one by one: a grid of 41 nodes an axis, about a second.
pub const EXACT_PAIRS: u64 = 3_000_000_000;

/// Rounding of single precision in units of the largest coordinate, see [`prepared`].
const ROUGH: f64 = 40.0 / 16_777_216.0;

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
    let [p, q] = diameter::longest(vectors)?.pair;
    let last = bin(&vectors[p], &vectors[q], bin_um);
    if last >= BINS - 1 {
        return None;
    }
    let tallies = in_threads(&prepared(vectors, bin_um)?, threads);
    let of_bin = |bin: usize| tallies.iter().flat_map(|tally| tally[bin]).map(u64::from).sum();
    Some((0..=last).map(of_bin).collect())
}

/// Rough coordinates in bins from the middle; `None` where there is no vector or one is not finite.
///
/// With |coordinate| ≤ R bins a rounded coordinate is wrong by R·2⁻²⁴ at most, a distance by
/// 2·√3 times that; differences, squares, sum and root add less than 6·2⁻²⁴ of a distance of at
/// most 2·√3·R, the comparison with the edges another 2·2⁻²⁴. 40·R·2⁻²⁴ is more than all of it.
fn prepared(vectors: &[Vector], bin_um: f64) -> Option<Cloud<'_>> {
    let (low, high) = diameter::bounds(vectors)?;
    let largest = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max) / 2.0 / bin_um;
    #[expect(clippy::cast_possible_truncation, reason = "rough on purpose")]
    let rough = [0, 1, 2].map(|c| {
        let middle = low[c] + (high[c] - low[c]) / 2.0;
        let inside = vectors.iter().map(|vector| (vector[c] - middle) / bin_um);
        inside.map(|v| v as f32).collect()
    });
    #[expect(clippy::cast_possible_truncation, reason = "a bound with room")]
    let doubt = (ROUGH * largest.max(1.0)) as f32;
    Some(Cloud { exact: vectors, rough, bin_um, doubt })
}

/// Integers add up to the same sum however the work is divided.
fn in_threads(cloud: &Cloud<'_>, threads: usize) -> Vec<Box<Tally>> {
    let work = |part: Range<usize>| {
        let mut tally = Box::new([[0; COUNTERS]; 1 << 16]);
        part.for_each(|one| count(cloud, one, &mut tally));
        tally
    };
    of_parts(parts(cloud.exact.len(), threads.max(1)), work)
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

/// Pairs done together: first the bins of all, then the counting.
const LANES: usize = 32;

/// Counters of a bin: neighbouring pairs often fall into the same bin, and one counter would
/// have to wait for itself.
const COUNTERS: usize = 2;

/// Bins at most.
const BINS: usize = 4096;

/// Counters by the last 16 bits of a bin: the processor reads those alone as fast as the whole number.
type Tally = [[u32; COUNTERS]; 1 << 16];

/// Added to a number below 2²² in size, leaves its nearest integer in the last bits.
const INTEGER: f32 = 12_582_912.0;

/// Vectors for counting.
struct Cloud<'a> {
    /// As they are.
    exact: &'a [Vector],
    /// In bins, from the middle: x, y, z.
    rough: [Vec<f32>; 3],
    /// Width of a bin, µm.
    bin_um: f64,
    /// What a rough distance may be wrong by, in bins.
    doubt: f32,
}

/// Bin of a distance, by the routine that decides.
#[inline]
fn bin(p: &Vector, q: &Vector, bin_um: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, reason = "of lengths; bounded by the caller")]
    let bin = (square(p, q).sqrt() / bin_um) as usize;
    bin
}

/// Counts the pairs of a vector with all that follow it.
fn count(cloud: &Cloud<'_>, one: usize, tally: &mut Tally) {
    let mut place = one + 1;
    let lanes = |c: usize| cloud.rough[c][one + 1..].as_chunks::<LANES>().0;
    let (xs, ys, zs) = (lanes(0), lanes(1), lanes(2));
    let from = [0, 1, 2].map(|c| cloud.rough[c][one]);
    let mut bins = [0; LANES];
    for ((x, y), z) in xs.iter().zip(ys).zip(zs) {
        let clear = rough_bins(from, [x, y, z], cloud.doubt, &mut bins);
        for (lane, bin) in bins.iter().enumerate() {
            *counter(tally, *bin, lane) += 1;
        }
        if !clear {
            correct(cloud, one, place, tally);
        }
        place += LANES;
    }
    for other in &cloud.exact[place..] {
        tally[bin(&cloud.exact[one], other, cloud.bin_um)][0] += 1;
    }
}

#[inline(always)]
fn counter(tally: &mut Tally, bin: u32, lane: usize) -> &mut u32 {
    &mut tally[bin as usize % (1 << 16)][lane % COUNTERS]
}

/// Bins of a vector and some others; false where a distance is near the edge of its bin.
#[inline(always)]
fn rough_bins(
    from: [f32; 3],
    [x, y, z]: [&[f32; LANES]; 3],
    doubt: f32,
    bins: &mut [u32; LANES],
) -> bool {
    let mut all_clear = true;
    for lane in 0..LANES {
        let (bin, clear) = rough_bin(from, [x[lane], y[lane], z[lane]], doubt);
        bins[lane] = bin;
        all_clear &= clear;
    }
    all_clear
}

/// Bin of a distance, and whether it is not near the edge of its bin.
#[inline(always)]
fn rough_bin(from: [f32; 3], to: [f32; 3], doubt: f32) -> (u32, bool) {
    let (dx, dy, dz) = (to[0] - from[0], to[1] - from[1], to[2] - from[2]);
    let distance = (dx * dx + dy * dy + dz * dz).sqrt();
    let bin = (distance - (0.5 + doubt)) + INTEGER;
    (bin.to_bits(), distance - (bin - INTEGER) <= 1.0 - doubt)
}

/// Counts anew what was not clear of the pairs done together.
#[cold]
#[inline(never)]
fn correct(cloud: &Cloud<'_>, one: usize, place: usize, tally: &mut Tally) {
    for lane in 0..LANES {
        let [from, to] = [one, place + lane].map(|n| [0, 1, 2].map(|c| cloud.rough[c][n]));
        let (rough, clear) = rough_bin(from, to, cloud.doubt);
        if !clear {
            *counter(tally, rough, lane) -= 1;
            let bin = bin(&cloud.exact[one], &cloud.exact[place + lane], cloud.bin_um);
            tally[bin][lane % COUNTERS] += 1;
        }
    }
}

// The histogram of a grid with too many pairs, estimated from some of them.
//
// The grid is cut into blocks of neighbouring nodes; every two blocks are a stratum, from which
// pairs are drawn in proportion to its size. The counts add up to the number of pairs, and
// every bin in which drawn pairs fell has a standard error. Drawing is seeded: the same seed gives the same figures.

/// Parts of an axis.
const PARTS: usize = 4;

/// Pairs drawn from a stratum at least, so that its scatter can be seen.
const LEAST: u64 = 4;

/// Bins at most of an estimate.
const MOST_BINS: usize = 1 << 20;

/// Counts of bins that were not counted but estimated, and what they rest on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Pairs drawn.
    pub drawn: u64,
    /// Estimated number of pairs of each bin, as in [`exact`]. `None` where no drawn pair fell into it: up to about
    /// 3/`drawn` of all pairs may be there (95 %). The last bin holds the largest difference, so
    /// never less than 1.
    #[serde(skip)]
    pub counts: Vec<Option<f64>>,
    /// Standard error of each count. `None` where the drawn pairs show no scatter, because none,
    /// or every one of a stratum, fell into the bin: it is not 0 but unknown.
    pub standard_errors: Vec<Option<f64>>,
}

/// A box of nodes.
type Block = [Range<usize>; 3];

/// Estimates the histogram from about `draws` pairs.
///
/// what   N_s·p_s of each stratum, added up; standard error √Σ N_s²·p_s·(1 − p_s)/(n_s − 1), with
///        N_s pairs of the stratum, n_s drawn from it with replacement, and p_s the part in the bin
/// source Cochran, Sampling Techniques (1977), chapter 5
/// limits `None` where `bin_um` is not positive or more than 2²⁰ bins were needed. A number below
///        n is drawn as the upper half of n·(32 random bits): uneven by n·2⁻³² at most
pub fn estimate(map: &GridMap, bin_um: f64, draws: u64, seed: u64) -> Option<Estimate> {
    let bin = |nodes: [Node; 2]| {
        let [p, q] = nodes.map(|node| map.at(node));
        bin(&p, &q, bin_um)
    };
    let last = bin(diameter::diameter(map).nodes);
    if bin_um.is_nan() || bin_um <= 0.0 || last >= MOST_BINS {
        return None;
    }
    let (mut hits, mut drawn) = (vec![0_u64; last + 1], 0);
    let [mut counts, mut variances] = [(); 2].map(|()| vec![0.0; last + 1]);
    for (stream, (one, other)) in strata(map.size()).into_iter().enumerate() {
        let size = if one == other {
            pairs(nodes(&one))
        } else {
            nodes(&one) as u64 * nodes(&other) as u64
        };
        if size == 0 {
            continue;
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream as u64);
        let share = u128::from(draws) * u128::from(size) / u128::from(pairs(map.count()));
        let number = u64::try_from(share).unwrap_or(u64::MAX).max(LEAST);
        for _ in 0..number {
            hits[bin(two(&mut random, &one, &other)).min(last)] += 1;
        }
        drawn += number;
        let (size, n) = (size as f64, number as f64);
        let sums = counts.iter_mut().zip(&mut variances);
        for (hits, (count, variance)) in hits.iter_mut().zip(sums).filter(|(hits, _)| **hits > 0) {
            let part = std::mem::take(hits) as f64 / n;
            *count += size * part;
            *variance += size * size * part * (1.0 - part) / (n - 1.0);
        }
    }
    let above_zero = |value: f64| (value > 0.0).then_some(value);
    let mut counts: Vec<Option<f64>> = counts.into_iter().map(above_zero).collect();
    counts[last] = Some(counts[last].unwrap_or(1.0).max(1.0));
    let standard_errors = variances.into_iter().map(f64::sqrt).map(above_zero).collect();
    Some(Estimate { drawn, counts, standard_errors })
}

fn nodes(block: &Block) -> usize {
    block.iter().map(ExactSizeIterator::len).product()
}

/// Every block with itself and with those that follow.
fn strata(size: Node) -> Vec<(Block, Block)> {
    let parts = size.map(|nodes| PARTS.min(nodes));
    let block = |number: usize| -> Block {
        let cell = node(number, parts);
        let at = |axis: usize, n: usize| n * size[axis] / parts[axis];
        [0, 1, 2].map(|axis| at(axis, cell[axis])..at(axis, cell[axis] + 1))
    };
    let blocks: Vec<Block> = (0..parts.iter().product()).map(block).collect();
    let with_others = |(n, one): (usize, &Block)| {
        blocks[n..].iter().map(|other| (one.clone(), other.clone())).collect::<Vec<_>>()
    };
    blocks.iter().enumerate().flat_map(with_others).collect()
}

fn draw(random: &mut ChaCha8Rng, block: &Block) -> Node {
    [0, 1, 2].map(|axis| {
        let length = block[axis].len() as u64;
        let below = (u64::from(random.next_u32()) * length) >> 32;
        block[axis].start + usize::try_from(below).unwrap_or(0)
    })
}

/// Two different nodes.
fn two(random: &mut ChaCha8Rng, one: &Block, other: &Block) -> [Node; 2] {
    loop {
        let pair = [draw(random, one), draw(random, other)];
        if pair[0] != pair[1] {
            return pair;
        }
    }
}

// The grouping method of paper 002, section 4.2, kept for comparison. **It is not exact.**
//
// Vectors of about the same direction form a group, and only the long ones of a group are
// compared. What is left out shares the direction of the one that stays, not its place: with a
// constant error added, which changes no difference, the result may be too small by half.

/// Tolerances of the grouping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest sum of the absolute differences between a unit vector and the mean of a group
    /// (table 1 of the paper: 0.05, 0.1, 0.2).
    pub angular: f64,
    /// Part of a group's longest vector below which a vector is dismissed (the paper: 0.9).
    pub magnitude: f64,
}

/// What the method keeps and finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Grouping {
    /// Number of groups.
    pub groups: usize,
    /// Numbers of the vectors that are kept (*records*), ascending.
    pub records: Vec<usize>,
    /// The longest difference of two records; `None` where nothing is kept.
    pub longest: Option<Longest>,
}

#[derive(Default)]
struct Group {
    sum: Vector,
    mean: Vector,
    joined: f64,
    largest: f64,
    members: Vec<(usize, f64)>,
}

/// Groups the vectors in their order and compares what is kept.
///
/// source paper 002 in the reading that comes nearest to its table 1: the sum of the differences
///        is of absolute values, the mean is of all that joined, and a new longest vector dismisses
///        earlier members that are too short beside it. Vectors of length 0 are skipped
/// limits a lower bound of the volumetric accuracy, without a bound of what is missing
pub fn grouping(vectors: &[Vector], tolerance: Tolerance) -> Grouping {
    let mut groups: Vec<Group> = Vec::new();
    for (number, vector) in vectors.iter().enumerate() {
        let length = dot(vector, vector).sqrt();
        if length <= 0.0 {
            continue;
        }
        let unit = vector.map(|c| c / length);
        let near = |group: &Group| apart(&unit, &group.mean) <= tolerance.angular;
        let place = groups.iter().position(near).unwrap_or(groups.len());
        if place == groups.len() {
            groups.push(Group::default());
        }
        groups[place].join(number, unit, length, tolerance.magnitude);
    }
    let members = groups.iter().flat_map(|group| &group.members);
    let mut records: Vec<usize> = members.map(|(number, _)| *number).collect();
    records.sort_unstable();
    Grouping { groups: groups.len(), longest: compare(vectors, &records), records }
}

fn apart(unit: &Vector, mean: &Vector) -> f64 {
    (unit[0] - mean[0]).abs() + (unit[1] - mean[1]).abs() + (unit[2] - mean[2]).abs()
}

fn compare(vectors: &[Vector], records: &[usize]) -> Option<Longest> {
    let mut longest = Longest::none(*records.first()?);
    let point = |number: &usize| NumberedVector { at: vectors[*number], number: *number };
    let top: Vec<NumberedVector> = records.iter().map(point).collect();
    pair::compare(&Ends { bottom: top.clone(), top }, &mut longest);
    Some(longest)
}

impl Group {
    fn join(&mut self, number: usize, unit: Vector, length: f64, magnitude: f64) {
        for (sum, c) in self.sum.iter_mut().zip(unit) {
            *sum += c;
        }
        self.joined += 1.0;
        self.mean = self.sum.map(|c| c / self.joined);
        if length < magnitude * self.largest {
            return;
        }
        if length > self.largest {
            self.largest = length;
            self.members.retain(|(_, other)| *other >= magnitude * length);
        }
        self.members.push((number, length));
    }
}
