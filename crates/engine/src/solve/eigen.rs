//! Eigenvalues and eigenvectors of a real matrix: reduction to Hessenberg form, then double-shifted QR with exceptional shifts.
//!
//! After `orthes` and `hqr2` of EISPACK (Smith et al., Matrix Eigensystem Routines, 1976), in the form of JAMA. The eigenvalues of linear
//! models of stiff machines span ten decades, for which nalgebra's Schur decomposition does not always deflate.

use nalgebra::{Complex, DMatrix};

/// `A V = V Λ` with a real `V`: the columns of a complex pair are the real and imaginary parts of the eigenvector for the eigenvalue with
/// positive imaginary part.
#[derive(Debug, Clone, PartialEq)]
pub struct Eigen {
    /// Eigenvalues; the two of a pair are adjacent, the one with positive imaginary part first.
    pub values: Vec<Complex<f64>>,
    /// Eigenvectors as columns; each, or each pair, is scaled to length 1.
    pub vectors: DMatrix<f64>,
}

/// Maximum number of QR sweeps per eigenvalue.
const MAXIMUM_SWEEPS: usize = 200;

/// Eigenvalues and eigenvectors; `None` if the iteration does not converge or the matrix is not finite.
pub fn eigen(matrix: &DMatrix<f64>) -> Option<Eigen> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let n = matrix.nrows();
    let mut work = Work { h: matrix.clone(), v: DMatrix::identity(n, n), re: vec![0.0; n], im: vec![0.0; n] };
    if n > 0 {
        work.hessenberg();
        work.triangular()?;
        work.back_substitute();
    }
    let values: Vec<_> = work.re.iter().zip(&work.im).map(|(&re, &im)| Complex::new(re, im)).collect();
    let mut vectors = work.v;
    let mut i = 0;
    while i < n {
        let columns = if values[i].im == 0.0 { 1 } else { 2 };
        let norm = vectors.columns(i, columns).norm();
        vectors.columns_mut(i, columns).unscale_mut(norm);
        i += columns;
    }
    vectors.iter().all(|x| x.is_finite()).then_some(Eigen { values, vectors })
}

/// State of the iteration: `h` becomes quasi-triangular, `v` accumulates the transformations.
struct Work {
    h: DMatrix<f64>,
    v: DMatrix<f64>,
    re: Vec<f64>,
    im: Vec<f64>,
}

/// Complex quotient `(a + bi)/(c + di)`.
fn quotient(a: f64, b: f64, c: f64, d: f64) -> (f64, f64) {
    let value = Complex::new(a, b) / Complex::new(c, d);
    (value.re, value.im)
}

impl Work {
    /// Reduces the matrix to Hessenberg form by Householder reflections.
    fn hessenberg(&mut self) {
        let n = self.h.nrows();
        let mut ort = vec![0.0; n];
        for m in 1..n.saturating_sub(1) {
            let scale: f64 = (m..n).map(|i| self.h[(i, m - 1)].abs()).sum();
            if scale == 0.0 {
                ort[m] = 0.0;
                continue;
            }
            let mut sum = 0.0;
            for i in (m..n).rev() {
                ort[i] = self.h[(i, m - 1)] / scale;
                sum += ort[i] * ort[i];
            }
            let g = if ort[m] > 0.0 { -sum.sqrt() } else { sum.sqrt() };
            sum -= ort[m] * g;
            ort[m] -= g;
            for j in m..n {
                let f = (m..n).rev().map(|i| ort[i] * self.h[(i, j)]).sum::<f64>() / sum;
                (m..n).for_each(|i| self.h[(i, j)] -= f * ort[i]);
            }
            for i in 0..n {
                let f = (m..n).rev().map(|j| ort[j] * self.h[(i, j)]).sum::<f64>() / sum;
                (m..n).for_each(|j| self.h[(i, j)] -= f * ort[j]);
            }
            ort[m] *= scale;
            self.h[(m, m - 1)] = scale * g;
        }
        for m in (1..n.saturating_sub(1)).rev() {
            if self.h[(m, m - 1)] == 0.0 {
                continue;
            }
            (m + 1..n).for_each(|i| ort[i] = self.h[(i, m - 1)]);
            for j in m..n {
                let g: f64 = (m..n).map(|i| ort[i] * self.v[(i, j)]).sum();
                let g = (g / ort[m]) / self.h[(m, m - 1)]; // divided twice, so that nothing underflows
                (m..n).for_each(|i| self.v[(i, j)] += g * ort[i]);
            }
        }
    }

