//! What is left over: the closure w, its test, and the readings that spoil it (formula 2).
//!
//! Four diagonals give four equations for three unknowns in every interval of every axis, so that
//! one combination w must be zero. A constant on an axis is set-up error or, with a flat mirror,
//! roll; a straight ramp is the roll of an axis that carries others; the rest is noise of the
//! readings or a disturbed reading. w is blind to pitch and yaw and to five of the eight patterns
//! of set-up error: a clean closure proves nothing.
//!
//! A reading takes part in two neighbouring increments, so the w are correlated. With C the
//! covariance of all w for readings of variance 1, and K the patterns that are no noise (the
//! constant of each axis; one for each disturbed reading; the ramps, where they are significant),
//!
//! ```text
//!   Q = min over c of (w − K c)ᵀ C⁻¹ (w − K c)        ~ σ² χ²(ν),  ν = number of w − patterns
//! ```
//! With forward passes only and nothing disturbed ν = 3n − 3. Order of the judgement: disturbed
//! readings are named with the ramps left free, so that a ramp accuses no reading; then the ramps
//! are judged with those readings left out, so that no reading makes a ramp.

mod patterns;

pub use self::patterns::RunCounts;

use self::patterns::{Patterns, Row};
use super::curves::closures;
use super::increments::{Group, Means};
use super::noise::{Noise, NoiseSource};
use super::outlier::{FALSE_DOUBT, Outlier, float};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, Volume};
use crate::quantity::units::Squared;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

/// A ramp of w that no instrument resolves is no roll, however small the noise, µm.
const SMALLEST_RAMP_UM: f64 = 0.02;

/// The closure of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    /// w by axis and machine interval, µm (mean of both directions where there are two).
    pub by_interval: PerAxis<Vec<f64>>,
    /// Its mean over each axis, µm: set-up error or, with a flat mirror, roll.
    pub mean: PerAxis<f64>,
    /// Expected standard deviation of one w of `by_interval` for readings of 1 µm; 2√2 with one run.
    pub scatter: PerAxis<f64>,
    /// Straight ramps of w.
    pub ramps: Option<Ramps>,
    /// Q for readings of 1 µm standard deviation, disturbed readings (and significant ramps) left out.
    pub weighted_square: f64,
    /// ν, degrees of freedom of Q.
    pub freedom: usize,
    /// Disturbed readings: those of single runs first, then those that only the closure shows.
    pub outliers: Vec<Outlier>,
}

/// Straight ramps of w over each axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramps {
    /// From the first interval to the last, µm.
    pub change_um: PerAxis<f64>,
    /// Their standard deviations for readings of 1 µm.
    pub u: PerAxis<f64>,
    /// Probability of ramps at least as large by noise alone.
    pub probability: f64,
}

impl Ramps {
    /// Whether they speak of the roll of an axis that carries others.
    pub fn is_roll(&self) -> bool {
        let largest = self
            .change_um
            .iter()
            .map(|(_, um)| um.abs())
            .fold(0.0, f64::max);
        self.probability < FALSE_DOUBT && largest > SMALLEST_RAMP_UM
    }
}

/// The scatter of the closure against a noise that is known otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterTest {
    /// Probability of a scatter at least as far off, to either side.
    pub probability: f64,
    /// Whether the scatter is larger than the noise says, not smaller.
    pub larger: bool,
}

