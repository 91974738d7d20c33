//! An error curve: the deviation of one term along one axis, between the measured positions too.
//!
//! A laser gives deviations at targets; a table has values on a grid of its own. Between the
//! two stands this curve: a cubic on every interval between neighbouring targets, held constant
//! outside the first and the last one. Everything that is asked of it (values, means, sums with a
//! straight line, largest residual) is answered from the cubics, never by sampling.
//!
//! ```text
//!  µm      ·——·        piece 1: c0 + c1·s + c2·s² + c3·s³,  s = x − knot 1
//!        ·     ·__
//!  ____·          ·______
//!    knot 0  1  2  3        mm
//!  held                held
//! ```

mod pieces;

pub use self::pieces::Interpolation;

use crate::quantity::{Deviation, Millimetres};

pub(crate) use pieces::solve_tridiagonal;
use pieces::{Cubic, value_of};

/// Micrometres per metre in one micrometre per millimetre.
const MM_PER_M: f64 = 1000.0;

/// A stretch that bends less is straight, in parts of its values (and µm near 0).
const ROUNDING: f64 = 1e-9;

/// A curve has one value at a place. Where a control adds a whole step at once, the step is written
/// as a straight line over this nanometre, mm: the value before it stands so far below the place,
/// the value behind it at the place. No measured curve moves by more than 10⁻⁶ µm over it.
pub const JUMP_MM: f64 = 1e-6;

/// Deviation as a function of position: piecewise cubic, held constant outside the knots.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorCurve {
    knots: Vec<Millimetres>,
    pieces: Vec<Cubic>,
    last: f64,
}

impl ErrorCurve {
    /// The curve through measured points.
    ///
    /// shape  as many deviations as positions, at least one; a single one gives a constant
    /// sign   actual − commanded, as measured
    /// source see [`Interpolation`]
    /// limits positions strictly ascending, all numbers finite; the caller has checked this
    ///
    /// ```
    /// use nonius_numerics::quantity::{Deviation, ErrorCurve, Interpolation, Millimetres};
    /// let curve = ErrorCurve::through(
    ///     &[0.0, 100.0].map(Millimetres::new),
    ///     &[0.0, 4.0].map(Deviation::from_um),
    ///     Interpolation::Linear,
    /// );
    /// assert_eq!(curve.at(Millimetres::new(25.0)), Deviation::from_um(1.0));
    /// assert_eq!(curve.at(Millimetres::new(140.0)), Deviation::from_um(4.0));
    /// ```
    pub fn through(
        positions: &[Millimetres],
        deviations: &[Deviation],
        kind: Interpolation,
    ) -> ErrorCurve {
        assert!(!positions.is_empty() && positions.len() == deviations.len());
        assert!(positions.is_sorted_by(|a, b| a < b));
        assert!(deviations.iter().all(|deviation| deviation.um().is_finite()));
        let values: Vec<f64> = deviations.iter().map(|deviation| deviation.um()).collect();
        ErrorCurve {
            knots: positions.to_vec(),
            pieces: pieces::through(positions, &values, kind),
            last: values.last().copied().unwrap_or(0.0),
        }
    }

    /// The curve with given cubics, for cases with an answer in closed form.
    #[cfg(test)]
    pub(crate) fn from_cubics(knots: &[f64], pieces: &[Cubic]) -> ErrorCurve {
        let end = pieces.len();
        ErrorCurve {
            knots: knots.iter().copied().map(Millimetres::new).collect(),
            pieces: pieces.to_vec(),
            last: value_of(&pieces[end - 1], knots[end] - knots[end - 1]),
        }
    }

    /// The deviation at a position, µm; outside the measured range that of the nearer end.
    #[inline]
    pub fn at(&self, position: Millimetres) -> Deviation {
        Deviation::from_um(self.um_at(position.mm()))
    }

    /// First and last measured position, mm.
    pub fn measured_range(&self) -> (Millimetres, Millimetres) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// The measured positions, ascending, mm.
    pub fn knots(&self) -> &[Millimetres] {
        &self.knots
    }

    /// The curve less a constant, µm.
    #[must_use]
    pub fn less(&self, constant: Deviation) -> ErrorCurve {
        self.adding(|_| -constant.um(), 0.0)
    }

    /// The curve shifted so that it is zero at `reference`: d(x) − d(reference).
    #[must_use]
    pub fn rezeroed_at(&self, reference: Millimetres) -> ErrorCurve {
        self.less(self.at(reference))
    }

