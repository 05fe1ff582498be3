//! S-10 to S-20: equilibrium against closed forms, elliptic integrals and shooting.

use crate::reference::{case, numbers};
use crate::rod::Rod;
use crate::statics::machines::{Cantilever, assert_order, at_rest, plant};
use foldwing::plant::{Holding, PlantError};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use std::f64::consts::{PI, TAU};

fn tip(beam: &Cantilever) -> Vector3<f64> {
    at_rest(&beam.text()).0.outputs().tips()[0].position_m
}

/// S-10. A tip moment `2π EI/L` rolls the beam up into a full circle, twice that moment into two: the tip coincides with the root on every
/// mesh (constant strain is exact), whether the moment follows the section or is fixed in the root frame.
#[test]
fn s10_roll_up_under_follower_and_dead_moment() {
    for (element, elements) in [("constant", 5), ("constant", 16), ("linear", 3), ("linear", 8)] {
        for load_frame in ["section", "root"] {
            for turns in [1.0, 2.0] {
                let moment = [0.0, TAU * turns, 0.0];
                let beam = Cantilever { element, elements, load_frame, tip: [[0.0; 3], moment], ..Default::default() };
                let (plant, effort) = at_rest(&beam.text());
                let gap = plant.outputs().tips()[0].position_m.norm();
                println!("S-10 {elements} {element}, {load_frame}, {turns} turns: gap {gap:.1e} L, {effort:?}");
                assert!(gap < 1e-10, "{elements} {element}, {load_frame}: tip misses root by {gap:.1e} L");
            }
        }
    }
}

fn elastica_errors(load: f64, frame: &'static str, element: &'static str, meshes: &[usize], w_u: [f64; 2]) -> Vec<f64> {
    let error = |&elements: &usize| {
        let beam = Cantilever {
            element,
            elements,
            load_frame: frame,
            tip: [[0.0, 0.0, load], [0.0; 3]],
            ..Default::default()
        };
        let tip = tip(&beam);
        (tip.z - w_u[0]).abs().max((1.0 - tip.x - w_u[1]).abs())
    };
    meshes.iter().map(error).collect()
}

/// S-11. Elastica under a dead tip force, `λ = PL²/EI` up to 10 (elliptic integrals, 1e-9): 16 constant elements are within 1e-3 L, order
/// 2; 8 pairs within 5e-6 L, order 4.
#[test]
fn s11_elastica_dead() {
    for row in case("static.elastica_dead")["expected"]["rows"].as_array().expect("rows") {
        let row = numbers(row);
        let constant = elastica_errors(row[0], "root", "constant", &[8, 16, 32], [row[1], row[2]]);
        assert_order(&format!("S-11 constant, load {}", row[0]), &constant, 1.9, 2.1);
        assert!(constant[1] <= 1e-3, "load {}: 16 elements off by {:.1e} L", row[0], constant[1]);
        let pairs = elastica_errors(row[0], "root", "linear", &[4, 8, 16], [row[1], row[2]]);
        assert!(pairs[1] <= 5e-6, "load {}: 8 pairs off by {:.1e} L", row[0], pairs[1]);
        assert_order(&format!("S-11 pairs, load {}", row[0]), &pairs, 3.3, 4.6);
    }
}

/// S-12. The elastica with a follower force up to 10 (the rod solver, 1e-12): 16 constant elements are within 3e-3 L, order 2; 8 pairs
/// within 1e-4 L, order 4. Strains at the mesh boundaries of 16 pairs are within 2e-4 of the load.
#[test]
fn s12_elastica_follower() {
    for load in [1.0, 3.0, 10.0] {
        let rod = Rod {
            length_m: 1.0,
            stiffness: Matrix4::from_diagonal(&Vector4::new(1e9, 1.0, 1.0, 1.0)),
            natural_strain: Vector4::zeros(),
            tip: [Vector3::z() * load, Vector3::zeros()],
            spread: |_| [Vector3::zeros(); 2],
        };
        let (_, exact, _) = rod.solve(1);
        let exact = [exact.z, 1.0 - exact.x];
        let constant = elastica_errors(load, "section", "constant", &[8, 16, 32], exact);
        assert_order(&format!("S-12 constant, load {load}"), &constant, 1.9, 2.1);
        assert!(constant[1] <= 3e-3, "load {load}: 16 elements off by {:.1e} L", constant[1]);
        let pairs = elastica_errors(load, "section", "linear", &[4, 8, 16], exact);
        assert_order(&format!("S-12 pairs, load {load}"), &pairs, 3.5, 4.5);
        assert!(pairs[1] <= 1e-4, "load {load}: 8 pairs off by {:.1e} L", pairs[1]);

        let follower =
            Cantilever { load_frame: "section", elements: 16, tip: [[0.0, 0.0, load], [0.0; 3]], ..Default::default() };
        let (plant, _) = at_rest(&follower.text());
        let (sections, _, _) = rod.solve(16);
        for (here, exact) in plant.shape()[0].iter().zip(&sections) {
            let error = (here.strain - exact.strain).amax();
            assert!(error < 2e-4 * load, "load {load}, strain at {} m off by {error:.1e}", here.place_m);
        }
    }
}

