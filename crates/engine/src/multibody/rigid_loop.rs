//! Rigid loops: points that coincide by constraint forces, NOTATION eqs. (C5)–(C7).
//!
//! The multipliers of the constraints are unknowns beside the accelerations, stored as the last coordinates; in their rows the residual has
//! the second rates of the gaps. The small matrix of the constraints follows from the factors of the tree; its pseudo-inverse omits
//! redundant rows.

use crate::multibody::closure::{self, Gap, project_unit_force};
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::model::Model;
use crate::multibody::norm::kinematic_norm;
use crate::multibody::rigid_factor::RigidFactor;
use crate::multibody::workspace::Workspace;
use nalgebra::Vector3;

/// The gap or one of its rates.
type Rate = fn(&Gap) -> Vector3<f64>;

/// Largest gap, relative to the machine's length, and largest rate of a gap, relative to the speeds at the loop, that count as round-off.
const ROUND_OFF: f64 = 2.0 * f64::EPSILON;
/// Gap relative to the machine's length above which a loop is open, if no correction reduces it further.
const OPEN: f64 = 1e-12;
/// Number of initial corrections in which the gaps or their rates may grow: the rates are corrected at coordinates that still change.
const SETTLED: usize = 3;
/// Maximum number of corrections: each reduces the gap in the ratio of the change of directions since the factorisation, as a rule to 1 %.
const CORRECTIONS: usize = 30;
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
        closure::solve(model, work, column);
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
