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
//! Source: derived and confirmed by simulation in the project's reference on the step-diagonal
//! method (docs/method.md §5); same idea as Ibaraki and Hata (2010). Neglected: P², about 10⁻⁹.

use crate::axis::{Axis, PerAxis};
use crate::diagonal::{Diagonal, PerDiagonal, Volume};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Number of unknowns: three scales, three squareness errors.
const UNKNOWNS: usize = 6;
const UM_PER_M: f64 = 1e-6;
/// What (7) neglects, µm/m. No equation is weighed as if it were more certain: readings without
/// any noise would make the system singular beside a line with a stated uncertainty.
const NEGLECTED_UM_PER_M: f64 = 1e-3;
/// Of the largest singular value: below this a direction of the unknowns is not measured.
const RANK_TOLERANCE: f64 = 1e-9;
/// A share of an unknown in what is not measured, below which it counts as determined.
const SHARE_TOLERANCE: f64 = 1e-6;

type Row = SVector<f64, UNKNOWNS>;

/// A plane of two axes, for squareness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// X and Y.
    Xy,
    /// X and Z.
    Xz,
    /// Y and Z.
    Yz,
}

impl Plane {
    /// The three planes, XY first.
    pub const ALL: [Plane; 3] = [Plane::Xy, Plane::Xz, Plane::Yz];

    /// Its key in documents.
    pub const fn key(self) -> &'static str {
        match self {
            Plane::Xy => "xy",
            Plane::Xz => "xz",
            Plane::Yz => "yz",
        }
    }

    /// Its two axes.
    pub const fn axes(self) -> (Axis, Axis) {
        match self {
            Plane::Xy => (Axis::X, Axis::Y),
            Plane::Xz => (Axis::X, Axis::Z),
            Plane::Yz => (Axis::Y, Axis::Z),
        }
    }
}

/// One value for each plane.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct PerPlane<T> {
    /// XY.
    pub xy: T,
    /// XZ.
    pub xz: T,
    /// YZ.
    pub yz: T,
}

impl<T: Copy> PerPlane<T> {
    /// The value of a plane.
    pub const fn of(&self, plane: Plane) -> T {
        match plane {
            Plane::Xy => self.xy,
            Plane::Xz => self.xz,
            Plane::Yz => self.yz,
        }
    }
}

/// One straight line whose length was measured beside the diagonals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightLine {
    /// Direction, of length 1.
    pub direction: PerAxis<f64>,
    /// Displacement error by length, µm/m.
    pub slope_um_per_m: f64,
    /// Its standard uncertainty (k = 1), µm/m; above 0.
    pub u_um_per_m: f64,
}

/// What is measured of a triad's metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Slopes of EXX, EYY, EZZ, µm/m; absent = not determined by the data.
    pub scale: PerAxis<Option<f64>>,
    /// Squareness φ, µm/m: positive = the angle between the positive axis directions is less
    /// than 90°.
    pub squareness: PerPlane<Option<f64>>,
    /// Covariance (µm/m)² of X, Y, Z scale, φxy, φxz, φyz; rows and columns of what is not
    /// determined hold only the determined part.
    pub covariance: [[f64; UNKNOWNS]; UNKNOWNS],
    /// Number of combinations of the six unknowns that the data determine.
    pub rank: usize,
    /// Weighted residuals of the redundant equations: Σ (residual/u)².
    pub chi_squared: f64,
    /// Number of redundant equations.
    pub redundancy: usize,
}

impl Metric {
    /// Whether everything is determined.
    pub const fn is_complete(&self) -> bool {
        self.rank == UNKNOWNS
    }

    /// Standard uncertainty of a scale, µm/m.
    pub fn u_scale(&self, axis: Axis) -> f64 {
        let index = scale_index(axis);
        self.covariance[index][index].sqrt()
    }

    /// Standard uncertainty of a squareness, µm/m.
    pub fn u_squareness(&self, plane: Plane) -> f64 {
        let index = plane_index(plane);
        self.covariance[index][index].sqrt()
    }

    /// What the data do not determine, in words; empty where all is.
    pub fn undetermined(&self) -> Vec<String> {
        let scales: Vec<String> = Axis::ALL
            .into_iter()
            .filter(|axis| self.scale[*axis].is_none())
            .map(|axis| axis.to_string())
            .collect();
        let mut words = Vec::new();
        match scales.as_slice() {
            [] => {}
            [x, y, z] => words.push(format!(
                "scale of {x}, {y} and {z} can be traded against each other; measure two axes along their length"
            )),
            [a, b] => words.push(format!(
                "scale of {a} and {b} can be traded against each other; measure one axis along its length"
            )),
            other => words.push(format!("scale of {}", other.join(" and "))),
        }
        for plane in Plane::ALL {
            if self.squareness.of(plane).is_none() {
                let (a, b) = plane.axes();
                words.push(format!(
                    "squareness of {a} and {b}; measure a face diagonal of their plane"
                ));
            }
        }
        words
    }
}

const fn scale_index(axis: Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}

const fn plane_index(plane: Plane) -> usize {
    match plane {
        Plane::Xy => 3,
        Plane::Xz => 4,
        Plane::Yz => 5,
    }
}

