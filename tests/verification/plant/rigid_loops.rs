//! Rigid loops, closed to round-off by constraint forces: against closed forms, minimal coordinates and the limit of penalties.

use crate::counting_allocator::allocations;
use crate::plant::loops::{BARS_M, START_RAD, kinematics, linkage};
use crate::plant::machines::*;
use foldwing::config;
use foldwing::machine::builder::{ClosureBuilder, MachineBuilder};
use foldwing::machine::*;
use foldwing::plant::{Holding, NotHybrid, Plant, PlantError};
use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};
use std::sync::Arc;
use std::time::Instant;

const MASSES_KG: [f64; 3] = [0.7, 1.9, 1.3];
const BRACED: &str = include_str!("../../../examples/braced/braced_wing.toml");
const FOUR_BAR: &str = include_str!("../../../examples/models/four_bar.toml");
/// Gap relative to the length of the machine that counts as round-off.
const CLOSED: f64 = 1e-12;

fn built(builder: MachineBuilder) -> Machine {
    builder.build().unwrap_or_else(|refused| panic!("{refused}"))
}

/// A four-bar linkage of slender rigid bars in the plane `x`–`z` rotated by `turn`, on which its motion does not depend.
pub(super) fn rigid_bars(motion: JointMotion, solver: Solver, turn: Rotation3<f64>) -> Machine {
    let (coupler_rad, rocker_rad, _) = kinematics(START_RAD);
    let bar = |name: &str, i: usize| {
        let about = MASSES_KG[i] * BARS_M[i].powi(2) / 12.0;
        let inertia = Matrix3::from_diagonal(&Vector3::new(1e-4, about, about));
        Body::rigid(name).inertia(MASSES_KG[i], [0.5 * BARS_M[i], 0.0, 0.0], inertia)
    };
    let mount = *turn.matrix();
    let hinge = |start_angle_rad| Revolute { start_angle_rad, ..Revolute::about(turn * Vector3::y()) };
    let crank = Revolute { motion, ..hinge(-START_RAD) };
    let pivot = turn * Vector3::new(BARS_M[3], 0.0, 0.0);
    let elbow = Joint::hinge("elbow", free_hinge(START_RAD - coupler_rad)).on("crank");
    built(
        Machine::builder("bars")
            .gravity_m_s2(turn * Vector3::new(0.0, 0.0, -9.8))
            .body(bar("crank", 0), hinged_to_root(crank).mount(mount))
            .body(bar("coupler", 1), elbow.offset_m([BARS_M[0], 0.0, 0.0]))
            .body(bar("rocker", 2), Joint::hinge("pivot", hinge(-rocker_rad)).at_root(pivot).mount(mount))
            .closure(
                Closure::rigid("pin", ["coupler", "rocker"]).offsets_m([[BARS_M[1], 0.0, 0.0], [BARS_M[2], 0.0, 0.0]]),
            )
            .solver(solver)
            .stop_time_s(2.0)
            .step_s(1e-3),
    )
}

/// Largest gap in the current outputs relative to the machine's length.
fn gap_of(plant: &Plant, length_m: f64) -> f64 {
    plant.outputs().loops().iter().map(|closure| closure.gap_m.norm()).fold(0.0, f64::max) / length_m
}

