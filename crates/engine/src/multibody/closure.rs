//! Closed loops by the penalty method: a joint between two nodes of the tree, or between a node and a point of the root frame.
//!
//! The gap `g` between both points is kept small by `m g̈ + c ġ + k g`, \[O\] section 1 and NOTATION eqs. (C1)–(C4). Its
//! contribution to the Newton matrix couples distant branches; it has low rank, so the O(n) factorisation of the tree is kept and the
//! Woodbury formula adds the loops.

use crate::math::strain::{SHEARED, STRAINS};
use crate::multibody::elimination::Weights;
use crate::multibody::loops::ClosureFactor;
use crate::multibody::model::{Base, Model};
use crate::multibody::norm::kinematic_norm;
use crate::multibody::slide;
use crate::multibody::tree_factor::solve_tree;
use crate::multibody::workspace::{Node, Pair, Workspace};
use nalgebra::Vector3;

pub use crate::multibody::loops::{Closure, ClosureDescription, Gap, Penalty};

impl Closure {
    /// Gap at the motion of the last sweep, eq. (C1).
    pub fn gap(&self, work: &Workspace) -> Gap {
        let point = |side: usize| {
            let Some(node) = self.nodes[side].map(|n| &work.nodes[n]) else {
                return [self.offsets_m[side], Vector3::zeros(), Vector3::zeros()]; // the motion is relative to the root frame
            };
            let arm = node.rotation * self.offsets_m[side];
            let swing = node.spin.cross(&arm);
            [
                node.position + arm,
                node.velocity + swing,
                node.acceleration + node.spin_rate.cross(&arm) + node.spin.cross(&swing),
            ]
        };
        let (first, second) = (point(0), point(1));
        Gap {
            position_m: second[0] - first[0],
            velocity_m_s: second[1] - first[1],
            acceleration_m_s2: second[2] - first[2],
        }
    }

    /// Penalty force at a gap on the first point in N, root frame; its opposite acts on the second. Eq. (C2).
    pub fn force_n(&self, gap: &Gap) -> Vector3<f64> {
        gap.acceleration_m_s2 * self.penalty.inertia_kg
            + gap.velocity_m_s * self.penalty.damping_n_s_m
            + gap.position_m * self.penalty.stiffness_n_m
    }

    /// Energy of the penalty in J: kinetic and elastic.
    pub fn energy_j(&self, work: &Workspace) -> (f64, f64) {
        let gap = self.gap(work);
        (
            0.5 * self.penalty.inertia_kg * gap.velocity_m_s.norm_squared(),
            0.5 * self.penalty.stiffness_n_m * gap.position_m.norm_squared(),
        )
    }

    /// Power of the penalty's damping in W.
    pub fn dissipation_w(&self, work: &Workspace) -> f64 {
        self.penalty.damping_n_s_m * self.gap(work).velocity_m_s.norm_squared()
    }

    /// Adds the penalty force to the wrenches of the nodes, eq. (C2). Returns the wrench about the origin on the root, with the sign of the
    /// nodes' wrenches, if the loop ends there.
    pub(crate) fn apply(&self, work: &mut Workspace) -> Option<Pair> {
        let force = self.force_n(&self.gap(work));
        self.apply_force(work, force)
    }

    /// [`Closure::apply`] for a given force on the first point in N, root frame.
    pub(crate) fn apply_force(&self, work: &mut Workspace, force: Vector3<f64>) -> Option<Pair> {
        let mut on_root = None;
        for (side, force) in [(0, -force), (1, force)] {
            let Some(n) = self.nodes[side] else {
                on_root = Some(Pair { linear: force, angular: self.offsets_m[side].cross(&force) });
                continue;
            };
            let node = &mut work.nodes[n];
            let moment = (node.rotation * self.offsets_m[side]).cross(&force);
            node.add_fixed(&force, &moment);
        }
        on_root
    }

    /// Change of the gap due to the node displacements in `work.bias`.
    pub(crate) fn gap_change(&self, work: &Workspace) -> Vector3<f64> {
        let [first, second] = self.point_changes(work);
        second - first
    }

