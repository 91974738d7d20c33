//! All w in one least-squares problem, and the patterns in them that are no noise.
//!
//! The patterns are kept as an orthonormal basis in the metric of C⁻¹, so that
//! P x = C⁻¹x − Σ b (bᵀx) is what is left of x, weighed, and leaving out one more is one step.

use super::banded::{Banded, Factor};
use super::curves::{closure_sign, closures};
use super::noise::{
    DIGIT_UM, FALSE_DOUBT, MOST_OUTLIERS, NORMAL_ONE_SIDED, Noise, Outlier, ReadingPlace,
    UNRESOLVED_UM, chance_of, float, stands_out,
};
use super::readings::{Group, Means, RunCounts};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;
use nalgebra::{Matrix3, Vector3};

/// What is known of the readings before the closure is judged.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known<'a> {
    /// Standard deviation of a single reading, where repeats or the job give it.
    pub(super) noise: Option<Noise>,
    /// Disturbed readings of single runs: their share in the means is left out of the test.
    pub(super) outliers: &'a [Outlier],
    /// The first and last interval are left out (missing overrun).
    pub(super) skip_ends: bool,
    /// What one standard uncertainty of each stated angle does to the readings, for each order of the axes.
    pub(super) angles: &'a [Vec<Means>],
}

impl Known<'_> {
    /// All w, with nothing taken out but the constants of the axes and the disturbed readings of single
    /// runs; `None` where C is singular.
    pub(super) fn patterns(
        &self,
        volume: &Volume,
        means: &Means,
        runs: &RunCounts,
    ) -> Option<Patterns> {
        let mut patterns = Patterns::new(volume, means, runs, self.skip_ends)?;
        patterns.leave_out(self.outliers.iter().flat_map(|outlier| &outlier.readings));
        Some(patterns)
    }
}

/// One w.
#[derive(Clone, Copy)]
struct Row {
    group: usize,
    axis: Axis,
    interval: usize,
}

/// The least-squares problem of all w.
pub(super) struct Patterns {
    rows: Vec<Row>,
    values: Vec<f64>,
    factor: Factor,
    /// The straight ramp of each axis.
    ramps: [Vec<f64>; 3],
    /// For each reading, the w that it takes part in and how.
    effects: Vec<(ReadingPlace, Vec<(usize, f64)>)>,
    pub(super) out: LeftOut,
}

/// What is left out so far.
#[derive(Clone, Default)]
pub(super) struct LeftOut {
    basis: Vec<Vec<f64>>,
    /// P times the values.
    left: Vec<f64>,
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
    /// With the constants of the axes left out; `None` where C is singular. `skip_ends`: without the
    /// first and last interval.
    pub(super) fn new(
        volume: &Volume,
        means: &Means,
        runs: &RunCounts,
        skip_ends: bool,
    ) -> Option<Patterns> {
        let rows = rows(volume, means.groups(), skip_ends);
        let effects = effects(volume, means, &rows);
        let factor = covariance(rows.len(), &effects, runs).factor()?;
        let values = values(volume, means, &rows);
        let middle = (volume.steps_f64() - 1.0) / 2.0;
        let ramp = |row: &Row| (float(row.interval) - middle) / (2.0 * middle).max(1.0);
        let over = |axis: Axis, value: &dyn Fn(&Row) -> f64| -> Vec<f64> {
            let of = |row: &Row| if row.axis == axis { value(row) } else { 0.0 };
            rows.iter().map(of).collect()
        };
        let constants = Axis::ALL.map(|axis| over(axis, &|_| 1.0));
        let ramps = Axis::ALL.map(|axis| over(axis, &ramp));
        let mut patterns = Patterns {
            out: LeftOut { basis: Vec::new(), left: factor.solve(&values) },
            rows,
            values,
            factor,
            ramps,
            effects,
        };
        constants.iter().for_each(|constant| patterns.add(constant));
        Some(patterns)
    }

    /// P x.
    fn projected(&self, x: &[f64]) -> Vec<f64> {
        let mut left = self.factor.solve(x);
        for base in &self.out.basis {
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
            less(&mut self.out.left, &base, share);
            self.out.basis.push(base);
        }
    }

