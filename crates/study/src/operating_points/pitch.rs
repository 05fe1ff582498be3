//! The joints by which the blades of a rotor are pitched.

use crate::operating_points::error::PointsError;
use foldwing_engine::machine::{JointKind, JointMotion, Machine, Motion, OneFreedom};

/// Returns the bodies on pitch joints: the named ones, or those between hub and blades if all of them have revolute joints.
pub fn pitch_joints(
    machine: &Machine,
    named: Option<&[String]>,
    blades: &[&[usize]],
) -> Result<Vec<usize>, PointsError> {
    let is_revolute = |body: usize| matches!(machine.bodies[body].joint.kind, JointKind::Revolute(_));
    let Some(named) = named else {
        let roots: Vec<usize> = blades.iter().filter_map(|bodies| bodies.first().copied()).collect();
        return Ok(if roots.iter().all(|root| is_revolute(*root)) { roots } else { Vec::new() });
    };
    let of = |name: &String| {
        let body = machine.bodies.iter().position(|body| body.joint.name == *name);
        body.filter(|body| is_revolute(*body)).ok_or_else(|| PointsError::PitchJoint { joint: name.clone() })
    };
    named.iter().map(of).collect()
}

/// Sets the pitch of a blade at its joint; the command of its motor is an input.
pub fn set_pitch(machine: &mut Machine, body: usize, pitch_rad: f64) -> Result<(), PointsError> {
    let joint = &mut machine.bodies[body].joint;
    let name = joint.name.clone();
    let JointKind::Revolute(hinge) = &mut joint.kind else { return Ok(()) };
    let OneFreedom { motion, motor: drive, start_angle_rad, .. } = &mut **hinge;
    match motion {
        JointMotion::Prescribed(motion) => *motion = Motion::Polynomial(vec![pitch_rad]),
        JointMotion::Free if drive.stiffness_n_m_rad == 0.0 => return Err(PointsError::LoosePitch { joint: name }),
        JointMotion::Free | JointMotion::Locked => {}
    }
    *start_angle_rad = pitch_rad;
    Ok(())
}
