//! Systems of equations whose matrix is symmetric, positive definite and has entries near its diagonal only.

use nalgebra::DVector;

/// The Cholesky factor of such a matrix.
#[derive(Clone)]
pub(super) struct Banded {
    /// How far below the diagonal entries lie.
    reach: usize,
    /// Its lower half, row by row, each from so far before the diagonal on.
    lower: Vec<Vec<f64>>,
}

impl Banded {
    /// Of the sum of entries by row and column, of which the upper half is not needed; `None` where the matrix is not
    /// positive definite.
    pub(super) fn factor(
        (size, reach): (usize, usize),
        entries: impl Iterator<Item = (usize, usize, f64)>,
    ) -> Option<Banded> {
        let mut found = Banded { reach, lower: vec![vec![0.0; reach + 1]; size] };
        for (row, column, value) in entries.filter(|(row, column, _)| column <= row) {
            found.lower[row][reach + column - row] += value;
        }
        for row in 0..size {
            let first = row.saturating_sub(reach);
            for column in first..=row {
                let known = (first..column).map(|k| found.at(row, k) * found.at(column, k));
                let rest = found.at(row, column) - known.sum::<f64>();
                found.lower[row][reach + column - row] = match column < row {
                    true => rest / found.at(column, column),
                    false => Some(rest.sqrt()).filter(|_| rest > 0.0)?,
                };
            }
        }
        Some(found)
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.lower[row][self.reach + column - row]
    }

    /// The solution of matrix · x = `right`.
    pub(super) fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut x = right.clone();
        for row in 0..x.len() {
            let before = row.saturating_sub(self.reach)..row;
            let known: f64 = before.map(|k| self.at(row, k) * x[k]).sum();
            x[row] = (x[row] - known) / self.at(row, row);
        }
        for row in (0..x.len()).rev() {
            let behind = row + 1..x.len().min(row + self.reach + 1);
            let known: f64 = behind.map(|k| self.at(k, row) * x[k]).sum();
            x[row] = (x[row] - known) / self.at(row, row);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_system_is_solved() {
        // [4 2 0; 2 5 1; 0 1 3] · [1 2 3] = [8 15 11]
        let entries = [(0, 0, 4.0), (1, 0, 2.0), (1, 1, 5.0), (2, 1, 1.0), (2, 2, 3.0)];
        let factor = Banded::factor((3, 1), entries.into_iter()).expect("positive definite");
        let x = factor.solve(&DVector::from_vec(vec![8.0, 15.0, 11.0]));
        assert!((x - DVector::from_vec(vec![1.0, 2.0, 3.0])).norm() < 1e-12);
    }
}
