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
//! * **The mirror image.** "At most d + t" for v is "at least −d − t" for −v. So an upper bound is
//!   written as a lower bound of the mirror image; pairs below are of v and of −v.
//! * **The smallest tolerance.** Lower bounds are maxima and upper bounds minima of functions
//!   affine in t, so the amount by which an interval is empty is convex in t. Newton's step along
//!   the binding pair never passes the answer and reaches it in finitely many steps.
//! * **Every place of the curve.** The places start as section ends, knots and stationary points
//!   against the chord, where the sampled table can be worst. Where the table found so breaks t,
//!   exactly computed, the place is added (exchange, as in the second algorithm of Remez). Each t
//!   is the best for a *part* of the demands, hence a lower bound of the answer; when nothing
//!   breaks it any more it is the answer.
//! * **The choice.** Admissible intervals usually leave room. From the outermost node inwards
//!   each value is taken as near to the sampled one as the interval allows.
//!
//! Best approximation by splines with fixed knots: G. Nürnberger, *Approximation by Spline
//! Functions*, Springer 1989. The tests certify t by the dual of the linear program.
//!
//! Limits: t governs the worst section of a side only; elsewhere the table keeps to t and to the
//! sampled values, and is not best section by section. A linear curve needs no exchange.

use crate::quantity::{ErrorCurve, Nodes};

/// Exchange rounds; convergence is quadratic and four are usual. A side that needs more keeps
/// the best values it has seen.
const ROUNDS: usize = 40;
/// A residual this much above t, relatively or in µm, still counts as t.
const RELATIVE_SLACK: f64 = 1e-10;
/// See [`RELATIVE_SLACK`]; far below a control's last digit, above rounding noise.
const ABSOLUTE_SLACK_UM: f64 = 1e-12;
/// Places nearer than this part of a section are one place.
const SAME_PART: f64 = 1e-12;

/// Minimax values, 0 at the reference.
pub(super) fn values(curve: &ErrorCurve, nodes: &Nodes) -> Vec<f64> {
    let reference = nodes.reference_node;
    let left: Vec<usize> = (0..=reference).rev().collect();
    let right: Vec<usize> = (reference..nodes.count).collect();
    let mut values = vec![0.0; nodes.count];
    for outwards in [left, right] {
        let places: Vec<f64> = outwards.iter().map(|&node| nodes.position(node).mm()).collect();
        for (node, value) in outwards.into_iter().zip(best(curve, &places)).skip(1) {
            values[node] = value;
        }
    }
    values
}

