//! Scales and squareness from the totals, free of the mirror's tilt (formula 7).
//!
//! A flat mirror measures along its normal g_d = u_d + η_d, where η_d is unknown in every set-up.
//! The measured displacement per commanded unit of axis k is q_dk. With A = I + P (P: slopes of
//! the nine curves) q_d = Aᵀ g_d and |g_d| = 1, so that, with h = (P + Pᵀ)/2,
//!
//! ```text
//!   (|q_d|² − 1)/2 = Σ_k q_dk² h_kk + q_dx q_dy φxy + q_dx q_dz φxz + q_dy q_dz φyz      (7)
//!   slope of EKK along axis k                = h_kk                        (a linear axis)
//!   slope along a straight line of direction v = vᵀ h v                    (another beam)
//! ```
//! No rotation occurs in (7): h is the metric of the axis triad. Four diagonals give the three
//! squareness errors and one combination of the scales; two linear axes or other beams close it.
//! Generalised least squares with V, the covariance of the equations:
//!
//! ```text
//!   y = M θ + v      cov(v) = V       θ = three scales, three squareness errors; V without unmeasured angles, which
//!                                     weigh nothing and count in u² alone
//!   θ̂ = B (BᵀMᵀV⁻¹MB)⁻¹ BᵀMᵀV⁻¹ y     B: orthonormal, the combinations that nominal directions determine
//! ```
//! Source: derived and confirmed by simulation in the project's reference on the step-diagonal
//! method (docs/method.md §5); same idea as Ibaraki and Hata (2010). Neglected: P², about 10⁻⁹.
//! Exact for any η where the beam meets the mirror along its normal; at an angle α to it every
//! diagonal reads α²/2 short.

use super::campaign::MeasuredLine;
use super::readings::{NORMAL_ONE_SIDED, chance_of};
use crate::machine::findings::SeparationFinding;
use crate::quantity::{Axis, ErrorTerm, Figure, PerAxis, PerPlane, Plane, Squared};
use crate::text::{Finding, joined};
use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector6};
use nonius_numerics::rows::{Model, Row, Uncertainty, Weights};
use serde::Serialize;

/// Of the largest singular value: below this a direction of the unknowns is not measured.
const RANK_TOLERANCE: f64 = 1e-9;
/// A share of an unknown in what is not measured, below which it counts as determined; also a
/// share of an equation in an unknown, below which the unknown does not depend on it.
const SHARE_TOLERANCE: f64 = 1e-6;
pub(super) const UM_PER_M: f64 = 1e-6;
/// What (7) neglects, µm/m. No equation is weighed as if it were more certain: readings without
/// any noise would make the system singular beside a line with a stated uncertainty.
const NEGLECTED_UM_PER_M: f64 = 1e-3;
/// Uncertainty that weighs totals where neither noise nor a statement gives one, µm/m.
const WEIGHT_UM_PER_M: f64 = 1.0;

/// What is measured of a triad's metric: the scales of X, Y, Z, then the squareness of the planes.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    unknowns: [Estimated; 6],
    /// Number of combinations of the six unknowns that the data determine.
    pub rank: usize,
    /// How much φ moves with what is not determined of the scales, because the mirrors are tilted,
    /// µm/m for each µm/m; 0 where all is determined.
    pub leak: PerPlane<f64>,
}

/// One of the six unknowns as the equations give it.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimated {
    /// How it hangs on what was measured, µm/m; nothing without a solution.
    pub(super) row: Row,
    /// Its value, µm/m; `None` = not determined by the data.
    pub um_per_m: Option<f64>,
    /// Whether the uncertainties of all that it depends on are known.
    pub(super) is_known: bool,
    /// Its uncertainty; `None` = not known.
    pub u: Option<Uncertainty>,
}

impl Estimated {
    fn new(row: Row, um_per_m: Option<f64>, is_known: bool, model: &Model) -> Estimated {
        let u = is_known.then(|| model.uncertainty(model.variance(&row))).flatten();
        Estimated { row, um_per_m, is_known, u }
    }

