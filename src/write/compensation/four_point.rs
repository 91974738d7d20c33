//! Four-point straightness: the three straight pieces that follow a row of amounts best.
//!
//! The control stores four points of the moving axis with a whole amount each, joins them by
//! straight lines and puts out the line, rounded, at every point (*node*, below).
//!
//! ```text
//!            b____.c        a, d   first and last node
//!           /      \        b, c   free, but the reference is one of the four, amount 0
//!      a___/        \d
//! ```
//! The two sides of the reference are problems of their own; nodes of a side are counted outwards.
//! Of one choice of breaks the module `gates` says whether amounts exist that leave less than a
//! limit. A few choices give a first limit. Then every choice, in order, is asked for less than
//! the best so far; only one that has an answer is followed to its own least. Nothing is missed:
//! the answer is the best of all whole amounts, not only of those beside the best fractional ones.

mod chain;
mod gates;
mod sieve;

use self::chain::{Chain, Side, output_between};

use gates::Gates;
use sieve::Sieve;

/// Halving stops here, detection units; the last bit is found by asking for less and less.
const FINE: f64 = 1.0 / 64.0;
/// Choices of breaks that give the first limit.
const SEEDS: usize = 24;
/// Beyond this no table is sought, detection units; keeps rounding noise far below the gates' slack.
const LARGEST: f64 = 1e6;

/// The points of one straightness set.
#[derive(Clone, Debug, PartialEq)]
pub struct FourPoint {
    /// Nodes of the four points, ascending; points of one node have one amount.
    pub nodes: [usize; 4],
    /// Amounts there, detection units.
    pub amounts: [i64; 4],
    /// Largest |output − wanted| over all nodes, detection units.
    pub residual: f64,
}

impl FourPoint {
    /// What the control puts out at a node: the straight line between the two points around it,
    /// rounded half away from zero; held outside the points.
    ///
    /// unit   detection units
    /// source B-63522EN/02 p. 223 (straightness compensation); rounding at every point is taken
    ///        from the emulated control, the manual does not state it
    pub fn output(&self, node: usize) -> i64 {
        let knot = |index: usize| (self.nodes[index], self.amounts[index] as f64);
        match self.nodes.partition_point(|&point| point < node) {
            0 => self.amounts[0],
            4 => self.amounts[3],
            next => whole(output_between(knot(next - 1), knot(next), node)),
        }
    }
}

/// The four points whose rounded output is nearest to the wanted amounts.
///
///   min over nodes and whole amounts of  max_i |round(W(i)) − wanted_i|
///
/// with the straight pieces W through the four points, a half rounded away from zero.
///
/// shape  `wanted[i]` belongs to node i; at least two nodes. First and last node are points, the
///        reference is one of the four, with amount 0, so that W counted from the reference and
///        W itself are the same. Points are distinct; the last is repeated where there are fewer
///        than four nodes or where fewer pieces leave truly less
/// unit   detection units of the compensation axis, fractions allowed in `wanted`
/// sign   that of `wanted`
/// source B-63522EN/02 p. 223 (straightness compensation)
/// limits `wanted[reference]` is 0; amounts stay within ±`amount_max`. `None` for other input,
///        for fewer than two nodes and beyond ±1e6 units. Of equally good points those with the
///        smaller nodes; each side of the reference is as good as its pieces allow. Where more
///        than about 100 units are left, the least is not searched to the last unit
///
/// ```
/// use nonius::write::compensation::four_point::best_fit;
/// let best = best_fit(&[0.0, 2.0, 4.0, 4.0, 4.0, 1.0], 0, 32767).unwrap();
/// assert_eq!(best.nodes, [0, 2, 4, 5]);
/// assert_eq!(best.amounts, [0, 4, 4, 1]);
/// ```
pub fn best_fit(wanted: &[f64], reference: usize, amount_max: u32) -> Option<FourPoint> {
    let at_reference = *wanted.get(reference)?;
    let usable = |amount: &f64| amount.abs() <= LARGEST;
    if wanted.len() < 2 || at_reference.abs() > 0.0 || !wanted.iter().all(usable) {
        return None;
    }
    let left = Side::new(wanted[..=reference].iter().rev(), amount_max, true);
    let right = Side::new(wanted[reference..].iter(), amount_max, false);
    let divided = |pieces: usize| (0..=pieces).rev().map(move |left| (left, pieces - left));
    let mut best: Option<FourPoint> = None;
    for (on_left, on_right) in [3, 2, 1].into_iter().flat_map(divided) {
        let limit = best.as_ref().map_or(f64::INFINITY, |best| best.residual);
        let sides = left.best(on_left, limit).zip(right.best(on_right, limit));
        best = sides.map(|sides| joined(reference, &sides)).or(best);
    }
    best
}

