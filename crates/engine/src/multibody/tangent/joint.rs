//! Joints in the tangent: their degrees of freedom and the arms between the nodes, NOTATION eqs. (L7) and (J8); held joints transmit the
//! complete wrench.

use crate::math::so3::hat;
use crate::multibody::model::Model;
use crate::multibody::tangent::block::{Block, UNKNOWNS, Unknowns};
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};

/// Springs of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointTangent {
    /// Whether the joint can move; otherwise it is held.
    pub free: bool,
    /// Change of the spring's forces with the degrees of freedom, N·m/rad, for translations N/m; only the first entry for a joint with one
    /// degree of freedom.
    pub stiffness: Matrix3<f64>,
}

impl JointTangent {
    /// Held joint: by its lock, locked, or prescribed.
    pub const HELD: Self =
        Self { free: false, stiffness: Matrix3::from_array_storage(nalgebra::ArrayStorage([[0.0; 3]; 3])) };

    /// A joint with one degree of freedom and a spring of this stiffness, N·m/rad or N/m.
    pub fn one_freedom(stiffness: f64) -> Self {
        let mut matrix = Matrix3::zeros();
        matrix[(0, 0)] = stiffness;
        Self { free: true, stiffness: matrix }
    }
}

/// Degrees of freedom of one joint, linearised about its pose.
#[derive(Debug, Clone)]
pub(super) struct JointBlock {
    /// Index of the first degree of freedom in the vectors.
    pub coordinate: usize,
    /// Number of degrees of freedom; 0 for a held or clamped joint.
    pub freedoms: usize,
    /// Whether all degrees of freedom are translations.
    slides: bool,
    /// `S`: twist of the body per degree of freedom; columns beyond the degrees of freedom are zero.
    map: Matrix6<f64>,
    /// Change of the residual's projection with the degrees of freedom: due to springs, and to axes that rotate.
    own: Matrix6<f64>,
    /// Change of the residual's projection with the rotation of the parent.
    turning: SMatrix<f64, 6, 3>,
    /// Change of the wrench on the parent with the degrees of freedom, in addition to that of the wrench itself: due to longer arms.
    lengthening: Matrix6<f64>,
    /// Vector from the parent's node to the body's first node, m.
    arm: Vector3<f64>,
    /// Force at the body's first node, N.
    force: Vector3<f64>,
}

impl Default for JointBlock {
    fn default() -> Self {
        Self {
            coordinate: 0,
            freedoms: 0,
            slides: false,
            map: Matrix6::zeros(),
            own: Matrix6::zeros(),
            turning: SMatrix::zeros(),
            lengthening: Matrix6::zeros(),
            arm: Vector3::zeros(),
            force: Vector3::zeros(),
        }
    }
}

impl JointBlock {
    /// Linearises the joint of a body at the poses and wrenches in `work`.
    pub fn new(model: &Model, work: &Workspace, index: usize, tangent: &JointTangent) -> Self {
        let (body, scratch) = (&model.bodies[index], &work.joints[index]);
        let joint = &body.joint;
        let node = &work.nodes[body.first_node];
        let mut block = Self { arm: scratch.arm, force: node.force, ..Self::default() };
        if !tangent.free {
            return block;
        }
        (block.coordinate, block.freedoms) = (joint.coordinate, joint.kind.freedoms());
        block.map = joint.freedom_twists(scratch);
        if !joint.kind.transmits() {
            return block;
        }
        let translations = joint.kind.translations();
        block.slides = translations == block.freedoms;
        for k in 0..block.freedoms {
            // the axis rotates with the parent, and a displacement along it lengthens the arm
            let along: Vector3<f64> = block.map.fixed_view::<3, 1>(0, k).into_owned();
            let about: Vector3<f64> = block.map.fixed_view::<3, 1>(3, k).into_owned();
            let turning = about.cross(&node.moment) + along.cross(&node.force);
            block.turning.row_mut(k).copy_from(&turning.transpose());
            if k < translations {
                block.lengthening.fixed_view_mut::<3, 1>(3, k).copy_from(&along.cross(&node.force));
            }
        }
        block.own.fixed_view_mut::<3, 3>(0, 0).copy_from(&tangent.stiffness);
        block.own += joint.turning_axes(scratch, &node.moment);
        block
    }

