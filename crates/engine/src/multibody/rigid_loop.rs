//! Rigid loops: points that coincide by constraint forces, NOTATION eqs. (C5)–(C7).
//!
//! The multipliers of the constraints are unknowns beside the accelerations, stored as the last coordinates; in their rows the residual has
//! the second rates of the gaps. The small matrix of the constraints follows from the factors of the tree; its pseudo-inverse omits
//! redundant rows.

use crate::multibody::closure::{Gap, project_unit_force};
use crate::multibody::factor::solve_bordered;
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::model::Model;
use crate::multibody::norm::kinematic_norm;
use crate::multibody::workspace::Workspace;
use nalgebra::Vector3;

/// The gap or one of its rates.
type Rate = fn(&Gap) -> Vector3<f64>;

/// Eigenvalue of the small matrix, relative to its largest, below which a row is redundant: round-off of rows that depend on others is
/// 1e-15, and the mobilities at the loops of one machine do not differ by more than this factor.
const REDUNDANT: f64 = 1e-11;
/// Eigenvalue of the small matrix, relative to the mobility of the points themselves, below which it is round-off: if no loop has a freedom,
/// as between points of a hinge's axis, the largest eigenvalue is round-off too.
const IMMOBILE: f64 = 1e-13;
/// Largest gap, relative to the machine's length, and largest rate of a gap, relative to the speeds at the loop, that count as round-off.
const ROUND_OFF: f64 = 2.0 * f64::EPSILON;
/// Gap relative to the machine's length above which a loop is open, if no correction reduces it further.
const OPEN: f64 = 1e-12;
/// Number of initial corrections in which the gaps or their rates may grow: the rates are corrected at coordinates that still change.
const SETTLED: usize = 3;
/// Maximum number of corrections: each reduces the gap in the ratio of the change of directions since the factorisation, as a rule to 1 %.
const CORRECTIONS: usize = 30;
/// Maximum number of sweeps of the Jacobi iteration, which converges quadratically.
const JACOBI_SWEEPS: usize = 30;

impl Model {
    /// Coordinates of the tree; those of the multipliers of rigid loops follow.
    pub fn tree_coordinates(&self) -> usize {
        self.coordinates - 3 * self.rigid_loops.len()
    }

    /// Indices of the multipliers of a rigid loop in vectors of accelerations: components of the force on its first point in N, root frame.
    pub fn multipliers(&self, rigid_loop: usize) -> std::ops::Range<usize> {
        let first = self.tree_coordinates() + 3 * rigid_loop;
        first..first + 3
    }
}

