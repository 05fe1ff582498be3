//! The instant at which a rigid latch closes: impulse, jump of the rates, energy loss, eq. (A7).
//!
//! Latches with a capture window of more than one revolution are enabled in motion and close within a communication step of zero length, so
//! that the states before and after belong to one instant.

use crate::plant::corners::{add_rod, rod, rod_inertia_kg_m2};
use crate::plant::loops::linkage;
use crate::plant::machines::*;
use foldwing::machine::*;
use foldwing::plant::{Argument, Outputs, Plant};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::collections::HashMap;

/// A free hinge about an axis, rotating at the start; its rigid latch closes wherever it is enabled.
fn hinge(axis: Vector3<f64>, start_rad: f64, rate_rad_s: f64) -> Revolute {
    Revolute {
        axis: axis.normalize(),
        start_rate_rad_s: rate_rad_s,
        latch: Some(Latch { capture_rad: 6.2, enable: false, ..rigid_latch() }),
        ..free_hinge(start_rad)
    }
}

/// Enables the latches of joints, which close at once.
fn close(plant: &mut Plant, joints: &[usize]) {
    for &joint in joints {
        plant.inputs_mut().joints_mut()[joint].latch_enable = true.into();
    }
    let time_s = plant.time_s();
    coast(plant, time_s);
    for &joint in joints {
        assert!(plant.outputs().latches()[joint].closed.is_on() && plant.outputs().joints()[joint].rate_rad_s == 0.0);
    }
}

/// Names of the free coordinates with their rates.
fn rates(plant: &Plant) -> HashMap<String, f64> {
    plant.freedoms().into_iter().map(|freedom| freedom.name).zip(plant.free_state().1).collect()
}

/// Closes latches and compares with the dense mass matrix `M` of the state before: `p = −(C M⁻¹ Cᵀ)⁻¹ (E v, 0)`, `Δv = M⁻¹ Cᵀ p`, rows `C`
/// of the angles that stop, `E`, and of the gaps of loops, loss `½ vᵀMv` before minus after. Returns the largest relative error of rates,
/// impulses and losses.
fn miss_of_dense_oracle(plant: &mut Plant, joints: &[usize]) -> f64 {
    let (before, kinetic_j, dissipated_j) =
        (rates(plant), plant.outputs().energy().kinetic, plant.outputs().energy().dissipated);
    let names: Vec<String> = plant.freedoms().into_iter().map(|freedom| freedom.name).collect();
    let v = DVector::from_iterator(names.len(), names.iter().map(|name| before[name]));
    let mass = plant.study().second_order().expect("a mass matrix").mass;
    let rows: Vec<usize> = joints
        .iter()
        .map(|&joint| {
            let body = plant.revolute_joints()[joint];
            let name = format!("{}.angle", plant.machine().bodies[body].joint.name);
            names.iter().position(|other| *other == name).expect("a free angle")
        })
        .collect();
    let gaps = |outputs: &Outputs| {
        DVector::from_iterator(
            3 * outputs.loops().len(),
            outputs.loops().iter().flat_map(|closed| closed.gap_m.data.0[0]),
        )
    };
    let slopes: Vec<DVector<f64>> =
        plant.freedoms().iter().map(|freedom| plant.study().output_slope(Argument::Position, freedom, &gaps)).collect();
    let gap_rows = slopes[0].len();
    let c = DMatrix::from_fn(rows.len() + gap_rows, names.len(), |i, j| match i.checked_sub(rows.len()) {
        Some(row) => slopes[j][row],
        None => f64::from(rows[i] == j),
    });
    let mut jump = DVector::zeros(c.nrows());
    rows.iter().enumerate().for_each(|(i, row)| jump[i] = -v[*row]);
    let by_impulse = mass.clone().lu().solve(&c.transpose()).expect("a regular mass matrix");
    let p = (&c * &by_impulse).lu().solve(&jump).expect("impulses");
    let expected = &v + &by_impulse * &p;
    let lost_j = -0.5 * (&expected - &v).dot(&(&mass * (&expected + &v)));
    close(plant, joints);
    let after = rates(plant);
    let mut miss = 0f64;
    for (i, name) in names.iter().enumerate().filter(|(i, _)| !rows.contains(i)) {
        // strains have different units: the error of each is relative to its jump and rate
        let size = expected[i].abs().max(v[i].abs()).max(1e-3 * (&expected - &v).amax());
        miss = miss.max((after[name] - expected[i]).abs() / size);
    }
    for (k, &joint) in joints.iter().enumerate() {
        miss = miss.max((plant.outputs().latches()[joint].impulse_n_m_s - p[k]).abs() / p.amax());
    }
    let energy = plant.outputs().energy();
    miss = miss.max((energy.dissipated - dissipated_j - lost_j).abs() / lost_j);
    miss.max((kinetic_j - energy.kinetic - lost_j).abs() / kinetic_j)
}

