//! Sliding joints: bodies that ride on a beam that deforms, against Exudyn, closed forms and the balance of momenta and energy.

use crate::counting_allocator::allocations;
use crate::plant::machines::*;
use foldwing::beam::section::Section;
use foldwing::machine::builder::{BodyBuilder, JointBuilder};
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Section of 0.5 kg/m with the given `EA` and `EI`, and a rotary inertia that is negligible but not zero, so that twist has inertia.
pub fn slender(ea_n: f64, ei_n_m2: f64, rotary_kg_m: f64) -> Section {
    Section {
        shear: None,
        stiffness: Matrix4::from_diagonal(&Vector4::new(ea_n, ei_n_m2, ei_n_m2, ei_n_m2)),
        mass_kg_m: 0.5,
        first_moment_kg: [0.0, 0.0],
        second_moment_kg_m: [0.5 * rotary_kg_m, 0.0, 0.5 * rotary_kg_m],
        half_width_m: 0.01,
        half_height_m: 0.01,
    }
}

/// A machine of a beam and a body that slides along it.
pub fn rail(
    beam: (BodyBuilder, JointBuilder),
    rider: (BodyBuilder, JointBuilder),
    masses: &[(&str, AttachedMass)],
) -> Machine {
    let mut built = Machine::builder("rail").body(beam.0, beam.1).body(rider.0, rider.1);
    for (body, mass) in masses {
        built = built.mass(*body, mass.clone());
    }
    let built = built.solver(solver(Method::Esdirk4, 1e-7)).stop_time_s(1.0).step_s(1e-2).build();
    built.unwrap_or_else(|refused| panic!("{refused}"))
}

/// The free slider of SJ-01 with `pairs` linear elements.
fn bead(pairs: usize, tolerance: f64) -> Machine {
    let beam = body("beam", 1.0, &slender(1e4, 1.0, 1e-7), ElementKind::Linear, pairs);
    let joint = Joint::sliding("slide").on("beam").start_position_m(0.25);
    let mass = AttachedMass::point("mass", 0.0, 0.1);
    let mut machine = rail((beam, clamped()), (Body::rigid("bead"), joint), &[("bead", mass)]);
    machine.gravity_m_s2 = Vector3::new(4.905, 0.0, -8.4957);
    machine.solver.tolerance = tolerance;
    machine
}

/// The bead of SJ-01 with `pairs` linear elements: largest distances of tip and bead from Exudyn's over 0.42 s in m, and the plant at the end.
fn against_exudyn(pairs: usize) -> ([f64; 2], Plant) {
    let mut plant = start(bead(pairs, 1e-7));
    let mut largest_m = [0.0f64; 2];
    for row in reference_rows("sliding/slider_exudyn.csv").iter().skip(1).filter(|row| row[0] < 0.4201) {
        coast(&mut plant, row[0]);
        for (tip, (largest, at)) in plant.outputs().tips().iter().zip(largest_m.iter_mut().zip([1, 3])) {
            *largest = largest.max((tip.position_m - Vector3::new(row[at], 0.0, row[at + 1])).norm());
        }
    }
    (largest_m, plant)
}

/// SJ-01. A point mass slides without friction along a cantilever that deflects by 0.65 of its length, compared with Exudyn (32 ANCF
/// cables, sliding joint, 0.25 ms; its own error is 5e-5 m). For an independent program with the same coordinates as here, the position of
/// the mass differs by 2.3e-3, 6.2e-4, 1.8e-4 and 8.5e-5 m with 2, 3, 4 and 6 pairs, and the energy lost at element boundaries is 2.6e-8,
/// 5.8e-11, 5.6e-12 and 6.6e-14 J.
#[test]
fn sj01_a_bead_slides_down_a_flexible_beam() {
    let mut bead_m = Vec::new();
    for (pairs, limits_m, lost_j) in [
        (2, [2.5e-3, 2.5e-3], 2.60e-8),
        (3, [1e-3, 1e-3], 5.83e-11),
        (4, [1e-3, 1e-3], 5.66e-12),
        (8, [1e-4, 1e-4], 0.0),
    ] {
        let (largest_m, plant) = against_exudyn(pairs);
        let lost = plant.outputs().energy().dissipated;
        println!("SJ-01 {pairs} pairs: tip {:.2e} m, bead {:.2e} m, lost {lost:.2e} J", largest_m[0], largest_m[1]);
        assert!(largest_m[0] < limits_m[0] && largest_m[1] < limits_m[1], "{pairs} pairs: {largest_m:?} m");
        assert!((lost - lost_j).abs() < 0.01 * lost_j + 1e-13, "{pairs} pairs: {lost:e} J");
        bead_m.push(largest_m[1]);
    }
    let order = (bead_m[0] / bead_m[2]).ln() / 2f64.ln();
    println!("SJ-01 order from 2 to 4 pairs {order:.2}");
    assert!(order > 2.0);
}