/// Displacement per commanded unit: q_dk = s_dk (V_k/R + n m̄_dk/V_k). Dimensionless; `means` in µm.
pub fn displacement_ratios(
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

/// vᵀ h v as a row of the six unknowns.
fn row(v: &PerAxis<f64>) -> Row {
    Row::from([
        v.x * v.x,
        v.y * v.y,
        v.z * v.z,
        v.x * v.y,
        v.x * v.z,
        v.y * v.z,
    ])
}

/// Solves (7) for the unit vectors that were measured along. `u_diagonal_um_per_m`: standard
/// uncertainty of a diagonal's total by its length.
pub fn solve(
    volume: &Volume,
    ratios: &PerDiagonal<PerAxis<f64>>,
    u_diagonal_um_per_m: f64,
    lines: &[StraightLine],
) -> Metric {
    let nominal = nominal_rows(volume, lines);
    let known = KnownSpace::of(&nominal);
    let mut rows: Vec<Row> = Vec::new();
    let mut values = Vec::new();
    let mut uncertainties = Vec::new();
    for (_, q) in ratios.iter() {
        let square = q.x * q.x + q.y * q.y + q.z * q.z;
        rows.push(row(q));
        values.push((square - 1.0) / 2.0 / UM_PER_M);
        uncertainties.push(u_diagonal_um_per_m.max(NEGLECTED_UM_PER_M));
    }
    for line in lines {
        rows.push(row(&line.direction));
        values.push(line.slope_um_per_m);
        uncertainties.push(line.u_um_per_m.max(NEGLECTED_UM_PER_M));
    }
    known.fit(&rows, &values, &uncertainties)
}

/// The same from straight runs, of first order: u_dᵀ h u_d = e_d(end)/R. `ends_um`: totals.
pub fn solve_totals(
    volume: &Volume,
    ends_um: &PerDiagonal<f64>,
    u_diagonal_um_per_m: f64,
    lines: &[StraightLine],
) -> Metric {
    let rows = nominal_rows(volume, lines);
    let length_m = volume.diagonal_mm() / 1000.0;
    let diagonals = ends_um
        .iter()
        .map(|(_, end_um)| (end_um / length_m, u_diagonal_um_per_m));
    let lines = lines
        .iter()
        .map(|line| (line.slope_um_per_m, line.u_um_per_m));
    let (values, uncertainties): (Vec<f64>, Vec<f64>) = diagonals
        .chain(lines)
        .map(|(value, u)| (value, u.max(NEGLECTED_UM_PER_M)))
        .unzip();
    KnownSpace::of(&rows).fit(&rows, &values, &uncertainties)
}

fn nominal_rows(volume: &Volume, lines: &[StraightLine]) -> Vec<Row> {
    let diagonals = Diagonal::ALL.map(|diagonal| row(&volume.laser(diagonal)));
    let others = lines.iter().map(|line| row(&line.direction));
    diagonals.into_iter().chain(others).collect()
}

/// The combinations of the unknowns that nominal directions determine. Small tilts make the
/// true equations look independent where the nominal ones are not; that is no information.
struct KnownSpace {
    /// Orthonormal columns, each a determined combination.
    basis: DMatrix<f64>,
}

impl KnownSpace {
    fn of(rows: &[Row]) -> KnownSpace {
        let mut normal = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
        for row in rows {
            normal += row * row.transpose();
        }
        let eigen = normal.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let columns: Vec<DVector<f64>> = (0..UNKNOWNS)
            .filter(|index| eigen.eigenvalues[*index] > RANK_TOLERANCE * largest)
            .map(|index| DVector::from_column_slice(eigen.eigenvectors.column(index).as_slice()))
            .collect();
        KnownSpace {
            basis: DMatrix::from_columns(&columns),
        }
    }

    fn determines(&self, unknown: usize) -> bool {
        let length: f64 = self.basis.row(unknown).iter().map(|part| part * part).sum();
        (1.0 - length).abs() < SHARE_TOLERANCE
    }

    fn fit(&self, rows: &[Row], values: &[f64], uncertainties: &[f64]) -> Metric {
        let rank = self.basis.ncols();
        let design = DMatrix::from_fn(rows.len(), UNKNOWNS, |i, j| rows[i][j] / uncertainties[i]);
        let design = design * &self.basis;
        let wanted = DVector::from_fn(rows.len(), |i, _| values[i] / uncertainties[i]);
        let normal = design.tr_mul(&design);
        let right = design.tr_mul(&wanted);
        let factor = normal.cholesky();
        let solvable = factor.is_some();
        let inverse = factor.map_or_else(|| DMatrix::zeros(rank, rank), |f| f.inverse());
        let found = &inverse * right;
        let residual = &wanted - &design * &found;
        let unknowns = &self.basis * found;
        let spread = &self.basis * inverse * self.basis.transpose();
        let value = |index: usize| (solvable && self.determines(index)).then(|| unknowns[index]);
        Metric {
            scale: PerAxis::from_fn(|axis| value(scale_index(axis))),
            squareness: PerPlane {
                xy: value(plane_index(Plane::Xy)),
                xz: value(plane_index(Plane::Xz)),
                yz: value(plane_index(Plane::Yz)),
            },
            covariance: std::array::from_fn(|i| std::array::from_fn(|j| spread[(i, j)])),
            rank,
            chi_squared: residual.norm_squared(),
            redundancy: rows.len().saturating_sub(rank),
        }
    }
}