/// Three plates in a row on hinges about different axes, bent and moving, with a mass off the axis.
fn chain() -> Plant {
    let axes = [Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.3, 1.0, 0.1), Vector3::new(-0.2, 0.8, 0.4)];
    let section = wing_section();
    let mut parts = Vec::new();
    for (i, (axis, rate)) in axes.into_iter().zip([3.0, -7.0, 5.0]).enumerate() {
        let joint = Joint::hinge(format!("h{i}"), hinge(axis, 0.4 * i as f64 - 0.3, rate));
        let joint = if i == 0 { joint } else { joint.on(format!("b{}", i - 1)) };
        parts.push((body(&format!("b{i}"), 0.15, &section, ElementKind::Linear, 2), joint));
    }
    let mut machine = machine(parts);
    let offset_m = Vector3::new(0.01, 0.03, -0.02);
    machine.bodies[2].masses = vec![AttachedMass { offset_m, ..AttachedMass::point("m", 0.1, 0.02) }];
    hinge_of(&mut machine, 1).motor.inertia_kg_m2 = 3e-5;
    machine.gravity_m_s2 = Vector3::new(-9.8, 0.0, 3.0);
    let mut plant = start(machine);
    coast(&mut plant, 0.0123);
    plant
}

/// RL-01. Jump of all rates, impulses and energy loss against the dense mass matrix: one latch, two at once, all three, one after another.
/// The oracle's inverse has errors of 1e-8 in strain rates whose inertias differ by six decades.
#[test]
fn rl01_the_impulse_is_that_of_the_dense_mass_matrix() {
    for joints in [&[0][..], &[1], &[2], &[0, 2], &[2, 1], &[0, 1, 2]] {
        let miss = miss_of_dense_oracle(&mut chain(), joints);
        println!("RL-01 {joints:?}: {miss:.1e}");
        assert!(miss < 1e-8, "latches {joints:?} miss the dense oracle by {miss:.1e}");
    }
    let mut plant = chain();
    for joint in [1, 0, 2] {
        let miss = miss_of_dense_oracle(&mut plant, &[joint]);
        assert!(miss < 1e-8, "latch {joint}, after others: {miss:.1e}");
    }
}

/// RL-05. The same comparison in a falling four-bar linkage: in the impulse its loop is a joint, whatever its penalty stiffness. The
/// rocker's latch, the elbow's, and both, which stop the whole linkage.
#[test]
fn rl05_loops_take_part_in_the_impulse() {
    for joints in [&[2][..], &[1], &[1, 2]] {
        for inertia_kg in [0.0, 0.3] {
            let mut machine = linkage(JointMotion::Free, 1e7);
            machine.closures[0].inertia_kg = inertia_kg;
            machine.bodies[2].joint.name = "pivot".into();
            for body in [1, 2] {
                hinge_of(&mut machine, body).latch = Some(Latch { capture_rad: 6.2, enable: false, ..rigid_latch() });
            }
            let mut plant = start(machine);
            coast(&mut plant, 0.2);
            let miss = miss_of_dense_oracle(&mut plant, joints);
            println!("RL-05 {joints:?}, {inertia_kg} kg: {miss:.1e}");
            // the rate of the gap jumps by a millionth of the others, a strain rate by a few millionths of itself
            assert!(miss < 2e-5, "latches {joints:?} miss the dense oracle by {miss:.1e}");
        }
    }
}