/// Modes of a cantilever of length 1 m that are taken into account.
const MODES: usize = 10;

/// Deflection of the tip of a cantilever of 0.5 kg/m and 2 N·m² every 0.02 s, under a force of 0.05 · 0.0981 N and a mass that move from the
/// root to the tip at 1 m/s: modal equations with the inertia of the mass, `M (ẅ + 2 v ẇ' + v² w'')`, by Runge–Kutta steps of 0.1 ms.
pub fn modal_tip_m(mass_kg: f64) -> Vec<f64> {
    let roots: [f64; MODES] = std::array::from_fn(|n| {
        let characteristic = |b: f64| b.cos() + 1.0 / b.cosh();
        let middle = (n as f64 + 0.5) * std::f64::consts::PI;
        let (mut low, mut high) = (middle - 0.4, middle + 0.4);
        for _ in 0..60 {
            let b = 0.5 * (low + high);
            if characteristic(b) * characteristic(low) > 0.0 { low = b } else { high = b }
        }
        0.5 * (low + high)
    });
    // shape and its slopes: w = cosh bx − cos bx − σ (sinh bx − sin bx), in a form without cancellation
    let shape = |b: f64, x: f64, slope: i32| -> f64 {
        let sigma = (b.cos() + b.cosh()) / (b.sin() + b.sinh());
        let grows = (1.0 - sigma) * (b * x).exp() / 2.0;
        let decays = (1.0 + sigma) * (-b * x).exp() / 2.0 * if slope == 1 { -1.0 } else { 1.0 };
        let (sin, cos) = (b * x).sin_cos();
        let swings = match slope {
            0 => -cos + sigma * sin,
            1 => sin + sigma * cos,
            _ => cos - sigma * sin,
        };
        (grows + decays + swings) * b.powi(slope)
    };
    type Modes = nalgebra::SVector<f64, MODES>;
    let stiffness = Modes::from_fn(|n, _| 2.0 * roots[n].powi(4));
    let acceleration = |time_s: f64, w: &Modes, v: &Modes| -> Modes {
        let at = |slope| Modes::from_fn(|n, _| shape(roots[n], time_s, slope));
        let [own, first, second] = [at(0), at(1), at(2)];
        let carried = 0.05 * 0.0981 + mass_kg * (2.0 * first.dot(v) + second.dot(w));
        let free = -(stiffness.component_mul(w) + own * carried) / 0.5;
        // (0.5 + M φ φᵀ)⁻¹ by Sherman and Morrison
        free - own * (mass_kg * own.dot(&free) / (0.5 + mass_kg * own.norm_squared()))
    };
    let (mut w, mut v, step_s) = (Modes::zeros(), Modes::zeros(), 1e-4);
    let mut tips_m = Vec::new();
    for step in 0..9800 {
        let time_s = f64::from(step) * step_s;
        let (v1, a1) = (v, acceleration(time_s, &w, &v));
        let (w2, v2) = (w + v1 * (0.5 * step_s), v + a1 * (0.5 * step_s));
        let a2 = acceleration(time_s + 0.5 * step_s, &w2, &v2);
        let (w3, v3) = (w + v2 * (0.5 * step_s), v + a2 * (0.5 * step_s));
        let a3 = acceleration(time_s + 0.5 * step_s, &w3, &v3);
        let (w4, v4) = (w + v3 * step_s, v + a3 * step_s);
        let a4 = acceleration(time_s + step_s, &w4, &v4);
        w += (v1 + (v2 + v3) * 2.0 + v4) * (step_s / 6.0);
        v += (a1 + (a2 + a3) * 2.0 + a4) * (step_s / 6.0);
        if (step + 1) % 200 == 0 {
            tips_m.push(w.iter().zip(roots).map(|(w, b)| w * shape(b, 1.0, 0)).sum());
        }
    }
    tips_m
}

