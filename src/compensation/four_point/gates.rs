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
const SLACK: f64 = 1e-6;
/// Newton steps for one end of an interval; finite by theory, about three in practice. An
/// interval that needs more stays too wide, which costs time only.
const STEPS: usize = 60;

/// A node and the amount there, detection units.
type Knot = (usize, f64);

/// From the lowest to the highest admissible amount.
#[derive(Clone, Copy)]
struct Span {
    low: f64,
    high: f64,
}

impl Span {
    fn or_none(self) -> Option<Span> {
        (self.low <= self.high + SLACK).then_some(self)
    }

    fn meets(self, other: Span) -> bool {
        self.low.max(other.low) <= self.high.min(other.high) + SLACK
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
    }
}

/// The steepest or flattest slope that a gate allows, and how it falls as the inner amount rises.
#[derive(Clone, Copy)]
struct Bound {
    slope: f64,
    inverse: f64,
}

/// The gates of a side for residuals below a limit.
pub(super) struct Gates<'a> {
    side: &'a Side,
    limit: f64,
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
        let mut spans: Vec<Span> = ends.iter().map(|&end| self.at(end)).collect();
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
    fn place(&self, pieces: &[(usize, Span)], knots: &mut Vec<Knot>) -> bool {
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

    fn keeps(&self, inner: Knot, outer: Knot) -> bool {
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
    fn at(&self, node: usize) -> Span {
        let most = self.side.amount_max;
        Span {
            low: (self.low[node] + 0.5).max(-most),
            high: (self.high[node] - 0.5).min(most),
        }
    }

    /// Least and greatest slope of lines from an amount at a node through the gates into `outer`.
    fn cone(&self, from: Knot, to: usize, outer: Span) -> (Bound, Bound) {
        let bound = |at: f64, inverse: f64| Bound {
            slope: (at - from.1) * inverse,
            inverse,
        };
        let inverse = self.side.inverse[to - from.0];
        let (mut least, mut greatest) = (bound(outer.low, inverse), bound(outer.high, inverse));
        let between = from.0 + 1..to;
        let gates = self.low[between.clone()].iter().zip(&self.high[between]);
        for ((&low, &high), &inverse) in gates.zip(&self.side.inverse[1..]) {
            let (low, high) = (bound(low, inverse), bound(high, inverse));
            if low.slope > least.slope {
                least = low;
            }
            if high.slope < greatest.slope {
                greatest = high;
            }
        }
        (least, greatest)
    }

    /// The part of `outer` at node `to` that can be reached from an amount at a node.
    fn reachable(&self, from: Knot, to: usize, outer: Span) -> Option<Span> {
        let (least, greatest) = self.cone(from, to, outer);
        let length = (to - from.0) as f64;
        let low = from.1 + least.slope * length;
        let high = from.1 + greatest.slope * length;
        Span { low, high }.or_none()
    }

    /// The part of `inner` at one end of a piece from which `outer` at its other can be reached.
    fn passable(&self, piece: (usize, usize), inner: Span, outer: Span) -> Option<Span> {
        let most = inner.high - inner.low + SLACK;
        let advance = |start: f64, sense: f64| {
            let moved = self.advance((piece.0, start), sense, (piece.1, outer))?;
            (moved <= most).then_some(start + sense * moved)
        };
        let low = advance(inner.low, 1.0)?;
        let high = advance(inner.high, -1.0)?;
        Span { low, high }.or_none()
    }

    /// How far an inner amount has to move, upwards or downwards, until the gates agree.
    fn advance(&self, start: Knot, sense: f64, outer: (usize, Span)) -> Option<f64> {
        let mut moved = 0.0;
        for _ in 0..STEPS {
            let from = (start.0, start.1 + sense * moved);
            let (least, greatest) = self.cone(from, outer.0, outer.1);
            let gap = least.slope - greatest.slope;
            if gap <= 0.0 {
                break;
            }
            let closing = sense * (least.inverse - greatest.inverse);
            if closing <= 0.0 {
                return None;
            }
            moved += gap / closing;
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

/// The gates, and what refuses most choices of breaks at a glance.
pub(super) struct Sieve<'a> {
    gates: Gates<'a>,
    /// Amounts of a node that can be reached from the reference in one piece.
    from_reference: Vec<Option<Span>>,
    /// Amounts of a node from which the end can be reached in one piece.
    to_end: Vec<Option<Span>>,
}

impl<'a> Sieve<'a> {
    pub(super) fn new(gates: Gates<'a>) -> Sieve<'a> {
        let end = gates.side.wanted.len() - 1;
        let inward = |node| gates.reachable((0, 0.0), node, gates.at(node));
        let outward = |node| gates.passable((node, end), gates.at(node), gates.at(end));
        // The reference itself is no break; it only keeps the numbering.
        Sieve {
            from_reference: [None].into_iter().chain((1..end).map(inward)).collect(),
            to_end: [None].into_iter().chain((1..end).map(outward)).collect(),
            gates,
        }
    }

    /// [`Gates::solve`], most refusals at less expense.
    pub(super) fn solve(&self, ends: &[usize]) -> Option<Chain> {
        match *ends {
            [b, c, _] => {
                let (inner, outer) = (self.from_reference[b]?, self.to_end[c]?);
                self.gates.passable((b, c), inner, outer)?;
            }
            [b, _] if !self.from_reference[b]?.meets(self.to_end[b]?) => return None,
            _ => {}
        }
        self.gates.solve(ends)
    }
}