    /// The curve plus a straight line: d(x) + φ·(x − zero)/1000.
    ///
    /// unit   φ in µm/m, x and zero in mm, result in µm
    /// sign   positive φ: the deviation grows with the coordinate
    /// limits the line acts inside the measured range; outside, the new end values are held
    #[must_use]
    pub fn plus_slope(&self, um_per_m: f64, zero: Millimetres) -> ErrorCurve {
        let slope = um_per_m / MM_PER_M;
        self.adding(|x| slope * (x - zero.mm()), slope)
    }

    /// The mean of two curves, e.g. of both directions of travel: (d₁ + d₂)/2.
    ///
    /// shape  knots of both curves inside the overlap of the measured ranges; exact
    /// limits `None` where the ranges have no point in common
    #[must_use]
    pub fn mean_with(&self, other: &ErrorCurve) -> Option<ErrorCurve> {
        self.combined(other, 0.5, 0.5)
    }

    /// The difference of two curves, e.g. the reversal value along the axis: d₁ − d₂.
    ///
    /// shape, limits as [`ErrorCurve::mean_with`]
    #[must_use]
    pub fn difference(&self, other: &ErrorCurve) -> Option<ErrorCurve> {
        self.combined(other, 1.0, -1.0)
    }

    /// The sum of two curves over both their ranges, each held beyond its ends: d₁ + d₂.
    ///
    /// shape  knots of both curves; exact
    #[must_use]
    pub fn plus(&self, other: &ErrorCurve) -> ErrorCurve {
        let (from, to) = self.measured_range();
        let (other_from, other_to) = other.measured_range();
        let low = from.mm().min(other_from.mm());
        let high = to.mm().max(other_to.mm());
        let (own, others) = (self.held_over(low, high), other.held_over(low, high));
        own.weighted(&others, (low, high), 1.0, 1.0)
    }

    /// The slope of the straight line through the two ends, µm/m; of one point, 0.
    ///
    /// sign   positive: the deviation grows with the coordinate (the axis is long)
    pub fn end_point_slope_um_per_m(&self) -> f64 {
        let (from, to) = self.measured_range();
        let length = (to - from).mm();
        if length > 0.0 { (self.last - self.um_at(from.mm())) / length * MM_PER_M } else { 0.0 }
    }

    /// Smallest and largest value of curve + straight line over a stretch, exactly.
    ///
    ///   d(x) + line(x),  line(from) = `line_from_um`, line(to) = `line_to_um`
    ///
    /// A cubic plus a line has its extremes at the ends of its interval or where the derivative,
    /// a quadratic, is zero; all of these places are visited.
    ///
    /// unit   µm
    /// sign   deviation + correction = residual, so the line is the emulated *correction*
    /// limits `from` ≤ `to`; with `from` = `to` both line values count
    pub fn extremes_against_line(
        &self,
        from: Millimetres,
        to: Millimetres,
        line_from_um: f64,
        line_to_um: f64,
    ) -> (f64, f64) {
        let (start, span) = (from.mm(), (to - from).mm());
        let rise = line_to_um - line_from_um;
        let slope = if span > 0.0 { rise / span } else { 0.0 };
        let at_end = self.um_at(to.mm()) + line_to_um;
        let (mut low, mut high) = (at_end, at_end);
        self.visit_candidates(start, to.mm(), slope, |x, um| {
            let along = if span > 0.0 { (x - start) / span } else { 0.0 };
            let sum = um + line_from_um + rise * along;
            low = low.min(sum);
            high = high.max(sum);
        });
        (low, high)
    }

    /// The largest absolute value over a stretch, µm, exactly; `from` ≤ `to`.
    pub fn largest_magnitude(&self, from: Millimetres, to: Millimetres) -> f64 {
        let (low, high) = self.extremes_against_line(from, to, 0.0, 0.0);
        high.abs().max(low.abs())
    }

    /// Calls `visit(x, d(x))` at every place in [from, to] where d(x) + slope·x (µm, mm) can have
    /// an extreme: ends, knots, zeros of the derivative. In ascending order of x.
    pub fn visit_candidates(
        &self,
        from: f64,
        to: f64,
        slope: f64,
        mut visit: impl FnMut(f64, f64),
    ) {
        visit(from, self.um_at(from));
        let above = self.knots.partition_point(|knot| knot.mm() <= from);
        for index in above.saturating_sub(1)..self.pieces.len() {
            let (left, right) = (self.knots[index].mm(), self.knots[index + 1].mm());
            if left >= to {
                break;
            }
            let piece = &self.pieces[index];
            if left > from {
                visit(left, piece[0]);
            }
            let (low, high) = (left.max(from) - left, right.min(to) - left);
            for s in pieces::stationary_points(piece, slope) {
                if s > low && s < high {
                    visit(left + s, value_of(piece, s));
                }
            }
        }
        let last = self.knots.last().filter(|knot| from < knot.mm() && knot.mm() < to);
        last.into_iter().for_each(|knot| visit(knot.mm(), self.last));
        visit(to, self.um_at(to));
    }

