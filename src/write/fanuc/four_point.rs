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
//! Whether anything leaves less than a limit is decided in three steps: the whole amounts at each
//! node that one piece from the reference reaches, those from which one piece reaches the end, and
//! a piece that joins the two. The limit is halved until nothing leaves less, so the answer is the
//! best of all whole amounts, not only of those beside the best fractional ones.

use crate::write::grid::{as_number, whole};

/// Halving stops here, detection units; the last bit is found by asking for less and less.
const FINE: f64 = 1.0 / 64.0;
/// Beyond this no table is sought, detection units; keeps rounding noise far below the slack.
const LARGEST: f64 = 1e6;
/// By so much a line may miss an amount before it is asked exactly, detection units.
const SLACK: f64 = 1e-6;
/// Whole amounts tried at one node, nearest to the wanted first: all of them where less than half
/// as many units are left; beyond, where no table is of use, this bounds the time.
const TRIES: usize = 256;

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
/// use nonius::write::fanuc::four_point::best_fit;
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
    let amount_max = i64::from(amount_max);
    let outwards = wanted[..=reference].iter().rev().copied().collect();
    let left = Side { wanted: outwards, amount_max, is_mirrored: true };
    let right = Side { wanted: wanted[reference..].to_vec(), amount_max, is_mirrored: false };
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
    let inner = left.knots[1..].iter().rev().map(|(node, amount)| (reference - node, *amount));
    let outer = right.knots.iter().map(|(node, amount)| (reference + node, *amount));
    let knots: Vec<Knot> = inner.chain(outer).collect();
    let knot = |index: usize| knots[index.min(knots.len() - 1)];
    FourPoint {
        nodes: [0, 1, 2, 3].map(|index| knot(index).0),
        amounts: [0, 1, 2, 3].map(|index| knot(index).1),
        residual: left.residual.max(right.residual),
    }
}

/// A node and the amount there, detection units.
type Knot = (usize, i64);

/// What the control puts out at a node from `inner` to `outer`, both included: the straight line, rounded half away
/// from zero. The division comes last: all before it is exact, so a half is met as a half.
///
/// unit   detection units
/// source B-63522EN/02 p. 223 (straightness compensation); rounding at every point is taken
///        from the emulated control, the manual does not state it
fn output_between(inner: Knot, outer: Knot, node: usize) -> f64 {
    let (before, after) = ((node - inner.0) as f64, (outer.0 - node) as f64);
    let sum = as_number(inner.1) * after + as_number(outer.1) * before;
    (sum / (before + after)).round()
}

/// One side of the reference, nodes counted outwards from it.
struct Side {
    wanted: Vec<f64>,
    amount_max: i64,
    /// Outwards is towards node 0 of the table.
    is_mirrored: bool,
}

/// Straight pieces outwards from the reference, and what they leave.
struct Chain {
    knots: Vec<Knot>,
    residual: f64,
}

impl Side {
    /// The best chain of so many pieces, none of length 0. `None` if they do not fit, if a side
    /// that has nodes is to have no pieces, or if they do not leave less than the limit.
    fn best(&self, pieces: usize, limit: f64) -> Option<Chain> {
        let end = self.wanted.len() - 1;
        if pieces > end || (pieces == 0) != (end == 0) {
            return None;
        }
        // No amounts at all leave less than this.
        let largest = self.wanted.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
        let below = |limit: f64| Gates::new(self, limit)?.chain(pieces);
        let most = limit.min(largest + 1.0);
        let (mut refuted, mut limit) = (0.0, most.min(1.0));
        let mut best = loop {
            match below(limit) {
                Some(found) => break found,
                None if limit >= most => return None,
                None => (refuted, limit) = (limit, most.min(2.0 * limit)),
            }
        };
        while best.residual - refuted > FINE {
            let limit = f64::midpoint(best.residual, refuted);
            match below(limit) {
                Some(better) => best = better,
                None => refuted = limit,
            }
        }
        while let Some(better) = below(best.residual) {
            best = better;
        }
        Some(best)
    }
}

/// The whole numbers that the rounded line may be at each node to leave less than a limit.
struct Gates<'a> {
    side: &'a Side,
    limit: f64,
    spans: Vec<(i64, i64)>,
}

