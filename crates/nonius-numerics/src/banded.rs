//! Systems whose unknowns hang together with their neighbours only.

/// The Cholesky factor of a symmetric, positive definite matrix with entries near its diagonal only.
pub struct Banded {
    /// How far below the diagonal entries lie.
    reach: usize,
    /// Its lower half, row after row, each from so far before the diagonal on.
    lower: Vec<f64>,
}

impl Banded {
    /// Of the sum of entries by row and column, of which the upper half is not needed; `None` where the matrix is not
    /// positive definite.
    pub fn factor(
        (size, reach): (usize, usize),
        entries: impl Iterator<Item = (usize, usize, f64)>,
    ) -> Option<Banded> {
        let mut found = Banded { reach, lower: vec![0.0; (reach + 1) * size] };
        for (row, column, value) in entries.filter(|(row, column, _)| column <= row) {
            let at = found.at(row, column);
            found.lower[at] += value;
        }
        for row in 0..size {
            let first = row.saturating_sub(reach);
            for column in first..=row {
                let of = |row| &found.lower[found.at(row, first)..found.at(row, column)];
                let known = of(row).iter().zip(of(column)).map(|(a, b)| a * b);
                let at = found.at(row, column);
                let rest = found.lower[at] - known.sum::<f64>();
                found.lower[at] = match column < row {
                    true => rest / found.lower[found.at(column, column)],
                    false => Some(rest.sqrt()).filter(|_| rest > 0.0)?,
                };
            }
        }
        Some(found)
    }

    /// Where an entry stands.
    fn at(&self, row: usize, column: usize) -> usize {
        row * self.reach + self.reach + column
    }

    /// The solution of matrix · x = `right`.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let (mut x, lower) = (right.to_vec(), &self.lower);
        for row in 0..x.len() {
            let (first, own) = (row.saturating_sub(self.reach), self.at(row, row));
            let before = lower[self.at(row, first)..own].iter().zip(&x[first..]);
            let known: f64 = before.map(|(by, x)| by * x).sum();
            x[row] = (x[row] - known) / lower[own];
        }
        for row in (0..x.len()).rev() {
            let (own, behind) = (self.at(row, row), x[row + 1..].iter());
            let column = lower[own..].iter().step_by(self.reach.max(1)).skip(1);
            let known: f64 = column.zip(behind.take(self.reach)).map(|(by, x)| by * x).sum();
            x[row] = (x[row] - known) / lower[own];
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
        let x = factor.solve(&[8.0, 15.0, 11.0]);
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(x, known)| (x - known).abs() < 1e-12));
    }
}