    /// Changes of both points due to the node displacements in `work.bias`.
    pub(crate) fn point_changes(&self, work: &Workspace) -> [Vector3<f64>; 2] {
        [0, 1].map(|side| {
            let Some(n) = self.nodes[side] else { return Vector3::zeros() };
            let arm = work.nodes[n].rotation * self.offsets_m[side];
            work.bias[n].linear + work.bias[n].angular.cross(&arm)
        })
    }
}

/// Value that replaces an absent penalty; its inverse and the square of the inverse are still finite.
const ABSENT: f64 = 1e-150;

/// Adds the closures and damped modes to a factorisation of the tree. `None` if the small matrix cannot be factorised.
pub(crate) fn factorize(model: &Model, work: &mut Workspace, weights: Weights) -> Option<()> {
    let gaps = 3 * model.closures.len();
    let rows = gaps + model.damped_modes.len();
    let mut factor = std::mem::replace(&mut work.closure_factor, ClosureFactor::new(0, 0));
    for row in 0..rows {
        let column = &mut factor.columns[row];
        let penalty = if row < gaps {
            let closure = &model.closures[row / 3];
            project_unit_force(model, work, closure, row % 3, column);
            let Penalty { inertia_kg, damping_n_s_m, stiffness_n_m } = closure.penalty;
            weights.mass * inertia_kg + weights.damping * damping_n_s_m + weights.stiffness * stiffness_n_m
        } else {
            let mode = &model.damped_modes[row - gaps];
            column.fill(0.0);
            column[mode.first..mode.first + mode.momenta.len()].copy_from_slice(&mode.momenta);
            weights.damping * mode.rate_1_s
        };
        solve_tree(model, work, column);
        for (other, closure) in model.closures.iter().enumerate() {
            let change = closure.gap_change(work);
            for axis in 0..3 {
                factor.cholesky[(3 * other + axis) * rows + row] = change[axis];
            }
        }
        for (other, mode) in model.damped_modes.iter().enumerate() {
            factor.cholesky[(gaps + other) * rows + row] = mode.rate(column);
        }
        // without penalty inertia the mass matrix does not contain the loop
        factor.cholesky[row * rows + row] += 1.0 / penalty.max(ABSENT);
    }
    let outcome = cholesky(&mut factor.cholesky, rows);
    work.closure_factor = factor;
    outcome
}

/// Corrects a solution of the tree for the closures and damped modes, eq. (C3); returns its kinematic norm. The node displacements of the tree's solution
/// must be in `work.bias`.
pub(crate) fn correct(model: &Model, work: &mut Workspace, x: &mut [f64]) -> f64 {
    let gaps = 3 * model.closures.len();
    let rows = gaps + model.damped_modes.len();
    let mut factor = std::mem::replace(&mut work.closure_factor, ClosureFactor::new(0, 0));
    for (i, closure) in model.closures.iter().enumerate() {
        factor.gaps[3 * i..3 * i + 3].copy_from_slice(closure.gap_change(work).as_slice());
    }
    for (i, mode) in model.damped_modes.iter().enumerate() {
        factor.gaps[gaps + i] = mode.rate(x);
    }
    let (l, w) = (&factor.cholesky, &mut factor.gaps);
    for i in 0..rows {
        for k in 0..i {
            w[i] -= l[i * rows + k] * w[k];
        }
        w[i] /= l[i * rows + i];
    }
    for i in (0..rows).rev() {
        for k in i + 1..rows {
            w[i] -= l[k * rows + i] * w[k];
        }
        w[i] /= l[i * rows + i];
    }
    for (column, weight) in factor.columns.iter().zip(&factor.gaps) {
        x.iter_mut().zip(column).for_each(|(x, z)| *x -= weight * z);
    }
    work.closure_factor = factor;
    kinematic_norm(model, work, x)
}