impl<'a> Gates<'a> {
    /// `None` if somewhere no whole number is near enough.
    fn new(side: &'a Side, limit: f64) -> Option<Gates<'a>> {
        let near = |wanted: &f64| {
            let is_near = |amount: &i64| (as_number(*amount) - wanted).abs() < limit;
            // Rounding of the sum may lose one; one to spare on each side.
            let (from, to) = (whole((wanted - limit).floor()), whole((wanted + limit).ceil()));
            let first = (from..=from + 2).find(is_near)?;
            Some((first, (to - 2..=to).rev().find(is_near)?))
        };
        let spans: Option<Vec<(i64, i64)>> = side.wanted.iter().map(near).collect();
        Some(Gates { side, limit, spans: spans? })
    }

    /// The first chain of so many pieces, smaller nodes of the table first.
    fn chain(&self, pieces: usize) -> Option<Chain> {
        let mut knots = vec![(0, 0)];
        self.place(&self.ends(pieces)?, &mut knots).then(|| Chain {
            residual: knots.windows(2).map(|p| self.left(p[0], p[1])).fold(0.0, f64::max),
            knots,
        })
    }

    /// Where the pieces end.
    fn ends(&self, pieces: usize) -> Option<Vec<usize>> {
        let end = self.side.wanted.len() - 1;
        if pieces < 2 {
            return Some(vec![end; pieces]);
        }
        let from_reference: Vec<(usize, i64, i64)> = self.reach((0, 0)).collect();
        let works = |node: usize, amount: &i64| self.keeps((0, 0), (node, *amount));
        let inner = from_reference.into_iter().filter(|(node, ..)| *node < end);
        let inner = inner.map(|(node, low, high)| {
            (node, self.amounts(node, low, high).filter(|a| works(node, a)).collect())
        });
        let inner: Vec<(usize, Vec<i64>)> = inner.collect();
        let outer: Vec<Vec<i64>> = (0..end).map(|node| self.reaching_the_end(node)).collect();
        if pieces == 2 {
            let mut nodes = inner
                .iter()
                .filter(|(b, amounts)| amounts.iter().any(|amount| outer[*b].contains(amount)));
            let node = if self.side.is_mirrored { nodes.next_back() } else { nodes.next() };
            return Some(vec![node?.0, end]);
        }
        let (b, c) = self.joined(&inner, &outer)?;
        Some(vec![b, c, end])
    }

    /// The first two nodes that a piece joins: from an amount of `inner` to one of `outer`.
    fn joined(&self, inner: &[(usize, Vec<i64>)], outer: &[Vec<i64>]) -> Option<(usize, usize)> {
        let from = inner.iter().flat_map(|(b, amounts)| amounts.iter().map(|own| (*b, *own)));
        let joined = from.flat_map(|from| {
            let reached = self.reach(from).take_while(|(c, ..)| *c < outer.len());
            let joins = move |(c, low, high): &(usize, i64, i64)| {
                let mut amounts = outer[*c].iter().filter(|own| (low..=high).contains(own));
                amounts.any(|own| self.keeps(from, (*c, *own)))
            };
            reached.filter(joins).map(move |(c, ..)| (from.0, c))
        });
        if self.side.is_mirrored { joined.max_by_key(|(b, c)| (*c, *b)) } else { joined.min() }
    }

    /// Amounts at a node from which one piece reaches the end.
    fn reaching_the_end(&self, node: usize) -> Vec<i64> {
        let end = self.side.wanted.len() - 1;
        let reaches = |amount: &i64| {
            let from = (node, *amount);
            self.reach(from).find(|(to, ..)| *to == end).is_some_and(|(_, low, high)| {
                self.amounts(end, low, high).any(|a| self.keeps(from, (end, a)))
            })
        };
        let (low, high) = self.spans[node];
        self.amounts(node, low, high).filter(reaches).collect()
    }

    /// Appends the ends of the pieces to the knots, if there are whole amounts for all of them.
    fn place(&self, ends: &[usize], knots: &mut Vec<Knot>) -> bool {
        let Some((&end, outer)) = ends.split_first() else {
            return true;
        };
        let from = knots[knots.len() - 1];
        let Some((_, low, high)) = self.reach(from).find(|(node, ..)| *node == end) else {
            return false;
        };
        let kept = |amount: &i64| self.keeps(from, (end, *amount));
        for amount in self.amounts(end, low, high).filter(kept) {
            knots.push((end, amount));
            if self.place(outer, knots) {
                return true;
            }
            knots.pop();
        }
        false
    }

    /// The nodes behind a knot, each with the lowest and the highest amount that a line through the
    /// gates between may have there.
    fn reach(&self, from: Knot) -> impl Iterator<Item = (usize, i64, i64)> + '_ {
        let (mut least, mut greatest) = (f64::NEG_INFINITY, f64::INFINITY);
        let amount = as_number(from.1);
        let behind = self.spans.iter().enumerate().skip(from.0 + 1);
        let spans = behind.map_while(move |(node, &(first, last))| {
            if least > greatest {
                return None;
            }
            let run = (node - from.0) as f64;
            let low = whole((amount + least * run - SLACK).ceil()).max(first);
            let high = whole((amount + greatest * run + SLACK).floor()).min(last);
            least = least.max((as_number(first) - 0.5 - SLACK - amount) / run);
            greatest = greatest.min((as_number(last) + 0.5 + SLACK - amount) / run);
            Some((node, low, high))
        });
        spans.filter(|(_, low, high)| low <= high)
    }

    /// The amounts of a span that the control takes, from the one nearest to the wanted outwards.
    fn amounts(&self, node: usize, low: i64, high: i64) -> impl Iterator<Item = i64> + use<> {
        let wanted = self.side.wanted[node];
        let (low, high) = (low.max(-self.side.amount_max), high.min(self.side.amount_max));
        let nearest = whole(wanted.round()).min(high).max(low);
        let sense = if wanted < as_number(nearest) { -1 } else { 1 };
        let zigzag = |&offset: &i64| Some(if offset > 0 { -offset } else { 1 - offset });
        std::iter::successors(Some(0), zigzag)
            .take_while(move |offset: &i64| offset.abs() <= high - low)
            .map(move |offset| nearest + sense * offset)
            .filter(move |amount| (low..=high).contains(amount))
            .take(TRIES)
    }

    fn keeps(&self, inner: Knot, outer: Knot) -> bool {
        (inner.0..=outer.0).all(|node| self.left_at(node, inner, outer) < self.limit)
    }

    /// What a piece leaves.
    fn left(&self, inner: Knot, outer: Knot) -> f64 {
        (inner.0..=outer.0).map(|node| self.left_at(node, inner, outer)).fold(0.0, f64::max)
    }

    fn left_at(&self, node: usize, inner: Knot, outer: Knot) -> f64 {
        (output_between(inner, outer, node) - self.side.wanted[node]).abs()
    }
}

#[cfg(test)]
mod tests;