/// LP-21. A four-bar linkage of rigid bars with a prescribed crank is fully determined by its loop: angles and rates of the two other
/// hinges agree with the closed form to round-off over two revolutions, with every method, also at communication points inside steps.
#[test]
fn lp21_a_prescribed_four_bar_follows_its_kinematics_to_round_off() {
    for method in [Method::Esdirk4, Method::Esdirk3, Method::TrBdf2, Method::GeneralizedAlpha, Method::Rk4] {
        let motion = Motion::Polynomial(vec![-START_RAD, 0.0, -3.0]);
        let fixed = (method == Method::Rk4).then_some(1e-3);
        let solver = Solver { fixed_step_s: fixed, ..solver(method, 1e-6) };
        let mut plant = start(rigid_bars(JointMotion::Prescribed(motion), solver, Rotation3::identity()));
        let (mut gap, mut angle, mut rate) = (0.0f64, 0.0f64, 0.0f64);
        for step in 1..=400 {
            let time_s = 5.3e-3 * f64::from(step);
            plant.step(time_s).unwrap_or_else(|error| panic!("{method:?}: {error}"));
            gap = gap.max(gap_of(&plant, 1.3));
            let (crank_rad, crank_rad_s) = (START_RAD + 3.0 * time_s * time_s, 6.0 * time_s);
            let (coupler_rad, rocker_rad, _) = kinematics(crank_rad);
            let [coupler_rate, rocker_rate] = rates(crank_rad);
            let joints = plant.outputs().joints();
            let turned = |found: f64, expected: f64| (0.5 * (found - expected)).sin().abs() * 2.0;
            angle = angle.max(turned(joints[1].angle_rad, crank_rad - coupler_rad));
            angle = angle.max(turned(joints[2].angle_rad, -rocker_rad));
            rate = rate.max((joints[1].rate_rad_s - crank_rad_s * (1.0 - coupler_rate)).abs() / (1.0 + crank_rad_s));
            rate = rate.max((joints[2].rate_rad_s + crank_rad_s * rocker_rate).abs() / (1.0 + crank_rad_s));
        }
        println!("LP-21 {method:?}: gap {gap:.1e}, angles {angle:.1e} rad, rates {rate:.1e}");
        // a prescribed angle of 10 rad has a round-off of 2e-15 rad, which the mechanism multiplies by up to 5
        assert!(gap < CLOSED && angle < 1e-12 && rate < 1e-11, "{method:?}: {gap:.1e} {angle:.1e} {rate:.1e}");
    }
}

/// Rates of coupler and rocker, divided by the rate of the crank.
fn rates(crank_rad: f64) -> [f64; 2] {
    let [crank, coupler, rocker, _] = BARS_M;
    let (b, c, _) = kinematics(crank_rad);
    [
        crank * (c - crank_rad).sin() / (coupler * (b - c).sin()),
        crank * (crank_rad - b).sin() / (rocker * (c - b).sin()),
    ]
}

/// Inertia of the linkage of rigid bars about its crank in kg·m², and potential in J, at a crank angle.
pub(super) fn crank_energy(crank_rad: f64) -> [f64; 2] {
    let (b, c, _) = kinematics(crank_rad);
    let [coupler_rate, rocker_rate] = rates(crank_rad);
    let along = |angle: f64| Vector2::new(angle.cos(), angle.sin());
    let across = |angle: f64| Vector2::new(-angle.sin(), angle.cos());
    let bar = |i: usize| MASSES_KG[i] * BARS_M[i].powi(2);
    let middle = across(crank_rad) * BARS_M[0] + across(b) * (0.5 * BARS_M[1] * coupler_rate);
    let inertia = bar(0) / 3.0
        + MASSES_KG[1] * middle.norm_squared()
        + bar(1) / 12.0 * coupler_rate.powi(2)
        + bar(2) / 3.0 * rocker_rate.powi(2);
    let height = MASSES_KG[0] * 0.5 * BARS_M[0] * along(crank_rad).y
        + MASSES_KG[1] * (BARS_M[0] * along(crank_rad).y + 0.5 * BARS_M[1] * along(b).y)
        + MASSES_KG[2] * 0.5 * BARS_M[2] * along(c).y;
    [inertia, 9.8 * height]
}

/// Crank angle and rate of the free linkage at a time: Lagrange's equation of its one degree of freedom, integrated by small steps of RK4;
/// derivatives of inertia and potential by central differences of fourth order, to 1e-12.
fn crank_at(time_s: f64) -> [f64; 2] {
    let slope = |angle: f64| {
        let h = 2e-3;
        let at = |k: f64| crank_energy(angle + k * h);
        let [p1, m1, p2, m2] = [at(1.0), at(-1.0), at(2.0), at(-2.0)];
        [0, 1].map(|i| (8.0 * (p1[i] - m1[i]) - (p2[i] - m2[i])) / (12.0 * h))
    };
    let rates = |[angle, rate]: [f64; 2]| {
        let [by_inertia, by_height] = slope(angle);
        [rate, -(0.5 * by_inertia * rate * rate + by_height) / crank_energy(angle)[0]]
    };
    let steps = 4000;
    let h = time_s / f64::from(steps);
    let ahead = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    (0..steps).fold([START_RAD, 0.0], |y, _| {
        let k1 = rates(y);
        let k2 = rates(ahead(y, k1, 0.5 * h));
        let k3 = rates(ahead(y, k2, 0.5 * h));
        let k4 = rates(ahead(y, k3, h));
        [0, 1].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    })
}

