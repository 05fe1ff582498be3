//! Loops closed on the root: against a rigid body clamped to the root, and against closed forms of a propped beam.

use crate::plant::machines::*;
use foldwing::beam::section::{Material, Section};
use foldwing::interface::Interface;
use foldwing::machine::builder::{ClosureBuilder, MachineBuilder};
use foldwing::machine::*;
use foldwing::plant::{Holding, Plant};
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The strut's foot on the root in m.
const FOOT_M: [f64; 3] = [0.1, 0.05, -0.3];

fn plate() -> Section {
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: 1400.0 };
    Section::rectangle(0.05, 0.004, &material, None)
}

/// A wing on a hinge with a folding outer part, and a strut from the wing to the root. The strut's foot is attached to the root or, with
/// `end = "block"`, to a block that is clamped to the root at the same position. Both machines contain the block.
fn braced(end: &str, order: [usize; 2], inertia_kg: f64) -> MachineBuilder {
    let along = Vector3::from(FOOT_M) - Vector3::new(0.3, 0.0, 0.0);
    let x = along.normalize();
    let z = x.cross(&Vector3::y()).normalize();
    let mount = Matrix3::from_columns(&[x, z.cross(&x), z]);
    let foot = if end == "root" { FOOT_M } else { [0.0; 3] };
    let pin: ClosureBuilder = Closure::between("foot", order.map(|side| ["strut", end][side]), 2e4)
        .positions_m(order.map(|side| [along.norm(), 0.0][side]))
        .offsets_m(order.map(|side| [[0.0; 3], foot][side]))
        .damping_n_s_m(2.0)
        .inertia_kg(inertia_kg);
    let motor = Motor { constant_torque_n_m: 0.1, ..Motor::default() };
    let fold =
        Revolute { motor, spring: Some(Spring { stiffness_n_m_rad: 3.0, ..Spring::default() }), ..free_hinge(0.4) };
    let block = Matrix3::from_diagonal(&Vector3::new(0.003, 0.002, 0.004));
    Machine::builder("braced")
        .gravity_m_s2([0.0, 0.0, -9.8])
        .body(body("inner", 0.3, &plate(), ElementKind::Linear, 1), hinged_to_root(free_hinge(0.0)))
        .body(body("outer", 0.2, &plate(), ElementKind::Linear, 1), Joint::hinge("fold", fold).on("inner"))
        .body(
            body("strut", along.norm(), &plate(), ElementKind::Constant, 2),
            Joint::universal("head", Vector3::y(), Vector3::z()).on("inner").mount(mount),
        )
        .body(Body::rigid("block").inertia(0.4, [0.01, 0.0, 0.02], block), Joint::clamped("weld").at_root(FOOT_M))
        .closure(pin)
        .solver(solver(Method::Esdirk4, 1e-8))
        .stop_time_s(1.0)
        .step_s(1e-3)
}

fn built(builder: MachineBuilder) -> Machine {
    builder.build().unwrap_or_else(|refused| panic!("{refused}"))
}

