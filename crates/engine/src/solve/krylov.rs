//! Linear algebra with a matrix available only through its products: the monodromy matrix over one revolution of a rotor, whose product
//! with a direction costs a time march, NOTATION eqs. (L33) and (L34).
//!
//! Eisenstat, Elman and Schultz, *Variational iterative methods for nonsymmetric systems of linear equations*, SIAM J. Numer. Anal. 20
//! (1983): generalised conjugate residuals; Saad, *Numerical Methods for Large Eigenvalue Problems* (2011), section 6.2: Arnoldi.

use crate::solve::eigen::eigen;
use nalgebra::{Complex, DMatrix, DVector};

/// Length of a direction after orthogonalisation below which it is linearly dependent: products computed by differences of marches are
/// accurate to about 1e-8.
const NOTHING_NEW: f64 = 1e-7;

/// Search directions with their products, for solving `(I − M) d = r`; kept from one right-hand side to the next.
#[derive(Debug, Clone, Default)]
pub struct Directions {
    vectors: Vec<DVector<f64>>,
    /// Orthonormal basis of the vectors `v − M v`.
    images: Vec<DVector<f64>>,
    /// Upper triangle of the factorisation: `v_j − M v_j = Σ images_i triangle[j][i]`.
    triangle: Vec<Vec<f64>>,
}

impl Directions {
    /// Number of products so far.
    pub fn products(&self) -> usize {
        self.vectors.len()
    }

    /// Removes all directions.
    pub fn clear(&mut self) {
        self.vectors.clear();
        self.images.clear();
        self.triangle.clear();
    }

    /// Returns the `d` with the smallest `‖r − (I − M) d‖` over the directions, which are extended until this is below `share ‖r‖`, up to
    /// `most` in total. `product` multiplies by `M`. Also returns the remaining fraction of `r`.
    ///
    /// # Errors
    /// If `product` fails.
    pub fn solve<E>(
        &mut self,
        right: &DVector<f64>,
        share: f64,
        most: usize,
        mut product: impl FnMut(&DVector<f64>) -> Result<DVector<f64>, E>,
    ) -> Result<(DVector<f64>, f64), E> {
        let whole = right.norm();
        let mut left = right.clone();
        let mut amounts: Vec<f64> = Vec::new();
        for image in &self.images {
            let amount = image.dot(&left);
            left.axpy(-amount, image, 1.0);
            amounts.push(amount);
        }
        while left.norm() > share * whole && self.vectors.len() < most.min(right.len()) {
            let mut vector = left.clone();
            let Some(_) = orthogonalise(&mut vector, &self.vectors) else { break };
            let mut image = &vector - product(&vector)?;
            let mut column = vec![0.0; self.images.len()];
            let size = image.norm();
            for _ in 0..2 {
                for (entry, known) in column.iter_mut().zip(&self.images) {
                    let amount = known.dot(&image);
                    image.axpy(-amount, known, 1.0);
                    *entry += amount;
                }
            }
            let own = image.norm();
            if own.partial_cmp(&(NOTHING_NEW * size)) != Some(std::cmp::Ordering::Greater) {
                break; // I − M is singular: a perturbation that neither grows nor decays
            }
            image /= own;
            column.push(own);
            let amount = image.dot(&left);
            left.axpy(-amount, &image, 1.0);
            amounts.push(amount);
            self.vectors.push(vector);
            self.images.push(image);
            self.triangle.push(column);
        }
        let mut change = DVector::zeros(right.len());
        for j in (0..self.vectors.len()).rev() {
            let amount = amounts[j] / self.triangle[j][j];
            change.axpy(amount, &self.vectors[j], 1.0);
            for (other, entry) in amounts[..j].iter_mut().zip(&self.triangle[j]) {
                *other -= amount * entry;
            }
        }
        Ok((change, if whole > 0.0 { left.norm() / whole } else { 0.0 }))
    }
}

/// Orthonormalises a vector against given directions; `None` if it is linearly dependent.
fn orthogonalise(vector: &mut DVector<f64>, known: &[DVector<f64>]) -> Option<Vec<f64>> {
    let size = vector.norm();
    let mut shares = vec![0.0; known.len()];
    for _ in 0..2 {
        for (share, other) in shares.iter_mut().zip(known) {
            let amount = other.dot(vector);
            vector.axpy(-amount, other, 1.0);
            *share += amount;
        }
    }
    let left = vector.norm();
    if left.partial_cmp(&(NOTHING_NEW * size)) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    *vector /= left;
    shares.push(left);
    Some(shares)
}

/// An approximate eigenvalue from the products.
#[derive(Debug, Clone, PartialEq)]
pub struct RitzPair {
    /// Eigenvalue; with positive imaginary part for a complex pair.
    pub value: Complex<f64>,
    /// Components of the eigenvector in the directions, in the order of the products.
    pub amounts: DVector<Complex<f64>>,
    /// Relative residual `‖M x − μ x‖ / (|μ| ‖x‖)`.
    pub error: f64,
}

