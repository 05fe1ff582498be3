//! The shipped folding wing built in Rust: the same machine as its file, and a bit-identical run.

use crate::model_file::{repository, shipped_models};
use foldwing::beam::section::{Material, Solid};
use foldwing::config;
use foldwing::machine::{AttachedMass, Body, Gauge, Joint, Latch, Machine, Motor};
use foldwing::plant::Plant;
use std::sync::Arc;

/// `examples/models/folding_wing.toml` in code.
pub fn folding_wing() -> Machine {
    let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 0.0, density_kg_m3: 1425.0 };
    let plate = Solid::rectangle(0.05, 0.002, material).with_torsional_rigidity_n_m2(0.18);
    let half = |name| Body::beam(name, 0.15, plate).elements(4).mass_damping_1_s(2.5);
    let drive =
        Motor { stiffness_n_m_rad: 0.026, damping_n_m_s_rad: 0.0008, constant_torque_n_m: 0.043, ..Motor::default() };
    let fold = Joint::revolute("fold", [0.0, 1.0, 0.0])
        .on("inner")
        .start_angle_rad(170f64.to_radians())
        .motor(drive)
        .latch(Latch::with_ratio(1e4));
    Machine::builder("FoldingWing")
        .description("Folding wing that unfolds and latches without air")
        .gravity_m_s2([-9.8, 0.0, 0.0])
        .body(half("inner"), Joint::clamped("mount"))
        .body(half("outer"), fold)
        .mass("inner", AttachedMass::point("actuator", 0.15, 0.0203))
        .gauge(Gauge::on("root", "inner", 0.02))
        .build()
        .unwrap_or_else(|refused| panic!("{refused}"))
}

/// M-04: the whole description with every field, and every output of the deployment and latching.
#[test]
fn folding_wing_in_code_is_that_of_the_file() {
    let path = repository().join("examples/models/folding_wing.toml");
    let from_file = config::read(path).unwrap_or_else(|error| panic!("{error}")).0;
    let from_code = folding_wing();
    assert_eq!(from_code, from_file);
    let [mut file, mut code] = [from_file, from_code].map(|machine| {
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant
    });
    for step in 1..=15 {
        let end_s = 0.01 * f64::from(step);
        for plant in [&mut file, &mut code] {
            plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
        }
        // equal texts of numbers mean equal bits; −0 and 0 are distinct
        assert_eq!(format!("{:?}", code.outputs()), format!("{:?}", file.outputs()), "at {end_s} s");
    }
    assert!(code.outputs().latches()[0].closed.is_on(), "the wing has latched, so that the run saw the latch");
}

/// Machines from files have passed the checks of the reader; this tests that they also pass the checks without a file.
#[test]
fn shipped_machines_are_sound() {
    for model in shipped_models() {
        let (machine, _) = config::read(&model).unwrap_or_else(|error| panic!("{error}"));
        let faults: Vec<String> = machine.validate().iter().map(ToString::to_string).collect();
        assert!(faults.is_empty(), "{}: {faults:?}", model.display());
    }
}
