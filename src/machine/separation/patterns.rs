//! All w in one least-squares problem, and the patterns in them that are no noise.
//!
//! w = K z, with rows as in [`linear`](super::linear); what anything does to the readings is a column c, and K c the
//! pattern that it makes of w. Patterns are kept as an orthonormal basis in the metric of C⁻¹, C = K diag(1/runs) Kᵀ, so
//! that P x = C⁻¹x − Σ b (bᵀx) is what is left of x, weighed, and leaving out one more is one step. C has entries near its
//! diagonal only.

use super::linear::{Cause, Layout, Model, Row};
use super::noise::{
    DIGIT_UM, FALSE_DOUBT, MOST_OUTLIERS, NORMAL_ONE_SIDED, Noise, Outlier, ReadingPlace,
    UNRESOLVED_UM, chance_of, float, stands_out,
};
use super::uncertainty::Budget;
use crate::quantity::{Axis, PerAxis, Squared};
use nalgebra::{DVector, Matrix3, Vector3};

/// The least-squares problem of all w.
pub(super) struct Patterns {
    layout: Layout,
    /// K.
    rows: Vec<Row>,
    w: DVector<f64>,
    factor: Banded,
    /// The straight ramp of each axis.
    ramps: [DVector<f64>; 3],
    /// For each reading, the w that it takes part in and how.
    effects: Vec<Vec<(usize, f64)>>,
    /// What is left out so far.
    basis: Vec<DVector<f64>>,
    /// How much of it is the constants of the axes.
    constants: usize,
    /// P w.
    left: DVector<f64>,
}

/// Straight ramps of w over each axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramps {
    /// From the first interval to the last, µm.
    pub change_um: PerAxis<f64>,
    /// Their standard deviations for readings of 1 µm.
    pub u: PerAxis<f64>,
    /// Probability of ramps at least as large by noise alone.
    by_noise: f64,
    /// The same by noise and the stated angles.
    pub probability: f64,
    /// How far they are beyond what noise and these angles make, µm.
    pub(super) beyond_um: PerAxis<f64>,
}

impl Ramps {
    /// Whether they speak of the roll of an axis that carries others, beyond what is stated of it.
    pub fn is_roll(&self) -> bool {
        self.is_no_noise() && self.probability < FALSE_DOUBT
    }

    /// Whether they are no noise of the readings, so that they do not belong in its test.
    pub(super) fn is_no_noise(&self) -> bool {
        let sizes = self.change_um.iter().map(|(_, um)| um.abs());
        self.by_noise < FALSE_DOUBT && sizes.fold(0.0, f64::max) > UNRESOLVED_UM
    }
}

/// Shares below this are rounding: such a pattern is left out already.
const NOTHING: f64 = 1e-9;

