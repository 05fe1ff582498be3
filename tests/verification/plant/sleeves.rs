//! Sleeves: a beam slides through a body that is held elsewhere. The sleeve is a body on a sliding joint of the beam, and loops hold it.

use crate::plant::machines::*;
use crate::plant::sliding::slender;
use foldwing::beam::section::Section;
use foldwing::config;
use foldwing::load::Wrench;
use foldwing::machine::builder::{ClosureBuilder, JointBuilder, MachineBuilder};
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::{Matrix3, SVector, Vector3};

/// Distance of the rod's or beam's inner end from the sleeve at the start, m.
const INSERTED_M: f64 = 0.3;

/// A beam of 1 m in free flight along `x`, which starts with the given velocity, and a sleeve on it at the root's origin, of 0.1 kg and at rest.
fn through(
    beam: (&Section, ElementKind, usize),
    fly: JointBuilder,
    velocity_m_s: f64,
    holds: impl IntoIterator<Item = ClosureBuilder>,
) -> MachineBuilder {
    let (section, kind, count) = beam;
    let sleeve = Body::rigid("sleeve").inertia(0.1, [0.0; 3], Matrix3::from_diagonal_element(1e-3));
    let slide = Joint::sliding("slide").on("beam").start_position_m(INSERTED_M).start_rate_m_s(-velocity_m_s);
    let built = Machine::builder("sleeve")
        .body(
            body("beam", 1.0, section, kind, count).load_station_positions_m([1.0]),
            fly.at_root([-INSERTED_M, 0.0, 0.0]),
        )
        .body(sleeve, slide);
    holds.into_iter().fold(built, |machine, hold| machine.closure(hold)).stop_time_s(2.0)
}

/// Rigid loops that hold three points of the sleeve on the root.
fn clamps() -> Vec<ClosureBuilder> {
    let points_m = [[0.0; 3], [0.05, 0.0, 0.0], [0.0, 0.05, 0.0]];
    let hold = |(i, point_m)| Closure::rigid(format!("hold{i}"), ["sleeve", "root"]).offsets_m([point_m, point_m]);
    points_m.into_iter().enumerate().map(hold).collect()
}

fn plant_of(machine: MachineBuilder, tolerance: f64) -> Plant {
    let built = machine.solver(solver(Method::Esdirk4, tolerance)).build();
    start(built.unwrap_or_else(|refused| panic!("{refused}")))
}

/// Largest gap of the loops in m.
fn gap_m(plant: &Plant) -> f64 {
    plant.outputs().loops().iter().map(|closure| closure.gap_m.norm()).fold(0.0, f64::max)
}

/// SJ-22. A stiff rod slides down through a fixed sleeve that is inclined by 30°: `s = s₀ − ½ g t² sin 30°` over element boundaries, without a
/// gap. Through a sleeve held at one point it also rotates: `(J + I + m r²) ω` is constant and `r̈ = r ω²`, with the distance `r` of its centre
/// of mass from the pivot, the inertia `J` of the rod and `I` of the sleeve.
#[test]
fn sj22_a_stiff_rod_slides_through_a_sleeve() {
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        let stiff = slender(1e8, 1e5, 1e-8);
        let machine = through((&stiff, kind, 4), Joint::free("fly"), 0.0, clamps());
        let (along, across) = (9.81 * 0.5, -9.81 * 0.75f64.sqrt());
        let mut plant = plant_of(machine.gravity_m_s2([along, 0.0, across]), 1e-8);
        let before_j = balance_j(plant.outputs());
        let (mut off_m, mut gap) = (0.0f64, 0.0f64);
        for step in 1..=34 {
            let time_s = 0.01 * f64::from(step);
            coast(&mut plant, time_s);
            let due_m = INSERTED_M - 0.5 * along * time_s * time_s;
            off_m = off_m.max((plant.outputs().joints()[0].angle_rad - due_m).abs());
            gap = gap.max(gap_m(&plant));
        }
        let (s_m, drift_j) = (plant.outputs().joints()[0].angle_rad, balance_j(plant.outputs()) - before_j);
        let sleeve_m = plant.outputs().tips()[1].position_m.norm();
        println!("SJ-22 fixed, {kind:?}: s {s_m:.4} m off by {off_m:.1e} m, gap {gap:.1e} m, drift {drift_j:.1e} J");
        assert!(s_m < 0.02 && plant.statistics().events >= 1, "{s_m}");
        assert!(off_m < 2e-6 && gap < 1e-12 && sleeve_m < 1e-12 && drift_j.abs() < 1e-6, "{off_m:e} {drift_j:e}");

        // ω about y; a rotation by +ω about y moves +x towards −z
        let spin = 4.0;
        let fly = Joint::free("fly").start_angular_velocity_rad_s([0.0, spin, 0.0]);
        let fly = fly.start_velocity_m_s([0.0, 0.0, INSERTED_M * spin]);
        let pivot = Closure::rigid("pivot", ["sleeve", "root"]).offsets_m([[0.0; 3]; 2]);
        let mut plant = plant_of(through((&stiff, kind, 4), fly, 0.0, [pivot]), 1e-9);
        let inertia = |r_m: f64| 0.5 / 12.0 + 1e-3 + 0.5 * r_m * r_m;
        let momentum = inertia(0.5 - INSERTED_M) * spin;
        let rates = |y: &SVector<f64, 3>| {
            let own = momentum / inertia(y[0]);
            SVector::<f64, 3>::new(y[1], y[0] * own * own, own)
        };
        let mut due = SVector::<f64, 3>::new(0.5 - INSERTED_M, 0.0, 0.0);
        let (end_s, steps) = (0.27, 1000);
        let h = end_s / f64::from(steps);
        for _ in 0..steps {
            let k1 = rates(&due);
            let k2 = rates(&(due + k1 * (0.5 * h)));
            let k3 = rates(&(due + k2 * (0.5 * h)));
            let k4 = rates(&(due + k3 * h));
            due += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        coast(&mut plant, end_s);
        let s_m = plant.outputs().joints()[0].angle_rad;
        let tip_m = Vector3::new(due[2].cos(), 0.0, -due[2].sin()) * (due[0] + 0.5);
        let off_m = (plant.outputs().tips()[0].position_m - tip_m).norm().max((0.5 - s_m - due[0]).abs());
        println!("SJ-22 pivoted, {kind:?}: s {s_m:.4} m off by {off_m:.1e} m, gap {:.1e} m", gap_m(&plant));
        assert!(s_m < 0.24 && plant.statistics().events >= 1, "{s_m}");
        assert!(off_m < 2e-6 && gap_m(&plant) < 1e-12, "{off_m:e}");
    }
}

