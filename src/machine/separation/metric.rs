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
use super::findings::SeparationFinding;
use super::linear::{Model, Row, Weights};
use super::noise::Noise;
use super::uncertainty::Uncertainty;
use crate::quantity::{Axis, ErrorTerm, PerAxis, PerDiagonal, PerPlane, Plane, Squared, Volume};
use crate::text::Finding;
use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector6};

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
    fn new(
        (row, um_per_m, is_known): (Row, Option<f64>, bool),
        model: &Model,
        noise: Option<Noise>,
    ) -> Estimated {
        let noise = noise.filter(|_| is_known);
        let u = noise.map(|noise| model.variance(&row).uncertainty(noise));
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
    pub(super) fn set_squareness(
        &mut self,
        plane: Plane,
        (row, um_per_m): (Row, f64),
        (model, noise): (&Model, Option<Noise>),
    ) {
        let found = Estimated::new((row, Some(um_per_m), true), model, noise);
        self.unknowns[3 + plane as usize] = found;
    }

    /// The one that the slope of a term is a part of.
    pub(super) fn of(&self, term: ErrorTerm) -> &Estimated {
        let plane = Plane::ALL.into_iter().find(|plane| plane.terms().contains(&term));
        plane.map_or(self.scale(term.along), |plane| self.squareness(plane))
    }

    /// The largest of them, µm/m.
    pub(super) fn largest_um_per_m(&self) -> f64 {
        let all = self.unknowns.iter().filter_map(|one| one.um_per_m);
        all.fold(0.0, |largest: f64, slope| largest.max(slope.abs()))
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

/// One equation of (7): vᵀ h v = value.
#[derive(Clone, Debug)]
pub(super) struct Equation {
    /// v, without unit.
    pub(super) direction: PerAxis<f64>,
    /// v where nothing is tilted.
    nominal: PerAxis<f64>,
    /// The value, µm/m.
    pub(super) value: f64,
    /// How it hangs on what was measured.
    row: Row,
    /// Its own variance, (µm/m)².
    own: f64,
    /// Whether that is known; else it is a weight.
    pub(super) known: bool,
}

/// vᵀ h v as a row of the six unknowns.
fn products(v: &PerAxis<f64>) -> Vector6<f64> {
    Vector6::new(v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z)
}

/// The equations of (7), the four diagonals first, then lines.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    pub(super) all: Vec<Equation>,
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
pub(super) struct Solution {
    unknowns: DVector<f64>,
    /// Covariance of the unknowns.
    spread: DMatrix<f64>,
    /// Residuals y − M θ̂, weighed with V⁻¹.
    pub(super) chi_squared: f64,
    /// dθ̂/dy = B (BᵀMᵀV⁻¹MB)⁻¹ BᵀMᵀV⁻¹.
    gain: DMatrix<f64>,
}

impl Solution {
    /// Value along a direction, and its variance.
    pub(super) fn along(&self, direction: &PerAxis<f64>) -> (f64, f64) {
        let row = products(direction);
        (row.dot(&self.unknowns), row.dot(&(&self.spread * row)))
    }
}

impl Equations {
    /// `diagonals`: directions and values; `rows`: of the diagonals, then of the lines, µm/m. Completes the
    /// model by what the equations neglect, and the rows with it.
    pub(super) fn new(
        volume: &Volume,
        diagonals: &PerDiagonal<(PerAxis<f64>, f64)>,
        lines: &[MeasuredLine],
        rows: Vec<Row>,
        (model, noise_is_known): (&mut Model, bool),
    ) -> Equations {
        let diagonals = diagonals.iter();
        let given = diagonals.map(|(d, (v, um))| (*v, volume.laser(d), *um, noise_is_known));
        let lines = lines.iter();
        let beside =
            lines.map(|l| (l.direction, l.direction, l.slope_um_per_m, l.u_um_per_m.is_some()));
        let mut all = Vec::new();
        let mut of_diagonals = 0.0;
        for ((place, mut row), given) in rows.into_iter().enumerate().zip(given.chain(beside)) {
            let (direction, nominal, value, known) = given;
            let weights = model.weights(&row);
            let (variance, common) = model.covariance(&weights, &weights);
            // What is not known is weighed: a diagonal by 1 µm/m, a line like a diagonal.
            let least = match (place < 4, known) {
                (true, false) => variance - common + WEIGHT_UM_PER_M.squared(),
                (false, false) => of_diagonals / 4.0,
                _ => NEGLECTED_UM_PER_M.squared(),
            };
            let own = (variance - common).max(least);
            let entry = model.layout.neglected(place);
            model.own[entry] = own - (variance - common);
            row.add(1.0, Row::of(entry));
            of_diagonals += if place < 4 { own } else { 0.0 };
            all.push(Equation { direction, nominal, value, row, own, known });
        }
        // A line that is only weighed shares nothing: it would carry its weight where it has no part.
        let shares = |k: usize| k < 4 || all[k].known;
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

    /// All but one.
    pub(super) fn without(&self, index: usize) -> Equations {
        let mut rest = self.all.clone();
        rest.remove(index);
        Equations::of(rest, self.shared.clone().remove_row(index).remove_column(index))
    }

    /// Number of redundant equations.
    pub(super) fn redundancy(&self) -> usize {
        self.all.len().saturating_sub(self.determined.ncols())
    }

    /// Whether the slope along a direction is determined.
    pub(super) fn holds(&self, direction: &PerAxis<f64>) -> bool {
        let row = products(direction);
        self.open.tr_mul(&row).norm() < SHARE_TOLERANCE * row.norm()
    }

    /// Variances for a test: an equation of unknown uncertainty counts as exact, but none as more
    /// certain than what (7) neglects at slopes of this size.
    pub(super) fn test_variances(&self, largest_slope_um_per_m: f64) -> DVector<f64> {
        let products = 3.0 * largest_slope_um_per_m.squared() * UM_PER_M;
        let neglected = products.max(NEGLECTED_UM_PER_M).squared();
        let own = |one: &Equation| if one.known { one.own.max(neglected) } else { neglected };
        DVector::from_iterator(self.all.len(), self.all.iter().map(own))
    }

    /// With the variances that the equations have, along their true or nominal directions.
    fn solved(&self, along: fn(&Equation) -> PerAxis<f64>) -> Option<Solution> {
        let own = self.all.iter().map(|one| one.own);
        self.solved_with(along, &DVector::from_iterator(self.all.len(), own))
    }

    /// With other variances; `None` where the covariance is not positive definite.
    pub(super) fn solved_with(
        &self,
        along: fn(&Equation) -> PerAxis<f64>,
        own: &DVector<f64>,
    ) -> Option<Solution> {
        let design = design(&self.all, along);
        let values = DVector::from_iterator(own.len(), self.all.iter().map(|one| one.value));
        let covariance = (&self.shared + DMatrix::from_diagonal(own)).cholesky()?;
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
    pub(super) fn metric(&self, model: &Model, noise: Option<Noise>) -> Metric {
        let solution = self.solved(|one| one.direction);
        // Which unknowns rest on nothing but equations of known uncertainty; judged at the nominal directions, like the
        // rank.
        let nominal = self.solved(|one| one.nominal);
        let is_known = |unknown: usize| {
            let mut weighed = (0..self.all.len()).filter(|at| !self.all[*at].known);
            weighed.all(|at| {
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
            let of = |found: &Solution, at| (found.gain[(index, at)], &self.all[at].row);
            let every = 0..self.all.len();
            Row::sum(solution.iter().flat_map(|found| every.clone().map(move |at| of(found, at))))
        };
        let unknown = |at| Estimated::new((row(at), value(at), is_known(at)), model, noise);
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
}

/// M: the equations by the six unknowns.
fn design(all: &[Equation], along: fn(&Equation) -> PerAxis<f64>) -> DMatrix<f64> {
    let rows: Vec<_> = all.iter().map(|one| products(&along(one)).transpose()).collect();
    DMatrix::from_fn(all.len(), 6, |i, j| rows[i][j])
}
