//! Disturbed readings: what is said of them, and when a reading counts as disturbed.
//!
//! A reading is named where taking it for unknown lowers the sum of squares more than chance
//! allows: t = size/u(size) against Student's t, with one false alarm in a hundred measurements
//! shared among all readings. The standard deviation is that of the others.

use crate::quantity::diagonal::{Diagonal, Pass};
use crate::quantity::units::Figure;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Chance that a test names a reading of a series without any disturbed one.
const FALSE_ALARM: f64 = 0.01;

/// Chance that a test of the whole closure (scatter, ramps, mean) speaks against a sound
/// measurement: rarer than the naming of a reading, because no repeated run answers it.
pub const FALSE_DOUBT: f64 = 0.001;

/// More disturbed readings than these are no outliers but another kind of trouble.
pub const MOST_OUTLIERS: usize = 12;

/// What an instrument does not resolve is no disturbance, however small the noise, µm.
pub const SMALLEST_DISTURBANCE_UM: f64 = 0.02;

/// A larger ratio says no more.
const LARGEST_RATIO: f64 = 1000.0;

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ReadingPlace {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Forward or reverse.
    pub pass: Pass,
    /// Number of the run, as in the file; `None` = the mean of all runs of the pass.
    pub run: Option<u32>,
    /// Node of the forward path.
    pub node: usize,
}

impl std::fmt::Display for ReadingPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ", self.diagonal)?;
        if let Some(run) = self.run {
            write!(f, "run {run} ")?;
        }
        write!(f, "{} node {}", self.pass.word(), self.node)
    }
}

/// A disturbed reading, or several of which one is.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlier {
    /// These cannot be told apart; one of them is disturbed.
    pub readings: Vec<ReadingPlace>,
    /// By how much, µm (sign of the first one).
    pub size_um: f64,
    /// The same in standard deviations.
    pub ratio: f64,
    /// By how much the mean over the runs is off, µm: that is what was separated.
    pub of_mean_um: f64,
}

impl Outlier {
    /// Which reading, by how much, in words.
    pub fn words(&self) -> String {
        let places: Vec<String> = self.readings.iter().map(ReadingPlace::to_string).collect();
        // Readings without noise leave no scatter to compare with.
        let ratio = match self.ratio < LARGEST_RATIO {
            true => format!("{:.1}", self.ratio),
            false => format!("more than {LARGEST_RATIO}"),
        };
        format!(
            "{}: {:+.3} µm, {ratio} standard deviations",
            places.join(" or "),
            Figure(self.size_um),
        )
    }
}

/// A candidate by what the sum of squares `square` of `freedom` loses with it: its ratio, if it
/// counts as disturbed. `sigma_um`: the standard deviation where it is known otherwise.
pub(super) fn stands_out(
    (size_um, drop): (f64, f64),
    (square, freedom): (f64, usize),
    sigma_um: Option<f64>,
    readings: usize,
) -> Option<f64> {
    let rest = freedom.saturating_sub(1);
    let (variance, freedom) = match sigma_um {
        Some(sigma) => (sigma * sigma, usize::MAX),
        None if rest > 0 => ((square - drop).max(0.0) / float(rest), rest),
        None => return None,
    };
    let ratio = (drop / variance).sqrt();
    let spread = StudentsT::new(0.0, 1.0, float(freedom.min(100_000))).ok()?;
    let limit = spread.inverse_cdf(1.0 - FALSE_ALARM / 2.0 / float(readings));
    (ratio > limit && size_um.abs() > SMALLEST_DISTURBANCE_UM).then_some(ratio)
}

#[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 readings")]
pub(super) const fn float(count: usize) -> f64 {
    count as f64
}