/// LP-22. The free four-bar linkage of rigid bars against its equation in the crank angle alone: every method keeps its order, the loop is
/// closed at each step, and the energy is conserved to the error of the motion.
#[test]
fn lp22_order_of_convergence_against_minimal_coordinates() {
    let time_s = 0.64;
    let [expected_rad, expected_rad_s] = crank_at(time_s);
    assert!(expected_rad_s.abs() > 1.0, "{expected_rad_s} rad/s");
    for (method, order, steps) in [
        (Method::Esdirk4, 4.0, [20, 40]),
        (Method::Esdirk3, 3.0, [40, 80]),
        (Method::TrBdf2, 2.0, [80, 160]),
        (Method::GeneralizedAlpha, 2.0, [80, 160]),
        (Method::Rk4, 4.0, [40, 80]),
    ] {
        let misses = steps.map(|steps| {
            let h_s = time_s / f64::from(steps);
            let solver = Solver { fixed_step_s: Some(h_s), max_step_s: h_s, ..solver(method, 1e-11) };
            let mut plant = start(rigid_bars(JointMotion::Free, solver, Rotation3::identity()));
            let begin_j = balance_j(plant.outputs());
            let (mut gap, mut drift_j) = (0.0f64, 0.0f64);
            for step in 1..=steps {
                plant.step(h_s * f64::from(step)).unwrap_or_else(|error| panic!("{method:?}: {error}"));
                gap = gap.max(gap_of(&plant, 1.3));
                drift_j = drift_j.max((balance_j(plant.outputs()) - begin_j).abs());
            }
            assert!(gap < CLOSED, "{method:?}: gap {gap:.1e}");
            let crank = plant.outputs().joints()[0];
            let miss = (crank.angle_rad + expected_rad).abs().max((crank.rate_rad_s + expected_rad_s).abs());
            assert!(drift_j < 100.0 * miss, "{method:?}: energy drifts by {drift_j:.1e} J at an error of {miss:.1e}");
            miss
        });
        let found = (misses[0] / misses[1]).log2();
        println!("LP-22 {method:?}: {misses:?}, order {found:.2} of {order}");
        assert!(misses[1] > 1e-11 && found > order - 0.35, "{method:?}: {misses:?}, order {found:.2}");
    }
}

/// The elastic linkage with a rigid pin.
fn elastic(motion: JointMotion, pin: Option<f64>, solver: Solver) -> Machine {
    let mut machine = linkage(motion, pin.unwrap_or(1e6));
    if pin.is_none() {
        let closure = &mut machine.closures[0];
        (closure.rigid, closure.stiffness_n_m, closure.damping_n_s_m) = (true, 0.0, 0.0);
    }
    machine.solver = solver;
    machine
}

/// LP-23. With penalties the result tends to that of the rigid loop in proportion to the inverse of the stiffness: the free linkage of
/// rigid bars after 0.3 s.
#[test]
fn lp23_penalties_tend_to_the_rigid_loop() {
    let end = |pin: Option<f64>| {
        let mut machine = rigid_bars(JointMotion::Free, solver(Method::Esdirk4, 1e-11), Rotation3::identity());
        if let Some(stiffness_n_m) = pin {
            let closure = &mut machine.closures[0];
            (closure.rigid, closure.stiffness_n_m, closure.damping_n_s_m) =
                (false, stiffness_n_m, 2e-4 * stiffness_n_m);
        }
        let mut plant = start(machine);
        coast(&mut plant, 0.3);
        plant.outputs().joints()[0].angle_rad
    };
    let rigid = end(None);
    let misses = [1e6, 1e7, 1e8].map(|stiffness_n_m| (end(Some(stiffness_n_m)) - rigid).abs());
    println!("LP-23 {misses:?} rad");
    for pair in misses.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!(
            (9.0..11.5).contains(&ratio),
            "ten times the stiffness divides the difference by {ratio:.2}: {misses:?}"
        );
    }
}