/// Tip of a rod under a dead tip force: Newton's method finds the follower force that has the required direction in the deformed state.
fn shoot(rod: &mut Rod, force: Vector3<f64>) -> Vector3<f64> {
    let miss = |rod: &mut Rod, local: Vector3<f64>| {
        rod.tip[0] = local;
        rod.solve(1).2 * local - force
    };
    // the load grows in steps so that the solution stays on the physical branch
    let mut local = Vector3::zeros();
    for step in 1..=10 {
        let share = f64::from(step) / 10.0;
        for _ in 0..12 {
            let here = miss(rod, local) + force * (1.0 - share);
            let h = 1e-5 * force.norm();
            let columns: [Vector3<f64>; 3] = [Vector3::x(), Vector3::y(), Vector3::z()]
                .map(|axis| (miss(rod, local + axis * h) - miss(rod, local - axis * h)) / (2.0 * h));
            local -= Matrix3::from_columns(&columns).lu().solve(&here).expect("regular");
        }
    }
    assert!(miss(rod, local).norm() < 1e-9 * force.norm(), "shooting has not converged");
    rod.solve(1).1
}

/// S-13. The 45° bend of Bathe and Bolourchi at 600 lb, and in a long test at 300 and 450 lb, with Saint-Venant's torsion constant: against shooting with the rod
/// solver (checked at 600 lb against the reference, 1e-5 in); order 4, and 3e-5 L with 8 pairs.
#[test]
fn s13_bend_of_45_degrees() {
    bend_of_45_degrees(&[600.0]);
}

#[test]
#[ignore = "long; `make long` runs it"]
fn s13_bend_of_45_degrees_under_smaller_loads() {
    bend_of_45_degrees(&[300.0, 450.0]);
}

fn bend_of_45_degrees(loads: &[f64]) {
    let (radius, area_2) = (100.0, 1e7 / 12.0);
    let stiffness = [1e7, 0.5e7 * 0.140_577_014_955_15, area_2, area_2];
    let length_m = radius * PI / 4.0;
    for &load in loads {
        let mut rod = Rod {
            length_m,
            stiffness: Matrix4::from_diagonal(&Vector4::from(stiffness)),
            natural_strain: Vector4::new(0.0, 0.0, 0.0, 1.0 / radius),
            tip: [Vector3::zeros(); 2],
            spread: |_| [Vector3::zeros(); 2],
        };
        let exact = shoot(&mut rod, Vector3::z() * load);
        if load == 600.0 {
            let expected = &case("static.bathe45")["expected"]["cases"]["Kirchhoff_extensible_GJ=G*0.140577"]["600"];
            let gap = (exact - Vector3::from_row_slice(&numbers(expected))).norm();
            assert!(gap < 2e-5, "shooting and reference differ by {gap:.1e} in");
        }
        let errors: Vec<f64> = [2, 4, 8]
            .iter()
            .map(|&elements| {
                let beam = Cantilever {
                    length_m,
                    stiffness,
                    elements,
                    natural_curvature: [0.0, 0.0, 1.0 / radius],
                    tip: [[0.0, 0.0, load], [0.0; 3]],
                    ..Default::default()
                };
                (tip(&beam) - exact).norm() / length_m
            })
            .collect();
        assert_order(&format!("S-13 {load} lb"), &errors, 3.8, 4.6);
        assert!(errors[2] < 3e-5, "{load} lb: 8 pairs off by {:.1e} L", errors[2]);
    }
}