    /// Whether it runs straight between its knots, to within rounding.
    pub fn is_straight(&self) -> bool {
        let spans = self.knots.windows(2).map(|pair| (pair[1] - pair[0]).mm());
        self.pieces.iter().zip(spans).all(|([um, _, square, cube], mm)| {
            let bent = (square.abs() + cube.abs() * mm) * mm * mm;
            bent <= ROUNDING * (1.0 + um.abs())
        })
    }

    /// The knots strictly between two positions (mm).
    pub fn knots_between(&self, from: f64, to: f64) -> &[Millimetres] {
        let start = self.knots.partition_point(|knot| knot.mm() <= from);
        let end = self.knots.partition_point(|knot| knot.mm() < to);
        &self.knots[start..end.max(start)]
    }

    /// The deviation in plain numbers: mm to µm.
    #[inline]
    pub fn um_at(&self, x: f64) -> f64 {
        self.piece_at(x).map_or(self.last, |(piece, s)| value_of(piece, s.max(0.0)))
    }

    /// The cubic that holds to the right of `x`, about `x`; of a single point, its constant.
    fn cubic_about(&self, x: f64) -> Cubic {
        self.piece_at(x).map_or([self.last, 0.0, 0.0, 0.0], |(piece, s)| pieces::about(piece, s))
    }

    /// The cubic that holds to the right of `x`, and how far `x` lies behind its knot; `None` from the last knot on.
    #[inline]
    fn piece_at(&self, x: f64) -> Option<(&Cubic, f64)> {
        let index = self.knots.partition_point(|knot| knot.mm() <= x).saturating_sub(1);
        Some((self.pieces.get(index)?, x - self.knots[index].mm()))
    }

    /// The curve plus `line(x)` of slope `slope` (µm/mm).
    fn adding(&self, line: impl Fn(f64) -> f64, slope: f64) -> ErrorCurve {
        let mut sum = self.clone();
        for (piece, knot) in sum.pieces.iter_mut().zip(&self.knots) {
            piece[0] += line(knot.mm());
            piece[1] += slope;
        }
        sum.last += self.knots.last().map_or(0.0, |knot| line(knot.mm()));
        sum
    }

    /// a·self + b·other on the knots of both inside the overlap.
    fn combined(&self, other: &ErrorCurve, a: f64, b: f64) -> Option<ErrorCurve> {
        let (from, to) = self.measured_range();
        let (other_from, other_to) = other.measured_range();
        let from = from.mm().max(other_from.mm());
        let to = to.mm().min(other_to.mm());
        (from <= to).then(|| self.weighted(other, (from, to), a, b))
    }

    /// a·self + b·other on the knots of both from one of them to another.
    fn weighted(&self, other: &ErrorCurve, (from, to): (f64, f64), a: f64, b: f64) -> ErrorCurve {
        let both = self.knots.iter().chain(&other.knots).copied();
        let mut knots: Vec<Millimetres> =
            both.filter(|knot| knot.mm() >= from && knot.mm() <= to).collect();
        knots.sort_by(|one, two| one.mm().total_cmp(&two.mm()));
        knots.dedup_by(|next, kept| next <= kept);
        let pieces = knots[..knots.len() - 1].iter().map(|knot| {
            let (own, others) = (self.cubic_about(knot.mm()), other.cubic_about(knot.mm()));
            std::array::from_fn(|power| a * own[power] + b * others[power])
        });
        ErrorCurve {
            pieces: pieces.collect(),
            last: a * self.um_at(to) + b * other.um_at(to),
            knots,
        }
    }

    /// The same curve, with the ends it holds as pieces of their own from `low` to `high`.
    fn held_over(&self, low: f64, high: f64) -> ErrorCurve {
        let (from, to) = self.measured_range();
        let mut wider = self.clone();
        if low < from.mm() {
            wider.knots.insert(0, Millimetres::new(low));
            wider.pieces.insert(0, [self.um_at(low), 0.0, 0.0, 0.0]);
        }
        if high > to.mm() {
            wider.knots.push(Millimetres::new(high));
            wider.pieces.push([self.last, 0.0, 0.0, 0.0]);
        }
        wider
    }
}

#[cfg(test)]
mod tests;
