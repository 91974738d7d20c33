//! Systems of equations whose matrix has entries near its diagonal only.

/// Lower half of a symmetric band matrix; after [`Banded::factor`] its Cholesky factor.
pub(super) struct Banded {
    size: usize,
    /// How far below the diagonal entries lie.
    reach: usize,
    /// Row by row, `reach` + 1 entries each, the last one on the diagonal.
    entries: Vec<f64>,
}

/// Cholesky factor of a symmetric positive definite matrix whose entries lie near its diagonal.
pub(super) struct Factor(Banded);

impl Banded {
    pub(super) fn zero(size: usize, reach: usize) -> Banded {
        Banded { size, reach, entries: vec![0.0; size * (reach + 1)] }
    }

    fn at(&self, row: usize, column: usize) -> usize {
        row * (self.reach + 1) + self.reach + column - row
    }

    /// Adds to the entry of a row and a column at or before it.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = self.at(row, column);
        self.entries[at] += value;
    }

    /// `None` where the matrix is not positive definite.
    pub(super) fn factor(mut self) -> Option<Factor> {
        for row in 0..self.size {
            let first = row.saturating_sub(self.reach);
            for column in first..=row {
                let shared = first.max(column.saturating_sub(self.reach))..column;
                let known: f64 = shared
                    .map(|k| self.entries[self.at(row, k)] * self.entries[self.at(column, k)])
                    .sum();
                let at = self.at(row, column);
                let rest = self.entries[at] - known;
                self.entries[at] = if column == row {
                    if rest <= 0.0 {
                        return None;
                    }
                    rest.sqrt()
                } else {
                    rest / self.entries[self.at(column, column)]
                };
            }
        }
        Some(Factor(self))
    }
}

impl Factor {
    /// The solution of matrix · x = `right`.
    pub(super) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let Factor(lower) = self;
        let mut x = right.to_vec();
        for row in 0..lower.size {
            let first = row.saturating_sub(lower.reach);
            let known: f64 = (first..row).map(|k| lower.entries[lower.at(row, k)] * x[k]).sum();
            x[row] = (x[row] - known) / lower.entries[lower.at(row, row)];
        }
        for row in (0..lower.size).rev() {
            let last = (row + lower.reach).min(lower.size.saturating_sub(1));
            let known: f64 = (row + 1..=last).map(|k| lower.entries[lower.at(k, row)] * x[k]).sum();
            x[row] = (x[row] - known) / lower.entries[lower.at(row, row)];
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
        let mut matrix = Banded::zero(3, 1);
        for (row, column, value) in
            [(0, 0, 4.0), (1, 0, 2.0), (1, 1, 5.0), (2, 1, 1.0), (2, 2, 3.0)]
        {
            matrix.add(row, column, value);
        }
        let Some(factor) = matrix.factor() else {
            panic!("the matrix is positive definite");
        };
        let x = factor.solve(&[8.0, 15.0, 11.0]);
        for (found, wanted) in x.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - wanted).abs() < 1e-12, "{x:?}");
        }
    }
}