/// A cantilever of 16 pairs with a body that moves at 1 m/s from its root to its tip, with the force of [`modal_tip_m`] and the given mass:
/// largest difference of the tip over 0.98 s, divided by its largest deflection.
fn moving_load(mass_kg: f64) -> f64 {
    let beam = body("beam", 1.0, &slender(1e6, 2.0, 1e-8), ElementKind::Linear, 16);
    let joint = Joint::sliding("slide").on("beam").prescribed(Motion::Polynomial(vec![0.0, 1.0]));
    let mass = AttachedMass::point("mass", 0.0, mass_kg);
    let mut machine = rail((beam, clamped()), (Body::rigid("bead").load_stations(1), joint), &[("bead", mass)]);
    machine.solver.tolerance = 1e-9;
    let mut plant = start(machine);
    plant.inputs_mut().stations_mut()[0].force_n.z = -0.05 * 0.0981;
    let (mut off_m, mut size_m) = (0.0f64, 0.0f64);
    for (i, due_m) in modal_tip_m(mass_kg).into_iter().enumerate() {
        coast(&mut plant, 0.02 * (i + 1) as f64);
        off_m = off_m.max((plant.outputs().tips()[0].position_m.z - due_m).abs());
        size_m = size_m.max(due_m.abs());
    }
    off_m / size_m
}

/// SJ-02. A moving force (a body of 1e-9 kg) and a moving mass on a cantilever at a constant speed, from the root almost to the tip, against
/// ten modes of the linear beam: the tip deflects by 8e-4 of the length.
#[test]
fn sj02_a_moving_load_and_a_moving_mass() {
    let errors = [moving_load(1e-9), moving_load(0.05)];
    println!("SJ-02 force {:.1e}, mass {:.1e} of the deflection", errors[0], errors[1]);
    assert!(errors.iter().all(|error| *error < 1e-4), "{errors:?}");
}

/// SJ-03. A bead on a stiff straight rod that rotates freely: `(J + m s²) ω` and `½ (J + m s²) ω² + ½ m ṡ²` are constant while the bead
/// moves outward across three element boundaries. The rod bends by 1e-7 of its length.
#[test]
fn sj03_a_bead_on_a_turning_rod() {
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        let rod = body("rod", 1.0, &slender(1e8, 1e5, 1e-8), kind, 4);
        let hinge = Joint::revolute("hinge", [0.0, 1.0, 0.0]).start_rate_rad_s(2.0);
        let mass = AttachedMass::point("mass", 0.0, 0.3);
        let joint = Joint::sliding("slide").on("rod").start_position_m(0.2);
        let mut machine = rail((rod, hinge), (Body::rigid("bead"), joint), &[("bead", mass)]);
        machine.solver.tolerance = 1e-9;
        let mut plant = start(machine);
        let inertia_kg_m2 = |s_m: f64| 0.5 / 3.0 + 0.3 * s_m * s_m;
        let momentum = inertia_kg_m2(0.2) * 2.0;
        coast(&mut plant, 1.2);
        let [turn, slide] = [0, 1].map(|joint| plant.outputs().joints()[joint]);
        let now = inertia_kg_m2(slide.angle_rad);
        let moment = now * turn.rate_rad_s / momentum - 1.0;
        let energy_j = 0.5 * (now * turn.rate_rad_s.powi(2) + 0.3 * slide.rate_rad_s.powi(2));
        let energy = energy_j / (0.5 * momentum * 2.0) - 1.0;
        println!("SJ-03 {kind:?}: s {:.4} m, momentum {moment:.1e}, energy {energy:.1e}", slide.angle_rad);
        assert!(slide.angle_rad > 0.75 && plant.statistics().events >= 3);
        assert!(moment.abs() < 1e-6 && energy.abs() < 1e-6);
    }
}

