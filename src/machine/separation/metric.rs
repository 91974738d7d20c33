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
use super::linear::{Model, Row};
pub use super::plane::{PerPlane, Plane};
use super::plane::{UNKNOWNS, Unknown};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{PerDiagonal, Volume};
use crate::quantity::units::Squared;
use crate::text::finding::Finding;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SMatrix, SVector};

/// Of the largest singular value: below this a direction of the unknowns is not measured.
const RANK_TOLERANCE: f64 = 1e-9;
/// A share of an unknown in what is not measured, below which it counts as determined; also a
/// share of an equation in an unknown, below which the unknown does not depend on it.
const SHARE_TOLERANCE: f64 = 1e-6;
const UM_PER_M: f64 = 1e-6;
/// What (7) neglects, µm/m. No equation is weighed as if it were more certain: readings without
/// any noise would make the system singular beside a line with a stated uncertainty.
const NEGLECTED_UM_PER_M: f64 = 1e-3;
/// Uncertainty that weighs totals where neither noise nor a statement gives one, µm/m.
const WEIGHT_UM_PER_M: f64 = 1.0;

/// What is measured of a triad's metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Slopes of EXX, EYY, EZZ, µm/m; absent = not determined by the data.
    pub scale: PerAxis<Option<f64>>,
    /// Squareness φ, µm/m: positive = the angle between the positive axis directions is less
    /// than 90°.
    pub squareness: PerPlane<Option<f64>>,
    /// Number of combinations of the six unknowns that the data determine.
    pub rank: usize,
    /// How much φ moves with what is not determined of the scales, because the mirrors are tilted,
    /// µm/m for each µm/m; 0 where all is determined.
    pub leak: PerPlane<f64>,
    /// Standard uncertainties of the unknowns, µm/m; of one that is not determined that of its
    /// determined part. `None` = something that it depends on is not known.
    u_um_per_m: [Option<f64>; UNKNOWNS],
}

impl Metric {
    /// Whether everything is determined.
    pub(super) const fn is_complete(&self) -> bool {
        self.rank == UNKNOWNS
    }

    /// Standard uncertainty of a scale, µm/m; `None` = not known.
    pub fn u_scale(&self, axis: Axis) -> Option<f64> {
        self.u(Unknown::Scale(axis))
    }

    /// Standard uncertainty of a squareness, µm/m; `None` = not known.
    pub fn u_squareness(&self, plane: Plane) -> Option<f64> {
        self.u(Unknown::Squareness(plane))
    }

    pub(super) fn u(&self, unknown: Unknown) -> Option<f64> {
        self.u_um_per_m[unknown.index()]
    }

    pub(super) fn value(&self, unknown: Unknown) -> Option<f64> {
        match unknown {
            Unknown::Scale(axis) => self.scale[axis],
            Unknown::Squareness(plane) => self.squareness.of(plane),
        }
    }

    /// What the data do not determine; empty where all is.
    pub(crate) fn undetermined(&self) -> Vec<Finding> {
        let open = |axis: &Axis| self.scale[*axis].is_none();
        let axes: Vec<Axis> = Axis::ALL.into_iter().filter(open).collect();
        let scales = (!axes.is_empty()).then_some(SeparationFinding::OpenScales { axes });
        let open = |plane: &Plane| self.squareness.of(*plane).is_none();
        let planes = Plane::ALL.into_iter().filter(open);
        let planes = planes.map(|plane| SeparationFinding::OpenSquareness {
            of: plane.axes().0,
            along: plane.axes().1,
        });
        scales.into_iter().chain(planes).map(Finding::from).collect()
    }
}

/// Displacement per commanded unit: q_dk = s_dk (V_k/R + n m̄_dk/V_k). Dimensionless; `means` in µm.
pub(super) fn displacement_ratios(
    volume: &Volume,
    means: &PerDiagonal<PerAxis<f64>>,
) -> PerDiagonal<PerAxis<f64>> {
    PerDiagonal::from_fn(|diagonal| {
        PerAxis::from_fn(|axis| {
            let step_um = volume.step_mm(axis) * 1000.0;
            diagonal.sign(axis) * (volume.cosine(axis) + means[diagonal][axis] / step_um)
        })
    })
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
    /// Covariances with all equations by what they share, (µm/m)².
    shared: Vec<f64>,
}

type Products = SVector<f64, UNKNOWNS>;

/// vᵀ h v as a row of the six unknowns.
fn products(v: &PerAxis<f64>) -> Products {
    Products::from([v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z])
}

/// (7) of step runs: q_dᵀ h q_d = (q_d² − 1)/2.
pub(super) fn stepped(ratios: &PerDiagonal<PerAxis<f64>>) -> PerDiagonal<(PerAxis<f64>, f64)> {
    PerDiagonal::from_fn(|d| (ratios[d], (ratios[d].dot(ratios[d]) - 1.0) / 2.0 / UM_PER_M))
}