impl Closure {
    /// Standard deviation of a single reading that the scatter of the closure speaks for, µm;
    /// `None` without degrees of freedom.
    pub fn sigma_um(&self) -> Option<f64> {
        let freedom = float(self.freedom);
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

    /// Two-sided test against a noise that is known otherwise: χ² where it is stated, F where it
    /// comes from repeated runs. `None` where it comes from this closure, so that nothing is tested.
    pub fn test(&self, noise: &Noise) -> Option<ScatterTest> {
        if noise.source == NoiseSource::Closure || self.freedom == 0 || noise.sigma_um <= 0.0 {
            return None;
        }
        let freedom = float(self.freedom);
        let ratio = self.weighted_square / (noise.sigma_um * noise.sigma_um);
        let (below, above) = match noise.freedom {
            Some(of_noise) => {
                let spread = FisherSnedecor::new(freedom, float(of_noise)).ok()?;
                (spread.cdf(ratio / freedom), spread.sf(ratio / freedom))
            }
            None => {
                let spread = ChiSquared::new(freedom).ok()?;
                (spread.cdf(ratio), spread.sf(ratio))
            }
        };
        Some(ScatterTest {
            probability: (2.0 * below.min(above)).min(1.0),
            larger: above < below,
        })
    }

    /// Expected standard deviation of the mean over an axis for a noise, µm.
    pub fn u_mean_um(&self, axis: Axis, sigma_um: f64) -> f64 {
        sigma_um * self.scatter[axis] / float(self.by_interval[axis].len()).sqrt()
    }
}

/// What is known of the readings before the closure is judged.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known<'a> {
    /// Standard deviation of a single reading, where repeats or the job give it.
    pub noise: Option<Noise>,
    /// Disturbed readings of single runs: their share in the means is left out of the test.
    pub outliers: &'a [Outlier],
    /// The first and last interval are left out (missing overrun).
    pub skip_ends: bool,
}

/// The closure of mean readings.
pub fn closure(volume: &Volume, means: &Means, runs: &RunCounts, known: Known<'_>) -> Closure {
    let groups = means.groups();
    let all = by_group(volume, means);
    let by_interval = mean_of(volume, &all);
    let mean = PerAxis::from_fn(|axis| by_interval[axis].iter().sum::<f64>() / volume.steps_f64());
    let judged = patterns(volume, means, &all, runs, known.skip_ends);
    let judged = judged.map(|patterns| judge(patterns, known));
    let judged = judged.unwrap_or_default();
    Closure {
        by_interval,
        mean,
        scatter: PerAxis::from_fn(|axis| scatter(groups, runs, axis)),
        ramps: judged.ramps,
        weighted_square: judged.square,
        freedom: judged.freedom,
        outliers: [known.outliers, &judged.outliers].concat(),
    }
}

/// What is left of readings under some names, with nothing taken out but the constants of the axes
/// and the disturbed readings of single runs: what one naming is compared with another by.
pub(super) struct Undisturbed {
    rows: Vec<Row>,
    patterns: Patterns,
}

impl Undisturbed {
    /// For readings like these; `None` where C is singular.
    pub(super) fn new(
        volume: &Volume,
        means: &Means,
        runs: &RunCounts,
        known: Known<'_>,
    ) -> Option<Undisturbed> {
        let rows = rows(volume, means.groups(), known.skip_ends);
        let mut patterns = patterns(
            volume,
            means,
            &by_group(volume, means),
            runs,
            known.skip_ends,
        )?;
        let named = known.outliers.iter().flat_map(|outlier| &outlier.readings);
        named.for_each(|place| patterns.leave_out(place));
        Some(Undisturbed { rows, patterns })
    }

    /// ν.
    pub(super) fn freedom(&self) -> usize {
        self.patterns.scatter().1
    }

    /// Q for readings of 1 µm standard deviation.
    pub(super) fn square(&self, volume: &Volume, means: &Means) -> f64 {
        self.patterns
            .square_of(&values(&self.rows, &by_group(volume, means)))
    }
}

fn values(rows: &[Row], all: &[PerAxis<Vec<f64>>]) -> Vec<f64> {
    let of = |row: &Row| all[row.group][row.axis][row.interval];
    rows.iter().map(of).collect()
}

/// The least-squares problem of all w; `None` where C is singular.
fn patterns(
    volume: &Volume,
    means: &Means,
    all: &[PerAxis<Vec<f64>>],
    runs: &RunCounts,
    skip_ends: bool,
) -> Option<Patterns> {
    let groups = means.groups();
    let rows = rows(volume, groups, skip_ends);
    let values = values(&rows, all);
    Patterns::new(volume, groups, rows, values, runs, means.reverse.is_some())
}

