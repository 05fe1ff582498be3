//! Energies of the model and accounts of work and dissipation.

use crate::multibody::energy;
use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};

/// Energies in J. `total − work + dissipated` is constant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct EnergyOutputs {
    /// Kinetic energy relative to the root frame.
    pub kinetic: f64,
    /// Strain energy of beams, springs and stops of fold joints, closed latches and closed loops.
    pub elastic: f64,
    /// Potential of `gravity − root acceleration`, zero at the root's origin.
    pub gravity: f64,
    /// Potential of the motors' stiffness and constant torques within their limits, and of springs of universal and ball joints.
    pub motor: f64,
    /// Work of inputs: loads, torques, commands, root motion, changed parameters.
    pub work: f64,
    /// Energy dissipated by damping, opening latches and stopping joints.
    pub dissipated: f64,
    /// `kinetic + elastic + gravity + motor`.
    pub total: f64,
}

/// Writes the current energies, except for the accounts.
pub(crate) fn fill(output: &mut EnergyOutputs, present: &Present) {
    let (equations, motion) = (present.equations, present.motion);
    let (model, work) = (&equations.model, &equations.work);
    let penalty: f64 = model.closures.iter().map(|closure| closure.energy_j(work).0).sum();
    let kinetic = energy::kinetic(model, work, |_, _| {}) + penalty + energy::kinetic_of_drives(model, work, motion.v);
    let potentials = equations.potentials(present.time_s(), motion.q);
    *output = EnergyOutputs {
        kinetic,
        elastic: potentials.elastic,
        gravity: potentials.gravity,
        motor: potentials.drive,
        total: kinetic + potentials.total(),
        ..*output
    };
}

/// Writes the accounts of work and dissipation.
pub(crate) fn fill_accounts(output: &mut EnergyOutputs, present: &Present) {
    (output.work, output.dissipated) = (present.state.now.work, present.state.now.dissipated);
}
