//! Spring and damper of a universal or ball joint.

use crate::force::{Here, Push};
use crate::math::so3::{hat, rotation_vector};
use crate::multibody::Workspace;
use crate::multibody::joint::{Joint, JointKind, RedundantWork};
use nalgebra::{Matrix3, Vector3};

/// Spring and damper on the degrees of freedom of a universal or ball joint.
#[derive(Debug, Clone, PartialEq)]
pub struct AttitudeSpring {
    body: usize,
    /// Parameters of the joint.
    joint: Joint,
    /// Attitude at which the spring is unloaded, parent ← body.
    neutral: Matrix3<f64>,
    /// Spring stiffness in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
}

impl AttitudeSpring {
    /// Spring and damper with zero coefficients; `neutral` is the attitude at which the spring is unloaded, parent ← body.
    pub fn new(body: usize, joint: Joint, neutral: Matrix3<f64>) -> Self {
        Self { body, joint, neutral, stiffness_n_m_rad: 0.0, damping_n_m_s_rad: 0.0 }
    }

    /// Subtracts the torques from the residual rows of the degrees of freedom, and adds the tangent.
    pub fn push(&self, here: &Here, sum: &mut Push) {
        sum.tangent.stiffness += self.stiffness_n_m_rad;
        sum.tangent.damping += self.damping_n_m_s_rad;
        let Some(parameters) = here.work.joints[self.body].redundant() else { return };
        let (angles, rates) = self.deflection(parameters, here.v);
        let torque = angles * self.stiffness_n_m_rad + rates * self.damping_n_m_s_rad;
        sum.rows.iter_mut().zip(&torque).for_each(|(row, torque)| *row += torque);
    }

    /// Moment of a ball joint on its body, root frame, in N·m: only spring and damper transmit it.
    pub fn ball_moment_n_m(&self, work: &Workspace, v: &[f64]) -> Option<Vector3<f64>> {
        let parameters = work.joints[self.body].redundant().filter(|_| self.joint.kind == JointKind::Ball)?;
        let (angles, rates) = self.deflection(parameters, v);
        Some(-(parameters.parent * (angles * self.stiffness_n_m_rad + rates * self.damping_n_m_s_rad)))
    }

    /// Energy stored in the spring in J.
    pub fn potential_j(&self, work: &Workspace) -> f64 {
        let Some(parameters) = work.joints[self.body].redundant() else { return 0.0 };
        0.5 * self.stiffness_n_m_rad * self.angles(parameters).norm_squared()
    }

    /// Power dissipated by the damper in W.
    pub fn dissipation_w(&self, work: &Workspace, v: &[f64]) -> f64 {
        let Some(parameters) = work.joints[self.body].redundant() else { return 0.0 };
        self.damping_n_m_s_rad * self.deflection(parameters, v).1.norm_squared()
    }

    /// Exact derivative of the spring's torques with respect to the degrees of freedom, N·m/rad: for a ball joint the inverse left tangent
    /// map of its rotation vector `φ`, `k (I − [φ]/2 + γ[φ]²)`, `γ = (1 − |φ|/2 cot(|φ|/2))/φ·φ`, NOTATION eq. (L7).
    pub fn stiffness(&self, work: &Workspace) -> Matrix3<f64> {
        let identity = Matrix3::identity() * self.stiffness_n_m_rad;
        let (JointKind::Ball, Some(parameters)) = (self.joint.kind, work.joints[self.body].redundant()) else {
            return identity;
        };
        let angles = self.angles(parameters);
        let square = angles.norm_squared();
        let half = 0.5 * square.sqrt();
        let gamma = if square < 1e-4 { 1.0 / 12.0 + square / 720.0 } else { (1.0 - half / half.tan()) / square };
        let turn = hat(&angles);
        identity + (turn * turn * gamma - turn * 0.5) * self.stiffness_n_m_rad
    }

    /// Exact derivatives of the torques of spring and damper on the degrees of freedom (rows) by a small rotation of the joint and by its
    /// angular velocity, both in the parent's frame, N·m/rad and N·m·s/rad; NOTATION eq. (X25).
    pub(crate) fn slopes(&self, work: &Workspace, v: &[f64]) -> Option<[Matrix3<f64>; 2]> {
        let at = work.joints[self.body].redundant()?;
        let JointKind::Universal { parent_axis, body_axis, .. } = &self.joint.kind else {
            return Some([self.stiffness(work), Matrix3::identity() * self.damping_n_m_s_rad]);
        };
        let rotation = &at.pose.rotation;
        let first_rad = self.angles(at)[0];
        let outer = rotation * body_axis;
        let flat = outer - parent_axis * parent_axis.dot(&outer);
        let first = outer.cross(&parent_axis.cross(&flat)) / flat.norm_squared();
        let before = crate::math::so3::rotation_about(parent_axis, first_rad) * self.neutral;
        let across = rotation * perpendicular(body_axis);
        let local = before.tr_mul(&across);
        let flat = local - body_axis * body_axis.dot(&local);
        let second = across.cross(&(before * body_axis.cross(&flat))) / flat.norm_squared();
        let second = second - first * second.dot(parent_axis);
        let angles = Matrix3::from_rows(&[first.transpose(), second.transpose(), Vector3::zeros().transpose()]);
        // rates: those of ω = n₁ θ̇₁ + n₂ θ̇₂, of which n₂ rotates with the body
        let (n1, n2) = (at.pose.axes.column(0).into_owned(), at.pose.axes.column(1).into_owned());
        let spin = self.spin(at, v);
        let cosine = n1.dot(&n2);
        let (a, b) = (n1.dot(&spin), n2.dot(&spin));
        let scale = 1.0 / (1.0 - cosine.powi(2));
        let steep = 2.0 * cosine * scale * scale;
        let by_axis = [
            (n1 * b + spin * cosine) * -scale + n1 * ((a - cosine * b) * steep),
            (spin - n1 * a) * scale + n1 * ((b - cosine * a) * steep),
        ];
        let [by_turn_1, by_turn_2] = by_axis.map(|by| n2.cross(&by).transpose());
        let rates = Matrix3::from_rows(&[by_turn_1, by_turn_2, Vector3::zeros().transpose()]);
        let by_spin = Matrix3::from_rows(&[
            ((n1 - n2 * cosine) * scale).transpose(),
            ((n2 - n1 * cosine) * scale).transpose(),
            Vector3::zeros().transpose(),
        ]);
        Some([angles * self.stiffness_n_m_rad + rates * self.damping_n_m_s_rad, by_spin * self.damping_n_m_s_rad])
    }

