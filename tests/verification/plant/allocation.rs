//! Stepping a plant allocates no memory after the first step.

use crate::counting_allocator::allocations;
use crate::plant::machines::*;
use foldwing::load::LoadFrame;
use foldwing::machine::{
    Closure, ElementKind, JointKind, JointMotion, LoopEnd, Machine, Method, Motion, SpatialFreedom,
};
use nalgebra::Vector3;

/// Allocations in a run of 0.3 s after its first step: inputs, loads, root motion and parameters change, the latch closes, opens and closes
/// again.
fn allocations_through_latches(machine: Machine) -> (u64, i32) {
    let mut plant = start(machine);
    coast(&mut plant, 1e-3);
    let before = allocations();
    for i in 2..=400 {
        let share = f64::from(i) / 400.0;
        let inputs = plant.inputs_mut();
        if i % 3 == 0 {
            for load in inputs.stations_mut() {
                load.force_n = Vector3::new(0.01, 0.02, 0.03) * share;
                load.moment_n_m = Vector3::new(1e-4, 0.0, 1e-4) * share;
            }
            inputs.root_mut().angular_velocity_rad_s = Vector3::new(0.1, 0.2, 0.3) * share;
        }
        inputs.joints_mut()[0].latch_enable = (!(200..250).contains(&i)).into();
        inputs.joints_mut()[0].command_rad = if (200..250).contains(&i) { 2.0 } else { -0.5 };
        if i == 100 {
            plant.parameters_mut().joints_mut()[0].damping_n_m_s_rad *= 1.1;
        }
        coast(&mut plant, 1e-3 * f64::from(i));
    }
    (allocations() - before, plant.outputs().latches()[0].count.get())
}

/// No method allocates in [`foldwing::plant::Plant::step`] after the first step; variable and fixed steps, real time, both
/// kinds of element, dead and follower loads, through latching twice.
#[test]
fn a01_steps_allocate_nothing() {
    for method in [Method::Esdirk4, Method::Esdirk3, Method::TrBdf2, Method::Sdirk2, Method::GeneralizedAlpha] {
        for (kind, count) in [(ElementKind::Linear, 2), (ElementKind::Constant, 5)] {
            for fixed_step_s in [None, Some(2e-4)] {
                let mut machine = wing(kind, count, method, 1e-4);
                machine.solver.fixed_step_s = fixed_step_s;
                // two iterations: some stages then do not converge
                let real_time = method == Method::Sdirk2 && fixed_step_s.is_some();
                machine.solver.most_iterations = real_time.then_some(2);
                hinge_of(&mut machine, 1).motor.rate_limit_rad_s = 30.0;
                for body in &mut machine.bodies {
                    body.station_positions_m = vec![0.05, 0.15];
                    body.stiffness_damping_s = 1e-6;
                }
                machine.bodies[1].load_frame = LoadFrame::Section;
                let (allocations, closings) = allocations_through_latches(machine);
                assert_eq!(allocations, 0, "{method:?}, {kind:?}, fixed step {fixed_step_s:?}: allocations");
                assert!(closings >= 1, "{method:?}, {kind:?}: the run must span a latch, closings: {closings}");
            }
        }
    }
}

/// The same with a prescribed joint.
#[test]
fn a02_prescribed_joint_allocates_nothing() {
    let mut machine = default_wing(1e-4);
    let knots = vec![(0.02, 2.9), (0.15, 1.0), (0.3, 0.1)];
    hinge_of(&mut machine, 1).motion = JointMotion::Prescribed(Motion::Table(knots));
    assert_eq!(allocations_through_latches(machine).0, 0, "allocations");
}

/// Allocations of a run of 0.1 s after its first millisecond, while the root spins up.
fn allocations_of(machine: Machine) -> u64 {
    let mut plant = start(machine);
    coast(&mut plant, 1e-3);
    let before = allocations();
    for i in 2..=100 {
        plant.inputs_mut().root_mut().angular_velocity_rad_s = Vector3::new(0.0, 0.0, 1e-3 * f64::from(i));
        coast(&mut plant, 1e-3 * f64::from(i));
    }
    allocations() - before
}