    /// Leaves the effects of disturbed readings out, whichever runs they are of.
    pub(super) fn leave_out<'a>(&mut self, places: impl Iterator<Item = &'a ReadingPlace>) {
        let key = |place: &ReadingPlace| (place.diagonal, place.pass, place.node);
        for place in places {
            let same = |(known, _): &(ReadingPlace, _)| key(known) == key(place);
            if let Some(index) = self.effects.iter().position(same) {
                let pattern = self.pattern(index);
                self.add(&pattern);
            }
        }
    }

    /// Leaves out what a cause does to the readings.
    pub(super) fn leave_out_effect(&mut self, volume: &Volume, means: &Means) {
        let pattern = values(volume, means, &self.rows);
        self.add(&pattern);
    }

    pub(super) fn leave_out_ramps(&mut self) {
        for ramp in self.ramps.clone() {
            self.add(&ramp);
        }
    }

    /// Q and ν.
    pub(super) fn scatter(&self) -> (f64, usize) {
        let square = dot(&self.values, &self.out.left);
        let freedom = self.values.len().saturating_sub(self.out.basis.len());
        (square.max(0.0), freedom)
    }

    /// Q of other readings.
    pub(super) fn square_of(&self, volume: &Volume, means: &Means) -> f64 {
        let values = values(volume, means, &self.rows);
        dot(&values, &self.projected(&values)).max(0.0)
    }

    /// The ramps beside what is left out, and how likely noise and the stated angles make them: by the order of
    /// the axes that explains them best. `None` where too little is left to tell them or to judge them by.
    pub(super) fn ramps(&self, volume: &Volume, known: Known<'_>) -> Option<Ramps> {
        let weighed = self.ramps.each_ref().map(|ramp| self.projected(ramp));
        let normal = Matrix3::from_fn(|i, j| dot(&self.ramps[i], &weighed[j]));
        let inverse = normal.cholesky()?.inverse();
        let of = |values: &[f64]| inverse * Vector3::from_fn(|i, _| dot(&weighed[i], values));
        let shares = of(&self.values);
        let (square, freedom) = self.scatter();
        let rest = freedom.checked_sub(3).filter(|rest| *rest > 0)?;
        let drop = (normal * shares).dot(&shares);
        let (variance, freedom) = match known.noise {
            Some(noise) => (noise.sigma_um.max(DIGIT_UM).squared(), noise.freedom),
            None => ((square - drop).max(0.0) / float(rest), Some(rest)),
        };
        let chance = |angles: &[Means]| {
            let of_angle = |means: &Means| of(&values(volume, means, &self.rows));
            let spread = angles.iter().map(of_angle).map(|c| c * c.transpose());
            let spread = spread.fold(inverse * variance, |sum, one| sum + one);
            let ratio =
                spread.cholesky().map_or(f64::INFINITY, |of| of.solve(&shares).dot(&shares));
            let u = PerAxis { x: spread.m11, y: spread.m22, z: spread.m33 };
            Some((chance_of(ratio, 3, freedom)?, u))
        };
        let by_noise = chance(&[])?;
        let of_orders = known.angles.iter().filter_map(|angles| chance(angles));
        let likeliest =
            of_orders.fold(by_noise, |best, one| if one.0 > best.0 { one } else { best });
        let (probability, variance) = likeliest;
        let beyond =
            |axis: Axis, um: f64| (um.abs() - NORMAL_ONE_SIDED * variance[axis].sqrt()).max(0.0);
        Some(Ramps {
            change_um: PerAxis { x: shares.x, y: shares.y, z: shares.z },
            u: PerAxis { x: inverse.m11.sqrt(), y: inverse.m22.sqrt(), z: inverse.m33.sqrt() },
            by_noise: by_noise.0,
            probability,
            beyond_um: PerAxis {
                x: beyond(Axis::X, shares.x),
                y: beyond(Axis::Y, shares.y),
                z: beyond(Axis::Z, shares.z),
            },
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
            let share: f64 = effect.iter().map(|(row, part)| part * self.out.left[*row]).sum();
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
        let size_um = dot(&pattern, &self.out.left) / weight;
        let drop = size_um * size_um * weight;
        let readings = self.effects.len();
        let ratio = stands_out((size_um, drop), self.scatter(), known_sigma_um, readings)?;
        let outlier = Outlier { readings: self.twins(index), size_um, ratio, of_mean_um: size_um };
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

/// w by axis and interval of every group of readings, as rows.
fn values(volume: &Volume, means: &Means, rows: &[Row]) -> Vec<f64> {
    let all = by_group(volume, means);
    let of = |row: &Row| all[row.group][row.axis][row.interval];
    rows.iter().map(of).collect()
}

/// w by axis and interval of every group of readings.
pub(super) fn by_group(volume: &Volume, means: &Means) -> Vec<PerAxis<Vec<f64>>> {
    let groups = means.groups().iter();
    groups.map(|group| closures(volume, &means.increments(volume, *group))).collect()
}

/// All w, those that share readings close to each other: diagonals that travel an axis in −
/// cross its intervals from the other end.
fn rows(volume: &Volume, groups: &[Group], skip_ends: bool) -> Vec<Row> {
    let last = volume.steps - 1;
    let intervals = (0..volume.steps).filter(|at| !(skip_ends && (*at == 0 || *at == last)));
    let of_interval = |interval: usize| {
        (0..groups.len()).flat_map(move |group| Axis::ALL.map(|axis| Row { group, axis, interval }))
    };
    let mut rows: Vec<Row> = intervals.flat_map(of_interval).collect();
    rows.sort_by_key(|row| (row.interval.min(last - row.interval), row.interval));
    rows
}

fn effects(volume: &Volume, means: &Means, rows: &[Row]) -> Vec<(ReadingPlace, Vec<(usize, f64)>)> {
    let passes = 1 + usize::from(means.reverse.is_some());
    let nodes = 3 * volume.steps + 1;
    let mut effects = Vec::with_capacity(passes * 4 * nodes);
    for pass in &Pass::BOTH[..passes] {
        for diagonal in Diagonal::ALL {
            effects.extend((0..nodes).map(|node| {
                let place = ReadingPlace { diagonal, pass: *pass, run: None, node };
                (place, Vec::with_capacity(2))
            }));
        }
    }
    let mut first = (0..4).map(|line| line * nodes);
    let first = PerDiagonal::from_fn(|_| first.next().unwrap_or(0));
    for (index, row) in rows.iter().enumerate() {
        for diagonal in Diagonal::ALL {
            let pass = means.groups()[row.group].pass(diagonal, row.axis);
            let step = volume.interval(diagonal, row.axis, row.interval);
            let back = usize::from(pass == Pass::Reverse) * 4 * nodes;
            let at = back + first[diagonal] + volume.node_after(row.axis, step);
            let sign = closure_sign(diagonal, row.axis);
            effects[at].1.push((index, sign));
            effects[at - 1].1.push((index, -sign));
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