/// LP-24. The energy balance of the elastic linkage, driven and free, closes with a rigid pin as with a penalty; the pin stores and
/// dissipates no energy.
#[test]
fn lp24_energy_accounts_close_around_a_rigid_loop() {
    let driven = JointMotion::Prescribed(Motion::Polynomial(vec![-START_RAD, 0.0, -3.0]));
    for motion in [driven, JointMotion::Free] {
        let mut plant = start(elastic(motion, None, solver(Method::Esdirk4, 1e-8)));
        let begin_j = balance_j(plant.outputs());
        let (mut drift_j, mut kinetic_j, mut gap) = (0.0f64, 0.0f64, 0.0f64);
        for step in 1..=50 {
            plant.step(0.01 * f64::from(step)).expect("a step");
            drift_j = drift_j.max((balance_j(plant.outputs()) - begin_j).abs());
            kinetic_j = kinetic_j.max(plant.outputs().energy().kinetic);
            gap = gap.max(gap_of(&plant, 1.3));
        }
        let share = drift_j / kinetic_j;
        println!("LP-24 drift {share:.1e} of {kinetic_j:.2} J, gap {gap:.1e}");
        assert!(share < 1e-5 && gap < CLOSED, "drift {share:.1e}, gap {gap:.1e}");
    }
}