/// SJ-04. A block with rotary inertia `I` and its centre of mass on the axis slides down a stiff arc of radius `1/κ` and rotates with the
/// arc, so that `½ (m + I κ²) ṡ² = m g h`. Without the rotational part of the joint's column, its speed would be 11 % higher.
#[test]
fn sj04_a_block_turns_with_the_arc() {
    for (kind, pairs) in [(ElementKind::Constant, 8), (ElementKind::Linear, 3)] {
        let curvature_1_m = 1.25;
        let arc =
            body("arc", 1.0, &slender(1e10, 1e7, 1e-8), kind, pairs).natural_curvature_1_m([0.0, curvature_1_m, 0.0]);
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.02));
        let block = Body::rigid("block").inertia(0.2, [0.0; 3], inertia);
        let joint = Joint::sliding("slide").on("arc").start_position_m(0.1);
        let mut machine = rail((arc, clamped()), (block, joint), &[]);
        machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -9.81);
        machine.solver.tolerance = 1e-8;
        let mut plant = start(machine);
        let from_m = plant.outputs().tips()[1].position_m.z;
        coast(&mut plant, 0.9);
        let slide = plant.outputs().joints()[0];
        let fallen_m = from_m - plant.outputs().tips()[1].position_m.z;
        // height of the arc: z = −(1 − cos κs)/κ
        let due_m = ((curvature_1_m * 0.1).cos() - (curvature_1_m * slide.angle_rad).cos()) / curvature_1_m;
        let speed_m_s = (2.0 * 0.2 * 9.81 * due_m / (0.2 + 0.03 * curvature_1_m * curvature_1_m)).sqrt();
        println!(
            "SJ-04 {kind:?}: s {:.4} m, {:.2e} m, {:.2e} m/s",
            slide.angle_rad,
            fallen_m - due_m,
            slide.rate_rad_s - speed_m_s
        );
        assert!(slide.angle_rad > 0.3, "{}", slide.angle_rad);
        assert!((fallen_m - due_m).abs() < 1e-6 && (slide.rate_rad_s / speed_m_s - 1.0).abs() < 1e-5);
    }
}

/// A curved beam in free flight, with a block that slides along it with an offset from the axis and rotates about all axes.
fn flying(kind: ElementKind, elements: usize, sheared: bool, motor_kg: f64) -> Machine {
    let mut section = slender(1e4, 1.0, 1e-3);
    if sheared {
        section = section.with_shear_stiffness_n([500.0, 500.0]);
    }
    let beam = body("beam", 1.0, &section, kind, elements).natural_curvature_1_m([0.3, 0.5, -0.4]);
    let fly = Joint::free("fly").start_angular_velocity_rad_s([1.0, 2.0, 0.5]).start_velocity_m_s([0.3, 0.1, -0.2]);
    let inertia = Matrix3::new(2e-3, 1e-4, 0.0, 1e-4, 3e-3, 2e-4, 0.0, 2e-4, 4e-3);
    let slide = Joint::sliding("slide").on("beam").start_position_m(0.1).start_rate_m_s(1.0);
    let slide = slide.offset_m([0.02, 0.03, -0.05]).mount_rotation_rad([0.3, -0.2, 0.5]);
    // a motor without force; its mass moves only with the coordinate
    let slide = slide.motor(LinearMotor { mass_kg: motor_kg, ..LinearMotor::default() });
    let mut machine = rail((beam, fly), (Body::rigid("block").inertia(0.3, [0.05, 0.02, 0.1], inertia), slide), &[]);
    machine.solver.tolerance = 1e-8;
    machine
}

/// SJ-05. The energy balance of a beam in free flight with an eccentric sliding block closes across element boundaries, with a loss that is
/// not negative: pairs, constant elements, elements with shear, a motor with a mass. The mass of the motor contributes neither to the loss
/// nor to the work, because its speed hardly changes.
#[test]
fn sj05_the_energy_account_closes_over_borders() {
    for (kind, elements, sheared, motor_kg) in [
        (ElementKind::Linear, 4, false, 0.0),
        (ElementKind::Constant, 6, false, 0.0),
        (ElementKind::Linear, 4, true, 0.0),
        (ElementKind::Constant, 6, true, 0.0),
        (ElementKind::Linear, 4, false, 0.2),
    ] {
        let mut plant = start(flying(kind, elements, sheared, motor_kg));
        let before_j = balance_j(plant.outputs());
        coast(&mut plant, 0.6);
        let (drift_j, energy) = (balance_j(plant.outputs()) - before_j, plant.outputs().energy());
        println!(
            "SJ-05 {kind:?} shear {sheared} motor {motor_kg} kg: drift {drift_j:.1e} J of {:.2} J, lost {:.2e} J, {} events",
            energy.kinetic,
            energy.dissipated,
            plant.statistics().events
        );
        assert!(plant.statistics().events > 0 && drift_j.abs() < 1e-7);
        assert!(energy.dissipated > 1e-9 && energy.dissipated < 1e-6 && energy.work.abs() < 1e-9);
    }
}

