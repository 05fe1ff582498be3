//! Forces on the joints of a model, from its description, its inputs and its parameters.

use crate::force::Force;
use crate::force::attitude::AttitudeSpring;
use crate::force::borders::Borders;
use crate::force::brake::Brake;
use crate::force::dc_motor::Armature;
use crate::force::end_stops::TwoSidedStops;
use crate::force::external::External;
use crate::force::generator::Generator;
use crate::force::joint::JointForces;
use crate::force::latch::{CatchingLatch, Latch};
use crate::force::memory::Contact;
use crate::force::motor::Motor;
use crate::force::prescribed::Law;
use crate::force::set::Forces;
use crate::force::spring::Spring;
use crate::machine::{JointMotion, Machine, OneFreedom};
use crate::multibody::Model;
use crate::multibody::model::Base;
use crate::signal::{Inputs, Parameters};
use crate::system::failure_memory;

/// Forces on all joints of a model; inputs and parameters are set later.
pub(crate) fn of_machine(machine: &Machine, model: &Model) -> Forces {
    let joints = machine.one_freedoms().map(|(body, own)| {
        let circuit = model.circuits.iter().find(|circuit| circuit.body == body);
        let mut forces = of_joint(own, circuit.map(|circuit| Armature { circuit: *circuit, voltage_v: 0.0 }));
        forces.extend(failure_memory::forces_on(machine, body));
        if let Base::Axis(slide) = model.bodies[body].base {
            forces.push(Force::Borders(Borders::new(model.slides[slide].borders_m(model))));
        }
        JointForces::new(body, &model.bodies[body].joint, forces)
    });
    let spatial = machine.spatials().map(|(body, _)| {
        let described = &model.bodies[body];
        let spring = AttitudeSpring::new(body, described.joint, described.mount);
        let forces = if described.joint.kind.floats() { vec![] } else { vec![Force::Attitude(spring)] };
        JointForces::new(body, &described.joint, forces)
    });
    Forces::new(joints.collect(), spatial.collect())
}

/// Forces on a joint, in the order in which their torques are added.
fn of_joint(own: &OneFreedom, armature: Option<Armature>) -> Vec<Force> {
    let mut forces = match &own.motion {
        JointMotion::Free => vec![
            Force::Motor(Motor { armature, ..Motor::default() }),
            Force::Spring(Spring::default()),
            Force::External(External::default()),
            Force::Brake(Brake),
        ],
        JointMotion::Prescribed(motion) => vec![Force::Prescribed(Law::new(motion))],
        JointMotion::Locked => vec![Force::Lock],
    };
    if let (Some(law), JointMotion::Free) = (&own.generator, &own.motion) {
        forces.push(Force::Generator(Generator {
            law: law.clone(),
            connected: law.connected,
            about_rad_s: None,
            held: None,
        }));
    }
    // before the latch, which a joint resting on a stop might not reach
    if let Some(stops) = own.end_stops {
        forces.push(Force::EndStops(TwoSidedStops { stops, contact: Contact::default() }));
    }
    if let Some(own) = &own.latch {
        let latch = Latch {
            kind: own.kind,
            angle_rad: own.angle_rad,
            stiffness_n_m_rad: own.stiffness_n_m_rad,
            capture_rad: own.capture_rad,
        };
        forces.push(Force::Latch(CatchingLatch { latch, closed: false }));
    }
    forces
}

/// Sets the forces from inputs and parameters. Allocates nothing.
pub(crate) fn set(forces: &mut Forces, inputs: &Inputs, parameters: &Parameters) {
    for (joint, (inputs, own)) in forces.joints_mut().iter_mut().zip(inputs.joints().iter().zip(parameters.joints())) {
        if let Some(motor) = joint.motor_mut() {
            motor.drive.stiffness_n_m_rad = own.stiffness_n_m_rad;
            motor.drive.damping_n_m_s_rad = own.damping_n_m_s_rad;
            motor.drive.constant_torque_n_m = own.constant_torque_n_m;
            motor.drive.torque_limit_n_m = own.torque_limit_n_m;
        }
        if let Some(spring) = joint.spring_mut() {
            spring.stiffness_n_m_rad = own.spring_stiffness_n_m_rad;
            spring.damping_n_m_s_rad = own.spring_damping_n_m_s_rad;
            spring.rest_angle_rad = own.rest_angle_rad;
        }
        if let Some(external) = joint.external_mut() {
            external.torque_n_m = inputs.torque_n_m;
        }
        if let Some(generator) = joint.generator_mut() {
            generator.connected = inputs.generator_on.is_on();
        }
        if let Some(latch) = joint.latch_mut() {
            latch.stiffness_n_m_rad = own.latch_stiffness_n_m_rad;
        }
    }
    forces.armatures_mut().zip(inputs.dc_motors()).for_each(|(armature, own)| armature.voltage_v = own.voltage_v);
    for (joint, own) in forces.spatial_mut().iter_mut().zip(parameters.spatial()) {
        if let Some(spring) = joint.attitude_mut() {
            spring.stiffness_n_m_rad = own.stiffness_n_m_rad;
            spring.damping_n_m_s_rad = own.damping_n_m_s_rad;
        }
    }
}
