//! Refuses most choices of two breaks at a glance.
//!
//! ```text
//!   reference ── inward ──> b ──── one line? ────> c <── outward ── end
//! ```
//! What the first piece allows at b and what the last one allows at c is the same for all choices
//! with this b or c, so it is found once for a limit and kept. Only where a line leads from one to
//! the other are whole amounts sought.

use super::Chain;
use super::gates::{Gates, SLACK, Span};

/// Intervals of a sieve are found anew when the limit has come down to this part of theirs.
const WORTH_IT: f64 = 0.9;

/// The amounts of a break that one of its two outer pieces allows.
#[derive(Clone, Copy)]
struct Reach {
    span: Option<Span>,
    /// The ends are whole amounts that work, not only fractional ones.
    is_whole: bool,
}

/// The gates, and what they allow at each node.
pub(super) struct Sieve<'a> {
    gates: Gates<'a>,
    /// The limit for which the reaches were found; those of a higher one are merely wider.
    limit: f64,
    /// Amounts of a node that one piece from the reference allows.
    inward: Vec<Reach>,
    /// Amounts of a node that one piece to the end allows.
    outward: Vec<Reach>,
}

impl<'a> Sieve<'a> {
    pub(super) fn new(gates: Gates<'a>) -> Sieve<'a> {
        let end = gates.side.wanted.len() - 1;
        let inward = |node| gates.reachable((0, 0.0), node, gates.at(node));
        let outward = |node| gates.passable((node, end), gates.at(node), gates.at(end));
        // The reference itself is no break; it only keeps the numbering.
        let all = |span: &dyn Fn(usize) -> Option<Span>| -> Vec<Reach> {
            let spans = [None].into_iter().chain((1..end).map(span));
            let fractional = |span| Reach {
                span,
                is_whole: false,
            };
            spans.map(fractional).collect()
        };
        Sieve {
            limit: gates.limit,
            inward: all(&inward),
            outward: all(&outward),
            gates,
        }
    }

    /// The sieve for a lower limit.
    pub(super) fn tightened(self, gates: Gates<'a>) -> Sieve<'a> {
        if gates.limit < WORTH_IT * self.limit {
            return Sieve::new(gates);
        }
        Sieve { gates, ..self }
    }

    /// [`Gates::solve`], most refusals at less expense.
    pub(super) fn solve(&mut self, ends: &[usize]) -> Option<Chain> {
        match *ends {
            [b, c, end] => {
                self.joined(b, c)?;
                self.make_whole(b, c, end);
                let (inner, outer) = self.joined(b, c)?;
                let spans = vec![inner, outer, self.gates.at(end)];
                self.gates.solve_within(ends, spans)
            }
            [b, _] if !self.inward[b].span?.meets(self.outward[b].span?) => None,
            _ => self.gates.solve(ends),
        }
    }

    /// What the outer pieces allow, if a line leads from one to the other.
    fn joined(&self, b: usize, c: usize) -> Option<(Span, Span)> {
        let (inner, outer) = (self.inward[b].span?, self.outward[c].span?);
        let most = inner.high - inner.low + SLACK;
        let line = self.gates.advance((b, inner.low), 1.0, (c, outer), most);
        line.map(|_| (inner, outer))
    }

    /// Narrows the two reaches to whole amounts, once.
    fn make_whole(&mut self, b: usize, c: usize, end: usize) {
        let gates = &self.gates;
        let narrow = |reach: &mut Reach, works: &dyn Fn(f64) -> bool| {
            if !reach.is_whole {
                reach.span = reach.span.and_then(|span| span.between_whole(works));
                reach.is_whole = true;
            }
        };
        let last = [(end, gates.at(end))];
        narrow(&mut self.inward[b], &|amount| {
            gates.keeps((0, 0.0), (b, amount))
        });
        narrow(&mut self.outward[c], &|amount| {
            gates.place(&last, &mut vec![(c, amount)])
        });
    }
}
