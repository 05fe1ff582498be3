//! The resolvent `(λ − L)⁻¹` of the lag states at many values of `λ`.

use nalgebra::{Complex, DMatrix, Hessenberg};

/// A matrix `L` in a form for which `(λ − L) x = b` is solved in a time proportional to the number of entries, instead of that number times
/// the size.
pub enum Resolvent {
    /// The diagonal of a diagonal matrix.
    Diagonal(Vec<f64>),
    /// `L = Q H Qᵀ`, `H` upper Hessenberg.
    Hessenberg {
        /// Orthogonal matrix `Q`.
        turned: DMatrix<f64>,
        /// Upper Hessenberg matrix `H`.
        upper: DMatrix<f64>,
    },
}

impl Resolvent {
    /// Transforms a square matrix.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let m = matrix.nrows();
        if (0..m).all(|i| (0..m).all(|j| i == j || matrix[(i, j)] == 0.0)) {
            return Self::Diagonal(matrix.diagonal().iter().copied().collect());
        }
        let (turned, upper) = Hessenberg::new(matrix.clone()).unpack();
        Self::Hessenberg { turned, upper }
    }

    /// `(λ − L)⁻¹` times a matrix. The result is not finite if `λ` is an eigenvalue of `L`.
    pub fn behind(&self, at: Complex<f64>, mut right: DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        match self {
            Self::Diagonal(entries) => {
                for (entry, mut row) in entries.iter().zip(right.row_iter_mut()) {
                    let inverse = (at - entry).inv();
                    row.iter_mut().for_each(|x| *x *= inverse);
                }
                right
            }
            Self::Hessenberg { turned, upper } => {
                let into = |matrix: &DMatrix<f64>, columns: &DMatrix<Complex<f64>>| {
                    let [re, im] = [columns.map(|x| x.re), columns.map(|x| x.im)].map(|part| matrix * part);
                    re.zip_map(&im, Complex::new)
                };
                into(turned, &solved(upper, at, into(&turned.transpose(), &right)))
            }
        }
    }
}

/// `(λ − H)⁻¹` times a matrix: eliminates one entry per column, with the larger of two rows as pivot.
fn solved(upper: &DMatrix<f64>, at: Complex<f64>, mut right: DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let m = upper.nrows();
    // stored row by row, in the direction of the elimination
    let mut rows: Vec<Vec<Complex<f64>>> = (0..m)
        .map(|i| (0..m).map(|j| if i == j { at - upper[(i, j)] } else { Complex::new(-upper[(i, j)], 0.0) }).collect())
        .collect();
    for k in 0..m - 1 {
        if rows[k + 1][k].norm_sqr() > rows[k][k].norm_sqr() {
            rows.swap(k, k + 1);
            right.swap_rows(k, k + 1);
        }
        let factor = rows[k + 1][k] / rows[k][k];
        if factor == Complex::new(0.0, 0.0) {
            continue;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        below[0][k..].iter_mut().zip(&above[k][k..]).for_each(|(entry, other)| *entry -= factor * other);
        for mut column in right.column_iter_mut() {
            let change = factor * column[k];
            column[k + 1] -= change;
        }
    }
    for mut column in right.column_iter_mut() {
        for k in (0..m).rev() {
            let known: Complex<f64> = (k + 1..m).map(|j| rows[k][j] * column[j]).sum();
            column[k] = (column[k] - known) / rows[k][k];
        }
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The equation `(λ − L) x = b` is satisfied for matrices with irregular entries, one of them with zeros on the diagonal, and for a
    /// diagonal one.
    #[test]
    fn it_solves_its_equation() {
        for (size, on_diagonal) in [(1, 1.0), (2, 0.0), (7, 1.0), (40, 0.0)] {
            let full = DMatrix::from_fn(size, size, |i, j| {
                if i == j { on_diagonal } else { ((3 * i + 7 * j * j + i * j) as f64).sin() }
            });
            let diagonal = DMatrix::from_fn(size, size, |i, j| if i == j { -1.0 - i as f64 } else { 0.0 });
            for matrix in [full, diagonal] {
                let right = DMatrix::from_fn(size, 3, |i, j| Complex::new((i + 5 * j) as f64, (i * j) as f64).sin());
                for at in [Complex::new(0.3, 2.0), Complex::new(0.0, 1e3)] {
                    let x = Resolvent::of(&matrix).behind(at, right.clone());
                    let back = &x * at - matrix.map(|entry| Complex::new(entry, 0.0)) * &x;
                    let size = right.map(|entry| entry.norm()).max();
                    let off = (back - &right).map(|entry| entry.norm()).max();
                    // backward stable: relative to the round-off of the entries of x times the matrix
                    assert!(off < 1e-10 * size, "{off:e}");
                }
            }
        }
    }
}