/// SJ-06. A run across element boundaries continues bit-identically from a saved state, and does not depend on the communication step.
#[test]
fn sj06_states_across_borders_are_restored() {
    let mut plant = start(bead(4, 1e-6));
    coast(&mut plant, 0.25);
    let (saved, s_m) = (plant.snapshot(), plant.outputs().joints()[0].angle_rad);
    coast(&mut plant, 0.42);
    let late = plant.outputs().joints()[0];
    assert!(s_m < 0.5 && late.angle_rad > 0.75, "{s_m} {}", late.angle_rad);
    plant.restore(&saved).expect("the state of this plant");
    coast(&mut plant, 0.42);
    assert_eq!(plant.outputs().joints()[0].angle_rad.to_bits(), late.angle_rad.to_bits());
    assert_eq!(plant.outputs().joints()[0].rate_rad_s.to_bits(), late.rate_rad_s.to_bits());
    let mut other = start(bead(4, 1e-6));
    (1..=42).for_each(|step| coast(&mut other, 0.01 * f64::from(step)));
    let differs_m = (other.outputs().joints()[0].angle_rad - late.angle_rad).abs();
    println!("SJ-06 {differs_m:.1e} m");
    assert!(differs_m < 1e-12);
}

/// SJ-11. Steps allocate no memory across element boundaries, including the first one.
#[test]
fn sj11_steps_across_borders_allocate_nothing() {
    for method in [Method::Esdirk4, Method::GeneralizedAlpha] {
        let mut machine = bead(4, 1e-6);
        machine.solver.method = method;
        let mut plant = start(machine);
        coast(&mut plant, 1e-3);
        let (before, s_m) = (allocations(), plant.outputs().joints()[0].angle_rad);
        (2..=420).for_each(|step| coast(&mut plant, 1e-3 * f64::from(step)));
        let allocated = allocations() - before;
        let crossed_m = plant.outputs().joints()[0].angle_rad;
        assert!(s_m < 0.251 && crossed_m > 0.75, "{method:?}: from {s_m} to {crossed_m} m, over two borders");
        assert_eq!(allocated, 0, "{method:?}: allocations");
    }
}

/// A massless carriage on a cantilever, with a pendulum on a hinge: a body that slides and rotates.
pub fn crane(change: impl Fn(JointBuilder) -> JointBuilder) -> Machine {
    crane_with(Joint::revolute("pin", [0.0, 1.0, 0.0]), [4.0, 0.0, -9.0], change)
}

/// The same with another joint for the pendulum, and another gravity in m/s².
pub fn crane_with(pin: JointBuilder, gravity_m_s2: [f64; 3], change: impl Fn(JointBuilder) -> JointBuilder) -> Machine {
    let beam = body("beam", 1.0, &slender(1e4, 2.0, 1e-6), ElementKind::Linear, 4);
    let bob = Body::rigid("bob").inertia(0.2, [0.0, 0.0, -0.2], Matrix3::from_diagonal_element(1e-4));
    let built = Machine::builder("crane")
        .gravity_m_s2(gravity_m_s2)
        .body(beam, clamped())
        .body(Body::rigid("carriage"), change(Joint::sliding("slide").on("beam")))
        .body(bob, pin.on("carriage"))
        .solver(solver(Method::Esdirk4, 1e-8))
        .build();
    built.unwrap_or_else(|refused| panic!("{refused}"))
}

