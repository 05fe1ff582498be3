//! Pitch joints of a rotor's blades, for its operating points.

use crate::cli::Failure;
use foldwing_engine::machine::{JointKind, JointMotion, Machine, Motion, OneFreedom};

/// Returns the bodies on pitch joints: the named ones, or those between hub and blades if all of them have revolute joints.
pub(super) fn pitch_joints(machine: &Machine, named: Option<&str>, blades: &[&[usize]]) -> Result<Vec<usize>, Failure> {
    let is_revolute = |body: usize| matches!(machine.bodies[body].joint.kind, JointKind::Revolute(_));
    let Some(named) = named else {
        let roots: Vec<usize> = blades.iter().filter_map(|bodies| bodies.first().copied()).collect();
        return Ok(if roots.iter().all(|root| is_revolute(*root)) { roots } else { Vec::new() });
    };
    let of = |name: &str| {
        let body = machine.bodies.iter().position(|body| body.joint.name == name.trim());
        body.filter(|body| is_revolute(*body)).ok_or_else(|| {
            Failure::Usage(format!("--pitch-joints {named}: the model has no revolute joint {:?}", name.trim()))
        })
    };
    named.split(',').map(of).collect()
}

/// Sets the pitch of a blade at its joint; the command of its motor is an input.
pub(super) fn set_pitch(machine: &mut Machine, body: usize, pitch_rad: f64) -> Result<(), Failure> {
    let joint = &mut machine.bodies[body].joint;
    let name = joint.name.clone();
    let JointKind::Revolute(hinge) = &mut joint.kind else { return Ok(()) };
    let OneFreedom { motion, motor: drive, start_angle_rad, .. } = &mut **hinge;
    match motion {
        JointMotion::Prescribed(motion) => *motion = Motion::Polynomial(vec![pitch_rad]),
        JointMotion::Free if drive.stiffness_n_m_rad == 0.0 => {
            return Err(Failure::Usage(format!(
                "the joint {name}: nothing holds its pitch; give it a motor with a stiffness, or motion = \"locked\""
            )));
        }
        JointMotion::Free | JointMotion::Locked => {}
    }
    *start_angle_rad = pitch_rad;
    Ok(())
}
