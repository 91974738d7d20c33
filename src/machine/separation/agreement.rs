//! Whether linear axes, beams and diagonals agree: the redundancy of formula (7).
//!
//! ```text
//!   χ² = min over θ of (y − Mθ)ᵀ V⁻¹ (y − Mθ)       ~ χ²(ν),   ν = number of equations − rank
//!   a line against all others:   stated − vᵀhv, with h solved from (7) without that line
//! ```
//! With the four diagonals and three linear axes ν = 1: X²p_xx + Y²p_yy + Z²p_zz against S. It is
//! the only thing that notices a slope of the wrong sign or unit, or a wrong edge of the box; which
//! of the equations is wrong it cannot tell. A line whose uncertainty is not known counts as exact.

use super::metric::{
    DiagonalEquation, Equations, Metric, Plane, StraightLine, TotalsUncertainty, row,
};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{PerDiagonal, Volume};
use crate::quantity::units::Figure;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Below this probability the equations contradict each other.
const SMALL_PROBABILITY: f64 = 0.01;

/// What to do about a contradiction.
pub const CHECK: &str = "check sign, unit, `laser_sign`, the size of the box, temperature and air";

/// One line against the diagonals and all other lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineCheck {
    /// Its direction, of length 1.
    pub direction: PerAxis<f64>,
    /// Its slope as measured (a beam: less the shapes between its ends), µm/m.
    pub stated_um_per_m: f64,
    /// What everything else says of it; `None` where nothing else does.
    pub others: Option<Others>,
}

/// What everything else says of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Others {
    /// Its slope, µm/m.
    pub found_um_per_m: f64,
    /// Standard uncertainty (k = 1) of stated − found, µm/m.
    pub u_difference_um_per_m: f64,
}

impl LineCheck {
    /// Stated − found, µm/m, and the same in standard deviations.
    pub fn difference(&self) -> Option<(f64, f64)> {
        let others = self.others?;
        let difference = self.stated_um_per_m - others.found_um_per_m;
        Some((difference, difference / others.u_difference_um_per_m))
    }

    /// `X` for a linear axis, else `beam` and its direction.
    pub fn name(&self) -> String {
        let along = |axis: &Axis| (self.direction[*axis].abs() - 1.0).abs() < 1e-9;
        match Axis::ALL.iter().find(|axis| along(axis)) {
            Some(axis) => axis.to_string(),
            None => {
                let PerAxis { x, y, z } = self.direction;
                format!("beam ({x:.2}, {y:.2}, {z:.2})")
            }
        }
    }
}

/// The test of what is redundant.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// Weighed residuals.
    pub chi_squared: f64,
    /// ν, number of redundant equations, at least 1.
    pub freedom: usize,
    /// Probability of residuals at least as large; `None` where the noise of the readings is not known.
    pub probability: Option<f64>,
    /// The lines, in the order of the job.
    pub lines: Vec<LineCheck>,
    /// Whether a line's uncertainty is not known: it counts as exact in this test.
    pub taken_as_exact: bool,
}

impl Agreement {
    /// Whether the equations contradict each other.
    pub fn is_refuted(&self) -> bool {
        self.probability.is_some_and(|p| p < SMALL_PROBABILITY)
    }

    /// The contradiction in one sentence; `None` where there is none.
    pub fn contradiction(&self) -> Option<String> {
        if !self.is_refuted() {
            return None;
        }
        let says = |line: &LineCheck| {
            let (um_per_m, ratio) = line.difference()?;
            let (name, um_per_m, ratio) = (line.name(), Figure(um_per_m), ratio.abs());
            Some(format!(
                "{name} by {um_per_m:+.3} µm/m ({ratio:.1} standard deviations)"
            ))
        };
        let all: Vec<String> = self.lines.iter().filter_map(says).collect();
        let missing = if self.taken_as_exact {
            "; a line without `u_um_per_m` counts as exact here: state it"
        } else {
            ""
        };
        Some(format!(
            "linear axes and diagonals DISAGREE: each against all others, {}; {CHECK}{missing}; no uncertainty of scales and squareness and no tilt is given",
            all.join(", ")
        ))
    }
}

/// Tests the redundancy; `None` where there is none.
pub fn agreement(
    volume: &Volume,
    diagonals: &PerDiagonal<DiagonalEquation>,
    totals: &TotalsUncertainty,
    lines: &[StraightLine],
    metric: &Metric,
) -> Option<Agreement> {
    let equations = Equations::new(volume, diagonals, totals, lines);
    let freedom = equations.redundancy();
    if freedom == 0 {
        return None;
    }
    let largest = largest_slope(metric);
    let variances = equations.test_variances(largest);
    let solution = equations
        .system(&equations.covariance(&variances))
        .solve()?;
    let check = |(index, line): (usize, &StraightLine)| {
        let mut rest = lines.to_vec();
        rest.remove(index);
        let rest = Equations::new(volume, diagonals, totals, &rest);
        LineCheck {
            direction: line.direction,
            stated_um_per_m: line.slope_um_per_m,
            others: rest.others(&line.direction, largest, variances[4 + index]),
        }
    };
    #[allow(clippy::cast_precision_loss, reason = "a handful of lines")]
    let spread = ChiSquared::new(freedom as f64).ok()?;
    Some(Agreement {
        chi_squared: solution.chi_squared,
        freedom,
        probability: totals.known.then(|| spread.sf(solution.chi_squared)),
        lines: lines.iter().enumerate().map(check).collect(),
        taken_as_exact: lines.iter().any(|line| line.u_um_per_m.is_none()),
    })
}

impl Equations {
    /// What these equations say of a line that is not among them, of this variance.
    fn others(&self, direction: &PerAxis<f64>, largest: f64, variance: f64) -> Option<Others> {
        let row = row(direction);
        if !self.space.holds(&row) {
            return None;
        }
        let solution = self
            .system(&self.covariance(&self.test_variances(largest)))
            .solve()?;
        let (found_um_per_m, found_variance) = solution.along(&row);
        Some(Others {
            found_um_per_m,
            u_difference_um_per_m: (variance + found_variance).sqrt(),
        })
    }
}

fn largest_slope(metric: &Metric) -> f64 {
    let scales = Axis::ALL.into_iter().filter_map(|axis| metric.scale[axis]);
    let squareness = Plane::ALL
        .into_iter()
        .filter_map(|plane| metric.squareness.of(plane));
    scales
        .chain(squareness)
        .fold(0.0, |largest: f64, slope| largest.max(slope.abs()))
}