/// LP-01. A loop on the root is equivalent to a loop on a body clamped to the root, in motion, while the root accelerates and rotates at
/// varying rates: all outputs agree, including those of the loop, the root and the energy accounts; with and without inertia, and with the
/// root as the first or the second point.
///
/// The two machines differ only in the arithmetic of the foot: 1e-9 of the largest output of the same kind after 0.2 s.
#[test]
fn lp01_a_loop_on_the_root_is_one_on_a_body_clamped_to_it() {
    for (order, inertia_kg) in [([0, 1], 0.0), ([1, 0], 0.02)] {
        let [mut own, mut other] = ["root", "block"].map(|end| start(built(braced(end, order, inertia_kg))));
        let (mut worst, mut pull_n, mut work_j) = (0.0f64, 0.0f64, 0.0f64);
        for step in 1..=100 {
            let time_s = 2e-3 * f64::from(step);
            for plant in [&mut own, &mut other] {
                let root = plant.inputs_mut().root_mut();
                root.acceleration_m_s2 = Vector3::new(3.0, -2.0, 8.0) * (9.0 * time_s).sin();
                root.angular_velocity_rad_s = Vector3::new(1.0, 2.0, -1.0) * (1.0 - (7.0 * time_s).cos());
                root.angular_acceleration_rad_s2 = Vector3::new(1.0, 2.0, -1.0) * (7.0 * (7.0 * time_s).sin());
                plant.step(time_s).expect("a step");
            }
            let layout = *own.outputs().layout();
            let (values, expected) = (own.outputs().values(), other.outputs().values());
            for range in [
                layout.joints.range(),
                layout.tips.range(),
                layout.loops.range(),
                layout.root.range(),
                layout.energy.range(),
            ] {
                let size = expected[range.clone()].iter().fold(1e-3f64, |size, value| size.max(value.abs()));
                let miss = range.map(|i| (values[i] - expected[i]).abs()).fold(0.0, f64::max) / size;
                worst = worst.max(miss);
            }
            pull_n = pull_n.max(own.outputs().loops()[0].force_n.norm());
            work_j = work_j.max(own.outputs().energy().work.abs());
        }
        println!("LP-01 inertia {inertia_kg} kg: {worst:.1e}; force up to {pull_n:.2} N, work up to {work_j:.3} J");
        assert!(pull_n > 1.0 && work_j > 0.1, "the strut carries {pull_n} N, the root works {work_j} J");
        assert!(worst < 1e-9, "inertia {inertia_kg} kg: {worst:.1e}");
    }
}

/// LP-02. The comparison of LP-01 in equilibrium: shape, modes and linear model (frequency response of all outputs; both machines have the
/// same coordinates). Tolerances 1e-9 and 1e-8.
#[test]
fn lp02_equilibrium_and_linear_model_with_a_loop_on_the_root() {
    let settled = |end: &str| {
        let mut plant = Plant::new(Arc::new(built(braced(end, [0, 1], 0.02))));
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{end}: {error}"));
        plant
    };
    let [mut own, mut other] = ["root", "block"].map(settled);
    let pair = [&own, &other].map(|plant| plant.outputs().loops()[0]);
    assert!(pair[0].force_n.norm() > 1.0, "{:?}", pair[0].force_n);
    assert!((pair[0].force_n - pair[1].force_n).norm() < 1e-9 * pair[1].force_n.norm());
    let weight_n = own.mass_kg() * 9.8;
    let root_n = own.outputs().root().force_n;
    assert!((root_n + Vector3::z() * weight_n).norm() < 1e-8 * weight_n, "{root_n:?} N for {weight_n} N");

    let modes = [&mut own, &mut other].map(|plant| plant.study().modes(4).expect("has modes"));
    for (mode, expected) in modes[0].iter().zip(&modes[1]) {
        let miss = (mode.eigenvalue_1_s - expected.eigenvalue_1_s).norm() / expected.eigenvalue_1_s.norm();
        println!("LP-02 mode {:.4} Hz: {miss:.1e}", expected.eigenvalue_1_s.im / TAU);
        assert!(miss < 1e-8, "{miss:.1e}");
    }
    let linear = [&mut own, &mut other].map(|plant| {
        let interface = Interface::new(plant.machine());
        let inputs: Vec<_> = interface.real_inputs().collect();
        // in one of the machines the weld of the block transmits the loop force
        let outputs: Vec<_> = interface.real_outputs().filter(|row| !row.name.starts_with("weld.")).collect();
        interface.linearize(plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}")).matrices
    });
    let miss = |own: &DMatrix<f64>, other: &DMatrix<f64>| (own - other).amax() / other.amax();
    let [own, other] = &linear;
    let misses = [miss(&own.a, &other.a), miss(&own.b, &other.b), miss(&own.c, &other.c), miss(&own.d, &other.d)];
    println!("LP-02 A, B, C, D: {misses:.1?}");
    assert!(misses.iter().all(|miss| *miss < 1e-8), "{misses:?}");
}