/// The best values of one side, or the sampled ones if they are as good. Nodes at `places`, mm,
/// counted outwards from the reference.
fn best(curve: &ErrorCurve, places: &[f64]) -> Vec<f64> {
    let sampled: Vec<f64> = places.iter().map(|&place| curve.um_at(place)).collect();
    let ends = places.windows(2).map(|pair| [pair[0], pair[1]]);
    let mut sections: Vec<Stretch> =
        ends.map(|ends_mm| Stretch { curve, ends_mm, hulls: Default::default() }).collect();
    let (by_sampling, _) = exchange(&mut sections, &sampled, f64::NEG_INFINITY);
    let (mut best, mut least) = (Vec::new(), f64::INFINITY);
    let mut tolerance = 0.0;
    for _ in 0..ROUNDS {
        let reached;
        (tolerance, reached) = smallest_tolerance(&sections, tolerance);
        let values = choice(&sections, &reached, tolerance, &sampled);
        let (largest, added) = exchange(&mut sections, &values, with_slack(tolerance));
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

/// The exact largest residual of the values. Places above the line by more than `limit` become
/// demands, those below it demands on the mirror image; whether they said anything new.
fn exchange(sections: &mut [Stretch], values: &[f64], limit: f64) -> (f64, bool) {
    let (mut largest, mut added) = (0.0_f64, false);
    for (section, ends) in sections.iter_mut().zip(values.windows(2)) {
        let mut beyond = [Vec::new(), Vec::new()];
        section.visit(ends[1] - ends[0], |parts, um| {
            let above = um - (parts[0] * ends[0] + parts[1] * ends[1]);
            largest = largest.max(above.abs());
            if above > limit {
                beyond[0].push(PlaceOnCurve { parts, um });
            }
            if -above > limit {
                beyond[1].push(PlaceOnCurve { parts, um: -um });
            }
        });
        for (hull, places) in section.hulls.iter_mut().zip(beyond) {
            added |= !places.is_empty() && widen(hull, places);
        }
    }
    (largest, added)
}

/// The least t not below `from` that meets all demands so far, and the bounds of the nodes under
/// it, by Newton's method: finite, about five steps are usual.
fn smallest_tolerance(sections: &[Stretch], from: f64) -> (f64, Vec<Bounds>) {
    let mut tolerance = from;
    // Where rounding alone keeps an interval empty, the steps are noise; they then double.
    let mut nudge = 4.0 * f64::EPSILON;
    loop {
        let raise = match propagate(sections, tolerance) {
            Ok(reached) => return (tolerance, reached),
            Err(raise) => raise,
        };
        if tolerance + raise <= with_slack(tolerance) {
            nudge *= 2.0;
        }
        tolerance += raise.max(nudge * (tolerance + ABSOLUTE_SLACK_UM));
    }
}

/// The bounds of every node, from inside out, between which the section behind it can be crossed
/// under `t`; or by how much t must grow at least.
fn propagate(sections: &[Stretch], t: f64) -> Result<Vec<Bounds>, f64> {
    let mut reached = Vec::with_capacity(sections.len() + 1);
    reached.push(exactly(0.0));
    for (node, section) in sections.iter().enumerate() {
        reached[node] = section.passable(t, reached[node])?;
        reached.push(section.across(t, 1, reached[node], UNBOUNDED));
    }
    Ok(reached)
}

/// Values that meet all demands, as near to the sampled ones as possible from outside in.
fn choice(sections: &[Stretch], reached: &[Bounds], t: f64, sampled: &[f64]) -> Vec<f64> {
    let mut values = vec![0.0; sampled.len()];
    let mut allowed = reached[sections.len()];
    for (node, section) in sections.iter().enumerate().rev() {
        values[node + 1] = nearest(sampled[node + 1], allowed);
        allowed = section.across(t, 0, exactly(values[node + 1]), reached[node]);
    }
    values
}

/// A lower bound as a function of the tolerance, at the present tolerance: value and derivative.
#[derive(Clone, Copy)]
struct Bound {
    um: f64,
    per_tolerance: f64,
}

impl Bound {
    /// The higher one of this and another bound.
    fn raise(&mut self, um: f64, per_tolerance: impl FnOnce() -> f64) {
        if um > self.um {
            *self = Bound { um, per_tolerance: per_tolerance() };
        }
    }
}

/// Bounds of a node's value v: of v and of −v.
type Bounds = [Bound; 2];

/// The bounds of a node of which nothing is known.
const UNBOUNDED: Bounds = [Bound { um: f64::NEG_INFINITY, per_tolerance: 0.0 }; 2];

/// The bounds that leave one value only.
fn exactly(um: f64) -> Bounds {
    [um, -um].map(|um| Bound { um, per_tolerance: 0.0 })
}

/// A place of a section: its parts of the inner and the outer node's value in the line there
/// (1 − u and u), and the curve's value in µm.
#[derive(Clone, Copy, PartialEq)]
struct PlaceOnCurve {
    parts: [f64; 2],
    um: f64,
}

/// From one node to the next one outwards, with the places that bind.
struct Stretch<'a> {
    curve: &'a ErrorCurve,
    /// The inner and the outer node.
    ends_mm: [f64; 2],
    /// Upper hulls of the curve and of its mirror image: the line stays above them less t.
    hulls: [Vec<PlaceOnCurve>; 2],
}

impl Stretch<'_> {
    /// Every place where the curve can be farthest from a line of this rise, as in [`PlaceOnCurve`].
    fn visit(&self, rise: f64, mut visit: impl FnMut([f64; 2], f64)) {
        let [inner, outer] = self.ends_mm;
        let (from, to, width) = (inner.min(outer), inner.max(outer), outer - inner);
        self.curve.visit_candidates(from, to, -rise / width, |x, um| {
            let along = (x - inner) / width;
            visit([1.0 - along, along], um);
        });
    }

    /// The part of the inner bounds from which the section can be crossed within `t`, or by how
    /// much `t` must grow at least.
    ///
    /// A place i of the curve and a place j of its mirror image bound the inner value by the line
    /// through (u_i, d_i − t) and (u_j, d_j + t), followed back to u = 0: v if j is the outer one
    /// of them, else −v.
    fn passable(&self, t: f64, mut inner: Bounds) -> Result<Bounds, f64> {
        for PlaceOnCurve { parts: [_, i], um: above } in &self.hulls[0] {
            for PlaceOnCurve { parts: [_, j], um: below } in &self.hulls[1] {
                let gap = (j - i).abs();
                if gap >= SAME_PART {
                    let um = (j * (above - t) + i * (below - t)) / gap;
                    inner[usize::from(j < i)].raise(um, || -(i + j) / gap);
                }
            }
        }
        let [low, high] = inner;
        if low.um + high.um > 0.0 {
            return Err(-(low.um + high.um) / (low.per_tolerance + high.per_tolerance));
        }
        Ok(inner)
    }

    /// `bounds` of the node at `end` (0 inner, 1 outer), tightened by those of the `other` one: the
    /// line through a place is lowest here when it is highest there.
    fn across(&self, t: f64, end: usize, other: Bounds, mut bounds: Bounds) -> Bounds {
        for (side, hull) in self.hulls.iter().enumerate() {
            let opposite = other[1 - side];
            for PlaceOnCurve { parts, um } in hull {
                let (part, rest) = (parts[end], parts[1 - end]);
                if part > SAME_PART {
                    let um = (um - t + rest * opposite.um) / part;
                    bounds[side].raise(um, || (rest * opposite.per_tolerance - 1.0) / part);
                }
            }
        }
        bounds
    }
}