/// RL-06. A prescribed hinge keeps its rate while another joint stops; the impulse that this takes does work, which the energy balance
/// contains.
#[test]
fn rl06_a_prescribed_joint_keeps_its_rate_by_work() {
    let mut machine =
        rod(Revolute { motion: JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 3.0])), ..free_hinge(0.0) });
    add_rod(&mut machine, hinge(Vector3::y(), 0.2, 5.0));
    let mut plant = start(machine);
    let before_j = balance_j(plant.outputs());
    let (kinetic_j, work_j) = (plant.outputs().energy().kinetic, plant.outputs().energy().work);
    close(&mut plant, &[1]);
    let drift_j = balance_j(plant.outputs()) - before_j;
    let jump_j = plant.outputs().energy().work - work_j;
    println!("RL-06 work {jump_j:.2e} J, account off by {drift_j:.1e} J");
    assert!(plant.outputs().joints()[0].rate_rad_s == 3.0 && jump_j.abs() > 1e-6 * kinetic_j, "work {jump_j:.1e} J");
    assert!(drift_j.abs() < 1e-13 * kinetic_j, "account off by {drift_j:.1e} J");
}

/// RL-02. Two stiff rods in a row: latching of the elbow conserves the angular momentum about the shoulder, and once bending has decayed
/// the rods rotate as one. Total energy loss: `½ (J_1 J_2 / (J_1 + J_2)) θ̇²` for rods in line, in closed form.
#[test]
fn rl02_two_rods_turn_as_one() {
    let mut machine = rod(Revolute { start_rate_rad_s: 2.0, ..free_hinge(0.0) });
    add_rod(&mut machine, hinge(Vector3::y(), 0.0, 5.0));
    machine.solver.tolerance = 1e-9;
    let mut plant = start(machine);
    let kinetic_j = plant.outputs().energy().kinetic;
    close(&mut plant, &[1]);
    let booked_j = plant.outputs().energy().dissipated;
    assert!(booked_j > 0.0 && (balance_j(plant.outputs()) - kinetic_j).abs() < 1e-12 * kinetic_j);
    coast(&mut plant, 0.2);
    let (length_m, mass_kg) = (0.15, 1425.0 * 0.02 * 0.01 * 0.15);
    let about_middle = mass_kg * (f64::powi(length_m, 2) + 0.01f64.powi(2)) / 12.0;
    let momentum = |shoulder: f64, elbow: f64| {
        let middle_m_s = shoulder * length_m + (shoulder + elbow) * 0.5 * length_m;
        rod_inertia_kg_m2() * shoulder + mass_kg * 1.5 * length_m * middle_m_s + about_middle * (shoulder + elbow)
    };
    let expected_rad_s = momentum(2.0, 5.0) / momentum(1.0, 0.0);
    let error_rad_s = plant.outputs().joints()[0].rate_rad_s - expected_rad_s;
    let lost_j = kinetic_j - 0.5 * momentum(1.0, 0.0) * expected_rad_s.powi(2);
    let error_j = kinetic_j - plant.outputs().energy().total - lost_j;
    let drift_j = balance_j(plant.outputs()) - kinetic_j;
    println!(
        "RL-02 rate off by {:.1e}, energy lost by {:.1e}, account by {:.1e} of itself; {:.0} % of the loss at once",
        error_rad_s / expected_rad_s,
        error_j / lost_j,
        drift_j / kinetic_j,
        100.0 * booked_j / lost_j
    );
    // the rods stretch by 1e-8 as they rotate
    assert!(error_rad_s.abs() < 1e-7 * expected_rad_s, "turns {error_rad_s:.1e} rad/s off {expected_rad_s} rad/s");
    assert!(error_j.abs() < 1e-6 * lost_j, "loses {error_j:.1e} J more than {lost_j} J");
    assert!(drift_j.abs() < 1e-2 * lost_j, "account off by {drift_j:.1e} J");
}

/// RL-03. The reaction of a latch that holds two rotating rods at an angle `φ` to each other: the moment of the centrifugal forces about
/// the elbow, `½ m ω² L² sin φ`.
#[test]
fn rl03_the_reaction_is_the_moment_of_the_centrifugal_forces() {
    let (angle_rad, rate_rad_s) = (0.7, 8.0);
    let mut machine = rod(Revolute { start_rate_rad_s: rate_rad_s, ..free_hinge(0.0) });
    let elbow = Revolute { latch: Some(Latch { angle_rad, ..rigid_latch() }), ..free_hinge(angle_rad) };
    add_rod(&mut machine, elbow);
    let mut plant = start(machine);
    coast(&mut plant, 0.3);
    let (joint, latch) = (plant.outputs().joints()[1], plant.outputs().latches()[1]);
    assert!(latch.closed.is_on() && latch.count.get() == 0 && joint.angle_rad == angle_rad);
    let (length_m, mass_kg) = (0.15f64, 1425.0 * 0.02 * 0.01 * 0.15);
    let rate_rad_s = plant.outputs().joints()[0].rate_rad_s;
    let expected_n_m = 0.5 * mass_kg * rate_rad_s.powi(2) * length_m.powi(2) * angle_rad.sin();
    let error_n_m = joint.latch_torque_n_m - expected_n_m;
    println!("RL-03 reaction {} N·m, off by {error_n_m:.1e} N·m", joint.latch_torque_n_m);
    assert!(error_n_m.abs() < 1e-4 * expected_n_m, "{} N·m, expected {expected_n_m} N·m", joint.latch_torque_n_m);
    assert_eq!(joint.holding_torque_n_m, 0.0);
}

