//! All w in one least-squares problem, and the patterns in them that are no noise.
//!
//! The patterns are kept as an orthonormal basis in the metric of C⁻¹, so that
//! P x = C⁻¹x − Σ b (bᵀx) is what is left of x, weighed, and leaving out one more is one step.

use crate::machine::separation::banded::{Banded, Factor};
use crate::machine::separation::curves::closure_sign;
use crate::machine::separation::increments::Group;
use crate::machine::separation::outlier::{MOST_OUTLIERS, Outlier, ReadingPlace, stands_out};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use nalgebra::{DMatrix, DVector};

/// One w.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) group: usize,
    pub(super) axis: Axis,
    pub(super) interval: usize,
}

/// The least-squares problem of all w.
pub(super) struct Patterns {
    values: Vec<f64>,
    factor: Factor,
    basis: Vec<Vec<f64>>,
    /// P times the values.
    left: Vec<f64>,
    ramps: Vec<(Axis, Vec<f64>)>,
    /// For each reading, the w that it takes part in and how.
    effects: Vec<(ReadingPlace, Vec<(usize, f64)>)>,
}

/// Where to go back to.
pub(super) struct Mark {
    patterns: usize,
    left: Vec<f64>,
}

/// Straight ramps fitted beside what is left out already.
pub(super) struct RampFit {
    pub(super) change_um: PerAxis<f64>,
    pub(super) u: PerAxis<f64>,
    /// By how much they lower the sum of squares, µm².
    pub(super) drop: f64,
    /// How many there are.
    pub(super) count: usize,
}

/// Shares below this are rounding: such a pattern is left out already.
const NOTHING: f64 = 1e-9;

impl Patterns {
    /// With the constants of the axes left out; `None` where C is singular.
    pub(super) fn new(
        volume: &Volume,
        groups: &[Group],
        rows: Vec<Row>,
        values: Vec<f64>,
        runs: &RunCounts,
        both_passes: bool,
    ) -> Option<Patterns> {
        let effects = effects(volume, groups, &rows, both_passes);
        let factor = covariance(rows.len(), &effects, runs).factor()?;
        let middle = (volume.steps_f64() - 1.0) / 2.0;
        #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 intervals")]
        let ramp = |row: &Row| (row.interval as f64 - middle) / (volume.steps_f64() - 1.0).max(1.0);
        let over = |axis: Axis, value: &dyn Fn(&Row) -> f64| -> Vec<f64> {
            let of = |row: &Row| if row.axis == axis { value(row) } else { 0.0 };
            rows.iter().map(of).collect()
        };
        let constants = Axis::ALL.map(|axis| over(axis, &|_| 1.0));
        let ramps = Axis::ALL.map(|axis| (axis, over(axis, &ramp)));
        let left = factor.solve(&values);
        let mut patterns = Patterns {
            values,
            factor,
            basis: Vec::new(),
            left,
            ramps: ramps.into(),
            effects,
        };
        constants.iter().for_each(|constant| patterns.add(constant));
        Some(patterns)
    }

    /// P x.
    fn projected(&self, x: &[f64]) -> Vec<f64> {
        let mut left = self.factor.solve(x);
        for base in &self.basis {
            less(&mut left, base, dot(base, x));
        }
        left
    }

    fn add(&mut self, pattern: &[f64]) {
        let mut base = self.projected(pattern);
        let weight = dot(pattern, &base);
        if weight > NOTHING * dot(pattern, pattern) {
            base.iter_mut().for_each(|value| *value /= weight.sqrt());
            let share = dot(&base, &self.values);
            less(&mut self.left, &base, share);
            self.basis.push(base);
        }
    }

    pub(super) fn mark(&self) -> Mark {
        Mark {
            patterns: self.basis.len(),
            left: self.left.clone(),
        }
    }

    pub(super) fn back_to(&mut self, mark: &Mark) {
        self.basis.truncate(mark.patterns);
        self.left.clone_from(&mark.left);
    }

    /// Leaves the effect of a reading out, whichever run it is of.
    pub(super) fn leave_out(&mut self, place: &ReadingPlace) {
        let same = |known: &ReadingPlace| {
            (known.diagonal, known.pass, known.node) == (place.diagonal, place.pass, place.node)
        };
        if let Some(index) = self.effects.iter().position(|(known, _)| same(known)) {
            let pattern = self.pattern(index);
            self.add(&pattern);
        }
    }

    pub(super) fn leave_out_ramps(&mut self) {
        for at in 0..self.ramps.len() {
            let ramp = std::mem::take(&mut self.ramps[at].1);
            self.add(&ramp);
            self.ramps[at].1 = ramp;
        }
    }

    /// Q and ν.
    pub(super) fn scatter(&self) -> (f64, usize) {
        let square = dot(&self.values, &self.left);
        let freedom = self.values.len().saturating_sub(self.basis.len());
        (square.max(0.0), freedom)
    }

    /// Q of other values.
    pub(super) fn square_of(&self, values: &[f64]) -> f64 {
        dot(values, &self.projected(values)).max(0.0)
    }

    /// The ramps beside what is left out; `None` where there is too little to tell them.
    pub(super) fn ramps(&self) -> Option<RampFit> {
        let count = self.ramps.len();
        let weighed: Vec<Vec<f64>> = self.ramps.iter().map(|(_, r)| self.projected(r)).collect();
        let normal = DMatrix::from_fn(count, count, |i, j| dot(&self.ramps[i].1, &weighed[j]));
        let right = DVector::from_fn(count, |i, _| dot(&self.ramps[i].1, &self.left));
        let inverse = normal.cholesky()?.inverse();
        let shares = &inverse * &right;
        let at = |axis: Axis| self.ramps.iter().position(|(known, _)| *known == axis);
        Some(RampFit {
            change_um: PerAxis::from_fn(|axis| at(axis).map_or(0.0, |i| shares[i])),
            u: PerAxis::from_fn(|axis| at(axis).map_or(0.0, |i| inverse[(i, i)].sqrt())),
            drop: shares.dot(&right),
            count,
        })
    }

