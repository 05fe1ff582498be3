//! Closed loops in the tangent: the penalty force rotates with the nodes and changes with the gap.
//!
//! The gap couples distant branches. The spring at each end, as if the other end were fixed, is added to the tree's factorisation; the
//! coupling of the ends has low rank and is added by the Woodbury formula, NOTATION eq. (L7). A loop may therefore stabilise a degree of
//! freedom that has no stiffness in the tree alone.

use crate::math::so3::hat;
use crate::multibody::model::Model;
use crate::multibody::tangent::loops::{ClosureTangent, Coupling};
use crate::multibody::tangent::twist::add;
use crate::multibody::tangent::{SingularTangent, Tangent, rigid};
use crate::multibody::workspace::Workspace;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x6, Vector3};

impl Tangent {
    /// Linearises the closures at the poses in `work`; their forces rotate with the arms.
    pub(super) fn linearize_closures(&mut self, model: &Model, work: &Workspace) {
        self.closures.clear();
        let penalties = model.closures.iter().map(|closure| {
            let stiffness_n_m = closure.penalty.stiffness_n_m;
            (closure, closure.gap(work).position_m * stiffness_n_m, stiffness_n_m)
        });
        let support_n_m = rigid::support_n_m(model);
        let rigid = model.rigid_loops.iter().zip(&work.rigid_forces);
        let rigid = rigid.map(|(closure, force_n)| (closure, *force_n, support_n_m));
        for (closure, force, stiffness_n_m) in penalties.chain(rigid) {
            let mut points = [Matrix3x6::zeros(); 2];
            for (side, force) in [(0, -force), (1, force)] {
                let Some(n) = closure.nodes[side] else { continue };
                let arm = work.nodes[n].rotation * closure.offsets_m[side];
                points[side].fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
                points[side].fixed_view_mut::<3, 3>(0, 3).copy_from(&-hat(&arm));
                let mut spin = self.nodes[n].fixed_view_mut::<3, 3>(3, 3);
                spin += hat(&force) * hat(&arm);
            }
            self.closures.push(ClosureTangent { nodes: closure.nodes, points, stiffness_n_m });
        }
    }

    /// Adds the change of the penalty forces with the gaps to the wrenches of the nodes.
    pub(super) fn push_closures(&mut self) {
        for closure in &self.closures {
            let moved: [Vector3<f64>; 2] = [0, 1].map(|side| closure.displacement(side, &self.displaced));
            let force = (moved[1] - moved[0]) * closure.stiffness_n_m;
            for (side, force) in [(0, -force), (1, force)] {
                let Some(n) = closure.nodes[side] else { continue };
                add(&mut self.wrenches[n], &(closure.points[side].transpose() * force));
            }
        }
    }

    /// Factorises the coupling; the tree's factors, with the spring at each end, must be current.
    pub(super) fn factorize_closures(&mut self, model: &Model) -> Result<(), SingularTangent> {
        self.coupling = None;
        let rows = 6 * self.closures.len();
        if rows == 0 {
            return Ok(());
        }
        let closures = self.closures.clone();
        let mut columns = DMatrix::zeros(model.coordinates, rows);
        let mut small = DMatrix::zeros(rows, rows);
        let mut x = vec![0.0; model.coordinates];
        for row in 0..rows {
            let (closure, side) = (&closures[row / 6], row % 6 / 3);
            // Gᵀ: a unit force at one point, as a right-hand side at its node
            x.fill(0.0);
            let wrench = closure.points[side].transpose().column(row % 3).into_owned();
            if let Some(n) = closure.nodes[side] {
                self.solve_tree(model, &mut x, Some((n, &wrench)));
                columns.column_mut(row).copy_from_slice(&x);
                small.column_mut(row).copy_from(&self.point_displacements(&closures));
            }
            // inverse of the coupling −k [[0, I], [I, 0]]
            let partner = if side == 0 { row + 3 } else { row - 3 };
            if closure.stiffness_n_m > 0.0 {
                small[(partner, row)] -= 1.0 / closure.stiffness_n_m;
            } else {
                small.column_mut(row).fill(0.0);
                small[(row, row)] = 1.0;
                columns.column_mut(row).fill(0.0);
            }
        }
        let symmetric = (&small + small.transpose()) * 0.5;
        let positive = symmetric.symmetric_eigenvalues().iter().filter(|value| **value > 0.0).count();
        let lu = small.lu();
        if !lu.is_invertible() {
            return Err(SingularTangent { coordinate: 0 });
        }
        self.coupling = Some(Coupling { columns, positive, lu });
        Ok(())
    }

    /// Adds the springs at the closures' ends to the tangents of their nodes, for the tree's factorisation.
    pub(super) fn add_own_springs(&self, outer: &mut [nalgebra::Matrix6<f64>]) {
        for closure in &self.closures {
            for side in 0..2 {
                let Some(n) = closure.nodes[side] else { continue };
                let points = &closure.points[side];
                outer[n] += points.transpose() * points * closure.stiffness_n_m;
            }
        }
    }

    /// Adds the coupling to a solution of the tree, whose displacements must be current.
    pub(super) fn correct_closures(&mut self, x: &mut [f64]) {
        let Some(coupling) = self.coupling.take() else { return };
        let closures = std::mem::take(&mut self.closures);
        let moved = self.point_displacements(&closures);
        if let Some(weights) = coupling.lu.solve(&moved) {
            let correction = &coupling.columns * weights;
            x.iter_mut().zip(correction.iter()).for_each(|(x, correction)| *x -= correction);
        }
        self.closures = closures;
        self.coupling = Some(coupling);
    }

    /// Displacements `G x` of all points of the closures, from the current node displacements.
    fn point_displacements(&self, closures: &[ClosureTangent]) -> DVector<f64> {
        let mut moved = DVector::zeros(6 * closures.len());
        for (i, closure) in closures.iter().enumerate() {
            for side in 0..2 {
                let point = closure.displacement(side, &self.displaced);
                moved.fixed_rows_mut::<3>(6 * i + 3 * side).copy_from(&point);
            }
        }
        moved
    }
}