/// Span in m, and elements, of the propped beam.
const SPAN_M: f64 = 1.0;
const ELEMENTS: usize = 12;
/// Stiffness of the prop in N/m.
const PROP_N_M: f64 = 1e7;

fn propped() -> Machine {
    let prop = Closure::between("prop", ["beam", "root"], PROP_N_M).offsets_m([[0.0; 3], [SPAN_M, 0.0, 0.0]]);
    built(
        Machine::builder("propped")
            .body(body("beam", SPAN_M, &plate(), ElementKind::Linear, ELEMENTS), clamped())
            .closure(prop)
            .solver(solver(Method::Esdirk4, 1e-10))
            .stop_time_s(1.0)
            .step_s(1e-3),
    )
}

/// LP-03. Propped cantilever of length L under a small uniform load w due to the acceleration of the root: the prop carries R = 3wL/8
/// divided by 1 + 3EI/(kL³), because of its own stiffness k; prop and clamp together transmit the whole load to the root; the moment at the
/// clamp is RL − wL²/2. Modes of the beam: tan βL = tanh βL.
///
/// At a load of 1e-6 g the beam is linear, and its axial strain is negligible; 24 elements: 2e-5. The modes agree to 1e-4: rotary inertia,
/// (h/L)²/12 with h/L = 4e-3, changes them by 1.3e-6·(βL)².
#[test]
fn lp03_propped_cantilever() {
    let section = plate();
    let (line_kg_m, flap_n_m2) = (section.mass_kg_m, section.stiffness[(2, 2)]);
    let mut plant = Plant::new(Arc::new(propped()));
    let acceleration_m_s2 = 1e-5;
    plant.inputs_mut().root_mut().acceleration_m_s2.z = acceleration_m_s2;
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let load_n_m = line_kg_m * acceleration_m_s2;
    let give = 3.0 * flap_n_m2 / (PROP_N_M * SPAN_M.powi(3));
    let prop_n = 0.375 * load_n_m * SPAN_M / (1.0 + give);
    let outputs = plant.outputs();
    // the first point is on the beam: the prop pushes it in the direction of the acceleration
    let found_n = outputs.loops()[0].force_n.z;
    let miss = (found_n / prop_n - 1.0).abs();
    println!("LP-03 prop {found_n:.6e} N for {prop_n:.6e} N, off by {miss:.1e}");
    assert!(miss < 2e-5, "{miss:.1e}");
    let root = outputs.root();
    assert!((root.force_n.z / (-load_n_m * SPAN_M) - 1.0).abs() < 1e-9, "{:?} N", root.force_n);
    // about the origin: loads of the whole machine, whatever carries them
    assert!((root.moment_n_m.y / (0.5 * load_n_m * SPAN_M * SPAN_M) - 1.0).abs() < 1e-6, "{:?} N m", root.moment_n_m);
    let clamp_n = outputs.joint_reactions()[0].force_n.z;
    assert!((clamp_n / (load_n_m * SPAN_M - prop_n) - 1.0).abs() < 2e-5, "{clamp_n} N");

    plant.inputs_mut().root_mut().acceleration_m_s2.z = 0.0;
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let modes = plant.study().modes(2).expect("has modes");
    for (mode, beta) in modes.iter().zip([3.926_602_312, 7.068_582_746]) {
        let expected = beta * beta * (flap_n_m2 / line_kg_m).sqrt() / (SPAN_M * SPAN_M);
        let miss = (mode.eigenvalue_1_s.im / expected - 1.0).abs();
        println!("LP-03 mode {expected:.4} rad/s: {miss:.1e}");
        assert!(miss < 3e-4, "{} for {expected} rad/s", mode.eigenvalue_1_s);
    }
}

