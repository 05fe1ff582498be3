//! Checks of sliding joints: the beam along which the body slides, its start, and parts of a machine that exclude sliding joints.

use crate::beam::element::ElementKind;
use crate::machine::fault::{Checker, array_text};
use crate::machine::units::shortest;
use crate::machine::{Body, Machine, Parent};

/// Checks all sliding joints.
pub(super) fn check(machine: &Machine, checker: &mut Checker) {
    for body in machine.bodies.iter().filter(|body| body.joint.kind.rides()) {
        let name = body.joint.name.as_str();
        let Parent::Body { index, position_m } = body.joint.parent else {
            let allowed = "a beam along which the body slides";
            checker.refuse(&["joint", name, "parent"], "\"root\"", allowed);
            continue;
        };
        let Some(beam) = machine.bodies.get(index) else { continue };
        if !beam.is_beam() {
            let allowed = "a beam along which the body slides, not a rigid or a modal body";
            checker.refuse(&["joint", name, "parent"], format!("{:?}", beam.name), allowed);
            continue;
        }
        if position_m != 0.0 {
            let allowed = "no position on a sliding joint, which moves along its parent; write start_position_m";
            checker.refuse(&["joint", name, "parent_position_m"], shortest(position_m), allowed);
        }
        let start_m = body.joint.kind.one_freedom().map_or(0.0, |(_, own)| own.start_angle_rad);
        if !(0.0..=beam.length_m).contains(&start_m) {
            let allowed = format!("a position on {:?}: from 0 to its length, {} m", beam.name, shortest(beam.length_m));
            checker.refuse(&["joint", name, "start_position_m"], shortest(start_m), allowed);
        }
        gauges(machine, index, name, checker);
    }
    carried(&machine.bodies, checker);
    let Some(joint) = machine.sliding_joint() else { return };
    for body in machine.bodies.iter().filter(|body| body.modal_damping_ratios.iter().any(|ratio| *ratio > 0.0)) {
        let allowed = format!(
            "no modal damping in a model with a sliding joint ({joint:?}); write stiffness_damping_s on the body"
        );
        checker.refuse(&["body", &body.name, "modal_damping_ratios"], array_text(&body.modal_damping_ratios), allowed);
    }
}

/// Reports rotors in a model with a sliding joint, for which there is no test.
pub(super) fn beside_rotors(machine: &Machine, checker: &mut Checker) {
    let rotors = machine.air.as_ref().map_or(0, |air| air.rotors().count());
    if let (Some(joint), true) = (machine.sliding_joint(), rotors > 0) {
        let allowed = format!(
            "no rotor in a model with a sliding joint ({joint:?}); use strips, a vortex lattice or a prismatic joint"
        );
        checker.refuse_state(&["aerodynamics"], "a rotor", allowed);
    }
}

/// Reports strains that would have to be recovered inside the element that carries the body.
fn gauges(machine: &Machine, beam: usize, joint: &str, checker: &mut Checker) {
    let linear = machine.bodies[beam].element == ElementKind::Linear;
    for gauge in machine.gauges.iter().filter(|gauge| gauge.body == beam && linear) {
        let allowed = format!(
            "a body with element = \"constant\", or without a sliding joint on it ({joint:?}): strains of linear elements are \
             recovered from forces at their ends"
        );
        checker.refuse_state(&["gauge", &gauge.name, "body"], "a gauge on a beam along which a body slides", allowed);
    }
}

/// Reports bodies carried by a sliding joint that have velocities beyond those of their nodes, for which an impulse is not known.
fn carried(bodies: &[Body], checker: &mut Checker) {
    let mut rides: Vec<bool> = Vec::with_capacity(bodies.len());
    for body in bodies {
        let parent = match body.joint.parent {
            Parent::Body { index, .. } => rides.get(index).copied().unwrap_or(false),
            Parent::Root { .. } => false,
        };
        let own = parent || body.joint.kind.rides();
        rides.push(own);
        if own && (body.is_modal() || body.has_shear()) {
            let allowed = "a rigid body, or a beam without shear, if a sliding joint carries it";
            let found = if body.is_modal() { "a modal body" } else { "a beam with shear" };
            checker.refuse_state(&["body", &body.name], found, allowed);
        }
    }
}