impl Patterns {
    /// With nothing left out but the constants of the axes and the disturbed readings of single runs; `None` where C
    /// is singular.
    pub(super) fn new(budget: &Budget<'_>) -> Option<Patterns> {
        let (start, layout, last) = (budget.start, budget.layout(), budget.volume().steps - 1);
        // Those that share readings stand close to each other: diagonals that travel an axis in − cross its intervals
        // from the other end.
        let is_end = |at: &usize| *at == 0 || *at == last;
        let mut intervals: Vec<usize> =
            (0..=last).filter(|at| !(budget.skips_ends() && is_end(at))).collect();
        intervals.sort_by_key(|at| (*at.min(&(last - at)), *at));
        let of_group = |at: usize| budget.groups().iter().map(move |group| (at, *group));
        let places = intervals.into_iter().flat_map(of_group);
        let places = places.flat_map(|(at, group)| Axis::ALL.map(|axis| (group, axis, at)));
        let places: Vec<_> = places.collect();
        let rows = places.iter().map(|(group, axis, at)| budget.closure(*group, *axis, *at));
        let rows: Vec<Row> = rows.collect();
        let mut effects = vec![Vec::new(); layout.len()];
        for (index, row) in rows.iter().enumerate() {
            row.0.iter().for_each(|(place, weight)| effects[*place].push((index, *weight)));
        }
        let ends = effects.iter().filter_map(|effect| effect.first().zip(effect.last()));
        let reach = ends.map(|((first, _), (last, _))| last - first).max().unwrap_or(0);
        let weighed = effects.iter().zip(start.counts());
        let products = weighed.flat_map(|(effect, count)| {
            let row = effect.iter().flat_map(|one| effect.iter().map(move |other| (*one, *other)));
            row.map(move |((row, a), (column, b))| (row, column, a * b * (1.0 / count)))
        });
        let factor = Banded::factor((rows.len(), reach), products)?;
        let over = |of: &dyn Fn(f64) -> f64| {
            Axis::ALL.map(|wanted| {
                let each = places.iter().map(|(_, axis, at)| (*axis == wanted, float(*at)));
                let each = each.map(|(is_on_it, at)| if is_on_it { of(at) } else { 0.0 });
                DVector::from_iterator(rows.len(), each)
            })
        };
        let middle = float(last) / 2.0;
        let ramps = over(&|at| (at - middle) / (2.0 * middle).max(1.0));
        let constants = over(&|_| 1.0);
        let w = of_column(&rows, &start.means());
        let (basis, left) = (Vec::new(), factor.solve(&w));
        let mut patterns =
            Patterns { layout, rows, w, factor, ramps, effects, basis, constants: 0, left };
        patterns.leave_out(&constants);
        patterns.constants = patterns.basis.len();
        patterns.leave_out_readings(start.outliers.iter().flat_map(|outlier| &outlier.readings));
        Some(patterns)
    }

    /// P x.
    fn projected(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut left = self.factor.solve(x);
        self.basis.iter().for_each(|base| left.axpy(-base.dot(x), base, 1.0));
        left
    }

    /// Leaves out no more than so many patterns.
    fn keep(&mut self, count: usize) {
        self.basis.truncate(count);
        self.left = self.projected(&self.w);
    }