    /// U, µm/m: its uncertainty with the coverage factor of its degrees of freedom.
    pub fn expanded_um_per_m(&self) -> Option<f64> {
        self.u.map(|u| u.expanded())
    }
}

impl Metric {
    /// Slope of EXX, EYY or EZZ.
    pub fn scale(&self, axis: Axis) -> &Estimated {
        &self.unknowns[axis as usize]
    }

    /// Squareness φ: positive = the angle between the positive axis directions is less than 90°.
    pub fn squareness(&self, plane: Plane) -> &Estimated {
        &self.unknowns[3 + plane as usize]
    }

    /// φ of each plane, µm/m.
    pub fn squareness_um_per_m(&self) -> PerPlane<Option<f64>> {
        PerPlane::from_fn(|plane| self.squareness(plane).um_per_m)
    }

    /// Its uncertainty; `None` = not known.
    pub fn u_squareness(&self) -> PerPlane<Option<Uncertainty>> {
        PerPlane::from_fn(|plane| self.squareness(plane).u)
    }

    /// Another φ, which is known.
    pub(super) fn set_squareness(&mut self, plane: Plane, row: Row, z: &[f64], model: &Model) {
        let um_per_m = Some(row.dot(z));
        self.unknowns[3 + plane as usize] = Estimated::new(row, um_per_m, true, model);
    }

    /// The one that the slope of a term is a part of.
    pub(super) fn of(&self, term: ErrorTerm) -> &Estimated {
        let plane = Plane::ALL.into_iter().find(|plane| plane.terms().contains(&term));
        plane.map_or(self.scale(term.along), |plane| self.squareness(plane))
    }

    /// Whether everything is determined.
    pub(super) const fn is_complete(&self) -> bool {
        self.rank == 6
    }

    /// What the data do not determine; empty where all is.
    pub(crate) fn undetermined(&self) -> Vec<Finding> {
        let open = |axis: &Axis| self.scale(*axis).um_per_m.is_none();
        let axes: Vec<Axis> = Axis::ALL.into_iter().filter(open).collect();
        let scales = (!axes.is_empty()).then_some(SeparationFinding::OpenScales { axes });
        let open = |plane: &Plane| self.squareness(*plane).um_per_m.is_none();
        let planes = Plane::ALL.into_iter().filter(open).map(Plane::axes);
        let planes = planes.map(|(of, along)| SeparationFinding::OpenSquareness { of, along });
        scales.into_iter().chain(planes).map(Finding::from).collect()
    }
}

/// The first four equations are those of the diagonals.
const DIAGONALS: usize = 4;

/// One equation of (7): vᵀ h v = value.
#[derive(Clone, Debug)]
pub(super) struct Equation {
    /// v, without unit.
    pub(super) direction: PerAxis<f64>,
    /// v where nothing is tilted.
    pub(super) nominal: PerAxis<f64>,
    /// The value, µm/m.
    pub(super) value: f64,
    /// How it hangs on what was measured.
    pub(super) row: Row,
    /// Whether its own variance is known; else it is a weight.
    pub(super) known: bool,
    /// That variance, (µm/m)².
    pub(super) own: f64,
}

impl Equation {
    /// A linear axis or beam by a row over what was measured.
    pub(super) fn of_line(line: &MeasuredLine, row: Row, z: &[f64]) -> Equation {
        let (direction, known) = (line.direction, line.u_um_per_m.is_some());
        Equation { direction, nominal: direction, value: row.dot(z), row, known, own: 0.0 }
    }
}

/// vᵀ h v as a row of the six unknowns.
fn products(v: &PerAxis<f64>) -> Vector6<f64> {
    Vector6::new(v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z)
}

/// M: the equations by the six unknowns.
fn design(all: &[Equation], along: fn(&Equation) -> PerAxis<f64>) -> DMatrix<f64> {
    let rows: Vec<_> = all.iter().map(|one| products(&along(one)).transpose()).collect();
    DMatrix::from_fn(all.len(), 6, |i, j| rows[i][j])
}

