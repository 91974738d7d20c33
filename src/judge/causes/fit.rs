//! The numbers of a fault, fitted: factors and slopes in closed form, shifts by search.

use super::data::Data;
use super::fault::Fault;
use super::quantile;
use crate::judge::causes::fault::Fit;
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
        match fault {
            Fault::Shifted(axis) => self.fit_shift(*axis),
            fault if fault.parameters() == 0 => self.evaluated(fault, Vec::new()),
            fault => {
                let fitted = self.linear(fault, fault.parameters());
                self.evaluated(fault, fitted)
            }
        }
    }

    /// Weighted least squares of numbers that act in proportion.
    fn linear(&self, fault: &Fault, count: usize) -> Vec<f64> {
        let weighted = |values: Vec<f64>| {
            let less = self.less_zeros(&values);
            let pairs = less.iter().zip(&self.sigma_um);
            pairs
                .map(|(value, sigma)| value / sigma)
                .collect::<Vec<f64>>()
        };
        let base = self.effects(fault, &vec![0.0; count]);
        let mut columns = Vec::new();
        for index in 0..count {
            let mut unit = vec![0.0; count];
            unit[index] = 1.0;
            let effects = self.effects(fault, &unit);
            columns.extend(weighted(
                effects.iter().zip(&base).map(|(a, b)| a - b).collect(),
            ));
        }
        let known = self.found_um.iter().zip(&base).map(|(a, b)| a + b);
        let left = weighted(
            self.measured_um
                .iter()
                .zip(known)
                .map(|(a, b)| a - b)
                .collect(),
        );
        let matrix = DMatrix::from_vec(left.len(), count, columns);
        let solved = matrix
            .svd(true, true)
            .solve(&DVector::from_vec(left), NEGLIGIBLE);
        solved.map_or_else(
            |_| vec![0.0; count],
            |found| found.iter().copied().collect(),
        )
    }

    /// A shift acts through the shape of the tables: searched on a grid, then narrowed. Axes are
    /// searched one after the other; twice where they meet on a diagonal.
    fn fit_shift(&self, axis: Option<Axis>) -> Fit {
        let fault = Fault::Shifted(axis);
        match axis {
            Some(own) => {
                let found = self.search(own, |mm| self.evaluated(&fault, vec![mm]));
                self.evaluated(&fault, vec![found])
            }
            None => {
                let mut fitted = vec![0.0; 3];
                let together = self.question.seen.iter().any(|o| o.diagonal.is_some());
                let rounds = if together { 2 } else { 1 };
                for _ in 0..rounds {
                    for (index, own) in Axis::ALL.into_iter().enumerate() {
                        fitted[index] = self.search(own, |mm| {
                            let mut tried = fitted.clone();
                            tried[index] = mm;
                            self.evaluated(&fault, tried)
                        });
                    }
                }
                self.evaluated(&fault, fitted)
            }
        }
    }

    fn search(&self, axis: Axis, of: impl Fn(f64) -> Fit) -> f64 {
        let most = self.longest_shift(axis);
        if most <= 0.0 {
            return 0.0;
        }
        let step = most / SHIFTS;
        let square = |mm: f64| self.square(&of(mm));
        let grid =
            std::iter::successors(Some(-most), |mm| Some(mm + step)).take_while(|mm| *mm <= most);
        let best = |places: &mut dyn Iterator<Item = f64>| {
            let squares = places.map(|mm| (square(mm), mm));
            let least = squares.min_by(|a, b| a.0.total_cmp(&b.0));
            least.map_or(0.0, |(_, mm)| mm)
        };
        let middle = best(&mut grid.into_iter());
        let narrow = narrowed(middle - step, middle + step, square);
        let best = best(&mut [middle, narrow].into_iter());
        let (low, high) = interval(
            best,
            most,
            square,
            square(best) * SAME_SQUARE + f64::MIN_POSITIVE,
        );
        f64::midpoint(low, high)
    }

    /// Half the length of the tables along an axis, mm; 0 without tables.
    fn longest_shift(&self, axis: Axis) -> f64 {
        let along = ErrorTerm::ALL.into_iter().filter(|term| term.along == axis);
        let nodes: Vec<f64> = along
            .flat_map(|term| self.question.control.nodes(term))
            .map(|at| at.mm())
            .collect();
        let low = nodes.iter().copied().fold(f64::INFINITY, f64::min);
        let high = nodes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        ((high - low) / 2.0).max(0.0)
    }

    /// How far a fitted shift may lie from the true one, mm: to the farther end of the shifts
    /// whose score is within that of 95 % (one degree of freedom), one number for each.
    pub(super) fn shift_uncertainty_mm(&self, fault: &Fault, fit: &Fit) -> Vec<f64> {
        let Fault::Shifted(axis) = fault else {
            return Vec::new();
        };
        let limit = self.score(fit) + quantile(COVERED, 1.0);
        let of = |(index, best): (usize, &f64)| {
            let own = axis.unwrap_or(Axis::ALL[index]);
            let score = |mm: f64| {
                let mut tried = fit.fitted.clone();
                tried[index] = mm;
                self.score(&self.evaluated(fault, tried))
            };
            let (low, high) = interval(*best, self.longest_shift(own), score, limit);
            (high - best).max(best - low)
        };
        fit.fitted.iter().enumerate().map(of).collect()
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