    /// QR iteration to quasi-triangular form. `None` if it does not converge.
    fn triangular(&mut self) -> Option<()> {
        let size = self.h.nrows();
        let norm: f64 = (0..size).map(|i| (i.saturating_sub(1)..size).map(|j| self.h[(i, j)].abs()).sum::<f64>()).sum();
        let (mut end, mut sweeps, mut shift) = (size, 0, 0.0);
        while end > 0 {
            let n = end - 1;
            let low = self.small_subdiagonal(n, norm);
            if low == n {
                self.h[(n, n)] += shift;
                (self.re[n], self.im[n]) = (self.h[(n, n)], 0.0);
                (end, sweeps) = (n, 0);
            } else if low + 1 == n {
                self.split_pair(n, shift);
                (end, sweeps) = (n - 1, 0);
            } else {
                if sweeps == MAXIMUM_SWEEPS {
                    return None;
                }
                let (mut x, mut y) = (self.h[(n, n)], self.h[(n - 1, n - 1)]);
                let mut w = self.h[(n, n - 1)] * self.h[(n - 1, n)];
                if sweeps % 20 == 10 {
                    // Wilkinson's exceptional shift
                    shift += x;
                    (0..=n).for_each(|i| self.h[(i, i)] -= x);
                    let s = self.h[(n, n - 1)].abs() + self.h[(n - 1, n - 2)].abs();
                    (x, y, w) = (0.75 * s, 0.75 * s, -0.4375 * s * s);
                } else if sweeps % 20 == 19 {
                    let half = 0.5 * (y - x);
                    let square = half * half + w;
                    if square > 0.0 {
                        let root = if y < x { -square.sqrt() } else { square.sqrt() };
                        let s = x - w / (half + root);
                        (0..=n).for_each(|i| self.h[(i, i)] -= s);
                        shift += s;
                        (x, y, w) = (0.964, 0.964, 0.964);
                    }
                }
                sweeps += 1;
                self.sweep(low, n, (x, y, w));
            }
        }
        Some(())
    }

    /// Start of the unreduced block that ends at `n`.
    fn small_subdiagonal(&self, n: usize, norm: f64) -> usize {
        let mut low = n;
        while low > 0 {
            let s = self.h[(low - 1, low - 1)].abs() + self.h[(low, low)].abs();
            let s = if s == 0.0 { norm } else { s };
            if self.h[(low, low - 1)].abs() <= f64::EPSILON * s {
                break;
            }
            low -= 1;
        }
        low
    }

    /// Computes the two eigenvalues at the end of the block that ends at `n`.
    fn split_pair(&mut self, n: usize, shift: f64) {
        let size = self.h.nrows();
        let w = self.h[(n, n - 1)] * self.h[(n - 1, n)];
        let p = 0.5 * (self.h[(n - 1, n - 1)] - self.h[(n, n)]);
        let q = p * p + w;
        let z = q.abs().sqrt();
        self.h[(n, n)] += shift;
        self.h[(n - 1, n - 1)] += shift;
        let x = self.h[(n, n)];
        if q < 0.0 {
            (self.re[n - 1], self.re[n]) = (x + p, x + p);
            (self.im[n - 1], self.im[n]) = (z, -z);
            return;
        }
        let z = if p >= 0.0 { p + z } else { p - z };
        self.re[n - 1] = x + z;
        self.re[n] = if z == 0.0 { x + z } else { x - w / z };
        (self.im[n - 1], self.im[n]) = (0.0, 0.0);
        let x = self.h[(n, n - 1)];
        let s = x.abs() + z.abs();
        let (p, q) = (x / s, z / s);
        let r = p.hypot(q);
        let (p, q) = (p / r, q / r);
        for j in n - 1..size {
            let z = self.h[(n - 1, j)];
            self.h[(n - 1, j)] = q * z + p * self.h[(n, j)];
            self.h[(n, j)] = q * self.h[(n, j)] - p * z;
        }
        for i in 0..=n {
            let z = self.h[(i, n - 1)];
            self.h[(i, n - 1)] = q * z + p * self.h[(i, n)];
            self.h[(i, n)] = q * self.h[(i, n)] - p * z;
        }
        for i in 0..size {
            let z = self.v[(i, n - 1)];
            self.v[(i, n - 1)] = q * z + p * self.v[(i, n)];
            self.v[(i, n)] = q * self.v[(i, n)] - p * z;
        }
    }