/// The equations of (7), the four diagonals first, then lines.
pub(super) struct Equations {
    all: Vec<Equation>,
    /// Their covariances by what they share, (µm/m)².
    shared: DMatrix<f64>,
    /// Orthonormal columns, each a combination of the unknowns that nominal directions determine.
    /// Small tilts make the true equations look independent where the nominal ones are not; that
    /// is no information.
    determined: DMatrix<f64>,
    /// Orthonormal columns, each a combination that stays open.
    open: DMatrix<f64>,
}

/// What the equations give.
struct Solution {
    unknowns: DVector<f64>,
    /// Covariance of the unknowns.
    spread: DMatrix<f64>,
    /// Residuals y − M θ̂, weighed with V⁻¹.
    chi_squared: f64,
    /// dθ̂/dy = B (BᵀMᵀV⁻¹MB)⁻¹ BᵀMᵀV⁻¹.
    gain: DMatrix<f64>,
}

impl Equations {
    /// Completes the model by what the equations neglect, and their rows with it.
    pub(super) fn new(mut all: Vec<Equation>, model: &mut Model) -> Equations {
        let mut of_diagonals = 0.0;
        for (place, one) in all.iter_mut().enumerate() {
            let weights = model.weights(&one.row);
            let (variance, common) = model.covariance(&weights, &weights);
            // What is not known is weighed: a diagonal by 1 µm/m, a line like a diagonal.
            let least = match (place < DIAGONALS, one.known) {
                (true, false) => variance - common + WEIGHT_UM_PER_M.squared(),
                (false, false) => of_diagonals / 4.0,
                _ => NEGLECTED_UM_PER_M.squared(),
            };
            one.own = (variance - common).max(least);
            let entry = model.layout.neglected(place);
            model.own[entry] = one.own - (variance - common);
            one.row.add(1.0, Row::of(entry));
            of_diagonals += if place < DIAGONALS { one.own } else { 0.0 };
        }
        // A line that is only weighed shares nothing: it would carry its weight where it has no part.
        let shares = |k: usize| k < DIAGONALS || all[k].known;
        let weights: Vec<Weights> = all.iter().map(|one| model.weights(&one.row)).collect();
        let covariance = |i: usize, j: usize| {
            let own = if i == j { all[i].own } else { 0.0 };
            let is_shared = shares(i) && shares(j);
            if is_shared { model.covariance(&weights[i], &weights[j]).0 - own } else { 0.0 }
        };
        let shared = DMatrix::from_fn(all.len(), all.len(), covariance);
        Equations::of(all, shared)
    }

    fn of(all: Vec<Equation>, shared: DMatrix<f64>) -> Equations {
        let nominal = design(&all, |one| one.nominal);
        let SymmetricEigen { eigenvalues, eigenvectors } =
            nominal.tr_mul(&nominal).symmetric_eigen();
        let limit = RANK_TOLERANCE * eigenvalues.max();
        let (known, open): (Vec<usize>, Vec<usize>) =
            (0..6).partition(|index| eigenvalues[*index] > limit);
        let [determined, open] = [known, open].map(|of| eigenvectors.select_columns(&of));
        Equations { all, shared, determined, open }
    }

    /// With these variances of their own; `None` where the covariance is not positive definite.
    fn solved(
        &self,
        along: fn(&Equation) -> PerAxis<f64>,
        own: impl Fn(&Equation) -> f64,
    ) -> Option<Solution> {
        let by = |of: &dyn Fn(&Equation) -> f64| {
            DVector::from_iterator(self.all.len(), self.all.iter().map(of))
        };
        let (design, values) = (design(&self.all, along), by(&|one| one.value));
        let covariance = (&self.shared + DMatrix::from_diagonal(&by(&own))).cholesky()?;
        let lower = covariance.l();
        let white = lower.solve_lower_triangular(&(&design * &self.determined))?;
        let wanted = lower.solve_lower_triangular(&values)?;
        let inverse = white.tr_mul(&white).cholesky()?.inverse();
        let found = &inverse * white.tr_mul(&wanted);
        let spread = &self.determined * &inverse * self.determined.transpose();
        Some(Solution {
            chi_squared: (&wanted - &white * &found).norm_squared(),
            gain: &spread * covariance.solve(&design).transpose(),
            unknowns: &self.determined * found,
            spread,
        })
    }

