//! The histogram of a grid with too many pairs, estimated from some of them.
//!
//! The grid is cut into blocks of neighbouring nodes; every two blocks are a stratum, from which
//! pairs are drawn in proportion to its size. The counts add up to the number of pairs, and
//! every bin in which drawn pairs fell has a standard error. Drawing is seeded: the same seed gives the same figures.

use super::diameter::diameter;
use super::grid_map::{GridMap, Node, node};
use super::histogram::{bin, pairs};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::Serialize;
use std::ops::Range;

/// Parts of an axis.
const PARTS: usize = 4;

/// Pairs drawn from a stratum at least, so that its scatter can be seen.
const LEAST: u64 = 4;

/// Bins at most.
const BINS: usize = 1 << 20;

/// Counts of bins that were not counted but estimated, and what they rest on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Pairs drawn.
    pub drawn: u64,
    /// Estimated number of pairs of each bin, as in [`super::histogram::exact`]. `None` where no drawn pair fell into it: up to about
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
    let last = bin(diameter(map).nodes);
    if bin_um.is_nan() || bin_um <= 0.0 || last >= BINS {
        return None;
    }
    let (mut hits, mut drawn) = (vec![0_u64; last + 1], 0);
    let [mut counts, mut variances] = [(); 2].map(|()| vec![0.0; last + 1]);
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
    let errors = variances.into_iter().map(f64::sqrt);
    let standard_errors = errors.map(above_zero).collect();
    Some(Estimate { drawn, counts, standard_errors })
}

fn count(block: &Block) -> usize {
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
