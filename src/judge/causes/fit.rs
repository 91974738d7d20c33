//! The numbers of a change, fitted: factors and slopes in closed form, shifts by search.

use super::change::Change;
use super::data::{Data, Fit, minus, plus, quantile};
use crate::quantity::{Axis, ErrorTerm};
use nalgebra::{DMatrix, DVector};

/// Singular values below this share of a column's length are rounding.
const NEGLIGIBLE: f64 = 1e-9;
/// Steps to either side in which a shift is searched over half the length of the tables.
const SHIFTS: f64 = 40.0;
/// Sums of squares that differ by less are rounding.
const SAME_SQUARE: f64 = 1.0 + 1e-9;
/// Share of the cases in which the true shift lies within its stated uncertainty.
const COVERED: f64 = 0.95;

impl Data<'_> {
    /// The change with its numbers fitted.
    pub(super) fn fit(&self, change: &Change) -> Fit {
        let fitted = match (change, change.numbers()) {
            (_, 0) => Vec::new(),
            (Change::Shifted(_), count) => self.shifted(change, count),
            (_, count) => self.linear(change, count),
        };
        self.evaluated(change, fitted)
    }

    /// Weighted least squares of numbers that act in proportion.
    fn linear(&self, change: &Change, count: usize) -> Vec<f64> {
        let weighted = |values: Vec<f64>| self.weighted(&self.less_zeros(&values));
        let mut numbers = vec![0.0; count];
        let base = self.effects(change, &numbers);
        let left = minus(&self.measured_um, &plus(&self.found_um, &base));
        let left = DVector::from_vec(weighted(left));
        let mut columns = Vec::new();
        for index in 0..count {
            numbers[index] = 1.0;
            columns.extend(weighted(minus(&self.effects(change, &numbers), &base)));
            numbers[index] = 0.0;
        }
        let matrix = DMatrix::from_vec(left.len(), count, columns);
        let solved = matrix.svd(true, true).solve(&left, NEGLIGIBLE);
        solved.map_or(numbers, |found| found.iter().copied().collect())
    }

    /// A shift acts through the shape of the tables: searched on a grid, then narrowed. Axes are
    /// searched one after the other; twice where they meet on a diagonal.
    fn shifted(&self, change: &Change, count: usize) -> Vec<f64> {
        let mut fitted = vec![0.0; count];
        let meet = self.question.seen.iter().any(|o| o.diagonal.is_some());
        for _ in 0..if meet && count > 1 { 2 } else { 1 } {
            for (axis, place) in change.shifts() {
                let of = |mm| self.square(&self.with(change, &fitted, place, mm));
                fitted[place] = self.search(axis, of);
            }
        }
        fitted
    }

    /// A change with one of its numbers changed.
    fn with(&self, change: &Change, fitted: &[f64], place: usize, number: f64) -> Fit {
        let mut tried = fitted.to_vec();
        tried[place] = number;
        self.evaluated(change, tried)
    }

    fn search(&self, axis: Axis, square: impl Fn(f64) -> f64) -> f64 {
        let most = self.longest_shift(axis);
        if most <= 0.0 {
            return 0.0;
        }
        let step = most / SHIFTS;
        let best = |places: &mut dyn Iterator<Item = f64>| {
            let squares = places.map(|mm| (square(mm), mm));
            squares.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
        };
        let next = |mm: &f64| Some(mm + step);
        let mut grid = std::iter::successors(Some(-most), next).take_while(|mm| *mm <= most);
        let (_, middle) = best(&mut grid);
        let narrow = narrowed(middle - step, middle + step, &square);
        let (least, best) = best(&mut [middle, narrow].into_iter());
        let limit = least * SAME_SQUARE + f64::MIN_POSITIVE;
        let (low, high) = interval(best, most, square, limit);
        f64::midpoint(low, high)
    }

    /// Half the length of the tables along an axis, mm; 0 without tables.
    fn longest_shift(&self, axis: Axis) -> f64 {
        let along = ErrorTerm::ALL.into_iter().filter(|term| term.along == axis);
        let nodes = along.flat_map(|term| self.question.control.nodes(term));
        let (low, high) = ends(nodes.map(|at| at.mm()));
        ((high - low) / 2.0).max(0.0)
    }

    /// How far a fitted shift may lie from the true one, mm: to the farther end of the shifts
    /// whose score is within that of 95 % (one degree of freedom), one number for each.
    pub(super) fn shift_uncertainty_mm(&self, change: &Change, fit: &Fit) -> Vec<f64> {
        let limit = self.score(fit) + quantile(COVERED, 1.0);
        let of = |(axis, place): (Axis, usize)| {
            let best = fit.fitted[place];
            let score = |mm: f64| self.score(&self.with(change, &fit.fitted, place, mm));
            let (low, high) = interval(best, self.longest_shift(axis), score, limit);
            (high - best).max(best - low)
        };
        change.shifts().into_iter().map(of).collect()
    }
}

/// Smallest and largest of some numbers; (∞, −∞) of none.
pub(super) fn ends(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    numbers.fold(none, |(low, high), number| (low.min(number), high.max(number)))
}

/// The stretch around `best` on which `of` stays within `limit`, to `most` on either side. Where a
/// control corrects in steps the squares do so too: every shift of a plateau is as good.
fn interval(best: f64, most: f64, of: impl Fn(f64) -> f64, limit: f64) -> (f64, f64) {
    const FIRST_MM: f64 = 1e-3;
    const ROUNDS: usize = 20;
    let edge = |sign: f64| {
        let within = |mm: f64| of(best + sign * mm) <= limit;
        let (mut inside, mut outside) = (0.0, FIRST_MM);
        while outside < most && within(outside) {
            (inside, outside) = (outside, 2.0 * outside);
        }
        for _ in 0..ROUNDS {
            let middle = f64::midpoint(inside, outside);
            *if within(middle) { &mut inside } else { &mut outside } = middle;
        }
        best + sign * inside
    };
    (edge(-1.0), edge(1.0))
}

/// Golden section.
fn narrowed(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_895;
    const ROUNDS: usize = 24; // 10⁻⁵ of the first width
    for _ in 0..ROUNDS {
        let (a, b) = (high - SHARE * (high - low), low + SHARE * (high - low));
        if of(a) <= of(b) {
            high = b;
        } else {
            low = a;
        }
    }
    f64::midpoint(low, high)
}
