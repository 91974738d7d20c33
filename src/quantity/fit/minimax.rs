//! The table whose largest distance from the curve is as small as it can be.
//!
//! The nodes are given, the value at the reference is 0, so the two sides of the reference are
//! problems of their own: find the smallest tolerance t and values v₁ … v_m, counted outwards from
//! v₀ = 0, with |d(x) − line(x)| ≤ t everywhere.
//!
//! * **A tolerance, checked.** At the places u (0 … 1) of section k, t demands
//!   d − t ≤ (1−u)·v_k−1 + u·v_k ≤ d + t. From the interval of admissible v_k−1 this gives the
//!   interval of admissible v_k, starting with {0}; an empty interval refutes t. Only the upper
//!   convex hull of the places can bind from below and the lower hull from above.
//! * **The smallest tolerance.** Lower bounds are maxima and upper bounds minima of functions
//!   affine in t, so the amount by which an interval is empty is convex in t. Newton's step along
//!   the binding pair never passes the answer and reaches it in finitely many steps.
//! * **Every place of the curve.** The places start as section ends, knots and stationary points
//!   against the chord. Where the table found so breaks t, exactly computed, the place is added
//!   (exchange, as in the second algorithm of Remez). Each t is the best for a *part* of the
//!   demands, hence a lower bound of the answer; when nothing breaks it any more it is the answer.
//! * **The choice.** Admissible intervals usually leave room. From the outermost node inwards
//!   each value is taken as near to the sampled one as the interval allows.
//!
//! Best approximation by splines with fixed knots: G. Nürnberger, *Approximation by Spline
//! Functions*, Springer 1989. The tests certify t by the dual of the linear program.
//!
//! Limits: t governs the worst section of a side only; elsewhere the table keeps to t and to the
//! sampled values, and is not best section by section. A linear curve needs no exchange.

use crate::quantity::curve::ErrorCurve;
use crate::quantity::fit::Nodes;

/// Exchange rounds; convergence is quadratic and four are usual. A side that needs more keeps
/// the best values it has seen.
const ROUNDS: usize = 40;
/// Newton steps for one tolerance; finite by theory, about five in practice.
const STEPS: usize = 200;
/// A residual this much above t, relatively or in µm, still counts as t.
const RELATIVE_SLACK: f64 = 1e-10;
/// See [`RELATIVE_SLACK`]; far below a control's last digit, above rounding noise.
const ABSOLUTE_SLACK_UM: f64 = 1e-12;
/// Places nearer than this part of a section are one place.
const SAME_PART: f64 = 1e-12;

/// Minimax values; `sampled` are the curve's values at the nodes, 0 at the reference.
pub(super) fn values(curve: &ErrorCurve, nodes: &Nodes, mut sampled: Vec<f64>) -> Vec<f64> {
    let reference = nodes.reference_node;
    let left: Vec<usize> = (0..=reference).rev().collect();
    let right: Vec<usize> = (reference..nodes.count).collect();
    for outwards in [left, right] {
        let mut side = Side::new(curve, nodes, &outwards, &sampled);
        for (&node, value) in outwards.iter().zip(side.best()) {
            sampled[node] = value;
        }
    }
    sampled
}

/// A place of a section: `along` from 0 (inner node) to 1 (outer node), value in µm.
#[derive(Clone, Copy)]
struct Point {
    along: f64,
    um: f64,
}

/// A bound as a function of the tolerance, at the present tolerance: value and derivative.
#[derive(Clone, Copy)]
struct Bound {
    um: f64,
    per_tolerance: f64,
}

/// Admissible values of a node.
#[derive(Clone, Copy)]
struct Interval {
    low: Bound,
    high: Bound,
}

impl Interval {
    const ZERO: Interval = {
        let zero = Bound { um: 0.0, per_tolerance: 0.0 };
        Interval { low: zero, high: zero }
    };
}

/// From one node to the next one outwards, with the places that bind.
struct Section {
    inner_mm: f64,
    outer_mm: f64,
    /// Upper hull: the line stays above these minus t.
    floor: Vec<Point>,
    /// Lower hull: the line stays below these plus t.
    ceiling: Vec<Point>,
}

impl Section {
    fn new(curve: &ErrorCurve, inner_mm: f64, outer_mm: f64) -> Section {
        let (floor, ceiling) = (Vec::with_capacity(8), Vec::with_capacity(8));
        let mut section = Section { inner_mm, outer_mm, floor, ceiling };
        let rise = curve.um_at(outer_mm) - curve.um_at(inner_mm);
        let mut places = Vec::with_capacity(8);
        section.visit(curve, rise, |point| places.push(point));
        for point in places {
            section.demand(point);
        }
        section
    }