    fn freedoms_of(&self, x: &[f64]) -> Vector6<f64> {
        let mut freedoms = Vector6::zeros();
        for k in 0..self.freedoms {
            freedoms[k] = x[self.coordinate + k];
        }
        freedoms
    }

    /// Twist of the body due to changes of the degrees of freedom and the twist of the parent, eq. (J8).
    pub fn displaced(&self, x: &[f64], parent: &Vector6<f64>) -> Vector6<f64> {
        self.shift() * parent + self.map * self.freedoms_of(x)
    }

    /// `Φ`: twist of the body's first node per twist of the parent's node, with a fixed joint.
    fn shift(&self) -> Matrix6<f64> {
        let mut shift = Matrix6::identity();
        if self.arm != Vector3::zeros() {
            shift.fixed_view_mut::<3, 3>(0, 3).copy_from(&-hat(&self.arm));
        }
        shift
    }

    /// Adds the changes of the torques to `y`; returns the change of the wrench on the parent.
    pub fn push(&self, x: &[f64], parent: &Vector6<f64>, wrench: &Vector6<f64>, y: &mut [f64]) -> Vector6<f64> {
        let (freedoms, turn) = (self.freedoms_of(x), parent.fixed_rows::<3>(3).into_owned());
        let forces = self.map.transpose() * wrench + self.own * freedoms + self.turning * turn;
        for k in 0..self.freedoms {
            y[self.coordinate + k] += forces[k];
        }
        self.carried(wrench) + self.lengthening * freedoms + self.swinging() * parent
    }

    /// `Φᵀ`: change of the wrench on the parent due to a change at the body's first node.
    pub fn carried(&self, wrench: &Vector6<f64>) -> Vector6<f64> {
        self.shift().transpose() * wrench
    }

    /// Change of the moment about the parent when the arm rotates with it under the force.
    fn swinging(&self) -> Matrix6<f64> {
        let mut change = Matrix6::zeros();
        if self.arm != Vector3::zeros() {
            change.fixed_view_mut::<3, 3>(3, 3).copy_from(&(hat(&self.force) * hat(&self.arm)));
        }
        change
    }

    /// Transmits the tangent `outer` of the body on the outer side of a joint without degrees of freedom.
    pub fn passed(&self, outer: &Matrix6<f64>) -> Matrix6<f64> {
        if self.arm == Vector3::zeros() {
            return *outer;
        }
        let shift = self.shift();
        shift.transpose() * outer * shift + self.swinging()
    }

    /// The joint's block with the tangent `outer` of the body on its outer side, and the magnitudes of the diagonal terms.
    pub fn block(&self, outer: &Matrix6<f64>) -> (Block, [f64; UNKNOWNS]) {
        let mut block = Block::<UNKNOWNS>::zeros();
        let mut scale = [1.0; UNKNOWNS];
        let rows = self.map.transpose() * outer;
        let xx = rows * self.map + self.own;
        let shift = self.shift();
        let mut xa = rows * shift;
        let mut columns = xa.fixed_view_mut::<6, 3>(0, 3);
        columns += self.turning;
        block.xx.fixed_view_mut::<6, 6>(0, 0).copy_from(&xx);
        block.xa.fixed_view_mut::<6, 6>(0, 0).copy_from(&xa);
        block.ax.fixed_view_mut::<6, 6>(0, 0).copy_from(&(shift.transpose() * outer * self.map + self.lengthening));
        block.aa = self.passed(outer);
        // a displacement along an axis is scaled by forces only
        let size = if self.slides { outer.fixed_view::<3, 3>(0, 0).amax() } else { outer.amax() };
        scale[..self.freedoms].fill(size + self.own.amax());
        (block, scale)
    }

    /// `Sᵀ` applied to a wrench.
    pub fn projected(&self, wrench: &Vector6<f64>) -> Unknowns {
        let projected = self.map.transpose() * wrench;
        let mut padded = Unknowns::<UNKNOWNS>::zeros();
        padded.fixed_rows_mut::<6>(0).copy_from(&projected);
        padded
    }
}
