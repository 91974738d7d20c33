//! Whole amounts at given breaks that leave less than a limit.
//!
//! Less than the limit is left at a node if the rounded line is one of a few whole numbers there,
//! so the line itself has to pass a *gate*, half a unit wider than these at both ends.
//!
//! * **Back.** From the outermost piece inwards: the interval of amounts at the inner end of a
//!   piece from which the interval at its outer end can be reached. How far the gates between
//!   contradict each other, as slopes, is convex in the inner amount; Newton's steps along the
//!   binding pair find both ends of the interval.
//! * **Forth.** From the reference outwards whole amounts of the intervals are tried, nearest to
//!   the wanted ones first, each piece checked by the rounding itself.
//!
//! Gates are a trifle too wide, so that rounding noise never refuses an answer; the check of each
//! piece decides.

use super::{Chain, Side, output_between};

/// Added to a gate at both ends, detection units.
pub(super) const SLACK: f64 = 1e-6;
/// Newton steps for one end of an interval; finite by theory, about three in practice. An
/// interval that needs more stays too wide, which costs time only.
const STEPS: usize = 60;

/// Whole amounts tried at one break, nearest to the wanted first. All of an interval where less
/// than half as many units are left; beyond, where no table is of use, this bounds the time.
const TRIES: usize = 256;

/// A node and the amount there, detection units.
pub(super) type Knot = (usize, f64);

/// From the lowest to the highest admissible amount.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Span {
    fn or_none(self) -> Option<Span> {
        (self.low <= self.high + SLACK).then_some(self)
    }

    pub(super) fn meets(self, other: Span) -> bool {
        self.low.max(other.low) <= self.high.min(other.high) + SLACK
    }

    /// From the first to the last whole number that works; long intervals stay as they are.
    pub(super) fn between_whole(self, works: impl Fn(f64) -> bool) -> Option<Span> {
        let first = (self.low - SLACK).ceil();
        let nth = |offset: usize| first + offset as f64;
        let count = (0..=TRIES)
            .take_while(|&offset| nth(offset) <= self.high + SLACK)
            .count();
        if count > TRIES {
            return Some(self);
        }
        let low = (0..count).map(nth).find(|&amount| works(amount))?;
        let high = (0..count).rev().map(nth).find(|&amount| works(amount))?;
        Some(Span { low, high })
    }

    /// The whole numbers, from the one nearest to `wanted` outwards.
    fn whole_numbers(self, wanted: f64) -> impl Iterator<Item = f64> {
        let (first, last) = ((self.low - SLACK).ceil(), (self.high + SLACK).floor());
        let nearest = wanted.round().min(last).max(first);
        let sense = (wanted - nearest).signum();
        let zigzag = |&offset: &f64| Some(if offset > 0.0 { -offset } else { 1.0 - offset });
        std::iter::successors(Some(0.0), zigzag)
            .take_while(move |offset: &f64| offset.abs() <= last - first)
            .map(move |offset| nearest + sense * offset)
            .filter(move |&amount| first <= amount && amount <= last)
            .take(TRIES)
    }
}

/// Gates looked at together, so that the loop over them becomes vector instructions.
const LANES: usize = 4;

