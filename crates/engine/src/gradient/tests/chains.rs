//! Gradients of machines with cylindrical joints.

use super::folding::{agree, flap, hold, without};
use super::*;
use crate::machine::LinearSpring;
use crate::machine::builder::BodyBuilder;
use crate::system::JointOutputs;
use nalgebra::Matrix3;
use std::mem::offset_of;

fn beam(numbers: Numbers, name: &str, length_m: f64) -> BodyBuilder {
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: numbers.density };
    Body::beam(name, length_m, Solid::rectangle(0.05, numbers.thickness, material))
        .elements(2)
        .stiffness_damping_s(numbers.beta)
        .load_stations(1)
}

/// A beam on a hinge, and a body that turns on it until a latch catches it, and slides on a spring and a damper.
fn telescope(numbers: Numbers) -> Result<Machine, String> {
    let latch = Latch::with_stiffness_n_m_rad(numbers.latch_stiffness).angle_rad(0.7 + 0.2 * numbers.latch_angle);
    let spring = LinearSpring {
        stiffness_n_m: 100.0 * numbers.stiffness,
        damping_n_s_m: 10.0 * numbers.damping,
        rest_position_m: 0.1 * numbers.torque,
    };
    let strut = Joint::cylindrical("strut", [1.0, 0.1, 0.0])
        .on("inner")
        .offset_m([0.01, 0.0, 0.005])
        .translation(|own| own.spring(spring).start_position_m(0.02).start_rate_m_s(0.1 * numbers.start_rate))
        .rotation(|own| {
            own.motor(hold(numbers))
                .start_angle_rad(numbers.start_angle)
                .start_rate_rad_s(10.0 * numbers.start_rate)
                .latch(latch.capture_rad(0.01))
        });
    let wrench = crate::load::Wrench { force_n: [0.0, 0.0, numbers.load].into(), ..Default::default() };
    let outer = Body::rigid("outer").inertia(numbers.mass, [0.1, 0.02, 0.01], Matrix3::identity() * 1e-3);
    Machine::builder("Telescope")
        .gravity_m_s2([0.0, 0.5, -9.81])
        .body(beam(numbers, "inner", numbers.length), flap())
        .body(outer, strut)
        .load("pull", "inner", 1, wrench)
        .gauge(Gauge::on("root", "inner", 0.05))
        // reactions contain the remainder of the iteration
        .solver(Solver { tolerance: 1e-12, ..solver() })
        .build()
        .map_err(|refused| refused.to_string())
}

/// Position, angle and rates of the joint, strain, reaction and energy at both times, and the time of the latch.
fn results(plant: &Plant) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let joint = |joint, offset| layout.joints.place(joint, offset);
    let indices = [
        joint(1, offset_of!(JointOutputs, angle_rad)),
        joint(1, offset_of!(JointOutputs, rate_rad_s)),
        joint(2, offset_of!(JointOutputs, angle_rad)),
        joint(2, offset_of!(JointOutputs, rate_rad_s)),
        layout.gauges.place(0, 0),
        layout.energy.place(0, 0),
        layout.root.place(0, 0) + 2,
    ];
    let outputs = (0..2).flat_map(|time| indices.map(move |index| RunResult::Output { index, time }));
    outputs.chain([RunResult::LatchTime { joint: 2 }]).collect()
}

/// CJ-12. Gradients of a run with a cylindrical joint on a flexible body, through the latch of its rotation, elastic and rigid.
#[test]
fn cj12_gradients_of_a_cylindrical_joint() {
    let places = without(&["stop", "command"]);
    let compared = compare_results(telescope, &InputRows::default(), &places, results);
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "cylindrical joint, elastic latch");
    let rigid = |numbers: Numbers| {
        let mut machine = telescope(numbers)?;
        let JointKind::Revolute(rotation) = &mut machine.bodies[2].joint.kind else { return Err("no rotation".into()) };
        let latch = rotation.latch.as_mut().ok_or("no latch")?;
        (latch.kind, latch.stiffness_n_m_rad) = (LatchKind::Rigid, 0.0);
        Ok(machine)
    };
    let places = without(&["stop", "command", "latch_stiffness"]);
    let compared = compare_results(rigid, &InputRows::default(), &places, results);
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "cylindrical joint, rigid latch");
}