    /// Performs one double-shifted sweep over the block from `low` to `n`.
    fn sweep(&mut self, low: usize, n: usize, (mut x, mut y, w): (f64, f64, f64)) {
        let size = self.h.nrows();
        let (mut p, mut q, mut r, mut z);
        let mut m = n - 2;
        loop {
            z = self.h[(m, m)];
            let (rr, ss) = (x - z, y - z);
            p = (rr * ss - w) / self.h[(m + 1, m)] + self.h[(m, m + 1)];
            q = self.h[(m + 1, m + 1)] - z - rr - ss;
            r = self.h[(m + 2, m + 1)];
            let s = p.abs() + q.abs() + r.abs();
            (p, q, r) = (p / s, q / s, r / s);
            if m == low {
                break;
            }
            let beside = self.h[(m, m - 1)].abs() * (q.abs() + r.abs());
            let around = self.h[(m - 1, m - 1)].abs() + z.abs() + self.h[(m + 1, m + 1)].abs();
            if beside < f64::EPSILON * p.abs() * around {
                break;
            }
            m -= 1;
        }
        for i in m + 2..=n {
            self.h[(i, i - 2)] = 0.0;
            if i > m + 2 {
                self.h[(i, i - 3)] = 0.0;
            }
        }
        for k in m..n {
            let last = k == n - 1;
            if k != m {
                p = self.h[(k, k - 1)];
                q = self.h[(k + 1, k - 1)];
                r = if last { 0.0 } else { self.h[(k + 2, k - 1)] };
                x = p.abs() + q.abs() + r.abs();
                if x == 0.0 {
                    continue;
                }
                (p, q, r) = (p / x, q / x, r / x);
            }
            let norm = (p * p + q * q + r * r).sqrt();
            let s = if p < 0.0 { -norm } else { norm };
            if s == 0.0 {
                continue;
            }
            if k != m {
                self.h[(k, k - 1)] = -s * x;
            } else if low != m {
                self.h[(k, k - 1)] = -self.h[(k, k - 1)];
            }
            p += s;
            x = p / s;
            y = q / s;
            z = r / s;
            q /= p;
            r /= p;
            for j in k..size {
                let mut t = self.h[(k, j)] + q * self.h[(k + 1, j)];
                if !last {
                    t += r * self.h[(k + 2, j)];
                    self.h[(k + 2, j)] -= t * z;
                }
                self.h[(k, j)] -= t * x;
                self.h[(k + 1, j)] -= t * y;
            }
            let rows = n.min(k + 3);
            for (matrix, rows) in [(&mut self.h, rows + 1), (&mut self.v, size)] {
                for i in 0..rows {
                    let mut t = x * matrix[(i, k)] + y * matrix[(i, k + 1)];
                    if !last {
                        t += z * matrix[(i, k + 2)];
                        matrix[(i, k + 2)] -= t * r;
                    }
                    matrix[(i, k)] -= t;
                    matrix[(i, k + 1)] -= t * q;
                }
            }
        }
    }

    /// Computes the eigenvectors of the quasi-triangular form, then those of the matrix.
    fn back_substitute(&mut self) {
        let size = self.h.nrows();
        let norm: f64 = (0..size).map(|i| (i.saturating_sub(1)..size).map(|j| self.h[(i, j)].abs()).sum::<f64>()).sum();
        if norm == 0.0 {
            return;
        }
        for n in (0..size).rev() {
            let (p, q) = (self.re[n], self.im[n]);
            if q == 0.0 {
                self.real_vector(n, p, norm);
            } else if q < 0.0 {
                self.complex_vector(n, p, q, norm);
            }
        }
        for j in (0..size).rev() {
            for i in 0..size {
                self.v[(i, j)] = (0..=j).map(|k| self.v[(i, k)] * self.h[(k, j)]).sum();
            }
        }
    }

    fn real_vector(&mut self, n: usize, p: f64, norm: f64) {
        let h = &mut self.h;
        let (mut l, mut z, mut s) = (n, 0.0, 0.0);
        h[(n, n)] = 1.0;
        for i in (0..n).rev() {
            let w = h[(i, i)] - p;
            let r: f64 = (l..=n).map(|j| h[(i, j)] * h[(j, n)]).sum();
            if self.im[i] < 0.0 {
                (z, s) = (w, r);
                continue;
            }
            l = i;
            if self.im[i] == 0.0 {
                h[(i, n)] = if w == 0.0 { -r / (f64::EPSILON * norm) } else { -r / w };
            } else {
                let (x, y) = (h[(i, i + 1)], h[(i + 1, i)]);
                let q = (self.re[i] - p).powi(2) + self.im[i].powi(2);
                let t = (x * s - z * r) / q;
                h[(i, n)] = t;
                h[(i + 1, n)] = if x.abs() > z.abs() { (-r - w * t) / x } else { (-s - y * t) / z };
            }
            let t = h[(i, n)].abs();
            if f64::EPSILON * t * t > 1.0 {
                (i..=n).for_each(|j| h[(j, n)] /= t);
            }
        }
    }

