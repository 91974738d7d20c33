//! Whether linear axes, beams and diagonals agree: the redundancy of formula (7).
//!
//! ```text
//!   χ² = min over θ of (y − Mθ)ᵀ V⁻¹ (y − Mθ)       ~ χ²(ν),   ν = number of equations − rank
//!   a line against all others:   stated − vᵀhv, with h solved from (7) without that line
//! ```
//! With the four diagonals and three linear axes ν = 1: X²p_xx + Y²p_yy + Z²p_zz against S. It is
//! the only thing that notices a slope of the wrong sign or unit, or a wrong edge of the box; which
//! of the equations is wrong it cannot tell. A line whose uncertainty is not known counts as exact.

use super::findings::SeparationFinding;
use super::metric::{Equation, Equations, Metric};
use super::noise::{NORMAL_ONE_SIDED, chance_of};
use crate::quantity::{Axis, Diagonal, Figure, PerAxis};
use crate::text::joined;

/// Below this probability the equations contradict each other.
const SMALL_PROBABILITY: f64 = 0.001;
/// The first four equations are those of the diagonals.
const DIAGONALS: usize = 4;

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
    /// By how much each equation may be false if it alone is: the diagonals, then the lines, µm/m.
    pub(super) false_by_um_per_m: Vec<f64>,
}

impl Agreement {
    /// Whether the equations contradict each other.
    pub fn is_refuted(&self) -> bool {
        self.probability.is_some_and(|p| p < SMALL_PROBABILITY)
    }

    /// The contradiction; `None` where there is none.
    pub(crate) fn contradiction(&self) -> Option<SeparationFinding> {
        let says = |line: &LineCheck| {
            let (um_per_m, ratio) = line.difference()?;
            let (name, um_per_m, ratio) = (line.name(), Figure(um_per_m), ratio.abs());
            Some(format!("{name} by {um_per_m:+.3} µm/m ({ratio:.1} standard deviations)"))
        };
        self.is_refuted().then(|| SeparationFinding::LinesDisagree {
            lines: joined(self.lines.iter().filter_map(says)),
            taken_as_exact: self.taken_as_exact,
        })
    }
}

impl Equations {
    /// Tests the redundancy; `None` where there is none, or no line beside the four diagonals (of a thin box they
    /// determine less).
    pub(super) fn agreement(&self, found: &Metric) -> Option<Agreement> {
        let freedom = self.redundancy();
        if freedom == 0 || self.all.len() <= Diagonal::ALL.len() {
            return None;
        }
        let largest = found.largest_um_per_m();
        let variances = self.test_variances(largest);
        let chi_squared = self.solved_with(|one| one.direction, &variances)?.chi_squared;
        let check = |(index, one): (usize, &Equation)| {
            let rest = self.without(index);
            let solved = || rest.solved_with(|one| one.direction, &rest.test_variances(largest));
            let found = rest.holds(&one.direction).then(solved).flatten();
            let others = found.map(|solution| {
                let (found_um_per_m, variance) = solution.along(&one.direction);
                let u_difference_um_per_m = (variances[index] + variance).sqrt();
                Others { found_um_per_m, u_difference_um_per_m }
            });
            LineCheck { direction: one.direction, stated_um_per_m: one.value, others }
        };
        let mut lines: Vec<LineCheck> = self.all.iter().enumerate().map(check).collect();
        let false_by = |line: &LineCheck| {
            let by = line.difference().zip(line.others).map_or(0.0, |((by, _), others)| {
                by.abs() - NORMAL_ONE_SIDED * others.u_difference_um_per_m
            });
            by.max(0.0)
        };
        let false_by_um_per_m = lines.iter().map(false_by).collect();
        let known = self.all[..DIAGONALS].iter().all(|one| one.known);
        Some(Agreement {
            chi_squared,
            freedom,
            probability: chance_of(chi_squared, freedom, None).filter(|_| known),
            lines: lines.split_off(DIAGONALS),
            taken_as_exact: self.all[DIAGONALS..].iter().any(|line| !line.known),
            false_by_um_per_m,
        })
    }
}