    fn spin(&self, parameters: &RedundantWork, v: &[f64]) -> Vector3<f64> {
        let rates = &v[self.joint.range()];
        parameters.pose.spin(&self.joint.kind, rates, rates).0
    }

    /// Spring angles and their rates: rotation vector in the parent's frame for a ball joint, the two angles of a universal joint (third
    /// entry zero).
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
            JointKind::Clamped
            | JointKind::Revolute { .. }
            | JointKind::Prismatic { .. }
            | JointKind::Sliding
            | JointKind::Ball
            | JointKind::Free => spin,
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
            JointKind::Clamped
            | JointKind::Revolute { .. }
            | JointKind::Prismatic { .. }
            | JointKind::Sliding
            | JointKind::Ball
            | JointKind::Free => {
                let relative = rotation * self.neutral.transpose();
                rotation_vector(&relative)
            }
        }
    }
}

/// Angle about `axis` that rotates `from` to `to`, in (−π, π].
fn turn_about(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let flat = |vector: &Vector3<f64>| vector - axis * axis.dot(vector);
    let (from, to) = (flat(from), flat(to));
    axis.dot(&from.cross(&to)).atan2(from.dot(&to))
}

/// An arbitrary vector normal to `axis`.
fn perpendicular(axis: &Vector3<f64>) -> Vector3<f64> {
    let other = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    axis.cross(&other).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{AttachedMass, Body, Joint as Described, Machine, Motor};
    use crate::multibody::kinematics::sweep_poses;
    use crate::run::Plant;
    use std::sync::Arc;

    /// The stiffness of a ball joint is the derivative of its torque with respect to small rotations about the parent's axes, for any angle
    /// and axis: compared with differences of the spring's angles.
    #[test]
    fn stiffness_is_the_slope_of_the_torque() {
        let mass = AttachedMass { inertia_kg_m2: Matrix3::identity(), ..AttachedMass::point("mass", 0.0, 1.0) };
        let drive = Motor { stiffness_n_m_rad: 3.0, ..Motor::default() };
        let machine = Machine::builder("Ball")
            .body(Body::rigid("body"), Described::ball("ball").motor(drive))
            .mass("body", mass)
            .step_s(0.01)
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let system = plant.system_mut();
        let (mut work, mut q) = (system.equations.work.clone(), system.state.now.q.clone());
        let spring = system.equations.forces.spatial()[0].attitude().expect("has a spring");
        let mut largest_rad = 0.0_f64;
        for turn in [[0.0, 0.0, 0.0], [0.003, -0.002, 0.004], [0.8, -0.3, 0.5], [-1.2, 1.5, 0.4], [0.2, 0.3, -2.8]] {
            let turn = Vector3::from(turn);
            largest_rad = largest_rad.max(turn.norm());
            let mut torque = |work: &mut Workspace, by: Vector3<f64>| {
                let turned = nalgebra::Rotation3::new(by) * nalgebra::Rotation3::new(turn);
                let parameters = spring.joint.kind.parameters_of(&(turned.matrix() * spring.neutral));
                let range = spring.joint.range();
                q[range.clone()].copy_from_slice(&parameters[..range.len()]);
                sweep_poses(&system.equations.model, work, &q);
                let parameters = work.joints[spring.body].redundant().expect("a ball joint");
                spring.angles(parameters) * spring.stiffness_n_m_rad
            };
            let mut slope = Matrix3::zeros();
            for axis in 0..3 {
                let small = Vector3::ith(axis, 1e-5);
                let change = torque(&mut work, small) - torque(&mut work, -small);
                slope.set_column(axis, &(change / 2e-5));
            }
            torque(&mut work, Vector3::zeros());
            let off = (spring.stiffness(&work) - slope).norm();
            // central differences: error of second order in the step, and round-off divided by the step
            assert!(off < 1e-8, "{turn}: {} for {slope}", spring.stiffness(&work));
        }
        assert!(largest_rad > 2.5);
    }
}
