//! What is left over: the closure w, its test, and the readings that spoil it (formula 2).
//!
//! Four diagonals give four equations for three unknowns in every interval of every axis, so that
//! one combination w must be zero. Its mean over an axis is set-up error; the rest is noise of the
//! readings, a disturbed reading, or the roll of an axis that carries others. w is blind to pitch
//! and yaw and to five of the eight patterns of set-up error: a clean closure proves nothing.
//!
//! A reading takes part in two neighbouring increments, so the w are correlated. With C the
//! covariance of all w for readings of variance 1, and K the constant of each axis,
//!
//! ```text
//!   Q = min over c of (w − K c)ᵀ C⁻¹ (w − K c)        ~ σ² χ²(ν),  ν = number of w − 3
//! ```
//! With forward passes only ν = 3n − 3.

use super::banded::{Banded, Factor};
use super::curves::{closure_sign, closures};
use super::increments::{Group, Means};
use super::noise::{Noise, NoiseSource};
use crate::axis::{Axis, PerAxis};
use crate::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Chance that a test names a reading of a series without any disturbed one.
const FALSE_ALARM: f64 = 0.01;
/// More disturbed readings than these are no outliers but another kind of trouble.
const MOST_OUTLIERS: usize = 12;

/// What an instrument does not resolve is no disturbance, however small the noise.
const SMALLEST_DISTURBANCE_UM: f64 = 0.02;

/// One reading of a mean run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ReadingPlace {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Forward or reverse.
    pub pass: Pass,
    /// Node of the forward path.
    pub node: usize,
}

/// A disturbed reading, or several of which one is.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlier {
    /// The closure cannot tell these apart; one of them is disturbed.
    pub readings: Vec<ReadingPlace>,
    /// By how much, µm (sign of the first one).
    pub size_um: f64,
    /// The same in standard deviations.
    pub ratio: f64,
}

/// The closure of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    /// w by axis and machine interval, µm (mean of both directions where there are two).
    pub by_interval: PerAxis<Vec<f64>>,
    /// Its mean over each axis, µm: set-up error.
    pub mean: PerAxis<f64>,
    /// Q for readings of 1 µm standard deviation, disturbed readings left out.
    pub weighted_square: f64,
    /// ν, degrees of freedom of Q.
    pub freedom: usize,
    /// Disturbed readings.
    pub outliers: Vec<Outlier>,
}

impl Closure {
    /// Standard deviation of a single reading that the scatter of the closure speaks for, µm;
    /// `None` without degrees of freedom.
    pub fn sigma_um(&self) -> Option<f64> {
        #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 intervals")]
        let freedom = self.freedom as f64;
        (self.freedom > 0).then(|| (self.weighted_square / freedom).sqrt())
    }

    /// The same as noise of the readings.
    pub fn noise(&self) -> Option<Noise> {
        self.sigma_um().map(|sigma_um| Noise {
            sigma_um,
            freedom: Some(self.freedom),
            source: NoiseSource::Closure,
        })
    }

    /// χ² test against a standard deviation that is known otherwise: the probability of a
    /// scatter at least as large.
    pub fn probability(&self, sigma_um: f64) -> Option<f64> {
        #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 intervals")]
        let spread = ChiSquared::new(self.freedom as f64).ok()?;
        (sigma_um > 0.0).then(|| spread.sf(self.weighted_square / (sigma_um * sigma_um)))
    }
}

/// How many runs stand behind the mean readings.
pub type RunCounts = PerDiagonal<[f64; 2]>;

/// The closure of mean readings. `known_sigma_um`: standard deviation of a single reading, where
/// repeats give it. `skip_ends`: the first and last interval are left out (missing overrun).
pub fn closure(
    volume: &Volume,
    means: &Means,
    runs: &RunCounts,
    known_sigma_um: Option<f64>,
    skip_ends: bool,
) -> Closure {
    let groups = means.groups();
    let all: Vec<PerAxis<Vec<f64>>> = groups
        .iter()
        .map(|group| closures(volume, &means.increments(volume, *group)))
        .collect();
    let by_interval = PerAxis::from_fn(|axis| {
        let at = |i: usize| all.iter().map(|w| w[axis][i]).sum::<f64>() / count(all.len());
        (0..volume.steps).map(at).collect::<Vec<f64>>()
    });
    let mean = PerAxis::from_fn(|axis| by_interval[axis].iter().sum::<f64>() / volume.steps_f64());
    let rows = rows(volume, groups, skip_ends);
    let values: Vec<f64> = rows
        .iter()
        .map(|row| all[row.group][row.axis][row.interval])
        .collect();
    let test = Test::new(volume, groups, rows, values, runs, means.reverse.is_some());
    let (weighted_square, freedom, outliers) = test.map_or((0.0, 0, Vec::new()), |mut test| {
        let outliers = test.outliers(known_sigma_um);
        let (square, freedom) = test.scatter();
        (square, freedom, outliers)
    });
    Closure {
        by_interval,
        mean,
        weighted_square,
        freedom,
        outliers,
    }
}

#[allow(clippy::cast_precision_loss, reason = "two directions at most")]
fn count(groups: usize) -> f64 {
    groups as f64
}

/// One w.
#[derive(Clone, Copy)]
struct Row {
    group: usize,
    axis: Axis,
    interval: usize,
}