/// Solves for the tree with the closures and damped modes, without rigid loops; the displacements of the nodes stay in `bias`.
pub(crate) fn solve(model: &Model, work: &mut Workspace, x: &mut [f64]) -> f64 {
    let norm = solve_tree(model, work, x);
    if model.is_bordered() { correct(model, work, x) } else { norm }
}

/// Generalised forces due to a unit force across a closure's gap.
pub(crate) fn project_unit_force(model: &Model, work: &mut Workspace, closure: &Closure, axis: usize, out: &mut [f64]) {
    work.bias.fill(Pair::ZERO);
    load_unit_force(work, closure, axis);
    project_bias(model, work, out);
}

/// Adds a unit force across a closure's gap to the wrenches in `work.bias`.
pub(crate) fn load_unit_force(work: &mut Workspace, closure: &Closure, axis: usize) {
    let mut unit = Vector3::zeros();
    unit[axis] = 1.0;
    for (side, force) in [(0, -unit), (1, unit)] {
        let Some(n) = closure.nodes[side] else { continue };
        let node: &Node = &work.nodes[n];
        work.bias[n].linear += force;
        work.bias[n].angular += (node.rotation * closure.offsets_m[side]).cross(&force);
    }
}

/// Generalised forces due to the wrenches on the nodes in `work.bias`, which are overwritten.
pub(crate) fn project_bias(model: &Model, work: &mut Workspace, out: &mut [f64]) {
    out.fill(0.0);
    for (index, body) in model.bodies.iter().enumerate().rev() {
        let mut p = work.bias[body.last_node()];
        for i in (0..body.elements).rev() {
            let place = (body.first_element + i, body.first_node + i);
            p = match body.sheared {
                false => project_on_element::<STRAINS>(model, work, place, &p, out),
                true => project_on_element::<SHEARED>(model, work, place, &p, out),
            };
        }
        if let (Some(modal), Some(scratch)) = (&body.modal, &work.modal[index]) {
            modal.project(scratch, &p, out);
            let own = &work.bias[body.first_node];
            let moment = p.angular + scratch.arm.cross(&p.linear);
            p = Pair { linear: own.linear + p.linear, angular: own.angular + moment };
        }
        let joint = &work.joints[index];
        body.joint.project(joint, &p, out);
        joint.pass_on(&p.linear, &mut p.angular);
        match body.base {
            Base::Root(_) => {}
            Base::Node(node) => {
                work.bias[node].linear += p.linear;
                work.bias[node].angular += p.angular;
            }
            // the carriage passes the force of a sleeve on to the beam, eq. (J17)
            Base::Axis(index) => slide::reduce(model, work, index, &p, out),
        }
    }
}

/// Forces on the strains of an element due to a wrench at its outer end, and the wrench transmitted to the inner end plus that of its node.
fn project_on_element<const N: usize>(
    model: &Model,
    work: &Workspace,
    (element, node): (usize, usize),
    p: &Pair,
    out: &mut [f64],
) -> Pair {
    let link = work.link::<N>(model, element, node);
    // beside the projections of bodies that slide along the element
    let rows = &mut out[model.elements[element].range_of::<N>()];
    rows.iter_mut().zip(link.project(&p.linear, &p.angular)).for_each(|(row, term)| *row += term);
    let own = &work.bias[node];
    Pair { linear: own.linear + p.linear, angular: own.angular + p.angular + link.arm_m.cross(&p.linear) }
}

/// In-place Cholesky factorisation of a small dense matrix, by rows.
fn cholesky(matrix: &mut [f64], n: usize) -> Option<()> {
    for j in 0..n {
        for i in j..n {
            let mut entry = matrix[i * n + j];
            for k in 0..j {
                entry -= matrix[i * n + k] * matrix[j * n + k];
            }
            if i == j {
                if !(entry > 0.0 && entry.is_finite()) {
                    return None;
                }
                matrix[i * n + j] = entry.sqrt();
            } else {
                matrix[i * n + j] = entry / matrix[j * n + j];
            }
        }
    }
    Some(())
}