/// The gates of a side for residuals below a limit.
pub(super) struct Gates<'a> {
    pub(super) side: &'a Side,
    pub(super) limit: f64,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl<'a> Gates<'a> {
    /// `None` if somewhere no whole number is near enough.
    pub(super) fn new(side: &'a Side, limit: f64) -> Option<Gates<'a>> {
        let count = side.wanted.len();
        let (mut low, mut high) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for &wanted in &side.wanted {
            let (first, last) = near(wanted, limit)?;
            low.push(first - 0.5 - SLACK);
            high.push(last + 0.5 + SLACK);
        }
        Some(Gates {
            side,
            limit,
            low,
            high,
        })
    }

    /// Whole amounts at the ends of the pieces, if there are any.
    pub(super) fn solve(&self, ends: &[usize]) -> Option<Chain> {
        self.solve_within(ends, ends.iter().map(|&end| self.at(end)).collect())
    }

    /// [`Gates::solve`] with amounts in these intervals, one for each end.
    pub(super) fn solve_within(&self, ends: &[usize], mut spans: Vec<Span>) -> Option<Chain> {
        for inner in (0..ends.len() - 1).rev() {
            let piece = (ends[inner], ends[inner + 1]);
            spans[inner] = self.passable(piece, spans[inner], spans[inner + 1])?;
        }
        let pieces: Vec<(usize, Span)> = ends.iter().copied().zip(spans).collect();
        let mut knots = vec![(0, 0.0)];
        self.place(&pieces, &mut knots).then(|| Chain {
            ends: ends.to_vec(),
            amounts: knots[1..].iter().map(|knot| knot.1).collect(),
            residual: self.residual(&knots),
        })
    }

    /// Appends the ends of the pieces to the knots, if there are whole amounts for all of them.
    pub(super) fn place(&self, pieces: &[(usize, Span)], knots: &mut Vec<Knot>) -> bool {
        let Some((&(end, span), outer)) = pieces.split_first() else {
            return true;
        };
        let from = knots[knots.len() - 1];
        let Some(span) = self.reachable(from, end, span) else {
            return false;
        };
        for amount in span.whole_numbers(self.side.wanted[end]) {
            if self.keeps(from, (end, amount)) {
                knots.push((end, amount));
                if self.place(outer, knots) {
                    return true;
                }
                knots.pop();
            }
        }
        false
    }

    pub(super) fn keeps(&self, inner: Knot, outer: Knot) -> bool {
        (inner.0..=outer.0).all(|node| self.left_at(node, inner, outer) < self.limit)
    }

    fn residual(&self, knots: &[Knot]) -> f64 {
        let left = |piece: &[Knot]| {
            let (inner, outer) = (piece[0], piece[1]);
            (inner.0..=outer.0).fold(0.0, |most: f64, node| {
                most.max(self.left_at(node, inner, outer))
            })
        };
        knots.windows(2).map(left).fold(0.0, f64::max)
    }

    fn left_at(&self, node: usize, inner: Knot, outer: Knot) -> f64 {
        (output_between(inner, outer, node) - self.side.wanted[node]).abs()
    }

    /// Amounts that a point at this node may have.
    pub(super) fn at(&self, node: usize) -> Span {
        let most = self.side.amount_max;
        Span {
            low: (self.low[node] + 0.5).max(-most),
            high: (self.high[node] - 0.5).min(most),
        }
    }

    /// Least and greatest slope of lines from an amount at a node through the gates into `outer`.
    fn cone(&self, from: Knot, to: usize, outer: Span) -> Span {
        let (node, amount) = from;
        let last = self.side.inverse[to - node];
        let mut least = [(outer.low - amount) * last; LANES];
        let mut greatest = [(outer.high - amount) * last; LANES];
        let mut bind = |lane: usize, low: f64, high: f64, inverse: f64| {
            let (low, high) = ((low - amount) * inverse, (high - amount) * inverse);
            least[lane] = if low > least[lane] { low } else { least[lane] };
            greatest[lane] = if high < greatest[lane] {
                high
            } else {
                greatest[lane]
            };
        };
        let (lows, lows_left) = self.low[node + 1..to].as_chunks::<LANES>();
        let (highs, highs_left) = self.high[node + 1..to].as_chunks::<LANES>();
        let (inverses, _) = self.side.inverse[1..].as_chunks::<LANES>();
        for ((low, high), inverse) in lows.iter().zip(highs).zip(inverses) {
            (0..LANES).for_each(|lane| bind(lane, low[lane], high[lane], inverse[lane]));
        }
        let left = lows_left.iter().zip(highs_left);
        for ((&low, &high), &inverse) in left.zip(&self.side.inverse[1 + LANES * lows.len()..]) {
            bind(0, low, high, inverse);
        }
        Span {
            low: least.into_iter().fold(f64::NEG_INFINITY, f64::max),
            high: greatest.into_iter().fold(f64::INFINITY, f64::min),
        }
    }

    /// How fast the gates of an empty cone come to agree as its amount rises.
    fn closing(&self, from: Knot, outer: (usize, Span), cone: Span) -> f64 {
        let (node, amount) = from;
        let last = self.side.inverse[outer.0 - node];
        let binding = |gates: &[f64], binds: &dyn Fn(f64) -> bool| {
            let slope = |(&gate, &inverse): (&f64, &f64)| {
                binds((gate - amount) * inverse).then_some(inverse)
            };
            gates[node + 1..outer.0]
                .iter()
                .zip(&self.side.inverse[1..])
                .find_map(slope)
        };
        let low = binding(&self.low, &|slope| slope >= cone.low);
        let high = binding(&self.high, &|slope| slope <= cone.high);
        low.unwrap_or(last) - high.unwrap_or(last)
    }

    /// The part of `outer` at node `to` that can be reached from an amount at a node.
    pub(super) fn reachable(&self, from: Knot, to: usize, outer: Span) -> Option<Span> {
        let slopes = self.cone(from, to, outer);
        let length = (to - from.0) as f64;
        let low = from.1 + slopes.low * length;
        let high = from.1 + slopes.high * length;
        Span { low, high }.or_none()
    }

    /// The part of `inner` at one end of a piece from which `outer` at its other can be reached.
    pub(super) fn passable(&self, piece: (usize, usize), inner: Span, outer: Span) -> Option<Span> {
        let most = inner.high - inner.low + SLACK;
        let outer = (piece.1, outer);
        let low = inner.low + self.advance((piece.0, inner.low), 1.0, outer, most)?;
        let high = inner.high - self.advance((piece.0, inner.high), -1.0, outer, most)?;
        Span { low, high }.or_none()
    }

    /// How far an inner amount has to move, upwards or downwards, until the gates agree; `None`
    /// if they never do, or not before `most`.
    pub(super) fn advance(
        &self,
        start: Knot,
        sense: f64,
        outer: (usize, Span),
        most: f64,
    ) -> Option<f64> {
        let mut moved = 0.0;
        for _ in 0..STEPS {
            let from = (start.0, start.1 + sense * moved);
            let cone = self.cone(from, outer.0, outer.1);
            let gap = cone.low - cone.high;
            if gap <= 0.0 {
                break;
            }
            let closing = sense * self.closing(from, outer, cone);
            moved += gap / closing;
            if closing <= 0.0 || moved > most {
                return None;
            }
        }
        Some(moved)
    }
}

/// The lowest and the highest whole number nearer than `limit`, to the last bit of the distance.
fn near(wanted: f64, limit: f64) -> Option<(f64, f64)> {
    let is_near = |amount: f64| (amount - wanted).abs() < limit;
    // Rounding of the sum may lose one; one to spare on each side.
    let (from, to) = ((wanted - limit).floor(), (wanted + limit).ceil());
    let first = [from, from + 1.0, from + 2.0]
        .into_iter()
        .find(|&amount| is_near(amount))?;
    let last = [to, to - 1.0, to - 2.0]
        .into_iter()
        .find(|&amount| is_near(amount))?;
    Some((first, last))
}