    /// Every place where the curve can be farthest from a line of this rise.
    fn visit(&self, curve: &ErrorCurve, rise: f64, mut visit: impl FnMut(Point)) {
        let width = self.outer_mm - self.inner_mm;
        let (from, to) = (self.inner_mm.min(self.outer_mm), self.inner_mm.max(self.outer_mm));
        curve.visit_candidates(from, to, -rise / width, |x, um| {
            visit(Point { along: (x - self.inner_mm) / width, um });
        });
    }

    /// Adds a place; false if it says nothing new.
    fn demand(&mut self, point: Point) -> bool {
        let floor = insert(&mut self.floor, point, 1.0);
        let ceiling = insert(&mut self.ceiling, point, -1.0);
        floor || ceiling
    }

    /// The part of the inner interval from which the section can be crossed within `t`, or by
    /// how much `t` must grow at least.
    ///
    /// A place i above and a place j below bound the inner value by the line through
    /// (u_i, d_i − t) and (u_j, d_j + t), followed back to u = 0.
    fn passable(&self, t: f64, inner: Interval) -> Result<Interval, f64> {
        let Interval { mut low, mut high } = inner;
        for i in &self.floor {
            for j in &self.ceiling {
                let gap = j.along - i.along;
                if gap.abs() < SAME_PART {
                    continue;
                }
                let um = (j.along * (i.um - t) - i.along * (j.um + t)) / gap;
                let per_tolerance = -(i.along + j.along) / gap;
                let bound = Bound { um, per_tolerance };
                if gap > 0.0 && um > low.um {
                    low = bound;
                } else if gap < 0.0 && um < high.um {
                    high = bound;
                }
            }
        }
        if low.um > high.um {
            return Err((low.um - high.um) / (high.per_tolerance - low.per_tolerance));
        }
        Ok(Interval { low, high })
    }

    /// The admissible values of the outer node when the inner one may be anywhere in `inner`.
    fn crossed(&self, t: f64, inner: Interval) -> Interval {
        let across = |point: &Point, t_sign: f64, from: Bound| Bound {
            um: (point.um + t_sign * t - (1.0 - point.along) * from.um) / point.along,
            per_tolerance: (t_sign - (1.0 - point.along) * from.per_tolerance) / point.along,
        };
        let beyond = |point: &&Point| point.along > SAME_PART;
        let lows = self.floor.iter().filter(beyond);
        let highs = self.ceiling.iter().filter(beyond);
        let low = lows.map(|point| across(point, -1.0, inner.high));
        let high = highs.map(|point| across(point, 1.0, inner.low));
        Interval {
            low: low.fold(UNBOUNDED.low, |one, two| if two.um > one.um { two } else { one }),
            high: high.fold(UNBOUNDED.high, |one, two| if two.um < one.um { two } else { one }),
        }
    }

    /// The lowest and highest inner value when the outer one is `outer`.
    fn inner_range(&self, t: f64, outer: f64) -> (f64, f64) {
        let back =
            |point: &Point, t: f64| (point.um + t - point.along * outer) / (1.0 - point.along);
        let before = |point: &&Point| point.along < 1.0 - SAME_PART;
        let lows = self.floor.iter().filter(before).map(|point| back(point, -t));
        let highs = self.ceiling.iter().filter(before).map(|point| back(point, t));
        (lows.fold(f64::NEG_INFINITY, f64::max), highs.fold(f64::INFINITY, f64::min))
    }
}

const UNBOUNDED: Interval = Interval {
    low: Bound { um: f64::NEG_INFINITY, per_tolerance: 0.0 },
    high: Bound { um: f64::INFINITY, per_tolerance: 0.0 },
};

/// Puts a point into a hull: upper for `side` = 1, lower for −1; false if it lies inside.
fn insert(hull: &mut Vec<Point>, point: Point, side: f64) -> bool {
    let inside = |a: &Point, b: &Point, c: &Point| {
        let (first, second) = (b.along - a.along, c.along - a.along);
        side * ((b.um - a.um) * second - (c.um - a.um) * first) <= 0.0
    };
    let at = hull.partition_point(|other| other.along < point.along);
    let near = |other: Option<&Point>| {
        other.is_some_and(|other| (other.along - point.along).abs() < SAME_PART)
    };
    if near(hull.get(at)) || at > 0 && near(hull.get(at - 1)) {
        return false;
    }
    if at > 0 && at < hull.len() && inside(&hull[at - 1], &point, &hull[at]) {
        return false;
    }
    hull.insert(at, point);
    while at + 2 < hull.len() && inside(&hull[at], &hull[at + 1], &hull[at + 2]) {
        hull.remove(at + 1);
    }
    let mut at = at;
    while at >= 2 && inside(&hull[at - 2], &hull[at - 1], &hull[at]) {
        hull.remove(at - 1);
        at -= 1;
    }
    true
}