/// SJ-07. Springs, dampers, end stops, motors, rigid latches, locks and prescribed motions act on a sliding joint as on a prismatic joint:
/// the energy balance closes, end stops reverse the carriage, the latch holds it, and prescribed motions are followed.
#[test]
fn sj07_forces_on_a_sliding_joint() {
    let at = |joint: JointBuilder, s_m: f64| joint.start_position_m(s_m);
    let spring = LinearSpring { stiffness_n_m: 30.0, damping_n_s_m: 0.5, rest_position_m: 0.6 };
    let stops =
        EndStops { lower_rad: Some(0.05), upper_rad: Some(0.9), stiffness_n_m_rad: 2e3, damping_n_m_s_rad: 2.0 };
    let motor =
        LinearMotor { stiffness_n_m: 50.0, damping_n_s_m: 5.0, mass_kg: 0.2, command_m: 0.5, ..LinearMotor::default() };
    let run = |change: &dyn Fn(JointBuilder) -> JointBuilder, end_s: f64| {
        let mut plant = start(crane(change));
        let before_j = balance_j(plant.outputs());
        let mut last_j = 0.0;
        for step in 1..=100 {
            coast(&mut plant, end_s * f64::from(step) / 100.0);
            let lost_j = plant.outputs().energy().dissipated;
            assert!(lost_j > last_j - 1e-12, "{lost_j} J after {last_j} J");
            last_j = lost_j;
        }
        let drift_j = balance_j(plant.outputs()) - before_j;
        let joint = plant.outputs().joints()[0];
        println!(
            "SJ-07 s {:.4} m, {:.3} m/s, drift {drift_j:.1e} J, {} events",
            joint.angle_rad,
            joint.rate_rad_s,
            plant.statistics().events
        );
        assert!(drift_j.abs() < 5e-6, "{drift_j:e} J");
        (plant.outputs().joints()[0], plant)
    };
    run(&|joint| at(joint, 0.35).spring(spring), 0.7);
    let (stopped, _) = run(&|joint| at(joint, 0.35).end_stops(stops), 1.5);
    assert!(stopped.angle_rad < 0.95);
    run(&|joint| at(joint, 0.35).motor(motor.clone()), 0.7);
    let (latched, plant) = run(&|joint| at(joint, 0.35).latch(Latch::rigid().angle_rad(0.7)), 0.7);
    assert!(
        (latched.angle_rad - 0.7).abs() < 2e-6
            && latched.rate_rad_s == 0.0
            && plant.outputs().latches()[0].closed.is_on()
    );
    let (locked, _) = run(&|joint| at(joint, 0.35).locked(), 0.3);
    assert_eq!([locked.angle_rad, locked.rate_rad_s], [0.35, 0.0]);
    let (moved, plant) = run(&|joint| joint.prescribed(Motion::Polynomial(vec![0.1, 0.2, 1.0])), 0.7);
    assert!((moved.angle_rad - 0.73).abs() < 1e-12 && (moved.rate_rad_s - 1.6).abs() < 1e-12);
    assert!(plant.outputs().energy().work.abs() > 0.1 && plant.statistics().events >= 2);
}

/// Error message for a machine that is rejected.
fn refused(machine: foldwing::machine::builder::MachineBuilder) -> String {
    machine.build().expect_err("a fault").to_string()
}

/// SJ-08. Machines, analyses and motions that are not allowed with a sliding joint are rejected with an error that names the joint.
#[test]
fn sj08_refusals_name_the_joint() {
    let beam = || (body("beam", 1.0, &slender(1e4, 1.0, 1e-7), ElementKind::Linear, 2), clamped());
    let bead = || Body::rigid("bead").inertia(0.1, [0.0; 3], Matrix3::from_diagonal_element(1e-4));
    let slide = || Joint::sliding("slide").on("beam").start_position_m(0.5);
    let with = |joint: JointBuilder| Machine::builder("t").body(beam().0, beam().1).body(bead(), joint);
    let second = || Body::rigid("other").inertia(0.1, [0.0; 3], Matrix3::from_diagonal_element(1e-4));
    for (machine, place, allowed) in [
        (with(Joint::sliding("slide")), "joint \"slide\", parent", "a beam along which the body slides"),
        (with(slide().start_position_m(1.5)), "joint \"slide\", start_position_m", "from 0 to its length"),
        (
            with(Joint::sliding("slide").on_at("beam", 0.5)),
            "joint \"slide\", parent_position_m",
            "write start_position_m",
        ),
        (
            with(slide()).body(second(), Joint::sliding("next").on("bead")),
            "joint \"next\", parent",
            "not a rigid or a modal body",
        ),
        (with(slide()).gauge(Gauge::on("root", "beam", 0.2)), "gauge \"root\"", "without a sliding joint on it"),
        (
            Machine::builder("t").body(beam().0.modal_damping_ratios([0.02]), beam().1).body(bead(), slide()),
            "body \"beam\", modal_damping_ratios",
            "write stiffness_damping_s",
        ),
    ] {
        let text = refused(machine);
        assert!(text.contains(place) && text.contains(allowed), "{text}");
    }
    let mut plant = start(with(slide()).build().unwrap_or_else(|refused| panic!("{refused}")));
    let rest = plant.study().equilibrium(0.0, foldwing::plant::Holding::AsReleased).map(|_| ());
    let rest = rest.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(rest.contains("no stiffness resists a motion of joint \"slide\": add a spring"), "{rest}");
    let mut exchange = start(with(slide()).build().unwrap_or_else(|refused| panic!("{refused}")));
    let text = exchange.hybrid().map(|_| ()).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(text.contains("sliding joint"), "{text}");
    let mut leaving = start(with(slide().start_rate_m_s(2.0)).build().unwrap_or_else(|refused| panic!("{refused}")));
    let gone = (1..=10).find_map(|step| leaving.step(0.1 * f64::from(step)).err());
    let text = gone.map(|error| error.to_string()).unwrap_or_default();
    println!("SJ-08 {text}");
    assert!(text.contains("joint slide") && text.contains("beam") && text.contains("end_stops"), "{text}");
    assert!(leaving.time_s() < 0.26, "{} s", leaving.time_s());
}