    /// Solves (7) for the unit vectors that were measured along.
    pub(super) fn metric(&self, model: &Model) -> Metric {
        let solution = self.solved(|one| one.direction, |one| one.own);
        // Which unknowns rest on nothing but equations of known uncertainty; judged at the nominal directions, like the
        // rank.
        let nominal = self.solved(|one| one.nominal, |one| one.own);
        let is_known = |unknown: usize| {
            (0..self.all.len()).filter(|at| !self.all[*at].known).all(|at| {
                let share = nominal.as_ref().map(|found| found.gain[(unknown, at)].abs());
                share.is_some_and(|share| share <= SHARE_TOLERANCE)
            })
        };
        let value = |index| {
            let length = self.determined.row(index).norm_squared();
            let is_determined = (1.0 - length).abs() < SHARE_TOLERANCE;
            Some(solution.as_ref().filter(|_| is_determined)?.unknowns[index])
        };
        let row = |index| {
            let of = |at: usize| Some((solution.as_ref()?.gain[(index, at)], &self.all[at].row));
            Row::sum((0..self.all.len()).filter_map(of))
        };
        let unknown = |at| Estimated::new(row(at), value(at), is_known(at), model);
        // Length of the row of dθ̂/d(open).
        let design = design(&self.all, |one| one.direction);
        let leaks = solution.as_ref().map(|found| &found.gain * &design * &self.open);
        let leak = |index| leaks.as_ref().map_or(0.0, |moved| moved.row(index).norm());
        Metric {
            unknowns: std::array::from_fn(unknown),
            rank: self.determined.ncols(),
            leak: PerPlane::from_fn(|plane| leak(3 + plane as usize)),
        }
    }

    /// Tests the redundancy; `None` where there is none, or no line beside the four diagonals (of a thin box they
    /// determine less). An equation of unknown uncertainty counts as exact, but none as more certain than what (7)
    /// neglects at slopes of this size.
    pub(super) fn agreement(&self, found: &Metric) -> Option<Agreement> {
        let freedom = self.all.len().saturating_sub(self.determined.ncols());
        if freedom == 0 || self.all.len() <= DIAGONALS {
            return None;
        }
        let slopes = found.unknowns.iter().filter_map(|one| one.um_per_m);
        let largest = slopes.fold(0.0, |largest: f64, slope| largest.max(slope.abs()));
        let neglected = (3.0 * largest.squared() * UM_PER_M).max(NEGLECTED_UM_PER_M).squared();
        let variance = |one: &Equation| if one.known { one.own.max(neglected) } else { neglected };
        let chi_squared = self.solved(|one| one.direction, variance)?.chi_squared;
        let check = |index: usize| {
            let mut rest = self.all.clone();
            let one = rest.remove(index);
            let shared = self.shared.clone().remove_row(index).remove_column(index);
            let (rest, row) = (Equations::of(rest, shared), products(&one.direction));
            // Whether the slope along the direction is determined.
            let holds = rest.open.tr_mul(&row).norm() < SHARE_TOLERANCE * row.norm();
            let found = holds.then(|| rest.solved(|one| one.direction, variance)).flatten();
            let by_others = found.as_ref().map(|found| row.dot(&found.unknowns));
            let square = |found: Solution| variance(&one) + row.dot(&(&found.spread * row));
            LineCheck {
                name: name(&one.direction),
                stated_um_per_m: one.value,
                by_others_um_per_m: by_others,
                difference_um_per_m: by_others.map(|found| one.value - found),
                u_difference_um_per_m: found.map(|found| square(found).sqrt()),
            }
        };
        let mut diagonals: Vec<LineCheck> = (0..self.all.len()).map(check).collect();
        let lines = diagonals.split_off(DIAGONALS);
        let known = self.all[..DIAGONALS].iter().all(|one| one.known);
        let probability = chance_of(chi_squared, freedom, None).filter(|_| known);
        let taken_as_exact = self.all[DIAGONALS..].iter().any(|line| !line.known);
        let refuted = probability.filter(|p| *p < SMALL_PROBABILITY);
        let contradiction = refuted.map(|_| contradiction(&lines, taken_as_exact));
        Some(Agreement { chi_squared, freedom, probability, contradiction, lines, diagonals })
    }
}