/// One side of the reference, nodes counted outwards.
struct Side<'a> {
    curve: &'a ErrorCurve,
    sections: Vec<Section>,
    sampled: Vec<f64>,
    /// Admissible values of each node from which the next one can be reached.
    reached: Vec<Interval>,
}

impl<'a> Side<'a> {
    fn new(curve: &'a ErrorCurve, nodes: &Nodes, outwards: &[usize], sampled: &[f64]) -> Self {
        let place = |node| nodes.position(node).mm();
        let pairs = outwards.windows(2);
        Side {
            curve,
            sections: pairs
                .map(|pair| Section::new(curve, place(pair[0]), place(pair[1])))
                .collect(),
            sampled: outwards.iter().map(|&node| sampled[node]).collect(),
            reached: Vec::with_capacity(outwards.len()),
        }
    }

    /// The best values, or the sampled ones if they are as good.
    fn best(&mut self) -> Vec<f64> {
        let sampled = self.sampled.clone();
        let (by_sampling, _) = self.exchange(&sampled, f64::INFINITY);
        let (mut best, mut least) = (Vec::new(), f64::INFINITY);
        let mut tolerance = 0.0;
        for _ in 0..ROUNDS {
            tolerance = self.smallest_tolerance(tolerance);
            let values = self.choice(tolerance);
            let (largest, added) = self.exchange(&values, tolerance);
            if !added || largest < least {
                (best, least) = (values, largest);
            }
            if !added {
                break;
            }
        }
        let as_good = by_sampling <= with_slack(least);
        if as_good { sampled } else { best }
    }

    /// The least t not below `from` that meets all demands so far, by Newton's method; leaves the
    /// intervals of that t behind.
    fn smallest_tolerance(&mut self, from: f64) -> f64 {
        let mut tolerance = from;
        // Where rounding alone keeps an interval empty, the steps are noise; they then double.
        let mut nudge = 4.0 * f64::EPSILON;
        for _ in 0..STEPS {
            let Err(raise) = self.propagate(tolerance) else {
                break;
            };
            if tolerance + raise <= with_slack(tolerance) {
                nudge *= 2.0;
            }
            let least = nudge * (tolerance + ABSOLUTE_SLACK_UM);
            tolerance += raise.max(least);
        }
        tolerance
    }

    fn propagate(&mut self, tolerance: f64) -> Result<(), f64> {
        self.reached.clear();
        let mut interval = Interval::ZERO;
        for section in &self.sections {
            let passable = section.passable(tolerance, interval)?;
            self.reached.push(passable);
            interval = section.crossed(tolerance, passable);
        }
        self.reached.push(interval);
        Ok(())
    }

    /// Values that meet all demands, as near to the sampled ones as possible from outside in.
    fn choice(&self, tolerance: f64) -> Vec<f64> {
        let mut values = self.sampled.clone();
        let mut allowed = (f64::NEG_INFINITY, f64::INFINITY);
        for node in (0..values.len()).rev() {
            if let Some(reached) = self.reached.get(node) {
                allowed = (allowed.0.max(reached.low.um), allowed.1.min(reached.high.um));
            }
            values[node] = nearest(values[node], allowed);
            if node > 0 {
                allowed = self.sections[node - 1].inner_range(tolerance, values[node]);
            }
        }
        values[0] = 0.0;
        values
    }

    /// The exact largest residual of the values, and whether places beyond t were added.
    fn exchange(&mut self, values: &[f64], tolerance: f64) -> (f64, bool) {
        let limit = with_slack(tolerance);
        let (mut largest, mut added) = (0.0_f64, false);
        let mut beyond = Vec::new();
        for (section, ends) in self.sections.iter_mut().zip(values.windows(2)) {
            section.visit(self.curve, ends[1] - ends[0], |point| {
                let line = (1.0 - point.along) * ends[0] + point.along * ends[1];
                let residual = (point.um - line).abs();
                largest = largest.max(residual);
                if residual > limit {
                    beyond.push(point);
                }
            });
            for point in beyond.drain(..) {
                added |= section.demand(point);
            }
        }
        (largest, added)
    }
}

/// What still counts as the tolerance.
fn with_slack(tolerance: f64) -> f64 {
    tolerance * (1.0 + RELATIVE_SLACK) + ABSOLUTE_SLACK_UM
}

/// The allowed value nearest to `wanted`; the middle where rounding left nothing between.
fn nearest(wanted: f64, (low, high): (f64, f64)) -> f64 {
    if low > high {
        return (low + high) / 2.0;
    }
    wanted.max(low).min(high)
}