/// SJ-09. A model file with a sliding joint gives the same machine as the builder.
#[test]
fn sj09_model_file() {
    let text = include_str!("sliding.toml");
    let machine = foldwing::config::parse(text, "sliding.toml").unwrap_or_else(|refused| panic!("{refused}"));
    let mut plant = start(machine);
    coast(&mut plant, 0.3);
    let mut same = start(bead(4, 1e-7));
    coast(&mut same, 0.3);
    let differs_m = (plant.outputs().joints()[0].angle_rad - same.outputs().joints()[0].angle_rad).abs();
    assert!(differs_m < 1e-12, "{differs_m:e} m");
    for (line, allowed) in [
        ("axis = [1.0, 0.0, 0.0]", "only with attitude = \"hinge\""),
        ("parent_position_m = 0.3", "write start_position_m"),
        ("start_angle_deg = 3.0", "only with attitude = \"hinge\""),
        ("motor.gear_ratio = 3.0", "\"revolute\""),
        ("spring.stiffness_N_m_rad = 3.0", "stiffness_N_m instead: the keys of a sliding joint are in m and N"),
    ] {
        let changed = text.replace("start_position_m = 0.25", &format!("start_position_m = 0.25\n{line}"));
        let refused = foldwing::config::parse(&changed, "sliding.toml").expect_err(line).to_string();
        assert!(refused.contains(allowed), "{line}: {refused}");
    }
}

/// SJ-10. Internal loads of a beam inside the pair along which a body slides: a body of 0.1 kg with prescribed constant speed along a stiff
/// beam loads the inboard sections by its weight, and none of the outboard sections; each section also carries the weight of the beam
/// outboard of it.
#[test]
fn sj10_internal_loads_beside_a_sliding_body() {
    let beam = body("beam", 1.0, &slender(1e9, 1e7, 1e-8), ElementKind::Linear, 2);
    let joint = Joint::sliding("slide").on("beam").prescribed(Motion::Polynomial(vec![0.1, 1.0]));
    let mut built = Machine::builder("t").gravity_m_s2([0.0, 0.0, -9.81]).body(beam, clamped());
    built = built.body(Body::rigid("bead"), joint).mass("bead", AttachedMass::point("mass", 0.0, 0.1));
    let places_m = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7];
    for (i, place_m) in places_m.iter().enumerate() {
        built = built.internal_load(InternalLoad::on(format!("cut{i}"), "beam", *place_m));
    }
    let stiff = Solver { max_step_s: 1e-3, ..solver(Method::Sdirk2, 1e-6) };
    let mut plant = start(built.solver(stiff).build().unwrap_or_else(|refused| panic!("{refused}")));
    for end_s in [0.15, 0.25] {
        coast(&mut plant, end_s);
        let s_m = 0.1 + end_s;
        for (load, place_m) in plant.outputs().internal_loads().iter().zip(places_m) {
            let riding = if s_m > place_m { 0.1 * 9.81 } else { 0.0 };
            let due_n = -(0.5 * 9.81 * (1.0 - place_m) + riding);
            let due_n_m = 0.5 * 9.81 * 0.5 * (1.0 - place_m).powi(2) + riding * (s_m - place_m);
            println!(
                "SJ-10 t {end_s} s at {place_m} m: {:.6} N of {due_n:.6}, {:.6} N·m of {due_n_m:.6}",
                load.force_n.z, load.moment_n_m.y
            );
            // vibrations of the stiff beam by the sudden load decay in SDIRK2
            assert!((load.force_n.z - due_n).abs() < 1e-5 && (load.moment_n_m.y - due_n_m).abs() < 1e-5);
        }
    }
}
