//! Forces and moments of joints, at sections, of closed loops and on the aircraft; strains of gauges.

use crate::load::Wrench;
use crate::machine::Machine;
use crate::multibody::gauge::GaugePoint;
use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;

/// Outputs of one closed loop, root frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LoopOutputs {
    /// Vector from the first to the second point in m, eq. (C1).
    pub gap_m: Vector3<f64>,
    /// Force on the first point in N, eq. (C2); its opposite acts on the second.
    pub force_n: Vector3<f64>,
}

/// Outputs of a skate or a wheel: forces of the plane on the body, and the distance from the constraints.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct NoSlipOutputs {
    /// Force across the heading in N, along `normal × heading`, eq. (L47).
    pub side_force_n: f64,
    /// Force along the heading in N; 0 without rolling.
    pub rolling_force_n: f64,
    /// Force along the normal of the plane in N, which is negative where the plane pulls; 0 without `hold_normal`.
    pub normal_force_n: f64,
    /// Velocity of slip in m/s, in the directions that are constrained: zero to round-off.
    pub slip_m_s: f64,
    /// Distance of the point of contact from the plane in m, along its normal.
    pub height_m: f64,
}

/// Writes the forces and moments of the joints on their bodies.
pub(crate) fn fill_reactions(outputs: &mut [Wrench], present: &Present) {
    let (equations, motion) = (present.equations, present.motion);
    let (model, work) = (&equations.model, &equations.work);
    for (reaction, body) in outputs.iter_mut().zip(&model.bodies) {
        let node = &work.nodes[body.first_node];
        *reaction = Wrench { force_n: node.force, moment_n_m: node.moment };
    }
    for joint in equations.forces.joints() {
        joint.complete_reaction(model, work, motion, present.time_s(), &mut outputs[joint.body]);
    }
    for joint in equations.forces.spatial() {
        if let Some(moment_n_m) = joint.attitude().and_then(|spring| spring.ball_moment_n_m(work, motion.v)) {
            outputs[joint.body].moment_n_m = moment_n_m;
        }
    }
}

/// Writes the strains of the gauges.
pub(crate) fn fill_gauges(outputs: &mut [f64], present: &Present, gauges: &[GaugePoint]) {
    let equations = present.equations;
    for (strain, gauge) in outputs.iter_mut().zip(gauges) {
        *strain = gauge.strain(&equations.model, &equations.work, present.motion, &equations.damping);
    }
}

/// Writes the internal loads.
pub(crate) fn fill_sections(outputs: &mut [Wrench], present: &Present) {
    let equations = present.equations;
    let loads: &[Wrench] = if equations.loaded { &equations.stations } else { &[] };
    for (load, section) in outputs.iter_mut().zip(&equations.sections) {
        *load = section.load(&equations.model, &equations.work, present.motion, loads);
    }
}

/// Writes the outputs of closed loops, those of rigid ones from their multipliers.
pub(crate) fn fill_loops(outputs: &mut [LoopOutputs], present: &Present, machine: &Machine) {
    let (model, work) = (&present.equations.model, &present.equations.work);
    let (mut penalties, mut rigid) = (model.closures.iter(), model.rigid_loops.iter().enumerate());
    for (output, described) in outputs.iter_mut().zip(&machine.closures) {
        let values = if described.rigid {
            rigid.next().map(|(index, closure)| {
                let force_n = Vector3::from_column_slice(&present.motion.a[model.multipliers(index)]);
                (closure.gap(work), force_n)
            })
        } else {
            penalties.next().map(|closure| {
                let gap = closure.gap(work);
                (gap, closure.force_n(&gap))
            })
        };
        if let Some((gap, force_n)) = values {
            *output = LoopOutputs { gap_m: gap.position_m, force_n };
        }
    }
}

/// Writes the outputs of skates and wheels.
pub(crate) fn fill_no_slips(outputs: &mut [NoSlipOutputs], present: &Present) {
    let (model, work) = (&present.equations.model, &present.equations.work);
    let first = model.rigid_loops.len();
    for (index, (output, no_slip)) in outputs.iter_mut().zip(&model.no_slips).enumerate() {
        let multipliers = &present.motion.a[model.multipliers(first + index)];
        let [across, along, normal] = no_slip.active().map(f64::from);
        let slip = no_slip.gap(work).velocity_m_s;
        *output = NoSlipOutputs {
            side_force_n: across * multipliers[0],
            rolling_force_n: along * multipliers[1],
            normal_force_n: normal * multipliers[2],
            slip_m_s: slip.x.hypot(slip.y),
            height_m: no_slip.height_m(work),
        };
    }
}

/// Writes the force and moment of the wing on the aircraft at the origin, root frame.
pub(crate) fn fill_root(output: &mut Wrench, present: &Present) {
    let work = &present.equations.work;
    *output = Wrench { force_n: -work.root_force, moment_n_m: -work.root_moment };
}
