//! The histogram of a grid with too many pairs, estimated from some of them.
//!
//! The grid is cut into blocks of neighbouring nodes; every two blocks are a stratum, from which
//! pairs are drawn in proportion to its size. The counts add up to the number of pairs, and
//! every bin in which drawn pairs fell has a standard error. Drawing is seeded: the same seed gives the same figures.

use super::diameter::diameter;
use super::grid_map::{GridMap, Node};
use super::histogram::{bin, pairs};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::ops::Range;

/// Parts of an axis.
const PARTS: usize = 4;

/// Pairs drawn from a stratum at least, so that its scatter can be seen.
const LEAST: u64 = 4;

/// Bins at most.
const BINS: usize = 1 << 20;

/// Counts of bins that were not counted but estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Estimated number of pairs of each bin, as in [`super::histogram::exact`]. `None` where no drawn pair fell into it: up to about
    /// 3/`drawn` of all pairs may be there (95 %). The last bin holds the largest difference, so
    /// never less than 1.
    pub counts: Vec<Option<f64>>,
    /// Standard error of each count. `None` where the drawn pairs show no scatter, because none,
    /// or every one of a stratum, fell into the bin: it is not 0 but unknown.
    pub standard_errors: Vec<Option<f64>>,
    /// Pairs drawn.
    pub drawn: u64,
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
    let last = bin(diameter(map).nodes);
    if bin_um.is_nan() || bin_um <= 0.0 || last >= BINS {
        return None;
    }
    let zeros = vec![0.0; last + 1];
    let hits = vec![0; last + 1];
    let mut sums = Sums { hits, counts: zeros.clone(), variances: zeros, drawn: 0 };
    for (stream, (one, other)) in strata(map.size()).into_iter().enumerate() {
        let size = if one == other {
            pairs(count(&one))
        } else {
            count(&one) as u64 * count(&other) as u64
        };
        if size == 0 {
            continue;
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream as u64);
        let share = u128::from(draws) * u128::from(size) / u128::from(pairs(map.count()));
        let number = u64::try_from(share).unwrap_or(u64::MAX).max(LEAST);
        for _ in 0..number {
            sums.hits[bin(two(&mut random, &one, &other)).min(last)] += 1;
        }
        sums.close(size, number);
    }
    let above_zero = |value: f64| (value > 0.0).then_some(value);
    let mut counts: Vec<Option<f64>> = sums.counts.into_iter().map(above_zero).collect();
    counts[last] = Some(counts[last].unwrap_or(1.0).max(1.0));
    let errors = sums.variances.into_iter().map(f64::sqrt);
    let standard_errors = errors.map(above_zero).collect();
    Some(Estimate { counts, standard_errors, drawn: sums.drawn })
}

/// What the strata have given so far.
struct Sums {
    hits: Vec<u64>,
    counts: Vec<f64>,
    variances: Vec<f64>,
    drawn: u64,
}

impl Sums {
    /// Adds a stratum of `size` pairs of which `drawn` were drawn.
    fn close(&mut self, size: u64, drawn: u64) {
        let (size, n) = (size as f64, drawn as f64);
        let sums = self.counts.iter_mut().zip(&mut self.variances);
        for (hits, (count, variance)) in self.hits.iter_mut().zip(sums) {
            if *hits > 0 {
                let part = *hits as f64 / n;
                *count += size * part;
                *variance += size * size * part * (1.0 - part) / (n - 1.0);
                *hits = 0;
            }
        }
        self.drawn += drawn;
    }
}

fn count(block: &Block) -> usize {
    block.iter().map(ExactSizeIterator::len).product()
}

/// Every block with itself and with those that follow.
fn strata(size: Node) -> Vec<(Block, Block)> {
    let cut = |axis: usize| {
        let parts = PARTS.min(size[axis]);
        let at = move |n: usize| n * size[axis] / parts;
        (0..parts).map(move |n| at(n)..at(n + 1))
    };
    let mut blocks: Vec<Block> = Vec::new();
    for i in cut(0) {
        for j in cut(1) {
            blocks.extend(cut(2).map(|k| [i.clone(), j.clone(), k]));
        }
    }
    let mut strata = Vec::new();
    for (n, one) in blocks.iter().enumerate() {
        let others = blocks[n..].iter();
        strata.extend(others.map(|other| (one.clone(), other.clone())));
    }
    strata
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
