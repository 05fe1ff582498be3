//! Factor of the constraints of rigid loops: the pseudo-inverse of their small matrix, NOTATION eq. (C6).

/// Eigenvalue of the small matrix, relative to its largest, below which a row is redundant: round-off of rows that depend on others is
/// 1e-15, and the mobilities at the loops of one machine do not differ by more than this factor.
const REDUNDANT: f64 = 1e-11;
/// Eigenvalue of the small matrix, relative to the mobility of the points themselves, below which it is round-off: if no loop has a freedom,
/// as between points of a hinge's axis, the largest eigenvalue is round-off too.
const IMMOBILE: f64 = 1e-13;
/// Maximum number of sweeps of the Jacobi iteration, which converges quadratically.
const JACOBI_SWEEPS: usize = 30;

/// Workspace of the rigid loops.
#[derive(Debug, Clone)]
pub(crate) struct RigidFactor {
    /// `Z = A⁻¹ Gᵀ`, one column per row of the gaps.
    pub(super) columns: Vec<Vec<f64>>,
    /// `S = G Z` by rows; after its inversion its eigenvalues on the diagonal.
    pub(super) small: Vec<f64>,
    /// Eigenvectors of `S` in columns.
    vectors: Vec<f64>,
    /// Pseudo-inverse of `S` by rows.
    inverse: Vec<f64>,
    pub(super) gaps: Vec<f64>,
    /// Eigenvalue up to which a row is redundant.
    least: f64,
    /// Largest change of a point, in place of the difference of two points in `S`.
    pub(super) mobility: f64,
}

impl RigidFactor {
    /// Workspace for `rows` rows and `coordinates` coordinates of the tree.
    pub(crate) fn new(rows: usize, coordinates: usize) -> Self {
        let square = vec![0.0; rows * rows];
        Self {
            columns: vec![vec![0.0; coordinates]; rows],
            small: square.clone(),
            vectors: square.clone(),
            inverse: square,
            gaps: vec![0.0; rows],
            least: 0.0,
            mobility: 0.0,
        }
    }

    /// Weight of the column of a row in the change that removes the gaps in `gaps`.
    pub(super) fn weight(&self, row: usize) -> f64 {
        let rows = self.gaps.len();
        self.inverse[row * rows..][..rows].iter().zip(&self.gaps).map(|(inverse, gap)| inverse * gap).sum()
    }

    /// Subtracts the change that removes the gaps in `gaps`.
    pub(super) fn remove_gaps(&self, x: &mut [f64]) {
        for (row, column) in self.columns.iter().enumerate() {
            let weight = self.weight(row);
            x.iter_mut().zip(column).for_each(|(x, z)| *x -= weight * z);
        }
    }

    /// Change of the tree's coordinates that removes a unit gap of a row.
    pub(crate) fn removal(&self, row: usize) -> Vec<f64> {
        let rows = self.columns.len();
        let mut change = vec![0.0; self.columns.first().map_or(0, Vec::len)];
        for (column, inverse) in self.columns.iter().zip(self.inverse.chunks_exact(rows)) {
            change.iter_mut().zip(column).for_each(|(x, z)| *x += inverse[row] * z);
        }
        change
    }

    /// Multipliers without a generalised force: eigenvectors that the pseudo-inverse omits.
    pub(crate) fn null_vectors(&self) -> impl Iterator<Item = Vec<f64>> {
        let n = self.gaps.len();
        let omitted = (0..n).filter(move |k| !self.keeps(self.small[k * n + k]));
        omitted.map(move |k| (0..n).map(|row| self.vectors[row * n + k]).collect())
    }

    fn keeps(&self, eigenvalue: f64) -> bool {
        eigenvalue > self.least
    }

    /// Computes the pseudo-inverse of the small matrix.
    pub(super) fn invert(&mut self) {
        let n = self.gaps.len();
        for i in 0..n {
            for j in 0..i {
                let mean = 0.5 * (self.small[i * n + j] + self.small[j * n + i]);
                (self.small[i * n + j], self.small[j * n + i]) = (mean, mean);
            }
        }
        diagonalize(&mut self.small, &mut self.vectors, n);
        let largest = (0..n).map(|k| self.small[k * n + k]).fold(0.0, f64::max);
        let least = (REDUNDANT * largest).max(IMMOBILE * self.mobility);
        self.inverse.fill(0.0);
        self.least = least;
        for k in 0..n {
            let value = self.small[k * n + k];
            if !self.keeps(value) {
                continue;
            }
            for i in 0..n {
                let scaled = self.vectors[i * n + k] / value;
                for j in 0..n {
                    self.inverse[i * n + j] += scaled * self.vectors[j * n + k];
                }
            }
        }
    }
}

/// Diagonalises a symmetric matrix in place by Jacobi rotations; `vectors` receives its eigenvectors in columns.
fn diagonalize(matrix: &mut [f64], vectors: &mut [f64], n: usize) {
    vectors.fill(0.0);
    (0..n).for_each(|i| vectors[i * n + i] = 1.0);
    for _ in 0..JACOBI_SWEEPS {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| i * n + j)).map(|at| matrix[at].powi(2)).sum();
        let size: f64 = (0..n).map(|i| matrix[i * n + i].powi(2)).sum();
        if off <= (f64::EPSILON * f64::EPSILON) * size || off.is_nan() {
            return;
        }
        for p in 0..n {
            for q in p + 1..n {
                let entry = matrix[p * n + q];
                if entry == 0.0 {
                    continue;
                }
                let slope = (matrix[q * n + q] - matrix[p * n + p]) / (2.0 * entry);
                let tangent = slope.signum() / (slope.abs() + slope.hypot(1.0));
                let cosine = tangent.hypot(1.0).recip();
                let sine = tangent * cosine;
                for k in 0..n {
                    let (a, b) = (matrix[k * n + p], matrix[k * n + q]);
                    (matrix[k * n + p], matrix[k * n + q]) = (cosine * a - sine * b, sine * a + cosine * b);
                }
                for k in 0..n {
                    let (a, b) = (matrix[p * n + k], matrix[q * n + k]);
                    (matrix[p * n + k], matrix[q * n + k]) = (cosine * a - sine * b, sine * a + cosine * b);
                    let (a, b) = (vectors[k * n + p], vectors[k * n + q]);
                    (vectors[k * n + p], vectors[k * n + q]) = (cosine * a - sine * b, sine * a + cosine * b);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pseudo-inverse of a matrix with two equal rows is that of Moore and Penrose: it yields the solution of least norm.
    #[test]
    fn redundant_rows_share_their_multipliers() {
        let mut factor = RigidFactor::new(3, 0);
        factor.small.copy_from_slice(&[2.0, 2.0, 0.5, 2.0, 2.0, 0.5, 0.5, 0.5, 3.0]);
        factor.invert();
        factor.gaps.copy_from_slice(&[1.0, 1.0, -2.0]);
        let weights: Vec<f64> = (0..3).map(|row| factor.weight(row)).collect();
        assert!((weights[0] - weights[1]).abs() < 1e-14, "{weights:?}");
        let sum = weights[0] + weights[1];
        assert!(
            (2.0 * sum + 0.5 * weights[2] - 1.0).abs() < 1e-14 && (0.5 * sum + 3.0 * weights[2] + 2.0).abs() < 1e-14
        );
    }
}