/// w by axis and interval of every group of readings.
fn by_group(volume: &Volume, means: &Means) -> Vec<PerAxis<Vec<f64>>> {
    let groups = means.groups().iter();
    groups
        .map(|group| closures(volume, &means.increments(volume, *group)))
        .collect()
}

fn mean_of(volume: &Volume, all: &[PerAxis<Vec<f64>>]) -> PerAxis<Vec<f64>> {
    PerAxis::from_fn(|axis| {
        let at = |i: usize| all.iter().map(|w| w[axis][i]).sum::<f64>() / float(all.len());
        (0..volume.steps).map(at).collect::<Vec<f64>>()
    })
}

#[derive(Default)]
struct Judged {
    ramps: Option<Ramps>,
    square: f64,
    freedom: usize,
    outliers: Vec<Outlier>,
}

/// Disturbed readings with the ramps left free; then the ramps without those readings.
fn judge(mut patterns: Patterns, known: Known<'_>) -> Judged {
    let sigma_um = known.noise.map(|noise| noise.sigma_um);
    let named = known.outliers.iter().flat_map(|outlier| &outlier.readings);
    named.for_each(|place| patterns.leave_out(place));
    let before = patterns.mark();
    patterns.leave_out_ramps();
    let outliers = patterns.name_outliers(sigma_um);
    patterns.back_to(&before);
    let found = outliers
        .iter()
        .filter_map(|outlier| outlier.readings.first());
    found.for_each(|place| patterns.leave_out(place));
    let ramps = ramps(&patterns, known.noise);
    if ramps.as_ref().is_some_and(Ramps::is_roll) {
        patterns.leave_out_ramps();
    }
    let (square, freedom) = patterns.scatter();
    Judged {
        ramps,
        square,
        freedom,
        outliers,
    }
}

/// The ramps and how likely noise makes them; `None` where too little is left to judge them by.
fn ramps(patterns: &Patterns, noise: Option<Noise>) -> Option<Ramps> {
    let fit = patterns.ramps()?;
    let (square, freedom) = patterns.scatter();
    let rest = freedom.checked_sub(fit.count).filter(|rest| *rest > 0)?;
    let (variance, freedom) = match noise {
        Some(noise) => (noise.sigma_um.squared(), noise.freedom),
        None => ((square - fit.drop).max(0.0) / float(rest), Some(rest)),
    };
    let ratio = fit.drop / variance;
    let probability = match freedom {
        Some(freedom) => above(ratio, fit.count, freedom)?,
        None => ChiSquared::new(float(fit.count)).ok()?.sf(ratio.max(0.0)),
    };
    Some(Ramps {
        change_um: fit.change_um,
        u: fit.u,
        probability,
    })
}

/// Probability that `count` parameters lower the sum of squares by `ratio` variances or more,
/// the variance known with `freedom` degrees of freedom.
fn above(ratio: f64, count: usize, freedom: usize) -> Option<f64> {
    let spread = FisherSnedecor::new(float(count), float(freedom)).ok()?;
    let f = ratio / float(count);
    if f.is_finite() {
        Some(spread.sf(f.max(0.0)))
    } else {
        Some(0.0)
    }
}

/// Standard deviation of one w, mean of the groups, for readings of 1 µm.
fn scatter(groups: &[Group], runs: &RunCounts, axis: Axis) -> f64 {
    let variance = |group: &Group| {
        let of = |d: Diagonal| {
            let pass = group.pass(d, axis);
            2.0 / runs[d][usize::from(pass == Pass::Reverse)]
        };
        Diagonal::ALL.into_iter().map(of).sum::<f64>()
    };
    groups.iter().map(variance).sum::<f64>().sqrt() / float(groups.len())
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
