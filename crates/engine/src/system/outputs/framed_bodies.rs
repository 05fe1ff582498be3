//! Outputs of bodies with a reference frame, modal bodies and beams with an axis given by points: deflection of the outer end, load at the
//! inner end.

use crate::load::Wrench;
use crate::machine::Machine;
use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;

/// Outputs of one modal body, or of one beam with a reference axis given by points, in the body's frame at its inner end.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct ModalOutputs {
    /// Displacement of the outer end from its undeformed position, in m.
    pub deflection_m: Vector3<f64>,
    /// Force and moment of the joint on the inner end, at that end.
    pub root: Wrench,
}

/// Writes the deflections of bodies with a reference frame, in the order of the bodies; poses must be current.
pub(crate) fn fill_deflections(outputs: &mut [ModalOutputs], machine: &Machine, present: &Present) {
    let work = &present.equations.work;
    for (output, index) in outputs.iter_mut().zip(machine.framed_bodies()) {
        let (body, described) = (&present.equations.model.bodies[index], &machine.bodies[index]);
        let (inner, outer) = (&work.nodes[body.first_node], &work.nodes[body.last_node()]);
        let displacement_m = inner.rotation.transpose() * (outer.position - inner.position);
        output.deflection_m = match &described.axis {
            Some(axis) => axis.first * displacement_m - axis.outer_m,
            None => displacement_m - Vector3::x() * described.length_m,
        };
    }
}

/// Writes the load at the inner end of a body with a reference frame, from that of its joint in the root frame.
pub(crate) fn fill_root(
    output: &mut ModalOutputs,
    (body, machine): (usize, &Machine),
    reaction: &Wrench,
    present: &Present,
) {
    let equations = present.equations;
    let section = equations.work.nodes[equations.model.bodies[body].first_node].rotation.transpose();
    let turned = machine.bodies[body].axis.map_or(section, |axis| axis.first * section);
    output.root = Wrench { force_n: turned * reaction.force_n, moment_n_m: turned * reaction.moment_n_m };
}