    fn complex_vector(&mut self, n: usize, p: f64, q: f64, norm: f64) {
        let h = &mut self.h;
        let mut l = n - 1;
        if h[(n, n - 1)].abs() > h[(n - 1, n)].abs() {
            h[(n - 1, n - 1)] = q / h[(n, n - 1)];
            h[(n - 1, n)] = -(h[(n, n)] - p) / h[(n, n - 1)];
        } else {
            let (re, im) = quotient(0.0, -h[(n - 1, n)], h[(n - 1, n - 1)] - p, q);
            (h[(n - 1, n - 1)], h[(n - 1, n)]) = (re, im);
        }
        (h[(n, n - 1)], h[(n, n)]) = (0.0, 1.0);
        let (mut z, mut r, mut s) = (0.0, 0.0, 0.0);
        for i in (0..n - 1).rev() {
            let ra: f64 = (l..=n).map(|j| h[(i, j)] * h[(j, n - 1)]).sum();
            let sa: f64 = (l..=n).map(|j| h[(i, j)] * h[(j, n)]).sum();
            let w = h[(i, i)] - p;
            if self.im[i] < 0.0 {
                (z, r, s) = (w, ra, sa);
                continue;
            }
            l = i;
            if self.im[i] == 0.0 {
                let (re, im) = quotient(-ra, -sa, w, q);
                (h[(i, n - 1)], h[(i, n)]) = (re, im);
            } else {
                let (x, y) = (h[(i, i + 1)], h[(i + 1, i)]);
                let mut vr = (self.re[i] - p).powi(2) + self.im[i].powi(2) - q * q;
                let vi = (self.re[i] - p) * 2.0 * q;
                if vr == 0.0 && vi == 0.0 {
                    vr = f64::EPSILON * norm * (w.abs() + q.abs() + x.abs() + y.abs() + z.abs());
                }
                let (re, im) = quotient(x * r - z * ra + q * sa, x * s - z * sa - q * ra, vr, vi);
                (h[(i, n - 1)], h[(i, n)]) = (re, im);
                if x.abs() > z.abs() + q.abs() {
                    h[(i + 1, n - 1)] = (-ra - w * re + q * im) / x;
                    h[(i + 1, n)] = (-sa - w * im - q * re) / x;
                } else {
                    let (re, im) = quotient(-r - y * re, -s - y * im, z, q);
                    (h[(i + 1, n - 1)], h[(i + 1, n)]) = (re, im);
                }
            }
            let t = h[(i, n - 1)].abs().max(h[(i, n)].abs());
            if f64::EPSILON * t * t > 1.0 {
                for j in i..=n {
                    h[(j, n - 1)] /= t;
                    h[(j, n)] /= t;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `A V = V Λ` to round-off for matrices with real, complex and equal eigenvalues, and for a stiff chain with ten decades.
    #[test]
    fn vectors_satisfy_the_equation() {
        let mut seed = 7u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut matrices = vec![DMatrix::from_fn(1, 1, |_, _| 3.0), DMatrix::identity(4, 4), DMatrix::zeros(3, 3)];
        for n in [2, 3, 5, 17, 60] {
            matrices.push(DMatrix::from_fn(n, n, |_, _| random()));
        }
        let n = 20;
        matrices.push(DMatrix::from_fn(2 * n, 2 * n, |i, j| {
            let frequency = 10f64.powf(5.0 * (i % n) as f64 / n as f64);
            match (i < n, j < n) {
                (true, false) if j == i + n => frequency,
                (false, true) if i == j + n => -frequency,
                (false, false) if i == j => -0.02 * frequency + 0.001,
                _ => 0.0,
            }
        }));
        for matrix in matrices {
            let Eigen { values, vectors } =
                eigen(&matrix).unwrap_or_else(|| panic!("{} × {}: no convergence", matrix.nrows(), matrix.ncols()));
            let mut image = DMatrix::zeros(values.len(), values.len());
            for (i, value) in values.iter().enumerate() {
                // for the first of a pair, with the vector re + i·im: A re = σ re − ω im, A im = ω re + σ im
                let column = match value.im {
                    0.0 => vectors.column(i) * value.re,
                    im if im > 0.0 => vectors.column(i) * value.re - vectors.column(i + 1) * im,
                    im => vectors.column(i) * value.re - vectors.column(i - 1) * im,
                };
                image.set_column(i, &column);
            }
            let off = (&matrix * &vectors - image).amax() / matrix.amax().max(1e-300);
            assert!(off < 1e-13 * values.len() as f64, "{} × {}: {off:e}", matrix.nrows(), matrix.ncols());
        }
    }
}
