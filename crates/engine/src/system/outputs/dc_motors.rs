//! Outputs of electrical DC motors.

use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};

/// Outputs of one electrical DC motor. Names are those of a revolute joint; for a prismatic joint read N for N·m.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct DcMotorOutputs {
    /// Armature current in A.
    pub current_a: f64,
    /// Torque on the outer body in the direction of `+θ`, in N·m.
    pub torque_n_m: f64,
    /// Electrical power at the terminals in W, negative if the motor returns power.
    pub power_w: f64,
}

/// Writes the outputs of the motors, in the order of their joints.
pub(crate) fn fill(outputs: &mut [DcMotorOutputs], present: &Present) {
    let rates = present.motion.v;
    for (output, armature) in outputs.iter_mut().zip(present.equations.forces.armatures()) {
        let current_a = rates[armature.circuit.coordinate];
        let torque_n_m = armature.circuit.torque_n_m(rates);
        *output = DcMotorOutputs { current_a, torque_n_m, power_w: armature.voltage_v * current_a };
    }
}