/// A flexible beam that moves at 1.2 m/s against `x` through a sleeve, and is pushed aside at its outer end, for 0.4 s, with other holds of the
/// sleeve.
fn pushed(pairs: usize, holds: impl IntoIterator<Item = ClosureBuilder>, tolerance: f64) -> Plant {
    let soft = slender(1e4, 1.0, 1e-6);
    let fly = Joint::free("fly").start_velocity_m_s([-1.2, 0.0, 0.0]);
    let mut plant = plant_of(through((&soft, ElementKind::Linear, pairs), fly, -1.2, holds), tolerance);
    plant.inputs_mut().stations_mut()[0] =
        Wrench { force_n: Vector3::new(0.0, 0.3, 0.9), moment_n_m: Vector3::zeros() };
    plant
}

/// SJ-23. A flexible beam slides through a fixed sleeve and is pushed aside: the energy account closes across element boundaries, with the loss
/// of the impulses, which rigid loops restrict. The motion converges slowly with the number of pairs, because the curvature of the beam jumps at
/// the sleeve, inside of an element. A sleeve of 1e4 kg in free flight instead of one held by loops, and loops with a stiffness, give the same
/// to 5e-4 m and to the gap.
#[test]
fn sj23_a_flexible_beam_slides_through_a_sleeve() {
    let mut tips_m = Vec::new();
    for pairs in [2, 4, 8, 16] {
        let mut plant = pushed(pairs, clamps(), 1e-10);
        let before_j = balance_j(plant.outputs());
        let (mut gap, mut aside_m) = (0.0f64, 0.0f64);
        for step in 1..=40 {
            coast(&mut plant, 0.01 * f64::from(step));
            gap = gap.max(gap_m(&plant));
            aside_m = aside_m.max(plant.outputs().tips()[0].position_m.yz().norm());
        }
        let drift_j = balance_j(plant.outputs()) - before_j;
        let (energy, tip_m) = (plant.outputs().energy(), plant.outputs().tips()[0].position_m);
        println!(
            "SJ-23 {pairs} pairs: tip aside {:.4} m, gap {gap:.1e} m, drift {drift_j:.1e} J of {:.2} J, lost {:.1e} J, {} events",
            aside_m,
            energy.total,
            energy.dissipated,
            plant.statistics().events
        );
        assert!(aside_m > 0.02 && plant.statistics().events >= 1 && energy.dissipated >= -1e-13);
        assert!(gap < 1e-12 && drift_j.abs() < 1e-7, "{gap:e} m, {drift_j:e} J");
        tips_m.push(tip_m);
    }
    let off: Vec<f64> = (0..3).map(|i| (tips_m[i] - tips_m[3]).norm()).collect();
    let order = (off[0] / off[2]).ln() / 4f64.ln();
    println!("SJ-23 apart {off:?} m, order {order:.2}");
    // the curvature jumps at the sleeve, inside of an element
    assert!(order > 1.0, "{order}");

    // a sleeve that its mass holds in place of the loops: it moves by the impulse of the push over its mass
    let mut heavy = pushed(4, [], 1e-8);
    let mut machine = heavy.machine().clone();
    machine.bodies[1].masses[0].mass_kg = 1e4;
    machine.bodies[1].masses[0].inertia_kg_m2 = Matrix3::from_diagonal_element(1e4);
    let push = heavy.inputs_mut().stations_mut()[0];
    heavy = start(machine);
    heavy.inputs_mut().stations_mut()[0] = push;
    coast(&mut heavy, 0.4);
    let apart_m = (heavy.outputs().tips()[0].position_m - tips_m[1]).norm();
    let mut sprung_m = Vec::new();
    for stiffness_n_m in [1e5, 1e6] {
        let holds = clamps().into_iter().enumerate().map(|(i, _)| {
            let point_m = [[0.0; 3], [0.05, 0.0, 0.0], [0.0, 0.05, 0.0]][i];
            let hold = Closure::between(format!("hold{i}"), ["sleeve", "root"], stiffness_n_m);
            hold.offsets_m([point_m, point_m]).damping_n_s_m(1e-3 * stiffness_n_m).inertia_kg(0.02)
        });
        let mut plant = pushed(4, holds, 1e-9);
        let before_j = balance_j(plant.outputs());
        coast(&mut plant, 0.4);
        let drift_j = balance_j(plant.outputs()) - before_j;
        assert!(drift_j.abs() < 1e-6, "{drift_j:e} J");
        sprung_m.push((plant.outputs().tips()[0].position_m - tips_m[1]).norm());
    }
    println!("SJ-23 heavy sleeve {apart_m:.1e} m apart, loops with a stiffness {sprung_m:?} m");
    assert!(apart_m < 5e-4 && sprung_m[1] < 0.2 * sprung_m[0] && sprung_m[1] < 1e-3, "{apart_m:e} {sprung_m:?}");
}

