//! Closed loops by the penalty method.

use crate::plant::machines::*;
use foldwing::beam::section::{Material, Section};
use foldwing::machine::*;
use foldwing::plant::{Holding, Plant};
use nalgebra::{Vector2, Vector3};
use std::sync::Arc;

/// Crank, coupler, rocker and ground of a four-bar linkage in m; the crank can make full revolutions.
pub(super) const BARS_M: [f64; 4] = [0.3, 0.8, 0.6, 0.7];
pub(super) const START_RAD: f64 = 0.5;
/// The crank angle is `START_RAD + SPIN_UP t²`.
const SPIN_UP_RAD_S2: f64 = 3.0;

/// Angles of coupler and rocker relative to the ground, and their common end, for a crank angle (all in the plane).
pub(super) fn kinematics(crank_rad: f64) -> (f64, f64, Vector2<f64>) {
    let [crank, coupler, rocker, ground] = BARS_M;
    let pin = Vector2::new(crank_rad.cos(), crank_rad.sin()) * crank;
    let pivot = Vector2::new(ground, 0.0);
    let span = pivot - pin;
    let angle = ((coupler * coupler + span.norm_squared() - rocker * rocker) / (2.0 * coupler * span.norm())).acos();
    let coupler_rad = span.y.atan2(span.x) + angle;
    let end = pin + Vector2::new(coupler_rad.cos(), coupler_rad.sin()) * coupler;
    let arm = end - pivot;
    (coupler_rad, arm.y.atan2(arm.x), end)
}

/// Steel bars in the `x`–`z` plane; the coupler's end is joined to the rocker's.
pub fn linkage(crank_motion: JointMotion, stiffness_n_m: f64) -> Machine {
    let material = Material { youngs_modulus_pa: 2e11, shear_modulus_pa: 8e10, density_kg_m3: 7800.0 };
    let section = Section::rectangle(0.02, 0.02, &material, None);
    let (coupler_rad, rocker_rad, _) = kinematics(START_RAD);
    // positive angles about y rotate x towards −z
    let mut crank_hinge = free_hinge(-START_RAD);
    crank_hinge.motion = crank_motion;
    let bar = |name: &str, i: usize| body(name, BARS_M[i], &section, ElementKind::Linear, 1);
    let pin = Closure::between("pin", ["coupler", "rocker"], stiffness_n_m).damping_n_s_m(2e-4 * stiffness_n_m);
    let built = Machine::builder("linkage")
        .gravity_m_s2([0.0, 0.0, -9.8])
        .body(bar("crank", 0), hinged_to_root(crank_hinge))
        .body(bar("coupler", 1), Joint::hinge("elbow", free_hinge(START_RAD - coupler_rad)).on("crank"))
        .body(bar("rocker", 2), Joint::hinge("pivot", free_hinge(-rocker_rad)).at_root([BARS_M[3], 0.0, 0.0]))
        .closure(pin)
        .solver(solver(Method::Esdirk4, 1e-6))
        .stop_time_s(1.0)
        .step_s(1e-3)
        .build();
    built.unwrap_or_else(|refused| panic!("{refused}"))
}

/// The linkage with bars 1e4 times as stiff and the crank prescribed.
fn four_bar(stiffness_n_m: f64, tolerance: f64) -> Plant {
    let spin_up = Motion::Polynomial(vec![-START_RAD, 0.0, -SPIN_UP_RAD_S2]);
    let mut machine = linkage(JointMotion::Prescribed(spin_up), stiffness_n_m);
    machine.solver.tolerance = tolerance;
    let mut plant = Plant::new(Arc::new(machine));
    plant.parameters_mut().bodies_mut().iter_mut().for_each(|body| body.stiffness_factor = 1e4);
    plant.initialize(0.0).expect("initial accelerations");
    plant
}

/// P-68. A four-bar linkage closed by a penalty joint follows its exact kinematics over two revolutions of the crank.
///
/// The pin force is of the order of 200 N (3 kg/m bars, 43 m/s² at the end), so the gap is 200 N divided by the stiffness: it must fall in
/// inverse proportion to the stiffness, and the error of the coupler's end is about the gap times the lever ratio of the mechanism.
#[test]
fn p68_four_bar_linkage_follows_its_kinematics() {
    let mut gaps = Vec::new();
    for stiffness_n_m in [1e6, 1e7] {
        let mut plant = four_bar(stiffness_n_m, 1e-6);
        let (mut miss_m, mut gap_m) = (0f64, 0f64);
        for step in 1..=200 {
            let time_s = 0.01 * f64::from(step);
            plant.step(time_s).expect("a step");
            let (_, _, end) = kinematics(START_RAD + SPIN_UP_RAD_S2 * time_s * time_s);
            let tip = plant.outputs().tips()[0].position_m;
            miss_m = miss_m.max((tip - Vector3::new(end.x, 0.0, end.y)).norm());
            gap_m = gap_m.max(plant.outputs().loops()[0].gap_m.norm());
        }
        println!("penalty {stiffness_n_m:.0e} N/m: gap {gap_m:.2e} m, end misses by {miss_m:.2e} m");
        assert!(gap_m < 400.0 / stiffness_n_m, "gap {gap_m:.1e} m at {stiffness_n_m:.0e} N/m");
        assert!(miss_m < 3.0 * gap_m, "end misses by {miss_m:.1e} m at a gap of {gap_m:.1e} m");
        gaps.push(gap_m);
    }
    let ratio = gaps[0] / gaps[1];
    assert!((9.0..11.0).contains(&ratio), "ten times the penalty divides the gap by {ratio:.2}");
}