/// LP-04. A free rigid body connected to the root only by a loop of low stiffness with a damper: the oscillation of its mass and the root
/// force, in closed form. The root force of this flying body is the force of the loop.
#[test]
fn lp04_a_flying_body_tied_to_the_root() {
    let (mass_kg, stiffness_n_m, damping_n_s_m) = (2.0, 50.0, 1.5);
    let tied = Machine::builder("tied")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(
            Body::rigid("bob").inertia(mass_kg, [0.0; 3], Matrix3::identity() * 0.1),
            Joint::free("flight").at_root([0.2, 0.1, 0.4]),
        )
        .closure(
            Closure::between("tie", ["root", "bob"], stiffness_n_m)
                .offsets_m([[0.2, 0.1, 0.4], [0.0; 3]])
                .damping_n_s_m(damping_n_s_m),
        )
        .solver(solver(Method::Esdirk4, 1e-10))
        .stop_time_s(1.0)
        .step_s(1e-3);
    let mut plant = start(built(tied));
    let balance = balance_j(plant.outputs());
    let decay = 0.5 * damping_n_s_m / mass_kg;
    let ring = (stiffness_n_m / mass_kg - decay * decay).sqrt();
    let sag_m = 9.81 * mass_kg / stiffness_n_m;
    for step in 1..=50 {
        let t = 0.02 * f64::from(step);
        plant.step(t).expect("a step");
        let expected_m = -sag_m * (1.0 - (-decay * t).exp() * ((ring * t).cos() + decay / ring * (ring * t).sin()));
        let outputs = plant.outputs();
        let gap_m = outputs.loops()[0].gap_m;
        assert!((gap_m - Vector3::z() * expected_m).norm() < 1e-8, "{gap_m:?} m for {expected_m} m at {t} s");
        // the first point is on the root
        assert!((outputs.root().force_n - outputs.loops()[0].force_n).norm() < 1e-12, "{:?} N", outputs.root().force_n);
        let arm_m = Vector3::new(0.2, 0.1, 0.4);
        let moment_n_m = arm_m.cross(&outputs.root().force_n);
        assert!((outputs.root().moment_n_m - moment_n_m).norm() < 1e-12);
        assert!((balance_j(outputs) - balance).abs() < 1e-8);
    }
}

/// LP-05. A loop on the root that breaks: from then on the strut's foot is free, the loop exerts no force on the root, and the energy
/// balance still closes.
#[test]
fn lp05_a_loop_on_the_root_breaks() {
    let snap = Failure::loop_break("snap", "foot", 0.0).at_time_s(0.0503);
    let mut plant = start(built(braced("root", [0, 1], 0.0).failure(snap)));
    let begin_j = balance_j(plant.outputs());
    for step in 1..=100 {
        let time_s = 2e-3 * f64::from(step);
        plant.step(time_s).expect("a step");
        let outputs = plant.outputs();
        let drift_j = (balance_j(outputs) - begin_j).abs();
        // 1e-5 of the kinetic energy of up to 1 J, as P-69
        assert!(drift_j < 1e-5, "drift {drift_j:.1e} J at {time_s} s");
        let pull_n = outputs.loops()[0].force_n.norm();
        assert!(if time_s < 0.0503 { pull_n > 0.1 } else { pull_n == 0.0 }, "{pull_n} N at {time_s} s");
        // the root carries the joints on it and, before it breaks, the loop
        let joints: Vector3<f64> = [0, 3].map(|joint| outputs.joint_reactions()[joint].force_n).iter().sum();
        let sum = outputs.root().force_n + joints + outputs.loops()[0].force_n;
        assert!(sum.norm() < 1e-9, "{sum:?} N at {time_s} s");
    }
    let gap_m = plant.outputs().loops()[0].gap_m.norm();
    assert!(gap_m > 0.01, "gap {gap_m} m");
}