/// Eigenvalues of `M` by Arnoldi's iteration with at most `most` products, largest first. `product` is called with the number of the
/// direction and the direction, of `n` entries. If the directions span an invariant subspace before `most`, for example because several
/// blades have equal eigenvalues, a new random direction is added.
///
/// # Errors
/// If `product` fails. The list is empty if `n` or `most` is zero, and if the small matrix has no accurate eigenvalues.
pub fn leading<E>(
    n: usize,
    most: usize,
    mut product: impl FnMut(usize, &DVector<f64>) -> Result<DVector<f64>, E>,
) -> Result<Vec<RitzPair>, E> {
    let most = most.min(n);
    if most == 0 {
        return Ok(Vec::new());
    }
    let mut basis: Vec<DVector<f64>> = Vec::with_capacity(most);
    let mut small = DMatrix::<f64>::zeros(most, most);
    let mut next = fresh(n, 0);
    let mut beyond = 0.0;
    let _ = orthogonalise(&mut next, &[]);
    for j in 0..most {
        basis.push(next.clone());
        let mut image = product(j, &basis[j])?;
        let size = image.norm();
        for _ in 0..2 {
            for (i, known) in basis.iter().enumerate() {
                let amount = known.dot(&image);
                image.axpy(-amount, known, 1.0);
                small[(i, j)] += amount;
            }
        }
        beyond = image.norm();
        let closed = beyond <= NOTHING_NEW * size.max(1.0);
        if !closed {
            image /= beyond;
            next = image;
        } else {
            beyond = 0.0;
            next = fresh(n, j + 1);
            if orthogonalise(&mut next, &basis).is_none() {
                break;
            }
        }
        if j + 1 < most {
            small[(j + 1, j)] = beyond;
        }
    }
    let m = basis.len();
    if m == n {
        beyond = 0.0;
    }
    let Some(found) = eigen(&small.view((0, 0), (m, m)).into_owned()) else { return Ok(Vec::new()) };
    let mut list = Vec::new();
    let mut i = 0;
    while i < m {
        let pair = found.values[i].im != 0.0;
        let imaginary = |row: usize| if pair { found.vectors[(row, i + 1)] } else { 0.0 };
        let mut amounts = DVector::from_fn(m, |row, _| Complex::new(found.vectors[(row, i)], imaginary(row)));
        let size = amounts.norm();
        amounts /= Complex::new(size, 0.0);
        let error = if found.values[i].norm() > 0.0 {
            beyond * amounts[m - 1].norm() / found.values[i].norm()
        } else {
            f64::INFINITY
        };
        list.push(RitzPair { value: found.values[i], amounts, error });
        i += if pair { 2 } else { 1 };
    }
    list.sort_by(|a, b| b.value.norm().total_cmp(&a.value.norm()));
    Ok(list)
}

/// An irregular direction, which has a component in every mode of a model.
fn fresh(n: usize, number: usize) -> DVector<f64> {
    DVector::from_fn(n, |i, _| ((i as f64 + 1.0) * (2.399_963 + 0.754_877 * number as f64)).sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    type Never = std::convert::Infallible;

    /// A matrix with given eigenvalues and coupled coordinates.
    fn matrix(values: &[f64]) -> DMatrix<f64> {
        let n = values.len();
        let mix = DMatrix::from_fn(n, n, |i, j| if i == j { 2.0 } else { fresh(n, i)[j] / n as f64 });
        let inverse = mix.clone().try_inverse().unwrap();
        mix * DMatrix::from_diagonal(&DVector::from_column_slice(values)) * inverse
    }

    /// A few products solve a system whose matrix has few eigenvalues that are not small; a similar second right-hand side needs no further
    /// ones. An eigenvalue above 1 has no effect.
    #[test]
    fn few_products_solve() {
        let mut values = vec![0.0; 40];
        values[..4].copy_from_slice(&[0.95, -0.7, 3.0, 0.5]);
        let a = matrix(&values);
        let right = fresh(40, 3);
        let mut known = Directions::default();
        let mut product = |v: &DVector<f64>| Ok::<_, Never>(&a * v);
        let (d, left) = known.solve(&right, 1e-10, 40, &mut product).unwrap();
        assert!(left <= 1e-10 && known.products() <= 6, "{left:e} after {}", known.products());
        assert!((&d - &a * &d - &right).norm() < 1e-8 * right.norm());
        let products = known.products();
        let second = &a * fresh(40, 5);
        let (d, _) = known.solve(&second, 1e-6, 40, &mut product).unwrap();
        assert!(known.products() <= products + 2, "{} after {products}", known.products());
        assert!((&d - &a * &d - &second).norm() < 1e-5 * second.norm());
    }

    /// Multiple eigenvalues, as of several equal blades, are found with their multiplicity, and those of a large matrix to the stated
    /// error.
    #[test]
    fn leading_eigenvalues() {
        let values = [0.9, 0.9, 0.9, -0.4, 0.1, 0.1];
        let a = matrix(&values);
        let found = leading(6, 6, |_, v| Ok::<_, Never>(&a * v)).unwrap();
        for (pair, value) in found.iter().zip(values) {
            assert!((pair.value - Complex::new(value, 0.0)).norm() < 1e-6, "{found:?}");
        }
        let many: Vec<f64> =
            (0..120).map(|k| 0.97f64.powi(k) * if k % 2 == 0 { 1.0 } else { -1.0 } * 0.3f64.powi(k / 6)).collect();
        let a = matrix(&many);
        let found = leading(120, 30, |_, v| Ok::<_, Never>(&a * v)).unwrap();
        for (pair, value) in found.iter().take(6).zip(&many) {
            assert!(
                pair.error < 1e-6 && (pair.value.re - value).abs() < 1e-6,
                "{} {value} {:e}",
                pair.value,
                pair.error
            );
        }
    }
}