    fn leave_out<'a>(&mut self, patterns: impl IntoIterator<Item = &'a DVector<f64>>) {
        for pattern in patterns {
            let mut base = self.projected(pattern);
            let weight = pattern.dot(&base);
            if weight > NOTHING * pattern.norm_squared() {
                base /= weight.sqrt();
                self.left.axpy(-base.dot(&self.w), &base, 1.0);
                self.basis.push(base);
            }
        }
    }

    /// Leaves the effects of disturbed readings out, whichever runs they are of.
    pub(super) fn leave_out_readings<'a>(&mut self, of: impl Iterator<Item = &'a ReadingPlace>) {
        for place in of {
            let pattern = self.pattern(self.layout.reading(place.pass, place.diagonal, place.node));
            self.leave_out([&pattern]);
        }
    }

    /// Nothing but the constants, these disturbed readings and what stated angles do is left out from now on.
    pub(super) fn restart(&mut self, outliers: &[Outlier], causes: &Model) {
        self.keep(self.constants);
        self.leave_out_readings(outliers.iter().flat_map(|outlier| &outlier.readings));
        for cause in causes.angles.iter().flatten() {
            let pattern = of_column(&self.rows, &causes.causes[*cause].column);
            self.leave_out([&pattern]);
        }
    }

    pub(super) fn leave_out_ramps(&mut self) {
        let ramps = self.ramps.clone();
        self.leave_out(&ramps);
    }

    /// Q and ν.
    pub(super) fn scatter(&self) -> (f64, usize) {
        let freedom = self.w.len().saturating_sub(self.basis.len());
        (self.w.dot(&self.left).max(0.0), freedom)
    }

    /// Q of other readings.
    pub(super) fn square_of(&self, means: &[f64]) -> f64 {
        let w = of_column(&self.rows, means);
        w.dot(&self.projected(&w)).max(0.0)
    }

    /// The ramps beside what is left out, and how likely noise and the stated angles make them: by the order of
    /// the axes that explains them best. `None` where too little is left to tell them or to judge them by.
    pub(super) fn ramps(&self, noise: Option<Noise>, causes: Option<&Model>) -> Option<Ramps> {
        let weighed = self.ramps.each_ref().map(|ramp| self.projected(ramp));
        let normal = Matrix3::from_fn(|i, j| self.ramps[i].dot(&weighed[j]));
        let inverse = normal.cholesky()?.inverse();
        let of = |w: &DVector<f64>| inverse * Vector3::from_fn(|i, _| weighed[i].dot(w));
        let shares = of(&self.w);
        let (square, freedom) = self.scatter();
        let rest = freedom.checked_sub(3).filter(|rest| *rest > 0)?;
        let drop = (normal * shares).dot(&shares);
        let (variance, freedom) = match noise {
            Some(noise) => (noise.sigma_um.max(DIGIT_UM).squared(), noise.freedom),
            None => ((square - drop).max(0.0) / float(rest), Some(rest)),
        };
        let chance = |angles: &[usize], causes: &[Cause]| {
            let of_angle = |at: &usize| of(&of_column(&self.rows, &causes[*at].column));
            let spread = angles.iter().map(of_angle).map(|c| c * c.transpose());
            let spread = spread.fold(inverse * variance, |sum, one| sum + one);
            let ratio =
                spread.cholesky().map_or(f64::INFINITY, |of| of.solve(&shares).dot(&shares));
            Some((chance_of(ratio, 3, freedom)?, spread))
        };
        let by_noise = chance(&[], &[])?;
        let orders = causes.iter().flat_map(|causes| {
            causes.angles.iter().filter_map(|angles| chance(angles, &causes.causes))
        });
        let (probability, spread) =
            orders.fold(by_noise, |best, one| if one.0 > best.0 { one } else { best });
        let by_axis = |of: &dyn Fn(usize) -> f64| PerAxis::from_fn(|axis| of(axis as usize));
        let beyond = |i: usize| shares[i].abs() - NORMAL_ONE_SIDED * spread[(i, i)].sqrt();
        Some(Ramps {
            change_um: by_axis(&|i| shares[i]),
            u: by_axis(&|i| inverse[(i, i)].sqrt()),
            by_noise: by_noise.0,
            probability,
            beyond_um: by_axis(&|i| beyond(i).max(0.0)),
        })
    }

    /// Names disturbed readings one by one, the largest first, until none stands out, with the ramps left free; leaves
    /// these readings out, and nothing else.
    pub(super) fn name_outliers(&mut self, known_sigma_um: Option<f64>) -> Vec<Outlier> {
        let before = self.basis.len();
        self.leave_out_ramps();
        let next = || {
            let found = self.largest(known_sigma_um)?;
            self.leave_out_readings(found.readings.iter().take(1));
            Some(found)
        };
        let found: Vec<Outlier> = std::iter::from_fn(next).take(MOST_OUTLIERS).collect();
        self.keep(before);
        self.leave_out_readings(found.iter().filter_map(|outlier| outlier.readings.first()));
        found
    }

    fn largest(&self, known_sigma_um: Option<f64>) -> Option<Outlier> {
        let share = |effect: &[(usize, f64)]| -> f64 {
            effect.iter().map(|(row, part)| part * self.left[*row]).sum()
        };
        let shares = self.effects.iter().map(|effect| share(effect).abs()).enumerate();
        // Of equal ones the first.
        let (index, _) = shares.rev().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let pattern = self.pattern(index);
        let weight = pattern.dot(&self.projected(&pattern));
        if weight <= NOTHING * pattern.norm_squared() {
            return None;
        }
        let size_um = pattern.dot(&self.left) / weight;
        let many = self.effects.iter().filter(|effect| !effect.is_empty()).count();
        let size = (size_um, size_um * size_um * weight);
        let ratio = stands_out(size, self.scatter(), known_sigma_um, many)?;
        Some(Outlier { readings: self.twins(index), size_um, ratio, of_mean_um: size_um })
    }

    fn pattern(&self, reading: usize) -> DVector<f64> {
        let mut pattern = DVector::zeros(self.w.len());
        self.effects[reading].iter().for_each(|(row, part)| pattern[*row] += part);
        pattern
    }

    /// A reading, then all whose effect on w is the same but for its sign.
    fn twins(&self, index: usize) -> Vec<ReadingPlace> {
        let shape = |reading: usize| {
            let effect = &self.effects[reading];
            let sign = effect.first().map_or(1.0, |(_, part)| part.signum());
            effect.iter().map(|(row, part)| (*row, sign * part)).collect::<Vec<_>>()
        };
        let wanted = shape(index);
        let others = (0..self.effects.len()).filter(|other| *other != index);
        let twins = others.filter(|other| shape(*other) == wanted);
        std::iter::once(index).chain(twins).map(|reading| self.layout.place(reading)).collect()
    }
}