/// (7) of straight runs, of first order: u_dᵀ h u_d = e_d(end)/R. `ends_um`: totals.
pub(super) fn straight(
    volume: &Volume,
    ends_um: &PerDiagonal<f64>,
) -> PerDiagonal<(PerAxis<f64>, f64)> {
    let length_m = volume.diagonal_mm() / 1000.0;
    PerDiagonal::from_fn(|d| (volume.laser(d), ends_um[d] / length_m))
}

/// The equations of (7), the four diagonals first, then lines.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    pub(super) all: Vec<Equation>,
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
    design: DMatrix<f64>,
    covariance: Cholesky<f64, Dyn>,
}

impl Solution {
    /// Value along a direction, and its variance.
    pub(super) fn along(&self, direction: &PerAxis<f64>) -> (f64, f64) {
        let row = DVector::from_column_slice(products(direction).as_slice());
        (row.dot(&self.unknowns), row.dot(&(&self.spread * &row)))
    }

    /// dθ̂/dy = B (BᵀMᵀV⁻¹MB)⁻¹ BᵀMᵀV⁻¹.
    fn gain(&self) -> DMatrix<f64> {
        &self.spread * self.covariance.solve(&self.design).transpose()
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
        let stepped = diagonals.iter().map(|(d, (v, value))| (*v, volume.laser(d), *value));
        let beside = lines.iter().map(|l| (l.direction, l.direction, l.slope_um_per_m));
        let known = std::iter::repeat_n(noise_is_known, 4);
        let known = known.chain(lines.iter().map(|line| line.u_um_per_m.is_some()));
        let given = stepped.chain(beside).zip(known).zip(rows);
        let mut all: Vec<Equation> = given
            .map(|(((direction, nominal, value), known), row)| {
                let (variance, common) = model.covariance(&row, &row);
                let own = variance - common;
                Equation { direction, nominal, value, row, own, known, shared: Vec::new() }
            })
            .collect();
        // What is not known is weighed: a diagonal by 1 µm/m, a line like a diagonal.
        let floor = NEGLECTED_UM_PER_M.squared();
        let mut of_diagonals = 0.0;
        for (place, one) in all.iter_mut().enumerate() {
            let least = match (place < 4, one.known) {
                (true, false) => one.own + WEIGHT_UM_PER_M.squared(),
                (false, false) => of_diagonals / 4.0,
                _ => floor,
            };
            let entry = model.layout.neglected(place);
            model.other[entry] = (least - one.own).max(0.0);
            one.own += model.other[entry];
            one.row.add(1.0, &Row::of(entry));
            of_diagonals += if place < 4 { one.own } else { 0.0 };
        }
        // A line that is only weighed shares nothing: it would carry its weight where it has no part.
        let covariance = |i: usize, j: usize| match [i, j].iter().all(|k| *k < 4 || all[*k].known) {
            true => model.covariance(&all[i].row, &all[j].row).0,
            false if i == j => all[i].own,
            false => 0.0,
        };
        let many = all.len();
        let of = |i: usize| (0..many).map(|j| covariance(i, j)).collect();
        let covariances: Vec<Vec<f64>> = (0..many).map(of).collect();
        for (place, (one, mut shared)) in all.iter_mut().zip(covariances).enumerate() {
            shared[place] -= one.own;
            one.shared = shared;
        }
        Equations::of(all)
    }

    fn of(all: Vec<Equation>) -> Equations {
        let mut normal = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
        for row in all.iter().map(|one| products(&one.nominal)) {
            normal += row * row.transpose();
        }
        let eigen = normal.symmetric_eigen();
        let limit = RANK_TOLERANCE * eigen.eigenvalues.max();
        let (known, open): (Vec<usize>, Vec<usize>) =
            (0..UNKNOWNS).partition(|index| eigen.eigenvalues[*index] > limit);
        let columns = |indices: Vec<usize>| {
            DMatrix::from_fn(UNKNOWNS, indices.len(), |i, j| eigen.eigenvectors[(i, indices[j])])
        };
        Equations { all, determined: columns(known), open: columns(open) }
    }

    /// All but one.
    pub(super) fn without(&self, index: usize) -> Equations {
        let mut rest = self.all.clone();
        rest.remove(index);
        rest.iter_mut().for_each(|one| {
            one.shared.remove(index);
        });
        Equations::of(rest)
    }

    fn rank(&self) -> usize {
        self.determined.ncols()
    }

    /// Whether there is anything beside the diagonals.
    pub(super) fn has_lines(&self) -> bool {
        self.all.len() > 4
    }

    /// Number of redundant equations.
    pub(super) fn redundancy(&self) -> usize {
        self.all.len().saturating_sub(self.rank())
    }

    /// Whether the slope along a direction is determined.
    pub(super) fn holds(&self, direction: &PerAxis<f64>) -> bool {
        let row = DVector::from_column_slice(products(direction).as_slice());
        self.open.tr_mul(&row).norm() < SHARE_TOLERANCE * row.norm()
    }