    /// Names disturbed readings one by one, the largest first, until none stands out, and leaves
    /// them out.
    pub(super) fn name_outliers(&mut self, known_sigma_um: Option<f64>) -> Vec<Outlier> {
        let mut found: Vec<Outlier> = Vec::new();
        while found.len() < MOST_OUTLIERS {
            let Some((outlier, pattern)) = self.largest(known_sigma_um) else {
                break;
            };
            self.add(&pattern);
            found.push(outlier);
        }
        found
    }

    fn largest(&self, known_sigma_um: Option<f64>) -> Option<(Outlier, Vec<f64>)> {
        let mut best: Option<(f64, usize)> = None;
        for (index, (_, effect)) in self.effects.iter().enumerate() {
            let share: f64 = effect
                .iter()
                .map(|(row, part)| part * self.left[*row])
                .sum();
            if best.is_none_or(|(largest, _)| share.abs() > largest) {
                best = Some((share.abs(), index));
            }
        }
        let (_, index) = best?;
        let pattern = self.pattern(index);
        let weight = dot(&pattern, &self.projected(&pattern));
        if weight <= NOTHING * dot(&pattern, &pattern) {
            return None;
        }
        let size_um = dot(&pattern, &self.left) / weight;
        let drop = size_um * size_um * weight;
        let readings = self.effects.len();
        let ratio = stands_out((size_um, drop), self.scatter(), known_sigma_um, readings)?;
        let outlier = Outlier {
            readings: self.twins(index),
            size_um,
            ratio,
            of_mean_um: size_um,
        };
        Some((outlier, pattern))
    }

    fn pattern(&self, index: usize) -> Vec<f64> {
        let mut pattern = vec![0.0; self.values.len()];
        for (row, part) in &self.effects[index].1 {
            pattern[*row] += part;
        }
        pattern
    }

    /// All readings whose effect on w is the same but for its sign.
    fn twins(&self, index: usize) -> Vec<ReadingPlace> {
        let rows = |index: usize| {
            let mut rows = self.effects[index].1.clone();
            rows.sort_by_key(|(row, _)| *row);
            rows
        };
        let wanted = rows(index);
        let same = |other: &[(usize, f64)], sign: f64| {
            other.len() == wanted.len()
                && other
                    .iter()
                    .zip(&wanted)
                    .all(|((a, x), (b, y))| a == b && (x - sign * y).abs() < 1e-12)
        };
        let mut twins = vec![self.effects[index].0];
        for (other, (place, _)) in self.effects.iter().enumerate() {
            let theirs = rows(other);
            if other != index && (same(&theirs, 1.0) || same(&theirs, -1.0)) {
                twins.push(*place);
            }
        }
        twins
    }
}

fn less(from: &mut [f64], what: &[f64], times: f64) {
    for (value, part) in from.iter_mut().zip(what) {
        *value -= times * part;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn effects(
    volume: &Volume,
    groups: &[Group],
    rows: &[Row],
    both_passes: bool,
) -> Vec<(ReadingPlace, Vec<(usize, f64)>)> {
    let passes: &[Pass] = if both_passes {
        &Pass::BOTH
    } else {
        &[Pass::Forward]
    };
    let nodes = 3 * volume.steps + 1;
    let mut effects = Vec::with_capacity(passes.len() * 4 * nodes);
    for pass in passes {
        for diagonal in Diagonal::ALL {
            for node in 0..nodes {
                let place = ReadingPlace {
                    diagonal,
                    pass: *pass,
                    run: None,
                    node,
                };
                effects.push((place, Vec::with_capacity(2)));
            }
        }
    }
    let of = |pass: Pass, diagonal: Diagonal, node: usize| {
        let pass = passes.iter().position(|known| *known == pass).unwrap_or(0);
        let line = Diagonal::ALL.iter().position(|known| *known == diagonal);
        (pass * 4 + line.unwrap_or(0)) * nodes + node
    };
    for (index, row) in rows.iter().enumerate() {
        for diagonal in Diagonal::ALL {
            let pass = groups[row.group].pass(diagonal, row.axis);
            let step = volume.interval(diagonal, row.axis, row.interval);
            let node = volume.node_after(row.axis, step);
            let sign = closure_sign(diagonal, row.axis);
            effects[of(pass, diagonal, node)].1.push((index, sign));
            effects[of(pass, diagonal, node - 1)].1.push((index, -sign));
        }
    }
    effects.retain(|(_, effect)| !effect.is_empty());
    effects
}

fn covariance(
    size: usize,
    effects: &[(ReadingPlace, Vec<(usize, f64)>)],
    runs: &RunCounts,
) -> Banded {
    let span = |effect: &[(usize, f64)]| {
        let rows = effect.iter().map(|(row, _)| *row);
        rows.clone().max().unwrap_or(0) - rows.min().unwrap_or(0)
    };
    let reach = effects.iter().map(|(_, effect)| span(effect)).max();
    let mut matrix = Banded::zero(size, reach.unwrap_or(0));
    for (place, effect) in effects {
        let variance = 1.0 / runs[place.diagonal][usize::from(place.pass == Pass::Reverse)];
        for (row, a) in effect {
            for (column, b) in effect {
                if column <= row {
                    matrix.add(*row, *column, a * b * variance);
                }
            }
        }
    }
    matrix
}

/// How many runs stand behind the mean readings.
pub type RunCounts = PerDiagonal<[f64; 2]>;