/// P-69. The energy balance also closes with a penalty joint: its springs count as elastic energy, its dampers as dissipation.
///
/// Tolerance 1e-8 per step; 1e-5 of the largest kinetic energy is the error of the prescribed crank's work.
#[test]
fn p69_energy_accounts_close_around_a_loop() {
    let mut plant = four_bar(1e6, 1e-8);
    let start_j = balance_j(plant.outputs());
    let (mut drift_j, mut kinetic_j) = (0f64, 0f64);
    for step in 1..=50 {
        plant.step(0.01 * f64::from(step)).expect("a step");
        drift_j = drift_j.max((balance_j(plant.outputs()) - start_j).abs());
        kinetic_j = kinetic_j.max(plant.outputs().energy().kinetic);
    }
    let share = drift_j / kinetic_j;
    println!("drift {share:.1e} of the largest kinetic energy");
    assert!(share < 1e-5, "drift {share:.1e} of the largest kinetic energy {kinetic_j:.2e} J");
}

/// Penalty stiffness of the held linkage.
const HELD_STIFFNESS_N_M: f64 = 1e8;

/// The linkage with its crank locked and its bars damped and 100 times as stiff.
fn held_linkage() -> Machine {
    let mut machine = linkage(JointMotion::Locked, HELD_STIFFNESS_N_M);
    for body in &mut machine.bodies {
        (body.mass_damping_1_s, body.section) = (60.0, body.section.scaled(1.0, 100.0));
    }
    machine
}

/// Force of the pin on the coupler of the rigid linkage in N, from the moments of both bars' weights about their hinges.
pub(super) fn rigid_pin_force_n(machine: &Machine) -> Vector2<f64> {
    let (coupler_rad, rocker_rad, _) = kinematics(START_RAD);
    let bar = |length_m: f64, angle_rad: f64| Vector2::new(angle_rad.cos(), angle_rad.sin()) * length_m;
    let (coupler, rocker) = (bar(BARS_M[1], coupler_rad), bar(BARS_M[2], rocker_rad));
    let weight_n = |i: usize| -9.8 * machine.bodies[i].section.mass_kg(BARS_M[i]);
    // c × F + ½ c × W = 0 for the coupler, r × (−F) + ½ r × W = 0 for the rocker
    let matrix = nalgebra::Matrix2::new(-coupler.y, coupler.x, rocker.y, -rocker.x);
    let moments = Vector2::new(-0.5 * coupler.x * weight_n(1), -0.5 * rocker.x * weight_n(2));
    matrix.lu().solve(&moments).expect("bars that are not in line")
}

/// P-73. Equilibrium of a linkage whose free hinges are held by the loop alone: the state in which the damped motion ends; the gap at the
/// pin is the force of the rigid linkage divided by the stiffness; the root carries the weight.
///
/// The damped motion decays at 30 1/s, e⁻⁴⁵ at 1.5 s. The gap of 2.5e-7 m and the bars' deflection, about 6e-7 m, rotate the lever arms by
/// about 1e-6: 1e-5 of the pin force.
#[test]
fn p73_equilibrium_of_a_linkage() {
    let mut plant = Plant::new(Arc::new(held_linkage()));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let still = plant.outputs().clone();
    let expected = rigid_pin_force_n(plant.machine());
    let own = Vector2::new(still.loops()[0].force_n.x, still.loops()[0].force_n.z);
    let miss = (own - expected).norm() / expected.norm();
    let gap_m = still.loops()[0].gap_m.norm();
    let weight_n = plant.mass_kg() * 9.8;
    println!("pin force {own:?} N, off by {miss:.1e} of itself; gap {gap_m:.3e} m");
    assert!(miss < 1e-5, "pin force {own:?} N, rigid linkage {expected:?} N");
    assert!(
        (gap_m * HELD_STIFFNESS_N_M - own.norm()).abs() < 1e-9 * own.norm(),
        "gap {gap_m:.3e} m under {:.3} N",
        own.norm()
    );
    assert!((still.root().force_n + Vector3::z() * weight_n).norm() < 1e-9 * weight_n, "{:?} N", still.root().force_n);

    plant.initialize(0.0).expect("initial accelerations");
    coast(&mut plant, 1.5);
    let settled = plant.outputs();
    for (tip, other) in settled.tips().iter().zip(still.tips()) {
        let miss_m = (tip.position_m - other.position_m).norm();
        println!("tip {miss_m:.1e} m from the equilibrium");
        assert!(miss_m < 1e-10, "{miss_m:.1e} m from the equilibrium after 1.5 s");
    }
    assert!((settled.loops()[0].force_n - still.loops()[0].force_n).norm() < 1e-6 * own.norm());
}

/// P-74. A linkage that starts from equilibrium with its hinges locked does not move; its loop is closed apart from the gap due to its
/// fraction of the weight.
#[test]
fn p74_linkage_that_starts_at_rest_stays() {
    let mut machine = held_linkage();
    machine.experiment.start = StartState::Equilibrium;
    for index in [1, 2] {
        hinge_of(&mut machine, index).release = false;
    }
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("an equilibrium");
    let start = plant.outputs().clone();
    assert!(start.loops()[0].gap_m.norm() < 1e-6, "gap {:.1e} m", start.loops()[0].gap_m.norm());
    coast(&mut plant, 0.2);
    for (tip, other) in plant.outputs().tips().iter().zip(start.tips()) {
        let moved_m = (tip.position_m - other.position_m).norm();
        assert!(moved_m < 1e-12, "moved by {moved_m:.1e} m");
    }
}