    fn determines(&self, unknown: usize) -> bool {
        let length = self.determined.row(unknown).norm_squared();
        (1.0 - length).abs() < SHARE_TOLERANCE
    }

    /// Variances for a test: an equation of unknown uncertainty counts as exact, but none as more
    /// certain than what (7) neglects at slopes of this size.
    pub(super) fn test_variances(&self, largest_slope_um_per_m: f64) -> Vec<f64> {
        let products = 3.0 * largest_slope_um_per_m.squared() * UM_PER_M;
        let neglected = products.max(NEGLECTED_UM_PER_M).squared();
        let of = |one: &Equation| one.own.max(neglected);
        let all = self.all.iter();
        all.map(|one| if one.known { of(one) } else { neglected }).collect()
    }

    /// With the variances that the equations have.
    fn solved(&self) -> Option<Solution> {
        let own: Vec<f64> = self.all.iter().map(|one| one.own).collect();
        self.solve(|one| one.direction, &own)
    }

    /// With other variances.
    pub(super) fn solved_with(&self, own: &[f64]) -> Option<Solution> {
        self.solve(|one| one.direction, own)
    }

    /// `None` where the covariance is not positive definite.
    fn solve(&self, along: fn(&Equation) -> PerAxis<f64>, own: &[f64]) -> Option<Solution> {
        let many = self.all.len();
        let covariance = DMatrix::from_fn(many, many, |i, j| {
            self.all[i].shared[j] + if i == j { own[i] } else { 0.0 }
        });
        let rows: Vec<Products> = self.all.iter().map(|one| products(&along(one))).collect();
        let design = DMatrix::from_fn(many, UNKNOWNS, |i, j| rows[i][j]);
        let values = DVector::from_fn(many, |i, _| self.all[i].value);
        let covariance = covariance.cholesky()?;
        let lower = covariance.l();
        let white = lower.solve_lower_triangular(&(&design * &self.determined))?;
        let wanted = lower.solve_lower_triangular(&values)?;
        let inverse = white.tr_mul(&white).cholesky()?.inverse();
        let found = &inverse * white.tr_mul(&wanted);
        Some(Solution {
            chi_squared: (&wanted - &white * &found).norm_squared(),
            spread: &self.determined * &inverse * self.determined.transpose(),
            unknowns: &self.determined * found,
            design,
            covariance,
        })
    }

    /// Which unknowns rest on nothing but equations of known uncertainty; judged at the nominal
    /// directions, like the rank.
    fn u_known(&self) -> [bool; UNKNOWNS] {
        if self.all.iter().all(|one| one.known) {
            return [true; UNKNOWNS];
        }
        let own: Vec<f64> = self.all.iter().map(|one| one.own).collect();
        let Some(gain) = self.solve(|one| one.nominal, &own).map(|found| found.gain()) else {
            return [false; UNKNOWNS];
        };
        let depends = |unknown: usize, equation| gain[(unknown, equation)].abs() > SHARE_TOLERANCE;
        std::array::from_fn(|unknown| {
            let mut equations = self.all.iter().enumerate();
            equations.all(|(equation, one)| one.known || !depends(unknown, equation))
        })
    }

    /// Solves (7) for the unit vectors that were measured along.
    pub(super) fn metric(&self) -> Metric {
        let solution = self.solved();
        let value = |unknown: Unknown| {
            let index = unknown.index();
            let solution = solution.as_ref().filter(|_| self.determines(index))?;
            Some(solution.unknowns[index])
        };
        // Length of the row of dθ̂/d(open).
        let leaks = solution.as_ref().filter(|_| self.rank() < UNKNOWNS);
        let leaks = leaks.map(|found| found.gain() * &found.design * &self.open);
        let leak = |plane| {
            let row = Unknown::Squareness(plane).index();
            leaks.as_ref().map_or(0.0, |moved| moved.row(row).norm())
        };
        let known = self.u_known();
        let u = |i: usize| solution.as_ref().map_or(0.0, |s| s.spread[(i, i)].sqrt());
        Metric {
            scale: PerAxis::from_fn(|axis| value(Unknown::Scale(axis))),
            squareness: PerPlane::from_fn(|plane| value(Unknown::Squareness(plane))),
            rank: self.rank(),
            leak: PerPlane::from_fn(leak),
            u_um_per_m: std::array::from_fn(|index| known[index].then(|| u(index))),
        }
    }

    /// The unknowns by what was measured, µm/m; nothing without a solution.
    pub(super) fn rows(&self) -> [Row; UNKNOWNS] {
        let gain = self.solved().map(|found| found.gain());
        Unknown::ALL.map(|unknown| {
            let shares = gain
                .iter()
                .flat_map(|gain| gain.row(unknown.index()).iter().copied().collect::<Vec<_>>());
            Row::sum(shares.zip(self.all.iter().map(|one| &one.row)))
        })
    }
}
