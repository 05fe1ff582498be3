//! Machines for the tests, built without the model file, and ways to run them.

use foldwing::beam::section::{Material, Section};
use foldwing::load::LoadFrame;
use foldwing::machine::*;
use foldwing::plant::{Outputs, Plant};
use nalgebra::{Matrix3, Vector3};
use std::path::Path;
use std::sync::Arc;

/// Time integration of most tests: the default method at the tolerance given, steps up to 5 ms.
pub fn solver(method: Method, tolerance: f64) -> Solver {
    Solver {
        method,
        tolerance,
        max_step_s: 5e-3,
        min_step_s: 1e-10,
        fixed_step_s: None,
        rho_infinity: 0.8,
        most_iterations: None,
    }
}

/// A machine of bodies, without gravity, ESDIRK4 at 1e-6.
pub fn machine(bodies: Vec<Body>) -> Machine {
    Machine {
        name: "test".into(),
        description: String::new(),
        bodies,
        closures: Vec::new(),
        air: None,
        gauges: Vec::new(),
        gravity_m_s2: Vector3::zeros(),
        solver: solver(Method::Esdirk4, 1e-6),
        experiment: Experiment { start_time_s: 0.0, stop_time_s: 1.0, step_s: 1e-3, start: StartState::Unstrained },
    }
}

/// Clamped at the root's origin along `x`.
pub fn clamped() -> Joint {
    Joint {
        name: "mount".into(),
        parent: Parent::Root { position_m: Vector3::zeros() },
        mount: Matrix3::identity(),
        kind: JointKind::Clamped,
    }
}

/// Hinge about `axis` at the end of body `parent`.
pub fn hinged_to(parent: &[Body], revolute: Revolute) -> Joint {
    let index = parent.len() - 1;
    Joint {
        name: format!("fold{index}"),
        parent: Parent::Body { index, position_m: parent[index].length_m },
        mount: Matrix3::identity(),
        kind: JointKind::Revolute(Box::new(revolute)),
    }
}

/// Hinge at the root's origin.
pub fn hinged_to_root(revolute: Revolute) -> Joint {
    Joint { kind: JointKind::Revolute(Box::new(revolute)), ..clamped() }
}

/// A drive that does nothing.
pub fn no_drive() -> Drive {
    Drive {
        stiffness_n_m_rad: 0.0,
        damping_n_m_s_rad: 0.0,
        constant_torque_n_m: 0.0,
        torque_limit_n_m: UNLIMITED,
        rate_limit_rad_s: UNLIMITED,
        inertia_kg_m2: 0.0,
        command_rad: 0.0,
    }
}

/// A free hinge about `y` without drive or latch.
pub fn free_hinge(start_angle_rad: f64) -> Revolute {
    Revolute {
        axis: Vector3::y(),
        start_angle_rad,
        start_rate_rad_s: 0.0,
        motion: JointMotion::Free,
        release: true,
        drive: no_drive(),
        spring: None,
        latch: None,
    }
}

/// A latch at zero of the stiffness given, open and enabled.
pub fn latch(stiffness_n_m_rad: f64) -> Latch {
    Latch { angle_rad: 0.0, stiffness_n_m_rad, capture_rad: 0.0, initially_closed: false, enable: true }
}

/// A body without damping, stations or masses: `count` elements of `kind`.
pub fn body(name: &str, length_m: f64, section: &Section, kind: ElementKind, count: usize, joint: Joint) -> Body {
    Body {
        name: name.into(),
        length_m,
        section: section.clone().into(),
        element: kind,
        elements: count,
        natural_strain: [0.0; 4].into(),
        mass_damping_1_s: 0.0,
        damp_attached_masses: false,
        stiffness_damping_s: 0.0,
        station_positions_m: Vec::new(),
        station_loads: Vec::new(),
        load_frame: LoadFrame::Root,
        masses: Vec::new(),
        joint,
    }
}

/// Section of the deployment experiment: Otsuka et al., Table 5; GJ of a thin strip.
pub fn wing_section() -> Section {
    let material = Material { young_pa: 2.83e9, shear_pa: 1e9, density_kg_m3: 1425.0 };
    Section::rectangle(0.05, 0.002, &material, Some(0.18))
}

/// Hinge of the deployment experiment with spring `k`: folded by 170°, latch of 9999 `k`.
pub fn wing_hinge(stiffness_n_m_rad: f64) -> Revolute {
    Revolute {
        drive: Drive { stiffness_n_m_rad, damping_n_m_s_rad: 0.0008, constant_torque_n_m: 0.043, ..no_drive() },
        latch: Some(latch(9999.0 * stiffness_n_m_rad)),
        ..free_hinge(170f64.to_radians())
    }
}

/// Wing of the deployment experiment (Otsuka et al., Table 5) with `k` = 0.026 N·m/rad.
pub fn wing(kind: ElementKind, count: usize, method: Method, tolerance: f64) -> Machine {
    let section = wing_section();
    let mut inner = body("inner", 0.15, &section, kind, count, clamped());
    inner.mass_damping_1_s = 2.5;
    inner.masses = vec![point_mass(0.15, 0.0203)];
    let mut bodies = vec![inner];
    let mut outer = body("outer", 0.15, &section, kind, count, hinged_to(&bodies, wing_hinge(0.026)));
    outer.mass_damping_1_s = 2.5;
    bodies.push(outer);
    Machine {
        closures: Vec::new(),
        air: None,
        gauges: vec![Gauge::axial("root", 0, 0.02, [0.0, 0.001])],
        gravity_m_s2: Vector3::new(-9.8, 0.0, 0.0),
        solver: solver(method, tolerance),
        ..machine(bodies)
    }
}

/// The default: two pairs per body, ESDIRK4.
pub fn default_wing(tolerance: f64) -> Machine {
    wing(ElementKind::Linear, 2, Method::Esdirk4, tolerance)
}

/// A point mass on the axis.
pub fn point_mass(position_m: f64, mass_kg: f64) -> AttachedMass {
    AttachedMass {
        name: "mass".into(),
        position_m,
        mass_kg,
        offset_m: Vector3::zeros(),
        inertia_kg_m2: Matrix3::zeros(),
    }
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

/// Goes on to `end_s` in `steps` equal steps; `visit` sees the plant before each step and its outputs afterwards.
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

/// Goes on to `end_s` with constant inputs.
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

/// What must stay constant: `total − work + dissipated` in J.
pub fn balance_j(outputs: &Outputs) -> f64 {
    outputs.energy.total - outputs.energy.work + outputs.energy.dissipated
}