/// An asymmetric aircraft in free flight: a keel, a wing of two panels on either side, flared hinges, masses.
fn aircraft() -> Machine {
    let section = wing_section();
    let flight =
        Joint::free("mount").start_velocity_m_s([0.3, 12.0, -0.7]).start_angular_velocity_rad_s([0.4, -0.9, 0.6]);
    let mut parts = vec![(body("keel", 0.2, &section, ElementKind::Linear, 1), flight)];
    for (name, side, turn) in [("right", 1.0, 0.0), ("left", -1.0, std::f64::consts::PI)] {
        let root = Joint::clamped(format!("root_{name}")).on_at("keel", 0.1).mount_rotation_rad([0.0, 0.0, turn]);
        parts.push((body(name, 0.15, &section, ElementKind::Linear, 2), root));
        let fold = hinge(Vector3::new(0.3, 1.0, 0.0), 0.5 + 0.2 * side, 6.0 + 3.0 * side);
        let outer = body(&format!("{name}_outer"), 0.1, &section, ElementKind::Linear, 2);
        parts.push((outer, Joint::hinge(format!("fold_{name}"), fold).on(name)));
    }
    let mut machine = machine(parts);
    let inertia_kg_m2 = Matrix3::from_diagonal(&Vector3::new(1e-4, 3e-4, 2e-4));
    machine.bodies[0].masses = vec![AttachedMass { inertia_kg_m2, ..AttachedMass::point("m", 0.0, 0.1) }];
    for (index, mass_kg) in [(2, 0.015), (4, 0.005)] {
        machine.bodies[index].masses = vec![AttachedMass::point("m", 0.1, mass_kg)];
    }
    machine
}

/// Momentum in N·s and angular momentum about the first section of the keel in N·m·s: derivatives of the kinetic energy, which is
/// quadratic, with respect to the rates of the free joint.
fn momentum(plant: &mut Plant) -> [f64; 6] {
    let freedoms = plant.freedoms();
    std::array::from_fn(|i| {
        assert!(freedoms[i].name.starts_with("mount."), "{}", freedoms[i].name);
        let mut kinetic_j =
            |rate| plant.study().outputs_beside(Some((Argument::Rate, &freedoms[i], rate))).energy().kinetic;
        0.5 * (kinetic_j(1.0) - kinetic_j(-1.0))
    })
}

/// RL-04. A free aircraft conserves momentum and angular momentum when one latch or both close, in bending motion: to the round-off of the
/// kinetic energies, 15 J, which is 1e-14 N·s.
#[test]
fn rl04_a_free_aircraft_keeps_its_momentum() {
    for joints in [&[0][..], &[1], &[0, 1]] {
        let mut plant = start(aircraft());
        coast(&mut plant, 0.0071);
        let (before, kinetic_j) = (momentum(&mut plant), plant.outputs().energy().kinetic);
        close(&mut plant, joints);
        let after = momentum(&mut plant);
        let change = before.iter().zip(&after).map(|(before, after)| (after - before).abs()).fold(0.0, f64::max);
        let impulses = joints.iter().map(|&joint| plant.outputs().latches()[joint].impulse_n_m_s.abs());
        let impulse_n_m_s = impulses.fold(f64::INFINITY, f64::min);
        println!("RL-04 {joints:?}: {before:.4?} changes by {change:.1e}, impulses from {impulse_n_m_s:.1e} N·m·s on");
        assert!(impulse_n_m_s > 1e-7, "the closing must matter: {impulse_n_m_s:.1e} N·m·s");
        assert!(change < 1e-13, "momentum changes by {change:.1e}");
        let lost_j = kinetic_j - plant.outputs().energy().kinetic;
        assert!((lost_j - plant.outputs().energy().dissipated).abs() < 1e-13 * kinetic_j);
    }
}
