//! Revolute and prismatic joints: angles, rates and torques.

use crate::force::joint::JointForces;
use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};

/// Outputs of one revolute or prismatic joint. Names are those of a revolute joint; for a prismatic joint read m for rad and N for N·m.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct JointOutputs {
    /// Fold angle in rad.
    pub angle_rad: f64,
    /// Fold rate in rad/s.
    pub rate_rad_s: f64,
    /// Neutral angle of the motor after its rate limit, in rad; 0 for joints without a motor.
    pub neutral_angle_rad: f64,
    /// Sum of motor, spring and external torque, and that of an electrical DC motor, on the outer body in the direction of `+θ`, in N·m.
    pub torque_applied_n_m: f64,
    /// Torque of the motor after its limit, in N·m.
    pub motor_torque_n_m: f64,
    /// Torque of the joint's spring and damper in N·m.
    pub spring_torque_n_m: f64,
    /// Applied external torque `τ_ext` in N·m.
    pub external_torque_n_m: f64,
    /// Constraint torque of a held joint (lock, locked or prescribed motion) in N·m; 0 for a free joint, and while a closed rigid latch
    /// bears the torque.
    pub holding_torque_n_m: f64,
    /// Latch torque on the outer body in N·m: of the spring, or the reaction of a rigid latch.
    pub latch_torque_n_m: f64,
}

impl JointOutputs {
    /// Adds the motor's contribution to the time derivatives of the outputs, on the current branch of its limits and slews: `motion` is
    /// angle, rate and acceleration, `others_n_m_s` the rates of the external torque and of the torque of a DC motor.
    pub(crate) fn add_drive(
        &mut self,
        joint: &JointForces,
        time_s: f64,
        [angle, rate, acceleration]: [f64; 3],
        [external_n_m_s, electrical_n_m_s]: [f64; 2],
    ) {
        let Some(motor) = joint.motor() else { return };
        let (drive, slew_rate) = (&motor.drive, motor.slew.at(time_s).1);
        let spring = joint.spring().copied().unwrap_or_default();
        self.neutral_angle_rad = slew_rate;
        self.motor_torque_n_m = if joint.motor_torque(time_s, angle, rate).saturated {
            0.0
        } else {
            -drive.stiffness_n_m_rad * (rate - slew_rate) - drive.damping_n_m_s_rad * acceleration
        };
        self.spring_torque_n_m = -spring.stiffness_n_m_rad * rate - spring.damping_n_m_s_rad * acceleration;
        self.external_torque_n_m = external_n_m_s;
        self.torque_applied_n_m =
            self.motor_torque_n_m + self.spring_torque_n_m + self.external_torque_n_m + electrical_n_m_s;
    }
}

/// Writes all outputs except those that need the residual.
pub(crate) fn fill(outputs: &mut [JointOutputs], present: &Present) {
    let time_s = present.time_s();
    for (output, joint) in outputs.iter_mut().zip(present.equations.forces.joints()) {
        let (angle, rate) = (present.motion.q[joint.coordinate], present.motion.v[joint.coordinate]);
        let motor = joint.motor_torque(time_s, angle, rate).applied_n_m;
        let (spring, external) = (joint.spring_torque_n_m(angle, rate), joint.external_torque_n_m());
        *output = JointOutputs {
            angle_rad: angle,
            rate_rad_s: rate,
            neutral_angle_rad: joint.motor().map_or(0.0, |motor| motor.neutral(time_s).0),
            torque_applied_n_m: motor + spring + external + joint.armature_torque_n_m(present.motion.v),
            motor_torque_n_m: motor,
            spring_torque_n_m: spring,
            external_torque_n_m: external,
            holding_torque_n_m: output.holding_torque_n_m,
            latch_torque_n_m: match joint.has_rigid_latch() {
                true => output.latch_torque_n_m,
                false => joint.latch_torque_n_m(angle),
            },
        };
    }
}

/// Writes the constraint torques of held joints, from the last residual.
pub(crate) fn fill_holding(outputs: &mut [JointOutputs], present: &Present) {
    for (output, joint) in outputs.iter_mut().zip(present.equations.forces.joints()) {
        output.holding_torque_n_m = joint.holding_n_m;
        if joint.has_rigid_latch() {
            // a closed latch bears the whole torque, even if the joint is also held otherwise, eq. (A7)
            let borne_n_m = if joint.is_latched() { joint.holding_n_m } else { 0.0 };
            output.latch_torque_n_m = borne_n_m;
            output.holding_torque_n_m -= borne_n_m;
        }
    }
}