/// Workspace of the rigid loops.
#[derive(Debug, Clone)]
pub(crate) struct RigidFactor {
    /// `Z = A⁻¹ Gᵀ`, one column per row of the gaps.
    columns: Vec<Vec<f64>>,
    /// `S = G Z` by rows; after its inversion its eigenvalues on the diagonal.
    small: Vec<f64>,
    /// Eigenvectors of `S` in columns.
    vectors: Vec<f64>,
    /// Pseudo-inverse of `S` by rows.
    inverse: Vec<f64>,
    gaps: Vec<f64>,
    /// Largest change of a point, in place of the difference of two points in `S`.
    mobility: f64,
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
            mobility: 0.0,
        }
    }

    /// Weight of the column of a row in the change that removes the gaps in `gaps`.
    fn weight(&self, row: usize) -> f64 {
        let rows = self.gaps.len();
        self.inverse[row * rows..][..rows].iter().zip(&self.gaps).map(|(inverse, gap)| inverse * gap).sum()
    }

    /// Subtracts the change that removes the gaps in `gaps`.
    fn remove_gaps(&self, x: &mut [f64]) {
        for (row, column) in self.columns.iter().enumerate() {
            let weight = self.weight(row);
            x.iter_mut().zip(column).for_each(|(x, z)| *x -= weight * z);
        }
    }

    /// Computes the pseudo-inverse of the small matrix.
    fn invert(&mut self) {
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
        for k in 0..n {
            let value = self.small[k * n + k];
            if value <= least || value.is_nan() {
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

/// Writes the second rates of the gaps to the rows of the multipliers, eq. (C5).
pub(crate) fn violations(model: &Model, work: &Workspace, residual: &mut [f64]) {
    for (index, closure) in model.rigid_loops.iter().enumerate() {
        residual[model.multipliers(index)].copy_from_slice(closure.gap(work).acceleration_m_s2.as_slice());
    }
}

/// Adds the rigid loops to a factorisation of the tree, its closures and its damped modes.
pub(crate) fn factorize(model: &Model, work: &mut Workspace) {
    let mut factor = std::mem::replace(&mut work.rigid_factor, RigidFactor::new(0, 0));
    let rows = factor.gaps.len();
    factor.mobility = 0.0;
    for row in 0..rows {
        let column = &mut factor.columns[row];
        project_unit_force(model, work, &model.rigid_loops[row / 3], row % 3, column);
        solve_bordered(model, work, column);
        for (other, closure) in model.rigid_loops.iter().enumerate() {
            let [first, second] = closure.point_changes(work);
            factor.mobility = factor.mobility.max(first.amax()).max(second.amax());
            let change = second - first;
            for axis in 0..3 {
                factor.small[(3 * other + axis) * rows + row] = change[axis];
            }
        }
    }
    factor.invert();
    work.rigid_factor = factor;
}

/// Adds the rigid loops to a solution without them, whose node displacements must be in `work.bias`. In the rows of the multipliers `x`
/// holds the second rates of the gaps on entry and the changes of the multipliers on return, eq. (C6). Returns the kinematic norm of the
/// solution.
pub(crate) fn correct(model: &Model, work: &mut Workspace, x: &mut [f64]) -> f64 {
    let mut factor = std::mem::replace(&mut work.rigid_factor, RigidFactor::new(0, 0));
    let (of_tree, rows) = x.split_at_mut(model.tree_coordinates());
    for (index, closure) in model.rigid_loops.iter().enumerate() {
        let change = closure.gap_change(work);
        for axis in 0..3 {
            factor.gaps[3 * index + axis] = change[axis] - rows[3 * index + axis];
        }
    }
    factor.remove_gaps(of_tree);
    rows.iter_mut().enumerate().for_each(|(row, x)| *x = factor.weight(row));
    work.rigid_factor = factor;
    kinematic_norm(model, work, x)
}

/// Projects a state onto the constraints with the last factors, eq. (C7): coordinates, then rates and accelerations at these. The error is
/// the largest gap relative to the machine's length, if it stays above round-off.
pub(crate) fn close(model: &Model, work: &mut Workspace, [q, v, a]: [&mut [f64]; 3]) -> Result<(), f64> {
    let tree = model.tree_coordinates();
    // integrals of the multipliers have no meaning
    q[tree..].fill(0.0);
    v[tree..].fill(0.0);
    let mut before = f64::INFINITY;
    let mut gap = f64::INFINITY;
    for round in 0..CORRECTIONS {
        sweep_motion(model, work, Motion { q, v, a });
        let [open, moving] = openness(model, work);
        gap = open;
        let worst = open.max(moving);
        if worst <= ROUND_OFF || (round >= SETTLED && worst > 0.5 * before && open <= OPEN) || !worst.is_finite() {
            break;
        }
        before = worst;
        let mut factor = std::mem::replace(&mut work.rigid_factor, RigidFactor::new(0, 0));
        let parts: [(&mut [f64], Rate); 3] = [
            (&mut q[..tree], |gap| gap.position_m),
            (&mut v[..tree], |gap| gap.velocity_m_s),
            (&mut a[..tree], |gap| gap.acceleration_m_s2),
        ];
        for (x, part) in parts {
            for (index, closure) in model.rigid_loops.iter().enumerate() {
                factor.gaps[3 * index..3 * index + 3].copy_from_slice(part(&closure.gap(work)).as_slice());
            }
            factor.remove_gaps(x);
        }
        work.rigid_factor = factor;
    }
    if gap <= OPEN { Ok(()) } else { Err(gap) }
}

/// Largest gap relative to the machine's length, and largest rate of a gap relative to the speed of its points, which counts as at least
/// one length per second.
fn openness(model: &Model, work: &Workspace) -> [f64; 2] {
    let length_m = model.reference_length_m;
    let mut largest = [0.0_f64; 2];
    for closure in &model.rigid_loops {
        let gap = closure.gap(work);
        let mut speed_m_s = length_m;
        for (node, offset_m) in closure.nodes.iter().zip(&closure.offsets_m) {
            let Some(node) = node.map(|n| &work.nodes[n]) else { continue };
            speed_m_s = speed_m_s.max(node.velocity.norm() + node.spin.norm() * offset_m.norm());
        }
        let shares = [gap.position_m.norm() / length_m, gap.velocity_m_s.norm() / speed_m_s];
        // a gap that is not a number is not closed
        for (largest, share) in largest.iter_mut().zip(shares) {
            *largest = if share.is_nan() { f64::INFINITY } else { largest.max(share) };
        }
    }
    largest
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
