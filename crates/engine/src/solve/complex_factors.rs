//! LU factors of a complex matrix with separate real and imaginary parts, so that the compiler vectorises the inner loop, which it does not
//! in a generic factorisation.

use nalgebra::{Complex, DVector};

/// `PA = LU` of a square matrix, with the largest pivot of each column.
pub(crate) struct ComplexFactors {
    size: usize,
    /// `L` below the diagonal (its diagonal is 1) and `U`, row by row.
    re: Vec<f64>,
    im: Vec<f64>,
    /// Row of `A` that corresponds to each row of the factors.
    order: Vec<usize>,
}

impl ComplexFactors {
    /// Factorises the matrix of `size` rows with these entries. The factors of a singular matrix are not finite.
    pub fn new(size: usize, entry: impl Fn(usize, usize) -> Complex<f64>) -> Self {
        let mut factors =
            Self { size, re: vec![0.0; size * size], im: vec![0.0; size * size], order: (0..size).collect() };
        for row in 0..size {
            for column in 0..size {
                let value = entry(row, column);
                (factors.re[row * size + column], factors.im[row * size + column]) = (value.re, value.im);
            }
        }
        for step in 0..size {
            factors.eliminate(step);
        }
        factors
    }

    fn at(&self, row: usize, column: usize) -> Complex<f64> {
        Complex::new(self.re[row * self.size + column], self.im[row * self.size + column])
    }

    /// Eliminates the pivot column of a step from all rows below.
    fn eliminate(&mut self, step: usize) {
        let n = self.size;
        let mut pivot = step;
        for row in step + 1..n {
            if self.at(row, step).norm_sqr() > self.at(pivot, step).norm_sqr() {
                pivot = row;
            }
        }
        if pivot != step {
            self.order.swap(step, pivot);
            for part in [&mut self.re, &mut self.im] {
                let (above, below) = part.split_at_mut(pivot * n);
                above[step * n..(step + 1) * n].swap_with_slice(&mut below[..n]);
            }
        }
        let inverse = self.at(step, step).inv();
        let (re_above, re_below) = self.re.split_at_mut((step + 1) * n);
        let (im_above, im_below) = self.im.split_at_mut((step + 1) * n);
        let (re_pivot, im_pivot) = (&re_above[step * n + step + 1..], &im_above[step * n + step + 1..]);
        for (re, im) in re_below.chunks_exact_mut(n).zip(im_below.chunks_exact_mut(n)) {
            let factor = Complex::new(re[step], im[step]) * inverse;
            (re[step], im[step]) = (factor.re, factor.im);
            let entries = re[step + 1..].iter_mut().zip(&mut im[step + 1..]);
            for ((re, im), (re_pivot, im_pivot)) in entries.zip(re_pivot.iter().zip(im_pivot)) {
                *re -= factor.re * re_pivot - factor.im * im_pivot;
                *im -= factor.re * im_pivot + factor.im * re_pivot;
            }
        }
    }

    /// Solution of `A x = b`.
    pub fn solve(&self, b: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        let n = self.size;
        let mut x = DVector::from_fn(n, |row, _| b[self.order[row]]);
        for row in 0..n {
            let sum: Complex<f64> = (0..row).map(|column| self.at(row, column) * x[column]).sum();
            x[row] -= sum;
        }
        for row in (0..n).rev() {
            let sum: Complex<f64> = (row + 1..n).map(|column| self.at(row, column) * x[column]).sum();
            x[row] = (x[row] - sum) / self.at(row, row);
        }
        x
    }

    /// Solution of `Aᴴ y = b` with the same factors: `Aᴴ = UᴴLᴴP`.
    pub fn solve_adjoint(&self, b: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        let n = self.size;
        let mut y = b.clone();
        for row in 0..n {
            y[row] /= self.at(row, row).conj();
            for column in row + 1..n {
                let known = y[row];
                y[column] -= self.at(row, column).conj() * known;
            }
        }
        for row in (0..n).rev() {
            for column in 0..row {
                let known = y[row];
                y[column] -= self.at(row, column).conj() * known;
            }
        }
        let mut placed = DVector::zeros(n);
        for row in 0..n {
            placed[self.order[row]] = y[row];
        }
        placed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Both solutions satisfy their equations; the first pivot is zero, which requires an exchange of rows.
    #[test]
    fn factors_solve_with_the_matrix_and_its_adjoint() {
        let n = 9;
        let entry = |row: usize, column: usize| match (row, column) {
            (0, 0) => Complex::new(0.0, 0.0),
            _ => Complex::new(((row * 7 + column * 3) % 11) as f64 - 4.0, ((row * 5 + column * column) % 13) as f64),
        };
        let matrix = DMatrix::from_fn(n, n, entry);
        let b = DVector::from_fn(n, |row, _| Complex::new(row as f64, 1.0 - row as f64));
        let factors = ComplexFactors::new(n, entry);
        assert!((&matrix * factors.solve(&b) - &b).norm() < 1e-12 * b.norm());
        assert!((matrix.adjoint() * factors.solve_adjoint(&b) - &b).norm() < 1e-12 * b.norm());
    }

    #[test]
    fn a_singular_matrix_has_no_finite_solution() {
        let factors = ComplexFactors::new(2, |_, _| Complex::new(1.0, 2.0));
        let x = factors.solve(&DVector::from_element(2, Complex::new(1.0, 0.0)));
        assert!(!x.norm().is_finite());
    }
}
