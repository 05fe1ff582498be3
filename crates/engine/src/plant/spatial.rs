//! Universal, ball and free joints in the plant: springs, dampers, start, projection.

use crate::machine::Machine;
use crate::machine::{Spatial, SpatialFreedom};
use crate::math::so3::hat;
use crate::multibody::factor::FreedomTangent;
use crate::multibody::joint::{Joint, JointKind, RedundantWork};
use crate::multibody::{Model, Workspace};
use crate::plant::spatials;
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3};

/// A universal, ball or free joint as the equations see it.
#[derive(Debug, Clone)]
pub(super) struct SpatialEquations {
    /// Body that it holds.
    pub body: usize,
    /// Its parameters.
    joint: Joint,
    /// Attitude at which the spring is slack, parent ← body.
    neutral: Matrix3<f64>,
    /// Spring stiffness in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
}

impl SpatialEquations {
    /// The joints of a machine; springs and dampers come with the parameters.
    pub fn of_machine(machine: &Machine, model: &Model) -> Vec<Self> {
        spatials(machine)
            .map(|(body, _)| Self {
                body,
                joint: model.bodies[body].joint,
                neutral: model.bodies[body].mount,
                stiffness_n_m_rad: 0.0,
                damping_n_m_s_rad: 0.0,
            })
            .collect()
    }

    /// The joint as the mesh maker needs it.
    pub fn describe(spatial: &Spatial) -> JointKind {
        match spatial.freedom {
            SpatialFreedom::Universal { parent_axis, body_axis } => JointKind::universal(parent_axis, body_axis),
            SpatialFreedom::Ball => JointKind::Ball,
            SpatialFreedom::Free => JointKind::Free,
        }
    }

    /// Start rates of the parameters that agree with the start velocities; `q` holds the start attitude.
    pub fn start(&self, spatial: &Spatial, q: &[f64], v: &mut [f64]) {
        let range = self.range();
        let rates = self.joint.kind.parameter_rates(&q[range.clone()], &spatial.start_angular_velocity_rad_s);
        v[range.clone()].copy_from_slice(&rates[..range.len()]);
        if self.joint.kind == JointKind::Free {
            v[range.start..range.start + 3].copy_from_slice(spatial.start_velocity_m_s.as_slice());
        }
    }

    /// Attitude, parent ← body, of the last sweep.
    pub fn rotation(&self, work: &Workspace) -> Matrix3<f64> {
        work.joints[self.body].redundant().map_or_else(Matrix3::identity, |parameters| parameters.pose.rotation)
    }

    /// Attitude (parent ← body) and angular velocity relative to the parent (parent's frame) of the last sweep.
    pub fn motion(&self, work: &Workspace, v: &[f64]) -> (Matrix3<f64>, Vector3<f64>) {
        let Some(parameters) = work.joints[self.body].redundant() else {
            return (Matrix3::identity(), Vector3::zeros());
        };
        (parameters.pose.rotation, self.spin(parameters, v))
    }

    /// Back to the constraints of the parameters.
    pub fn project(&self, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        self.joint.restore(q, v, a);
    }

    /// Subtracts the torques of spring and damper from the residual of the freedoms.
    pub fn add_torque(&self, work: &Workspace, v: &[f64], residual: &mut [f64]) {
        let Some(parameters) = work.joints[self.body].redundant() else { return };
        if self.joint.kind == JointKind::Free {
            return;
        }
        let (angles, rates) = self.deflection(parameters, v);
        let torque = angles * self.stiffness_n_m_rad + rates * self.damping_n_m_s_rad;
        for i in 0..self.joint.kind.freedoms() {
            residual[self.joint.coordinate + i] += torque[i];
        }
    }

    /// Moment of a ball joint on its body, root frame, in N·m: its spring and damper are all that passes one on.
    pub fn ball_moment_n_m(&self, work: &Workspace, v: &[f64]) -> Option<Vector3<f64>> {
        let parameters = work.joints[self.body].redundant().filter(|_| self.joint.kind == JointKind::Ball)?;
        let (angles, rates) = self.deflection(parameters, v);
        Some(-(parameters.parent * (angles * self.stiffness_n_m_rad + rates * self.damping_n_m_s_rad)))
    }

    /// Energy of the spring in J.
    pub fn potential_j(&self, work: &Workspace) -> f64 {
        let Some(parameters) = work.joints[self.body].redundant() else { return 0.0 };
        if self.joint.kind == JointKind::Free {
            return 0.0;
        }
        0.5 * self.stiffness_n_m_rad * self.angles(parameters).norm_squared()
    }