/// S-14. \[M\] set 1, a 90 m beam of 8 m × 2 m under 10 and 50 MN (shooting, 1e-8): 12 pairs within 1e-7 L, order 4;
/// 32 constant elements within 1e-3 L, order 2.
#[test]
fn s14_wide_blade_of_seed_001() {
    for row in case("static.seed001_set1")["expected"].as_array().expect("rows") {
        let value = |key: &str| row[key].as_f64().expect("a number");
        for (element, meshes, finest, least, most) in
            [("linear", [3, 6, 12], 1e-7, 3.5, 4.5), ("constant", [8, 16, 32], 1e-3, 1.9, 2.1)]
        {
            let errors = meshes.map(|elements| {
                let young = 70e9;
                let beam = Cantilever {
                    length_m: 90.0,
                    stiffness: [young * 16.0, 28e9 * 17.9, young * 16.0 / 3.0, young * 256.0 / 3.0],
                    element,
                    elements,
                    tip: [[0.0, 0.0, 1e3 * value("F_kN")], [0.0; 3]],
                    ..Default::default()
                };
                let tip = tip(&beam);
                let gaps = [tip.z - value("kirch_ext_w"), tip.x - 90.0 - value("kirch_ext_u")];
                gaps[0].abs().max(gaps[1].abs()) / 90.0
            });
            assert_order(&format!("S-14 {element}, {} kN", row["F_kN"]), &errors, least, most);
            assert!(errors[2] < finest, "{} kN: {} {element} off by {:.1e} L", row["F_kN"], meshes[2], errors[2]);
        }
    }
}

/// Tip of an inextensible cantilever under its weight `w` per length towards −z: `θ'' = w (L − s) cos θ`, `EI = 1`,
/// shooting for `θ'(L) = 0` with Runge–Kutta 4.
fn heavy_elastica(weight: f64) -> [f64; 2] {
    let march = |slope: f64| {
        let steps = 4000;
        let h = 1.0 / f64::from(steps);
        // θ positive downward
        let f = |s: f64, y: [f64; 4]| [y[1], -weight * (1.0 - s) * y[0].cos(), y[0].cos(), -y[0].sin()];
        let mut y = [0.0, slope, 0.0, 0.0];
        for i in 0..steps {
            let s = f64::from(i) * h;
            let plus = |k: [f64; 4], h: f64| std::array::from_fn(|j| y[j] + h * k[j]);
            let k1 = f(s, y);
            let k2 = f(s + 0.5 * h, plus(k1, 0.5 * h));
            let k3 = f(s + 0.5 * h, plus(k2, 0.5 * h));
            let k4 = f(s + h, plus(k3, h));
            y = std::array::from_fn(|j| y[j] + h / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]));
        }
        y
    };
    let (mut low, mut high) = (0.0, weight);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if march(middle)[1] > 0.0 { high = middle } else { low = middle }
    }
    let end = march(0.5 * (low + high));
    [end[2], end[3]]
}

/// S-15. A beam that sags under its own weight, `wL³/EI = 2` and 20, against shooting: order 4, and 1e-5 L with 8 pairs. The root reaction
/// equals the weight to round-off.
#[test]
fn s15_beam_under_its_weight() {
    for weight in [2.0, 20.0] {
        let exact = heavy_elastica(weight);
        let errors: Vec<f64> = [4, 8, 16]
            .iter()
            .map(|&elements| {
                let beam = Cantilever { elements, gravity: [0.0, 0.0, -weight], ..Default::default() };
                let (plant, _) = at_rest(&beam.text());
                let outputs = plant.outputs();
                let force = outputs.root().force_n + Vector3::new(0.0, 0.0, weight);
                assert!(force.norm() < 1e-12 * weight, "root force off by {:.1e} N", force.norm());
                let tip = outputs.tips()[0].position_m;
                (tip.x - exact[0]).abs().max((tip.z - exact[1]).abs())
            })
            .collect();
        assert_order(&format!("S-15 weight {weight}"), &errors, 3.4, 4.6);
        assert!(errors[1] < 2e-5, "weight {weight}: 8 pairs off by {:.1e} L", errors[1]);
    }
}

/// Two stiff bars of unit length and mass along `x`, the outer one on a hinge about `y` at 30°.
fn bars(joint: &str, rest: &str) -> String {
    format!(
        "name = 'Bars'\ngravity_m_s2 = [0.0, 0.0, -10.0]\n\
         [section.s]\nshape = 'explicit'\naxial_stiffness_N = 1e10\ntorsional_rigidity_N_m2 = 1e9\n\
         flap_stiffness_N_m2 = 1e9\nedge_stiffness_N_m2 = 1e9\nmass_kg_m = 1.0\nsecond_moments_kg_m = [1e-9, 0.0, 0.0]\n\
         [body.inner]\nlength_m = 1.0\nsection = 's'\nelements = 1\n\
         [body.outer]\nlength_m = 1.0\nsection = 's'\nelements = 1\n\
         [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'inner'\n\
         [joint.fold]\ntype = 'revolute'\nparent = 'inner'\nchild = 'outer'\naxis = [0.0, 1.0, 0.0]\n\
         start_angle_deg = 30.0\n{joint}\n{rest}\n"
    )
}