fn rigid_file(text: &str) -> String {
    let lines = text.lines().scan("", |table, line| {
        if line.starts_with('[') {
            *table = line;
        }
        let of_loop = table.starts_with("[loop.");
        Some(match of_loop {
            true if line.starts_with("stiffness_N_m") => "rigid = true",
            true if line.starts_with("damping_N_s_m") => "",
            _ => line,
        })
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn of_file(text: &str) -> Machine {
    config::parse(&rigid_file(text), "rigid.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// LP-25. The strut-braced wing with rigid loops rises, its knee latches rigidly, and its loops have no gap before, at and after the latch;
/// the energy balance closes; the foot carries the same force as with penalties. Steps repeated from a snapshot before the latch are
/// identical bit by bit.
#[test]
fn lp25_braced_wing_latches_with_closed_loops() {
    let mut plant = start(of_file(BRACED));
    let mut soft = start(config::parse(BRACED, "braced_wing.toml").expect("the model of the example"));
    let begin_j = [&plant, &soft].map(|plant| balance_j(plant.outputs()));
    let (mut drift_j, mut gap) = ([0.0f64; 2], 0.0f64);
    let mut kept = None;
    for step in 1..=800 {
        let time_s = 5e-3 * f64::from(step);
        if step % 50 == 1 && !plant.outputs().latches()[2].closed.is_on() {
            kept = Some((plant.snapshot(), step));
        }
        plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        soft.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        gap = gap.max(gap_of(&plant, 1.6));
        for (i, plant) in [&plant, &soft].into_iter().enumerate() {
            drift_j[i] = drift_j[i].max((balance_j(plant.outputs()) - begin_j[i]).abs());
        }
    }
    let latch = plant.outputs().latches()[2];
    let foot = |plant: &Plant| plant.outputs().loops().iter().map(|closure| closure.force_n).sum::<Vector3<f64>>();
    let miss = (foot(&plant) - foot(&soft)).norm() / foot(&soft).norm();
    let later_s = (latch.time_s - soft.outputs().latches()[2].time_s).abs();
    println!(
        "LP-25 latch at {:.4} s, {later_s:.1e} s off; gap {gap:.1e}, foot off by {miss:.1e}; drift {:.1e} J, with penalties {:.1e} J",
        latch.time_s, drift_j[0], drift_j[1]
    );
    assert!(latch.closed.is_on() && gap < CLOSED, "gap {gap:.1e}");
    // the tolerance of the model is 1e-4
    assert!(drift_j[0] < 1.5 * drift_j[1] && drift_j[1] < 0.1, "drift {drift_j:?} J");
    assert!(later_s < 2e-3, "{later_s} s");
    assert!(miss < 1e-2, "{miss:.1e}");

    let (snapshot, from) = kept.expect("steps before the latch");
    let ends: Vec<Vec<f64>> = (0..2)
        .map(|_| {
            plant.restore(&snapshot).expect("own snapshot");
            (from..from + 80)
                .flat_map(|step| {
                    plant.step(5e-3 * f64::from(step) + 1e-4).expect("a step");
                    plant.outputs().values().to_vec()
                })
                .collect()
        })
        .collect();
    assert!(plant.outputs().latches()[2].closed.is_on(), "the repeated steps cross the latch");
    assert!(ends[0].iter().zip(&ends[1]).all(|(a, b)| a.to_bits() == b.to_bits()));
}

/// LP-26. A linkage in a rotated plane moves as in the plane `x`–`z`, and its forces are rotated in the same way: no axis is preferred.
#[test]
fn lp26_rotated_linkages_move_alike() {
    let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.3);
    let [mut own, mut other] = [Rotation3::identity(), turn]
        .map(|turn| start(rigid_bars(JointMotion::Free, solver(Method::Esdirk4, 1e-8), turn)));
    let mut worst = 0.0f64;
    for step in 1..=50 {
        for plant in [&mut own, &mut other] {
            plant.step(0.01 * f64::from(step)).expect("a step");
        }
        let [a, b] = [&own, &other].map(|plant| plant.outputs());
        worst = worst.max((a.joints()[0].angle_rad - b.joints()[0].angle_rad).abs());
        worst = worst.max((turn * a.loops()[0].force_n - b.loops()[0].force_n).norm() / a.loops()[0].force_n.norm());
    }
    println!("LP-26 {worst:.1e}");
    assert!(worst < 1e-8, "{worst:.1e}");
}

/// LP-27. Equilibrium: the pin force of the locked linkage is that of the closed form, without a gap; a simulation that starts there stays
/// at rest; and the state is the limit of those with penalties.
#[test]
fn lp27_equilibrium_with_a_rigid_loop() {
    let held = |pin: Option<f64>| {
        let mut machine = elastic(JointMotion::Locked, pin, solver(Method::Esdirk4, 1e-8));
        for body in &mut machine.bodies {
            body.section = body.section.scaled(1.0, 100.0);
        }
        let mut plant = Plant::new(Arc::new(machine));
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        plant
    };
    let mut plant = held(None);
    let still = plant.outputs().clone();
    let expected = crate::plant::loops::rigid_pin_force_n(plant.machine());
    let own = Vector2::new(still.loops()[0].force_n.x, still.loops()[0].force_n.z);
    let miss = (own - expected).norm() / expected.norm();
    let gap = gap_of(&plant, 1.3);
    let weight_n = plant.mass_kg() * 9.8;
    let unbalanced = (still.root().force_n + Vector3::z() * weight_n).norm() / weight_n;
    println!("LP-27 pin off by {miss:.1e}, gap {gap:.1e}, root {unbalanced:.1e}");
    assert!(miss < 1e-5 && gap < CLOSED && unbalanced < 1e-9, "{miss:.1e} {gap:.1e} {unbalanced:.1e}");
    let tip_m = |plant: &Plant| plant.outputs().tips()[1].position_m;
    let differences = [1e8, 1e9].map(|k| (tip_m(&held(Some(k))) - tip_m(&plant)).norm());
    println!("LP-27 penalties {differences:?} m");
    assert!((8.0..12.0).contains(&(differences[0] / differences[1])), "{differences:?}");

    let mut machine = elastic(JointMotion::Locked, None, solver(Method::Esdirk4, 1e-8));
    machine.experiment.start = StartState::Equilibrium;
    for index in [1, 2] {
        hinge_of(&mut machine, index).release = false;
    }
    plant = start(machine);
    let begin = plant.outputs().clone();
    coast(&mut plant, 0.2);
    let moved_m = (plant.outputs().tips()[1].position_m - begin.tips()[1].position_m).norm();
    let change_n = (plant.outputs().loops()[0].force_n - begin.loops()[0].force_n).norm();
    println!("LP-27 moved {moved_m:.1e} m, force {change_n:.1e} N");
    assert!(moved_m < 1e-10 && change_n < 1e-6, "{moved_m:.1e} m, {change_n:.1e} N");
}

/// LP-28. A pin made of two ball joints, whose axial constraints are redundant: the four-bar linkage of the examples with rigid loops has
/// no gap, both ball joints carry the same axial force, the solution of least norm, and the motion is that with penalties.
#[test]
fn lp28_redundant_rows_of_a_planar_linkage() {
    let mut plant = start(of_file(FOUR_BAR));
    let mut soft = start(config::parse(FOUR_BAR, "four_bar.toml").expect("the model of the example"));
    let (mut gap, mut uneven, mut force_n) = (0.0f64, 0.0f64, 0.0f64);
    for step in 1..=250 {
        let time_s = 2e-3 * f64::from(step);
        plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        soft.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        gap = gap.max(gap_of(&plant, 0.55));
        let [front, back] = [0, 1].map(|i| plant.outputs().loops()[i].force_n);
        uneven = uneven.max((front.y - back.y).abs());
        force_n = force_n.max(front.norm());
    }
    let miss = (plant.outputs().joints()[0].angle_rad - soft.outputs().joints()[0].angle_rad).abs();
    println!("LP-28 gap {gap:.1e}, uneven {uneven:.1e} N of {force_n:.1} N, crank off by {miss:.1e} rad");
    assert!(gap < CLOSED && uneven < 1e-6 * force_n, "gap {gap:.1e}, uneven {uneven:.1e} N");
    assert!(miss < 2e-3, "{miss:.1e} rad");
}

/// LP-29. Features that are not supported with rigid loops are errors that name them: external integrators, linear models and
/// modes of moving states, rotor analyses, gradients, penalties and failures of the loop; prescribed motions that contradict a loop are errors too.
#[test]
fn lp29_refusals_name_the_loop() {
    let mut plant = start(elastic(JointMotion::Free, None, solver(Method::Esdirk4, 1e-6)));
    assert_eq!(plant.hybrid().err(), Some(NotHybrid::RigidLoop));
    for refused in [plant.study().second_order().map(|_| ()), plant.study().modes(3).map(|_| ())] {
        let text = refused.expect_err("no linear model").to_string();
        assert!(text.contains("rigid loops are linearised at rest only"), "{text}");
    }
    let text = plant.study().rotor(0.0, None).map(|_| ()).expect_err("no rotor analysis").to_string();
    assert!(text.contains("the loop \"pin\" is rigid") && text.contains("stiffness_N_m"), "{text}");
    let mut held = Plant::new(Arc::new(elastic(JointMotion::Locked, None, solver(Method::Esdirk4, 1e-6))));
    held.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    assert_eq!(held.study().stability().expect("by pivots").static_directions(), 0);

    let with = |pin: ClosureBuilder| {
        let bars = rigid_bars(JointMotion::Free, solver(Method::Esdirk4, 1e-6), Rotation3::identity());
        let bar =
            |i: usize| Body::rigid(bars.bodies[i].name.clone()).inertia(1.0, [0.1, 0.0, 0.0], Matrix3::identity());
        Machine::builder("two")
            .body(bar(0), hinged_to_root(free_hinge(0.0)))
            .body(bar(1), Joint::hinge("other", free_hinge(0.0)).at_root([0.0, 0.0, 0.0]))
            .closure(pin)
            .stop_time_s(1.0)
            .step_s(1e-3)
    };
    let pin = || Closure::rigid("pin", ["crank", "coupler"]).offsets_m([[0.2, 0.0, 0.0]; 2]);
    let cases = [
        (with(pin().stiffness_n_m(1e5)), "no penalty in a loop with rigid = true"),
        (with(pin().damping_n_s_m(1.0)), "no penalty in a loop with rigid = true"),
        (with(pin().inertia_kg(1.0)), "no penalty in a loop with rigid = true"),
        (with(Closure::between("pin", ["crank", "coupler"], 0.0).offsets_m([[0.2, 0.0, 0.0]; 2])), "or rigid = true"),
        (with(pin()).failure(Failure::loop_break("snap", "pin", 0.5)), "constraint forces have none to weaken"),
    ];
    for (builder, expected) in cases {
        let text = builder.build().expect_err(expected).to_string();
        assert!(text.contains(expected), "{text}");
    }

    // the prescribed motions of both ends of the pin separate them
    let mut machine = built(with(pin()));
    hinge_of(&mut machine, 0).motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 1.0]));
    hinge_of(&mut machine, 1).motion = JointMotion::Locked;
    let mut plant = Plant::new(Arc::new(machine));
    let refused = plant.initialize(0.0).and_then(|()| plant.step(0.01));
    let text = refused.as_ref().expect_err("a contradiction").to_string();
    assert!(text.contains("rigid loops stay open") && text.contains("release a joint"), "{text}");
    assert!(!matches!(refused, Err(PlantError::NotFinite { .. })));
}

/// LP-30. Cost compared with the penalty: the elastic linkage over the same time at the same tolerance, alternately in one run; shortest of
/// five times.
#[test]
fn lp30_cost_beside_the_penalty() {
    let spent = |pin: Option<f64>| {
        let mut plant = start(elastic(JointMotion::Free, pin, solver(Method::Esdirk4, 1e-6)));
        let begin = Instant::now();
        coast(&mut plant, 0.3);
        (begin.elapsed().as_secs_f64(), plant.statistics())
    };
    let mut least = [f64::INFINITY; 2];
    let mut counts = [Default::default(); 2];
    for _ in 0..5 {
        for (i, pin) in [None, Some(1e7)].into_iter().enumerate() {
            let (time_s, statistics) = spent(pin);
            least[i] = least[i].min(time_s);
            counts[i] = statistics;
        }
    }
    let [rigid, penalty] = counts;
    let per_step = |i: usize| least[i] / counts[i].steps as f64;
    println!(
        "LP-30 rigid {:.2} ms, {} steps, {} iterations; penalty {:.2} ms, {} steps, {} iterations; per step {:.2} times",
        1e3 * least[0],
        rigid.steps,
        rigid.iterations,
        1e3 * least[1],
        penalty.steps,
        penalty.iterations,
        per_step(0) / per_step(1)
    );
    assert!(rigid.iterations <= 2 * penalty.iterations, "{} iterations for {}", rigid.iterations, penalty.iterations);
}

/// LP-31. Steps with rigid loops allocate no memory: every method, with communication points inside internal steps; the braced wing through
/// its latch.
#[test]
fn lp31_steps_with_rigid_loops_allocate_nothing() {
    let counted = |label: &str, mut plant: Plant, step_s: f64, steps: u32| {
        coast(&mut plant, step_s);
        let before = allocations();
        (2..=steps).for_each(|step| coast(&mut plant, step_s * f64::from(step)));
        assert_eq!(allocations() - before, 0, "{label}: allocations");
        plant
    };
    for method in [Method::Esdirk4, Method::Esdirk3, Method::TrBdf2, Method::GeneralizedAlpha, Method::Rk4] {
        let fixed = (method == Method::Rk4).then_some(1e-3);
        let solver = Solver { fixed_step_s: fixed, ..solver(method, 1e-6) };
        let bars = rigid_bars(JointMotion::Free, solver, Rotation3::identity());
        counted(&format!("{method:?}"), start(bars), 1.3e-3, 200);
    }
    let wing = counted("braced wing", start(of_file(BRACED)), 5e-3, 220);
    assert!(wing.outputs().latches()[2].closed.is_on(), "the steps cross the latch");
}