// Whether linear axes, beams and diagonals agree: the redundancy of formula (7).
//
// ```text
//   χ² = min over θ of (y − Mθ)ᵀ V⁻¹ (y − Mθ)       ~ χ²(ν),   ν = number of equations − rank
//   a line against all others:   stated − vᵀhv, with h solved from (7) without that line
// ```
// With the four diagonals and three linear axes ν = 1: X²p_xx + Y²p_yy + Z²p_zz against S. It is
// the only thing that notices a slope of the wrong sign or unit, or a wrong edge of the box; which
// of the equations is wrong it cannot tell. A line whose uncertainty is not known counts as exact.

/// Below this probability the equations contradict each other.
const SMALL_PROBABILITY: f64 = 0.001;

/// One line against the diagonals and all other lines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LineCheck {
    /// `X` for a linear axis, else `beam` and its direction.
    #[serde(rename = "line")]
    pub name: String,
    /// Its slope as measured (a beam: less the shapes between its ends), µm/m.
    pub stated_um_per_m: f64,
    /// What everything else says of it, µm/m; `None` where nothing else does.
    pub by_others_um_per_m: Option<f64>,
    /// Stated less by others, µm/m.
    pub difference_um_per_m: Option<f64>,
    /// Its standard uncertainty (k = 1), µm/m.
    pub u_difference_um_per_m: Option<f64>,
}

impl LineCheck {
    /// The difference in standard deviations.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.difference_um_per_m? / self.u_difference_um_per_m?)
    }

    /// By how much it may be false if it alone is, µm/m.
    pub(super) fn false_by_um_per_m(&self) -> Option<f64> {
        let beyond =
            self.difference_um_per_m?.abs() - NORMAL_ONE_SIDED * self.u_difference_um_per_m?;
        (beyond > 0.0).then_some(beyond)
    }
}

fn name(direction: &PerAxis<f64>) -> String {
    let along = |axis: &Axis| (direction[*axis].abs() - 1.0).abs() < 1e-9;
    match Axis::ALL.iter().find(|axis| along(axis)) {
        Some(axis) => axis.to_string(),
        None => {
            let PerAxis { x, y, z } = direction;
            format!("beam ({x:.2}, {y:.2}, {z:.2})")
        }
    }
}

/// The test of what is redundant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Weighed residuals.
    pub chi_squared: f64,
    /// ν, number of redundant equations, at least 1.
    #[serde(rename = "degrees_of_freedom")]
    pub freedom: usize,
    /// Probability of residuals at least as large; `None` where the noise of the readings is not known.
    pub probability: Option<f64>,
    /// Whether the equations contradict each other, and by how much.
    pub contradiction: Option<Finding>,
    /// The lines, in the order of the job.
    pub lines: Vec<LineCheck>,
    /// The diagonals, likewise.
    #[serde(skip)]
    pub(super) diagonals: Vec<LineCheck>,
}

/// What contradicts each other; `taken_as_exact`: whether a line's uncertainty is not known.
fn contradiction(lines: &[LineCheck], taken_as_exact: bool) -> Finding {
    let says = |line: &LineCheck| {
        let (um_per_m, ratio) = (Figure(line.difference_um_per_m?), line.ratio()?.abs());
        Some(format!("{} by {um_per_m:+.3} µm/m ({ratio:.1} standard deviations)", line.name))
    };
    let lines = joined(lines.iter().filter_map(says));
    SeparationFinding::LinesDisagree { lines, taken_as_exact }.into()
}
