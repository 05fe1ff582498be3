//! Machines for the tests, built without a model file, and functions to run them.

use foldwing::beam::section::{Material, Section};
use foldwing::machine::builder::{BodyBuilder, JointBuilder};
use foldwing::machine::*;
use foldwing::plant::{LatchOutputs, Outputs, Plant};
use nalgebra::Vector3;
use std::path::Path;
use std::sync::Arc;

/// Time integration of most tests: the default method at the given tolerance, steps up to 5 ms.
pub fn solver(method: Method, tolerance: f64) -> Solver {
    Solver { method, tolerance, min_step_s: 1e-10, ..Solver::default() }
}

/// A beam and the joint that holds it.
pub type Part = (BodyBuilder, JointBuilder);

/// A machine of bodies, without gravity, ESDIRK4 at 1e-6, for 1 s.
pub fn machine(parts: impl IntoIterator<Item = Part>) -> Machine {
    let empty = Machine::builder("test").solver(solver(Method::Esdirk4, 1e-6)).stop_time_s(1.0).step_s(1e-3);
    let whole = parts.into_iter().fold(empty, |machine, (body, joint)| machine.body(body, joint));
    whole.build().unwrap_or_else(|refused| panic!("{refused}"))
}

/// A clamp at the root's origin, along `x`.
pub fn clamped() -> JointBuilder {
    Joint::clamped("mount")
}

/// Hinge at the root's origin.
pub fn hinged_to_root(hinge: Revolute) -> JointBuilder {
    Joint::hinge("mount", hinge)
}

/// A free hinge about `y` without drive or latch.
pub fn free_hinge(start_angle_rad: f64) -> Revolute {
    Revolute { start_angle_rad, ..Revolute::about(Vector3::y()) }
}

/// A latch at zero with the given stiffness, open and enabled.
pub fn latch(stiffness_n_m_rad: f64) -> Latch {
    Latch {
        kind: LatchKind::Elastic,
        angle_rad: 0.0,
        stiffness_n_m_rad,
        capture_rad: 0.0,
        initially_closed: false,
        enable: true,
    }
}

/// A rigid latch at zero with the default window, open and enabled.
pub fn rigid_latch() -> Latch {
    Latch { kind: LatchKind::Rigid, capture_rad: DEFAULT_CAPTURE_RAD, ..latch(0.0) }
}

/// A body without damping or stations, with `count` elements of `kind`.
pub fn body(name: &str, length_m: f64, section: &Section, kind: ElementKind, count: usize) -> BodyBuilder {
    Body::beam(name, length_m, section.clone()).element(kind).elements(count).load_stations(0)
}

/// Section of the deployment experiment: Otsuka et al., Table 5; GJ of a thin strip.
pub fn wing_section() -> Section {
    let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 1e9, density_kg_m3: 1425.0 };
    Section::rectangle(0.05, 0.002, &material, Some(0.18))
}

/// Hinge of the deployment experiment with spring `k`: folded by 170°, latch of 9999 `k`.
pub fn wing_hinge(stiffness_n_m_rad: f64) -> Revolute {
    Revolute {
        motor: Motor { stiffness_n_m_rad, damping_n_m_s_rad: 0.0008, constant_torque_n_m: 0.043, ..Motor::default() },
        latch: Some(latch(9999.0 * stiffness_n_m_rad)),
        ..free_hinge(170f64.to_radians())
    }
}

/// Wing of the deployment experiment (Otsuka et al., Table 5) with `k` = 0.026 N·m/rad.
pub fn wing(kind: ElementKind, count: usize, method: Method, tolerance: f64) -> Machine {
    let half = |name| body(name, 0.15, &wing_section(), kind, count).mass_damping_1_s(2.5);
    let built = Machine::builder("test")
        .gravity_m_s2([-9.8, 0.0, 0.0])
        .body(half("inner"), clamped())
        .body(half("outer"), Joint::hinge("fold0", wing_hinge(0.026)).on("inner"))
        .mass("inner", AttachedMass::point("mass", 0.15, 0.0203))
        .gauge(Gauge::on("root", "inner", 0.02))
        .solver(solver(method, tolerance))
        .stop_time_s(1.0)
        .step_s(1e-3)
        .build();
    built.unwrap_or_else(|refused| panic!("{refused}"))
}

/// The wing with default settings: two pairs per body, ESDIRK4.
pub fn default_wing(tolerance: f64) -> Machine {
    wing(ElementKind::Linear, 2, Method::Esdirk4, tolerance)
}

/// The fold joint of body `index`.
pub fn hinge_of(machine: &mut Machine, index: usize) -> &mut Revolute {
    match &mut machine.bodies[index].joint.kind {
        JointKind::Revolute(revolute) => revolute,
        _ => panic!("the joint of body {index} is not revolute"),
    }
}

/// A plant at its start.
pub fn start(machine: Machine) -> Plant {
    start_at(machine, 0.0)
}

/// A plant at its start at a time other than zero.
pub fn start_at(machine: Machine, time_s: f64) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(time_s).expect("the machine has initial accelerations");
    plant
}

/// Continues to `end_s` in `steps` equal steps; `visit` is called with the plant before each step and its outputs afterwards.
pub fn run(
    plant: &mut Plant,
    end_s: f64,
    steps: usize,
    mut before: impl FnMut(&mut Plant),
    mut after: impl FnMut(&Outputs),
) {
    let begin_s = plant.time_s();
    for i in 1..=steps {
        before(plant);
        let time_s = begin_s + (end_s - begin_s) * i as f64 / steps as f64;
        plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        after(plant.outputs());
    }
}

/// Continues to `end_s` with constant inputs.
pub fn coast(plant: &mut Plant, end_s: f64) {
    plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
}

/// Rows of a CSV file in `tests/reference`, without its header.
pub fn reference_rows(name: &str) -> Vec<Vec<f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().expect("a number")).collect()).collect()
}

/// `expected` of a case in `tests/reference/cases.json`.
pub fn expected(case: &str) -> serde_json::Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/cases.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let cases: Vec<serde_json::Value> = serde_json::from_str(&text).expect("an array of cases");
    let found = cases.into_iter().find(|entry| entry["name"] == case);
    found.unwrap_or_else(|| panic!("no case {case}"))["expected"].clone()
}

/// Conserved quantity: `total − work + dissipated` in J.
pub fn balance_j(outputs: &Outputs) -> f64 {
    outputs.energy().total - outputs.energy().work + outputs.energy().dissipated
}

/// The latch of the first revolute or prismatic joint.
pub fn latch_of(plant: &Plant) -> LatchOutputs {
    plant.outputs().latches()[0]
}