/// S-16. A hinge with a spring rotates until spring, motor and weight balance: `k(θ − θ_cmd) + T = ½ m g cos θ`. Stiff bars: 1e-7. A locked
/// hinge does not move, and a simulation started from equilibrium remains at rest.
#[test]
fn s16_hinge_with_spring_stopper_and_latch() {
    let drive = "[joint.fold.motor]\nstiffness_N_m_rad = 4.0\nconstant_torque_N_m = 0.7\ncommand_deg = 20.0\n";
    let (plant_at_rest, effort) = at_rest(&bars(drive, ""));
    let angle = plant_at_rest.outputs().joints()[0].angle_rad;
    let balance = 4.0 * (angle - 20f64.to_radians()) + 0.7 - 5.0 * angle.cos();
    println!("S-16 angle {:.6} deg, {effort:?}", angle.to_degrees());
    assert!(balance.abs() < 1e-7, "{balance:.1e} N·m at {angle} rad");

    let limited = "[joint.fold.motor]\nstiffness_N_m_rad = 40.0\ntorque_limit_N_m = 3.0\n";
    let (plant_at_rest, _) = at_rest(&bars(limited, ""));
    let angle = plant_at_rest.outputs().joints()[0].angle_rad;
    assert!((5.0 * angle.cos() - 3.0).abs() < 1e-6, "the limit of 3 N·m holds the bar at acos(0.6), not {angle} rad");

    let latch = "[joint.fold.motor]\nstiffness_N_m_rad = 4.0\n[joint.fold.latch]\nstiffness_N_m_rad = 1e3\n\
                 angle_deg = 30.0\ninitially_closed = true\n";
    let (plant_at_rest, _) = at_rest(&bars(latch, ""));
    let angle = plant_at_rest.outputs().joints()[0].angle_rad;
    let balance = 4.0 * angle + 1e3 * (angle - 30f64.to_radians()) - 5.0 * angle.cos();
    assert!(balance.abs() < 1e-6 && plant_at_rest.outputs().latches()[0].closed.is_on(), "{balance:.1e} N·m");

    let mut held = plant(&bars(&format!("release = false\n{drive}"), "[simulation]\nstart = 'equilibrium'"));
    held.initialize(0.0).unwrap();
    let before = held.outputs().clone();
    held.step(0.3).unwrap();
    let moved = (held.outputs().tips()[0].position_m - before.tips()[0].position_m).norm();
    assert_eq!(held.outputs().joints()[0].angle_rad, 30f64.to_radians());
    assert!(moved < 1e-12 && before.tips()[0].position_m.z < -0.4, "the tip moves by {moved:.1e} m");
}

/// S-17. A free hinge without restraint is rejected with its name and the load reached.
#[test]
fn s17_free_hinge_is_refused() {
    let text = bars("", "").replace("-10.0", "0.0");
    let error = plant(&text).study().equilibrium(0.0, Holding::AsReleased).unwrap_err();
    assert!(matches!(error, PlantError::Equilibrium { reached: 0.0, .. }), "{error:?}");
    let message = error.to_string();
    assert!(message.contains("joint \"fold\"") && message.contains("release = false"), "{message}");
    // under gravity it hangs down
    let (plant, effort) = at_rest(&bars("", ""));
    let angle = plant.outputs().joints()[0].angle_rad;
    println!("S-17 hangs at {angle}, {effort:?}");
    assert!((angle - PI / 2.0).abs() < 1e-7, "{angle}");
}