/// What a column of the readings makes of w.
fn of_column(rows: &[Row], column: &[f64]) -> DVector<f64> {
    DVector::from_iterator(rows.len(), rows.iter().map(|row| row.dot(column)))
}

/// The Cholesky factor of a symmetric, positive definite matrix with entries near its diagonal only.
struct Banded {
    /// How far below the diagonal entries lie.
    reach: usize,
    /// Its lower half, row after row, each from so far before the diagonal on.
    lower: Vec<f64>,
}

impl Banded {
    /// Of the sum of entries by row and column, of which the upper half is not needed; `None` where the matrix is not
    /// positive definite.
    fn factor(
        (size, reach): (usize, usize),
        entries: impl Iterator<Item = (usize, usize, f64)>,
    ) -> Option<Banded> {
        let mut found = Banded { reach, lower: vec![0.0; (reach + 1) * size] };
        for (row, column, value) in entries.filter(|(row, column, _)| column <= row) {
            let at = found.at(row, column);
            found.lower[at] += value;
        }
        for row in 0..size {
            let first = row.saturating_sub(reach);
            for column in first..=row {
                let of = |row| &found.lower[found.at(row, first)..found.at(row, column)];
                let known = of(row).iter().zip(of(column)).map(|(a, b)| a * b);
                let at = found.at(row, column);
                let rest = found.lower[at] - known.sum::<f64>();
                found.lower[at] = match column < row {
                    true => rest / found.lower[found.at(column, column)],
                    false => Some(rest.sqrt()).filter(|_| rest > 0.0)?,
                };
            }
        }
        Some(found)
    }

    /// Where an entry stands.
    fn at(&self, row: usize, column: usize) -> usize {
        row * self.reach + self.reach + column
    }

    /// The solution of matrix · x = `right`.
    fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let (mut x, lower) = (right.clone(), &self.lower);
        for row in 0..x.len() {
            let (first, own) = (row.saturating_sub(self.reach), self.at(row, row));
            let before = lower[self.at(row, first)..own].iter().zip(&x.as_slice()[first..]);
            let known: f64 = before.map(|(by, x)| by * x).sum();
            x[row] = (x[row] - known) / lower[own];
        }
        for row in (0..x.len()).rev() {
            let (own, behind) = (self.at(row, row), x.as_slice()[row + 1..].iter());
            let column = lower[own..].iter().step_by(self.reach.max(1)).skip(1);
            let known: f64 = column.zip(behind.take(self.reach)).map(|(by, x)| by * x).sum();
            x[row] = (x[row] - known) / lower[own];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_system_is_solved() {
        // [4 2 0; 2 5 1; 0 1 3] · [1 2 3] = [8 15 11]
        let entries = [(0, 0, 4.0), (1, 0, 2.0), (1, 1, 5.0), (2, 1, 1.0), (2, 2, 3.0)];
        let factor = Banded::factor((3, 1), entries.into_iter()).expect("positive definite");
        let x = factor.solve(&DVector::from_vec(vec![8.0, 15.0, 11.0]));
        assert!((x - DVector::from_vec(vec![1.0, 2.0, 3.0])).norm() < 1e-12);
    }
}