/// A shipped model.
fn shipped(name: &str) -> Machine {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models").join(name);
    foldwing::config::read(path).unwrap_or_else(|error| panic!("{error}")).0
}

/// The same with every other joint or body: ball, universal and free joints, a tree, a curved, twisted and tapered body, on a root
/// with increasing spin; implicit methods and explicit Runge–Kutta; also with a penalty joint that closes a loop.
#[test]
fn a03_other_joints_bodies_and_methods_allocate_nothing() {
    let universal = || {
        let mut machine = shipped("double_pendulum.toml");
        let JointKind::Spatial(elbow) = &mut machine.bodies[1].joint.kind else { panic!("a ball joint") };
        elbow.freedom = SpatialFreedom::Universal { parent_axis: Vector3::y(), body_axis: Vector3::z() };
        machine
    };
    let looped = || {
        let mut machine = shipped("double_pendulum.toml");
        machine.closures.push(Closure {
            name: "thread".into(),
            ends: [0, 1].map(|index| LoopEnd::Body { index, position_m: 0.9 }),
            offsets_m: [Vector3::zeros(); 2],
            rigid: false,
            inertia_kg: 0.1,
            damping_n_s_m: 1.0,
            stiffness_n_m: 100.0,
        });
        machine
    };
    let machines: [(&str, &dyn Fn() -> Machine); 7] = [
        ("ball", &|| shipped("double_pendulum.toml")),
        ("universal", &universal),
        ("loop", &looped),
        ("free", &|| shipped("flying_wing.toml")),
        ("curved", &|| shipped("curved_blade.toml")),
        ("tree", &|| shipped("branched.toml")),
        ("three bodies", &|| shipped("three_bodies.toml")),
    ];
    for (name, machine) in machines {
        for method in [Method::Esdirk4, Method::GeneralizedAlpha] {
            let mut machine = machine();
            machine.solver.method = method;
            assert_eq!(allocations_of(machine), 0, "{name}, {method:?}: allocations");
        }
    }
    for machine in [shipped("double_pendulum.toml"), universal()] {
        let mut machine = machine;
        machine.solver.method = Method::Rk4;
        machine.solver.fixed_step_s = Some(2e-5);
        assert_eq!(allocations_of(machine), 0, "Runge–Kutta: allocations");
    }
}

/// The same with aerodynamics: strips and lattice with its wake, prescribed and free, while the wind changes.
#[test]
fn a04_steps_in_air_allocate_nothing() {
    for air in [
        "model = \"strip\"\nstep_s = 1e-3",
        "model = \"uvlm\"\nwake_rows = 5\nreport_circulation = true",
        "model = \"uvlm\"\nwake_rows = 5\nfree_wake = true\nleading_edge_suction = true",
    ] {
        let mut text = include_str!("../../../examples/models/folding_wing.toml").to_owned();
        text += &format!("\n[aerodynamics]\nwind_m_s = [0.0, -10.0, 0.0]\n{air}\n");
        let panels = if air.contains("strip") { "" } else { "chord_panels = 2\n" };
        for body in ["inner", "outer"] {
            text += &format!("[surface.{body}]\nbody = \"{body}\"\nstrips = 3\n{panels}");
        }
        let machine = foldwing::config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
        let mut plant = start(machine);
        // through the first aerodynamic steps, in which the wake grows
        coast(&mut plant, 2e-2);
        let before = allocations();
        for i in 1..=60 {
            if i % 10 == 0 {
                *plant.inputs_mut().wind_m_s_mut() = Vector3::new(0.0, -10.0, 0.01 * f64::from(i));
            }
            coast(&mut plant, 2e-2 + 1e-3 * f64::from(i));
        }
        assert_eq!(allocations() - before, 0, "{air}");
    }
}