/// S-18. A root that rotates about `z` stretches the beam: `EA ε(0) = ½ρΩ²L²` to first order in the strain (1e-7).
#[test]
fn s18_spinning_root_stretches_the_beam() {
    let beam = Cantilever { stiffness: [1e9, 1e3, 1e3, 1e3], elements: 4, ..Default::default() };
    let mut plant = plant(&beam.text());
    plant.inputs_mut().root_mut().angular_velocity_rad_s = Vector3::new(0.0, 0.0, 20.0);
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap();
    let strain = plant.shape()[0][0].strain[0];
    let exact = 0.5 * 400.0 / 1e9;
    assert!((strain / exact - 1.0).abs() < 1e-6, "{strain:.9e} instead of {exact:.9e}");
    let force = plant.outputs().root().force_n.x;
    assert!((force - 200.0).abs() < 1e-4, "{force} N on the root");
}

/// S-19. The work of a static solution is proportional to the number of elements: 1000 pairs take as many iterations, each of one outward
/// and one inward sweep, as 16, apart from one that depends on round-off. The time of an iteration is measured by `cargo bench -p
/// foldwing-benches --bench kernels` (group `statics`), because clocks are unreliable on a shared computer.
#[test]
fn s19_cost_is_linear() {
    let effort = |elements: usize| {
        let beam = Cantilever { elements, tip: [[0.0, 0.0, 3.0], [0.0; 3]], ..Default::default() };
        plant(&beam.text()).study().equilibrium(0.0, Holding::AsReleased).unwrap()
    };
    let (few, many) = (effort(16), effort(1000));
    println!("S-19 {few:?} with 16 pairs, {many:?} with 1000");
    assert_eq!((few.load_steps, few.halvings), (many.load_steps, many.halvings));
    let (few, many) = (16 * few.iterations, 1000 * many.iterations);
    assert!(many * 16 <= (few + 16) * 1000, "{few} elements swept with 16 pairs, {many} with 1000");
}

/// Two bodies with a ball joint and its spring between them, rotated as a whole by a rotation vector in degrees, under gravity `g`, also
/// rotated.
fn ball_wing(turn_deg: Vector3<f64>) -> (String, Matrix3<f64>) {
    let rotation = nalgebra::Rotation3::new(turn_deg.map(f64::to_radians)).into_inner();
    let gravity: [f64; 3] = (rotation * Vector3::new(1.0, 3.0, -9.0)).into();
    let mount: [f64; 3] = turn_deg.into();
    let text = format!(
        "name = 'Ball'\ngravity_m_s2 = {gravity:?}\n\
         [section.s]\nshape = 'explicit'\naxial_stiffness_N = 1e5\ntorsional_rigidity_N_m2 = 8.0\n\
         flap_stiffness_N_m2 = 9.0\nedge_stiffness_N_m2 = 20.0\nmass_kg_m = 0.4\n\
         centre_of_mass_m = [0.03, 0.01]\nsecond_moments_kg_m = [1e-3, 0.0, 1e-4]\n\
         [body.inner]\nlength_m = 0.7\nsection = 's'\nelements = 2\n\
         [body.outer]\nlength_m = 0.6\nsection = 's'\nelements = 2\n\
         [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'inner'\nmount_rotation_deg = {mount:?}\n\
         [joint.hip]\ntype = 'ball'\nparent = 'inner'\nchild = 'outer'\nmount_rotation_deg = [20.0, 30.0, 40.0]\n\
         [joint.hip.motor]\nstiffness_N_m_rad = 1.5\n"
    );
    (text, rotation)
}

/// S-20. Frame invariance with a flexible ball joint: the machine and its gravity rotated as a whole bend to the same shape, rotated;
/// frequencies are equal. The spring of a ball joint used to act in the root frame.
#[test]
fn s20_turned_machines_bend_alike() {
    let (text, _) = ball_wing(Vector3::zeros());
    let (mut straight, _) = at_rest(&text);
    let tip = straight.outputs().tips()[0].position_m;
    let before = straight.study().modes(4).unwrap();
    for turn_deg in [Vector3::new(0.0, 0.0, 90.0), Vector3::new(50.0, -120.0, 70.0)] {
        let (text, rotation) = ball_wing(turn_deg);
        let (mut turned, effort) = at_rest(&text);
        let gap = (turned.outputs().tips()[0].position_m - rotation * tip).norm();
        println!("S-20 {turn_deg:?}: {gap:.1e} m, {effort:?}");
        assert!(gap < 1e-12, "{turn_deg:?}: tip off by {gap:.1e} m");
        for (mode, reference) in turned.study().modes(4).unwrap().iter().zip(&before) {
            let error = (mode.frequency_hz / reference.frequency_hz - 1.0).abs();
            assert!(error < 1e-9, "{} Hz against {} Hz", mode.frequency_hz, reference.frequency_hz);
        }
    }
}