/// SJ-23. A drive pulls a bent beam through a fixed sleeve at a prescribed rate: the energy account closes with the work of the drive, also that
/// of its impulses at borders of constant elements, where the curvature jumps.
#[test]
fn sj23_a_drive_pulls_a_bent_beam_through_a_sleeve() {
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        let (soft, speed_m_s) = (slender(1e4, 1.0, 1e-3), 1.5);
        let sleeve = Body::rigid("sleeve").inertia(0.1, [0.0; 3], Matrix3::from_diagonal_element(1e-3));
        let slide = Joint::sliding("slide").on("beam").prescribed(Motion::Polynomial(vec![INSERTED_M, speed_m_s]));
        let fly = Joint::free("fly").start_velocity_m_s([-speed_m_s, 0.0, 0.0]).at_root([-INSERTED_M, 0.0, 0.0]);
        let beam = body("beam", 1.0, &soft, kind, 6);
        let built = Machine::builder("drawn").gravity_m_s2([0.0, 3.0, -9.81]).body(beam, fly).body(sleeve, slide);
        let mut plant = plant_of(clamps().into_iter().fold(built, |machine, hold| machine.closure(hold)), 1e-9);
        let before_j = balance_j(plant.outputs());
        coast(&mut plant, 0.35);
        let (drift_j, energy) = (balance_j(plant.outputs()) - before_j, plant.outputs().energy());
        println!(
            "SJ-23 driven, {kind:?}: work {:.4} J, lost {:.1e} J, drift {drift_j:.1e} J, gap {:.1e} m, {} events",
            energy.work,
            energy.dissipated,
            gap_m(&plant),
            plant.statistics().events
        );
        assert!(plant.statistics().events >= 2 && energy.work.abs() > 0.01 && energy.dissipated > -1e-12);
        assert!(drift_j.abs() < 1e-7 && gap_m(&plant) < 1e-12, "{drift_j:e} J");
    }
}

/// SJ-23. A sleeve in a model file; a state saved before a border continues to the bit.
#[test]
fn sj23_a_sleeve_in_a_file() {
    let text = include_str!("sliding.toml").replace("type = \"clamped\"", "type = \"free\"");
    let sleeve = "[mass.own]\nbody = \"bead\"\nposition_m = 0.0\nmass_kg = 0.1\n";
    let holds: String = [[0.0, 0.0], [0.05, 0.0], [0.0, 0.05]]
        .iter()
        .enumerate()
        .map(|(i, [x, y])| {
            format!("[loop.hold{i}]\nbodies = [\"bead\", \"root\"]\noffsets_m = [[{x:?}, {y:?}, 0.0], [{:?}, {y:?}, 0.0]]\nrigid = true\n", x + 0.25)
        })
        .collect();
    let text = text.replace("[mass.mass]\nbody = \"bead\"\nposition_m = 0.0\nmass_kg = 0.1\n", sleeve) + "\n" + &holds;
    let text = text.replace("gravity_m_s2 = [4.905, 0.0, -8.4957]", "gravity_m_s2 = [-4.905, 0.0, -8.4957]");
    let mut plant = start(config::parse(&text, "sleeve.toml").unwrap_or_else(|refused| panic!("{refused}")));
    coast(&mut plant, 0.2);
    let (saved, early) = (plant.snapshot(), plant.statistics().events);
    coast(&mut plant, 0.4);
    let late = plant.outputs().joints()[0];
    assert!(plant.statistics().events > early && late.angle_rad > 0.5, "{late:?}");
    assert!(gap_m(&plant) < 1e-12, "{}", gap_m(&plant));
    plant.restore(&saved).expect("the state of this plant");
    coast(&mut plant, 0.4);
    assert_eq!(plant.outputs().joints()[0], late);
}