/// All w, those that share readings close to each other: diagonals that travel an axis in −
/// cross its intervals from the other end.
fn rows(volume: &Volume, groups: &[Group], skip_ends: bool) -> Vec<Row> {
    let last = volume.steps - 1;
    let mut rows = Vec::new();
    for group in 0..groups.len() {
        for axis in Axis::ALL {
            for interval in 0..volume.steps {
                if !(skip_ends && (interval == 0 || interval == last)) {
                    rows.push(Row {
                        group,
                        axis,
                        interval,
                    });
                }
            }
        }
    }
    rows.sort_by_key(|row| (row.interval.min(last - row.interval), row.interval));
    rows
}

/// The generalised least-squares test of all w.
struct Test {
    values: Vec<f64>,
    factor: Factor,
    /// Patterns of w that are not noise: the constant of each axis, then one for each outlier.
    patterns: Vec<Vec<f64>>,
    /// For each reading, the w that it takes part in and how.
    effects: Vec<(ReadingPlace, Vec<(usize, f64)>)>,
}

impl Test {
    fn new(
        volume: &Volume,
        groups: &[Group],
        rows: Vec<Row>,
        values: Vec<f64>,
        runs: &RunCounts,
        both_passes: bool,
    ) -> Option<Test> {
        let effects = effects(volume, groups, &rows, both_passes);
        let factor = covariance(rows.len(), &effects, runs).factor()?;
        let of_axis = |axis: Axis| rows.iter().map(|row| f64::from(row.axis == axis)).collect();
        Some(Test {
            values,
            factor,
            patterns: Axis::ALL.map(of_axis).into(),
            effects,
        })
    }

    /// P w with P = C⁻¹ − C⁻¹K (KᵀC⁻¹K)⁻¹ KᵀC⁻¹.
    fn projected(&self, w: &[f64]) -> Vec<f64> {
        let solved = self.factor.solve(w);
        let weighed: Vec<Vec<f64>> = self.patterns.iter().map(|k| self.factor.solve(k)).collect();
        let size = self.patterns.len();
        let normal = DMatrix::from_fn(size, size, |i, j| dot(&self.patterns[i], &weighed[j]));
        let right = DVector::from_fn(size, |i, _| dot(&self.patterns[i], &solved));
        let Some(shares) = normal.cholesky().map(|factor| factor.solve(&right)) else {
            return solved;
        };
        let mut left = solved;
        for (share, weighed) in shares.iter().zip(&weighed) {
            for (value, part) in left.iter_mut().zip(weighed) {
                *value -= share * part;
            }
        }
        left
    }

    /// Q and ν.
    fn scatter(&self) -> (f64, usize) {
        let square = dot(&self.values, &self.projected(&self.values));
        let freedom = self.values.len().saturating_sub(self.patterns.len());
        (square.max(0.0), freedom)
    }

    /// Names disturbed readings one by one, the largest first, until none stands out.
    fn outliers(&mut self, known_sigma_um: Option<f64>) -> Vec<Outlier> {
        let mut found: Vec<Outlier> = Vec::new();
        while found.len() < MOST_OUTLIERS {
            let Some((outlier, pattern)) = self.largest(known_sigma_um) else {
                break;
            };
            self.patterns.push(pattern);
            found.push(outlier);
        }
        found
    }

    fn largest(&self, known_sigma_um: Option<f64>) -> Option<(Outlier, Vec<f64>)> {
        let left = self.projected(&self.values);
        let (square, freedom) = self.scatter();
        let mut best: Option<(f64, usize)> = None;
        for (index, (_, effect)) in self.effects.iter().enumerate() {
            let share: f64 = effect.iter().map(|(row, part)| part * left[*row]).sum();
            if best.is_none_or(|(largest, _)| share.abs() > largest) {
                best = Some((share.abs(), index));
            }
        }
        let (_, index) = best?;
        let pattern = self.pattern(index);
        let weighed = self.projected(&pattern);
        let weight = dot(&pattern, &weighed);
        let size_um = dot(&pattern, &left) / weight;
        let drop = size_um * size_um * weight;
        let variance = match known_sigma_um {
            Some(sigma) => sigma * sigma,
            None if freedom > 1 => (square - drop).max(0.0) / freedom_of(freedom - 1),
            None => return None,
        };
        let ratio = (drop / variance).sqrt();
        let limit = self.limit(known_sigma_um.map_or(freedom.saturating_sub(1), |_| usize::MAX))?;
        (weight > 0.0 && ratio > limit && size_um.abs() > SMALLEST_DISTURBANCE_UM).then(|| {
            let outlier = Outlier {
                readings: self.twins(index),
                size_um,
                ratio,
            };
            (outlier, pattern)
        })
    }

    /// Two-sided limit with the chance of a false alarm shared among all readings.
    fn limit(&self, freedom: usize) -> Option<f64> {
        #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 readings")]
        let readings = self.effects.len() as f64;
        let spread = StudentsT::new(0.0, 1.0, freedom_of(freedom.min(100_000))).ok()?;
        Some(spread.inverse_cdf(1.0 - FALSE_ALARM / 2.0 / readings))
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

#[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 readings")]
fn freedom_of(freedom: usize) -> f64 {
    freedom as f64
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