/// Both sides as one set; the last point is repeated until there are four.
fn joined(reference: usize, (left, right): &(Chain, Chain)) -> FourPoint {
    let mut knots: Vec<(usize, f64)> = vec![(reference, 0.0)];
    knots.extend(
        right
            .knots()
            .map(|(node, amount)| (reference + node, amount)),
    );
    knots.splice(
        0..0,
        left.knots()
            .rev()
            .map(|(node, amount)| (reference - node, amount)),
    );
    let knot = |index: usize| knots[index.min(knots.len() - 1)];
    FourPoint {
        nodes: [0, 1, 2, 3].map(|index| knot(index).0),
        amounts: [0, 1, 2, 3].map(|index| whole(knot(index).1)),
        residual: left.residual.max(right.residual),
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "a whole number within the control's amounts"
)]
fn whole(amount: f64) -> i64 {
    amount as i64
}

impl Side {
    fn new<'a>(outwards: impl Iterator<Item = &'a f64>, amount_max: u32, mirrored: bool) -> Side {
        let wanted: Vec<f64> = outwards.copied().collect();
        Side {
            inverse: (0..wanted.len()).map(|k| 1.0 / k as f64).collect(),
            amount_max: f64::from(amount_max),
            wanted,
            mirrored,
        }
    }

    /// The best chain of so many pieces, none of length 0. `None` if they do not fit, if a side
    /// that has nodes is to have no pieces, or if they do not leave less than the limit.
    fn best(&self, pieces: usize, limit: f64) -> Option<Chain> {
        let end = self.wanted.len() - 1;
        if pieces > end || (pieces == 0) != (end == 0) {
            return None;
        }
        if pieces == 0 {
            return Some(Chain {
                ends: Vec::new(),
                amounts: Vec::new(),
                residual: 0.0,
            });
        }
        let all = self.choices(pieces);
        let choices = || all.chunks_exact(pieces);
        let largest = |most: f64, amount: &f64| most.max(amount.abs());
        // No amounts at all leave less than this.
        let limit = limit.min(self.wanted.iter().fold(0.0, largest) + 1.0);
        let sparse = choices().step_by(choices().len() / SEEDS + 1);
        let seed = self.least_of(sparse, limit);
        let limit = seed.as_ref().map_or(limit, |seed| seed.residual.next_up());
        self.least_of(choices(), limit).or(seed)
    }

    /// All ends of so many pieces, choice after choice, the smaller nodes of the table first.
    fn choices(&self, pieces: usize) -> Vec<usize> {
        let end = self.wanted.len() - 1;
        match (pieces, self.mirrored) {
            (1, _) => vec![end],
            (2, false) => (1..end).flat_map(|b| [b, end]).collect(),
            (2, true) => (1..end).rev().flat_map(|b| [b, end]).collect(),
            (_, false) => {
                let after = |b| (b + 1..end).flat_map(move |c| [b, c, end]);
                (1..end).flat_map(after).collect()
            }
            (_, true) => {
                let before = |c| (1..c).rev().flat_map(move |b| [b, c, end]);
                (1..end).rev().flat_map(before).collect()
            }
        }
    }

    /// The first of the best choices, if it leaves less than `limit`.
    fn least_of<'c>(
        &self,
        choices: impl Iterator<Item = &'c [usize]>,
        limit: f64,
    ) -> Option<Chain> {
        let mut best = None;
        let mut sieve = Sieve::new(Gates::new(self, limit)?);
        for ends in choices {
            let Some(chain) = sieve.solve(ends) else {
                continue;
            };
            let chain = self.improved(chain);
            let gates = Gates::new(self, chain.residual);
            best = Some(chain);
            match gates {
                Some(gates) => sieve = sieve.tightened(gates),
                None => break,
            }
        }
        best
    }

    /// The best amounts for the breaks of a chain.
    fn improved(&self, mut chain: Chain) -> Chain {
        let below = |limit: f64, ends: &[usize]| Gates::new(self, limit)?.solve(ends);
        let mut refuted = 0.0;
        while chain.residual - refuted > FINE {
            let limit = f64::midpoint(chain.residual, refuted);
            match below(limit, &chain.ends) {
                Some(better) => chain = better,
                None => refuted = limit,
            }
        }
        while let Some(better) = below(chain.residual, &chain.ends) {
            chain = better;
        }
        chain
    }
}

#[cfg(test)]
mod tests;
