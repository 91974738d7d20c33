//! The numbers of a fault, fitted: factors and slopes in closed form, shifts by search.

use super::data::{Data, quantile};
use super::fault::{Act, Fault, Fit, Fitted};
use crate::quantity::axis::{Axis, ErrorTerm};
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
    /// The fault with its numbers fitted.
    pub(super) fn fit(&self, fault: &Fault) -> Fit {
        let fitted = match &fault.act {
            Act::Shifted(places) => self.shifted(fault, places),
            _ if fault.numbers() == 0 => Vec::new(),
            _ => self.linear(fault, fault.numbers()),
        };
        self.evaluated(fault, fitted)
    }

    /// Weighted least squares of numbers that act in proportion.
    fn linear(&self, fault: &Fault, count: usize) -> Vec<f64> {
        let weighted = |values: Vec<f64>| self.weighted(&self.less_zeros(&values));
        let base = self.effects(fault, &vec![0.0; count]);
        let mut columns = Vec::new();
        for index in 0..count {
            let mut unit = vec![0.0; count];
            unit[index] = 1.0;
            let effects = self.effects(fault, &unit);
            let pairs = effects.iter().zip(&base);
            columns.extend(weighted(pairs.map(|(a, b)| a - b).collect()));
        }
        let known = self.found_um.iter().zip(&base).map(|(a, b)| a + b);
        let left = self.measured_um.iter().zip(known).map(|(a, b)| a - b);
        let left = DVector::from_vec(weighted(left.collect()));
        let matrix = DMatrix::from_vec(left.len(), count, columns);
        let solved = matrix.svd(true, true).solve(&left, NEGLIGIBLE);
        solved.map_or(vec![0.0; count], |found| found.iter().copied().collect())
    }

    /// A shift acts through the shape of the tables: searched on a grid, then narrowed. Axes are
    /// searched one after the other; twice where they meet on a diagonal.
    fn shifted(&self, fault: &Fault, places: &Fitted) -> Vec<f64> {
        let mut fitted = vec![0.0; fault.numbers()];
        let meet = self.question.seen.iter().any(|o| o.diagonal.is_some());
        let rounds = if meet && fitted.len() > 1 { 2 } else { 1 };
        for _ in 0..rounds {
            for (axis, place) in places.iter() {
                if let Some(place) = *place {
                    let of = |mm| self.square(&self.with(fault, &fitted, place, mm));
                    fitted[place] = self.search(axis, of);
                }
            }
        }
        fitted
    }

    /// A fault with one of its numbers changed.
    fn with(&self, fault: &Fault, fitted: &[f64], place: usize, number: f64) -> Fit {
        let mut tried = fitted.to_vec();
        tried[place] = number;
        self.evaluated(fault, tried)
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
        let nodes: Vec<f64> =
            along.flat_map(|term| self.question.control.nodes(term)).map(|at| at.mm()).collect();
        let low = nodes.iter().copied().fold(f64::INFINITY, f64::min);
        let high = nodes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        ((high - low) / 2.0).max(0.0)
    }

    /// How far a fitted shift may lie from the true one, mm: to the farther end of the shifts
    /// whose score is within that of 95 % (one degree of freedom), one number for each.
    pub(super) fn shift_uncertainty_mm(&self, fault: &Fault, fit: &Fit) -> Vec<f64> {
        let Act::Shifted(places) = &fault.act else {
            return Vec::new();
        };
        let limit = self.score(fit) + quantile(COVERED, 1.0);
        let of = |(axis, place): (Axis, &Option<usize>)| {
            let place = (*place)?;
            let best = fit.fitted[place];
            let score = |mm: f64| self.score(&self.with(fault, &fit.fitted, place, mm));
            let (low, high) = interval(best, self.longest_shift(axis), score, limit);
            Some((high - best).max(best - low))
        };
        places.iter().filter_map(of).collect()
    }
}

/// The stretch around `best` on which `of` stays within `limit`, to `most` on either side. Where a
/// control corrects in steps the squares do so too: every shift of a plateau is as good.
fn interval(best: f64, most: f64, of: impl Fn(f64) -> f64, limit: f64) -> (f64, f64) {
    const FIRST_MM: f64 = 1e-3;
    const ROUNDS: usize = 20;
    let edge = |sign: f64| {
        let within = |mm: f64| of(best + sign * mm) <= limit;
        let mut inside = 0.0;
        let mut outside = FIRST_MM;
        while outside < most && within(outside) {
            inside = outside;
            outside *= 2.0;
        }
        for _ in 0..ROUNDS {
            let middle = f64::midpoint(inside, outside);
            if within(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
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