/// Adds places to an upper hull, unless they are there; false if they say nothing new.
fn widen(hull: &mut Vec<PlaceOnCurve>, mut places: Vec<PlaceOnCurve>) -> bool {
    let same =
        |one: &PlaceOnCurve, two: &PlaceOnCurve| (one.parts[1] - two.parts[1]).abs() < SAME_PART;
    places.dedup_by(|next, kept| same(next, kept));
    places.retain(|place| !hull.iter().any(|known| same(known, place)));
    places.extend_from_slice(hull);
    places.sort_by(|one, two| one.parts[1].total_cmp(&two.parts[1]));
    let mut wider: Vec<PlaceOnCurve> = Vec::with_capacity(places.len());
    for place in places {
        while let [.., one, two] = wider[..]
            && inside(one, two, place)
        {
            wider.pop();
        }
        wider.push(place);
    }
    let new = wider != *hull;
    *hull = wider;
    new
}

/// Whether `middle` lies on or below the line from `one` to `two`.
fn inside(one: PlaceOnCurve, middle: PlaceOnCurve, two: PlaceOnCurve) -> bool {
    let [first, second] = [middle, two].map(|point| point.parts[1] - one.parts[1]);
    (middle.um - one.um) * second <= (two.um - one.um) * first
}

/// What still counts as the tolerance.
fn with_slack(tolerance: f64) -> f64 {
    tolerance * (1.0 + RELATIVE_SLACK) + ABSOLUTE_SLACK_UM
}

/// The value between the bounds nearest to `wanted`; the middle where rounding left nothing
/// between.
fn nearest(wanted: f64, [low, mirrored_high]: Bounds) -> f64 {
    let (low, high) = (low.um, -mirrored_high.um);
    if low > high { (low + high) / 2.0 } else { wanted.max(low).min(high) }
}