    /// Power of the damper in W.
    pub fn dissipation_w(&self, work: &Workspace, v: &[f64]) -> f64 {
        let Some(parameters) = work.joints[self.body].redundant() else { return 0.0 };
        if self.joint.kind == JointKind::Free {
            return 0.0;
        }
        self.damping_n_m_s_rad * self.deflection(parameters, v).1.norm_squared()
    }

    /// Tangent of spring and damper, per freedom.
    pub fn tangent(&self) -> FreedomTangent {
        FreedomTangent { free: true, stiffness: self.stiffness_n_m_rad, damping: self.damping_n_m_s_rad }
    }

    /// Exact change of the spring's torques with the freedoms, N·m/rad: for a ball joint the inverse left tangent map of
    /// its rotation vector `φ`, `k (I − [φ]/2 + γ[φ]²)`, `γ = (1 − |φ|/2 cot(|φ|/2))/φ·φ`, NOTATION eq. (L7).
    pub fn stiffness(&self, work: &Workspace) -> Matrix3<f64> {
        let identity = Matrix3::identity() * self.stiffness_n_m_rad;
        let (JointKind::Ball, Some(parameters)) = (self.joint.kind, work.joints[self.body].redundant()) else {
            return if self.joint.kind == JointKind::Free { Matrix3::zeros() } else { identity };
        };
        let angles = self.angles(parameters);
        let square = angles.norm_squared();
        let half = 0.5 * square.sqrt();
        let gamma = if square < 1e-4 { 1.0 / 12.0 + square / 720.0 } else { (1.0 - half / half.tan()) / square };
        let turn = hat(&angles);
        identity + (turn * turn * gamma - turn * 0.5) * self.stiffness_n_m_rad
    }

    /// Adds the damper to a matrix over the coordinates.
    pub fn add_damping(&self, matrix: &mut DMatrix<f64>) {
        if self.joint.kind != JointKind::Free {
            for c in self.joint.coordinate..self.joint.coordinate + self.joint.kind.freedoms() {
                matrix[(c, c)] += self.damping_n_m_s_rad;
            }
        }
    }

    /// Its parameters in the coordinates.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.joint.range()
    }

    fn spin(&self, parameters: &RedundantWork, v: &[f64]) -> Vector3<f64> {
        let rates = &v[self.range()];
        parameters.pose.spin(&self.joint.kind, rates, rates).0
    }

    /// Spring angles and their rates along the freedoms: rotation vector in the parent's frame for a ball joint, the two
    /// angles of a universal joint (third entry zero).
    fn deflection(&self, parameters: &RedundantWork, v: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let spin = self.spin(parameters, v);
        let rates = match self.joint.kind {
            JointKind::Universal { .. } => {
                // ω = n₁ θ̇₁ + n₂ θ̇₂
                let (first, second) = (parameters.pose.axes.column(0), parameters.pose.axes.column(1));
                let cosine = first.dot(&second);
                let (a, b) = (first.dot(&spin), second.dot(&spin));
                let scale = 1.0 / (1.0 - cosine * cosine);
                Vector3::new((a - cosine * b) * scale, (b - cosine * a) * scale, 0.0)
            }
            _ => spin,
        };
        (self.angles(parameters), rates)
    }

    fn angles(&self, parameters: &RedundantWork) -> Vector3<f64> {
        let rotation = &parameters.pose.rotation;
        match self.joint.kind {
            JointKind::Universal { parent_axis, body_axis, .. } => {
                let first = turn_about(&parent_axis, &(self.neutral * body_axis), &(rotation * body_axis));
                let before = crate::math::so3::rotation_about(&parent_axis, first) * self.neutral;
                let relative = before.transpose() * rotation;
                let across = perpendicular(&body_axis);
                Vector3::new(first, turn_about(&body_axis, &across, &(relative * across)), 0.0)
            }
            _ => {
                let relative = rotation * self.neutral.transpose();
                Rotation3::from_matrix_unchecked(relative).scaled_axis()
            }
        }
    }
}

/// Angle about `axis` that brings `from` to `to`, in (−π, π].
fn turn_about(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let flat = |vector: &Vector3<f64>| vector - axis * axis.dot(vector);
    let (from, to) = (flat(from), flat(to));
    axis.dot(&from.cross(&to)).atan2(from.dot(&to))
}

/// Some vector across `axis`.
fn perpendicular(axis: &Vector3<f64>) -> Vector3<f64> {
    let other = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    axis.cross(&other).normalize()
}
