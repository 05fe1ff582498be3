//! Joints in the tangent: hinges, universal, ball and free joints; held ones pass everything on.

use crate::multibody::joint::{ParameterJoint, ParameterKind};
use crate::multibody::model::Model;
use crate::multibody::tangent::block::Block;
use crate::multibody::workspace::{ParameterWork, Workspace};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

/// Springs of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointTangent {
    /// The joint can move; otherwise it is held.
    pub free: bool,
    /// Change of the spring's torques on the freedoms with the freedoms, N·m/rad; a hinge has the first entry alone.
    pub stiffness_n_m_rad: Matrix3<f64>,
}

impl JointTangent {
    /// Held: stopper, lock or prescribed motion.
    pub const HELD: Self =
        Self { free: false, stiffness_n_m_rad: Matrix3::from_array_storage(nalgebra::ArrayStorage([[0.0; 3]; 3])) };

    /// A hinge with a spring of this stiffness.
    pub fn hinge(stiffness_n_m_rad: f64) -> Self {
        let mut stiffness = Matrix3::zeros();
        stiffness[(0, 0)] = stiffness_n_m_rad;
        Self { free: true, stiffness_n_m_rad: stiffness }
    }
}

/// Freedoms of one joint about its pose.
#[derive(Debug, Clone)]
pub(super) struct JointBlock {
    /// Index of the first freedom in the vectors.
    pub coordinate: usize,
    /// Number of freedoms; 0 for a held or clamped joint.
    pub freedoms: usize,
    /// `S`: twist of the body per freedom; columns beyond the freedoms are zero.
    map: Matrix6<f64>,
    /// Change of the residual's projection with the freedoms: springs, and axes that turn.
    own: Matrix6<f64>,
    /// Change of the residual's projection with the turn of the parent.
    turning: SMatrix<f64, 6, 3>,
}

impl Default for JointBlock {
    fn default() -> Self {
        Self { coordinate: 0, freedoms: 0, map: Matrix6::zeros(), own: Matrix6::zeros(), turning: SMatrix::zeros() }
    }
}

impl JointBlock {
    /// The joint of a body at the poses and wrenches in `work`.
    pub fn new(model: &Model, work: &Workspace, index: usize, tangent: &JointTangent) -> Self {
        let mut block = Self::default();
        let body = &model.bodies[index];
        if !tangent.free {
            return block;
        }
        let moment = &work.nodes[body.first_node].moment;
        if let Some(hinge) = &body.hinge {
            (block.coordinate, block.freedoms) = (hinge.coordinate, 1);
            block.own[(0, 0)] = tangent.stiffness_n_m_rad[(0, 0)];
            block.add_axis(0, &work.hinges[index], moment);
        }
        if let (Some(joint), Some(parameters)) = (&body.parameters, &work.parameters[index]) {
            (block.coordinate, block.freedoms) = (joint.coordinate, joint.kind.freedoms());
            if joint.kind == ParameterKind::Free {
                block.map = Matrix6::identity();
                return block;
            }
            for k in 0..block.freedoms {
                block.add_axis(k, &parameters.axes.column(k).into_owned(), moment);
            }
            block.own.fixed_view_mut::<3, 3>(0, 0).copy_from(&tangent.stiffness_n_m_rad);
            if let ParameterKind::Universal { .. } = joint.kind {
                // the second axis turns with the first rotation
                let axis = |k: usize| -> Vector3<f64> { parameters.axes.column(k).into_owned() };
                block.own[(1, 0)] += moment.dot(&axis(0).cross(&axis(1)));
            }
        }
        block
    }

    fn add_axis(&mut self, k: usize, axis: &Vector3<f64>, moment: &Vector3<f64>) {
        self.map.fixed_view_mut::<3, 1>(3, k).copy_from(axis);
        self.turning.row_mut(k).copy_from(&axis.cross(moment).transpose());
    }

    fn freedoms_of(&self, x: &[f64]) -> Vector6<f64> {
        let mut freedoms = Vector6::zeros();
        for k in 0..self.freedoms {
            freedoms[k] = x[self.coordinate + k];
        }
        freedoms
    }

    /// Twist of the body for changes of the freedoms and the twist of the parent.
    pub fn displaced(&self, x: &[f64], parent: &Vector6<f64>) -> Vector6<f64> {
        parent + self.map * self.freedoms_of(x)
    }

    /// Adds the changes of the torques to `y`; returns the change of the wrench that the parent feels.
    pub fn push(&self, x: &[f64], parent: &Vector6<f64>, wrench: &Vector6<f64>, y: &mut [f64]) -> Vector6<f64> {
        let turn: Vector3<f64> = parent.fixed_rows::<3>(3).into_owned();
        let forces = self.map.transpose() * wrench + self.own * self.freedoms_of(x) + self.turning * turn;
        for k in 0..self.freedoms {
            y[self.coordinate + k] += forces[k];
        }
        *wrench
    }

    /// The joint's block with the tangent `outer` of the body behind it, and the sizes of the terms on the diagonal.
    pub fn block(&self, outer: &Matrix6<f64>) -> (Block, [f64; 8]) {
        let mut block = Block::zeros();
        let mut scale = [1.0; 8];
        let mut rows = self.map.transpose() * outer;
        let xx = rows * self.map + self.own;
        let mut columns = rows.fixed_view_mut::<6, 3>(0, 3);
        columns += self.turning;
        block.xx.fixed_view_mut::<6, 6>(0, 0).copy_from(&xx);
        block.xa.fixed_view_mut::<6, 6>(0, 0).copy_from(&rows);
        block.ax.fixed_view_mut::<6, 6>(0, 0).copy_from(&(outer * self.map));
        block.aa = *outer;
        let size = outer.amax() + self.own.amax();
        scale[..self.freedoms].fill(size);
        (block, scale)
    }

    /// `Sᵀ` on a wrench.
    pub fn projected(&self, wrench: &Vector6<f64>) -> SVector<f64, 8> {
        let projected = self.map.transpose() * wrench;
        let mut padded = SVector::<f64, 8>::zeros();
        padded.fixed_rows_mut::<6>(0).copy_from(&projected);
        padded
    }
}

/// Turns the freedoms of a joint in `x` into changes of its parameters, in place.
pub(super) fn to_parameters(joint: &ParameterJoint, parameters: &ParameterWork, x: &mut [f64]) {
    let range = joint.coordinate..joint.coordinate + joint.kind.parameters();
    let x = &mut x[range];
    let shift = if joint.kind == ParameterKind::Free { 3 } else { 0 };
    let mut turn = Vector3::zeros();
    for k in 0..joint.kind.freedoms() - shift {
        turn += if shift == 3 { Vector3::ith(k, x[shift + k]) } else { parameters.axes.column(k) * x[k] };
    }
    let change = parameters.pose.parameter_change(&joint.kind, &(parameters.parent.transpose() * turn), &[0.0; 7]);
    let kept = [x[0], x[1], x[2]];
    let count = x.len();
    x.copy_from_slice(&change[..count]);
    if shift == 3 {
        x[..3].copy_from_slice(&kept);
    }
}
