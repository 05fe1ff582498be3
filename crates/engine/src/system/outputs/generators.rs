//! Outputs of generators.

use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};

/// Outputs of one generator.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct GeneratorOutputs {
    /// Speed of the generator's shaft, on the output side of the gearbox, in rad/s.
    pub speed_rad_s: f64,
    /// Torque on the generator's shaft that opposes its rotation, in N·m.
    pub torque_n_m: f64,
    /// Electrical power in W.
    pub power_w: f64,
}

/// Writes the outputs of the generators, in the order of their joints.
pub(crate) fn fill(outputs: &mut [GeneratorOutputs], present: &Present) {
    let rates = present.motion.v;
    let joints = present.equations.forces.joints().iter();
    let states = joints.filter_map(|joint| joint.generated(rates[joint.coordinate]));
    for (output, state) in outputs.iter_mut().zip(states) {
        *output =
            GeneratorOutputs { speed_rad_s: state.speed_rad_s, torque_n_m: state.torque_n_m, power_w: state.power_w };
    }
}
