//! Generalised least squares for the six unknowns of formula (7).
//!
//! ```text
//!   y = M θ + v      cov(v) = V       θ = three scales, three squareness errors
//!   θ̂ = B (BᵀMᵀV⁻¹MB)⁻¹ BᵀMᵀV⁻¹ y     B: orthonormal, the combinations that nominal directions determine
//! ```

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Number of unknowns: three scales, three squareness errors.
pub(super) const UNKNOWNS: usize = 6;
/// Of the largest singular value: below this a direction of the unknowns is not measured.
const RANK_TOLERANCE: f64 = 1e-9;
/// A share of an unknown in what is not measured, below which it counts as determined; also a
/// share of an equation in an unknown, below which the unknown does not depend on it.
const SHARE_TOLERANCE: f64 = 1e-6;

pub(super) type Row = SVector<f64, UNKNOWNS>;

/// The combinations of the unknowns that nominal directions determine. Small tilts make the
/// true equations look independent where the nominal ones are not; that is no information.
pub(super) struct KnownSpace {
    /// Orthonormal columns, each a determined combination.
    basis: DMatrix<f64>,
    /// Orthonormal columns, each a combination that stays open.
    open: DMatrix<f64>,
}

impl KnownSpace {
    pub(super) fn of(rows: &[Row]) -> KnownSpace {
        let mut normal = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
        for row in rows {
            normal += row * row.transpose();
        }
        let eigen = normal.symmetric_eigen();
        let limit = RANK_TOLERANCE * eigen.eigenvalues.max();
        let (known, open): (Vec<usize>, Vec<usize>) =
            (0..UNKNOWNS).partition(|index| eigen.eigenvalues[*index] > limit);
        let columns = |indices: Vec<usize>| {
            DMatrix::from_fn(UNKNOWNS, indices.len(), |i, j| {
                eigen.eigenvectors[(i, indices[j])]
            })
        };
        KnownSpace {
            basis: columns(known),
            open: columns(open),
        }
    }

    pub(super) fn rank(&self) -> usize {
        self.basis.ncols()
    }

    /// Whether a combination of the unknowns is determined.
    pub(super) fn holds(&self, row: &Row) -> bool {
        let row = DVector::from_column_slice(row.as_slice());
        self.open.tr_mul(&row).norm() < SHARE_TOLERANCE * row.norm()
    }

    pub(super) fn determines(&self, unknown: usize) -> bool {
        let length: f64 = self.basis.row(unknown).iter().map(|part| part * part).sum();
        (1.0 - length).abs() < SHARE_TOLERANCE
    }
}

/// Equations with their covariance.
pub(super) struct System<'a> {
    pub(super) space: &'a KnownSpace,
    pub(super) rows: &'a [Row],
    pub(super) values: &'a [f64],
    pub(super) covariance: &'a DMatrix<f64>,
}

/// What a system gives.
pub(super) struct Solution {
    pub(super) unknowns: DVector<f64>,
    /// Covariance of the unknowns.
    pub(super) spread: DMatrix<f64>,
    /// Residuals y − M θ̂, weighed with V⁻¹.
    pub(super) chi_squared: f64,
}

impl System<'_> {
    /// `None` where the covariance is not positive definite.
    pub(super) fn solve(&self) -> Option<Solution> {
        let design = self.rows_matrix() * &self.space.basis;
        let values = DVector::from_column_slice(self.values);
        let factor = self.covariance.clone().cholesky()?;
        let lower = factor.l();
        let white = lower.solve_lower_triangular(&design)?;
        let wanted = lower.solve_lower_triangular(&values)?;
        let inverse = white.tr_mul(&white).cholesky()?.inverse();
        let found = &inverse * white.tr_mul(&wanted);
        let chi_squared = (&wanted - &white * &found).norm_squared();
        let spread = &self.space.basis * &inverse * self.space.basis.transpose();
        Some(Solution {
            unknowns: &self.space.basis * found,
            spread,
            chi_squared,
        })
    }

    fn rows_matrix(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows.len(), UNKNOWNS, |i, j| self.rows[i][j])
    }
}

impl Solution {
    /// Value along a row of the unknowns, and its variance.
    pub(super) fn along(&self, row: &Row) -> (f64, f64) {
        let row = DVector::from_column_slice(row.as_slice());
        (row.dot(&self.unknowns), row.dot(&(&self.spread * &row)))
    }
}

/// dθ̂/dy of a system.
pub(super) struct Gain(DMatrix<f64>);

impl System<'_> {
    /// B (BᵀMᵀV⁻¹MB)⁻¹ BᵀMᵀV⁻¹.
    pub(super) fn gain(&self, solution: &Solution) -> Option<Gain> {
        let weighed = self
            .covariance
            .clone()
            .cholesky()?
            .solve(&self.rows_matrix());
        Some(Gain(&solution.spread * weighed.transpose()))
    }

    /// How far each unknown moves with the combinations that stay open, because the true
    /// directions are not the nominal ones: length of the row of dθ̂/d(open).
    pub(super) fn leaks(&self, gain: &Gain) -> [f64; UNKNOWNS] {
        let moved = &gain.0 * self.rows_matrix() * &self.space.open;
        std::array::from_fn(|unknown| moved.row(unknown).norm())
    }
}

impl Gain {
    /// Change of an unknown with the value of an equation.
    pub(super) fn of(&self, unknown: usize, equation: usize) -> f64 {
        self.0[(unknown, equation)]
    }

    /// Whether an unknown depends on an equation.
    pub(super) fn depends(&self, unknown: usize, equation: usize) -> bool {
        self.of(unknown, equation).abs() > SHARE_TOLERANCE
    }
}
