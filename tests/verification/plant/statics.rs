//! Static results that remain after the motion has decayed.

use crate::plant::machines::*;
use crate::plant::rod::{Joint, Load, Rod, Segment};
use foldwing::load::{LoadFrame, Wrench};
use foldwing::machine::{ElementKind, Gauge, Latch, Machine};
use foldwing::plant::Plant;
use nalgebra::Vector3;

/// A clamped blade of 0.3 m with the wing's section, axially stiff, overdamped, with one station at its free end.
fn blade(frame: LoadFrame) -> Machine {
    let mut section = wing_section();
    section.stiffness[(0, 0)] = 1e9;
    let blade = body("blade", 0.3, &section, ElementKind::Linear, 8).mass_damping_1_s(60.0).stiffness_damping_s(1e-5);
    machine([(blade.load_station_positions_m([0.3]).load_frame(frame), clamped())])
}

/// Deflection and shortening (both divided by the length) and tip angle under a transverse force `lambda = P L²/EI`, after the motion has
/// decayed.
fn bent(frame: LoadFrame, lambda: f64) -> [f64; 3] {
    let machine = blade(frame);
    let stiffness_n_m2 = machine.bodies[0].section.at(0.0).stiffness[(2, 2)];
    let mut plant = start(machine);
    plant.inputs_mut().stations_mut()[0].force_n.z = lambda * stiffness_n_m2 / 0.09;
    coast(&mut plant, 1.2);
    assert!(plant.outputs().energy().kinetic < 1e-18, "still moving: {:.1e} J", plant.outputs().energy().kinetic);
    let tip = plant.outputs().tips()[0];
    let axis = tip.rotation * Vector3::x();
    [tip.position_m.z / 0.3, 1.0 - tip.position_m.x / 0.3, axis.z.atan2(axis.x)]
}

/// P-70. A transverse dead force at the free end: the elastica, `λ` up to 5 (elliptic integrals, 1e-9).
///
/// 8 pairs: 5e-6 is the engine's static target; the motion decays at 30 1/s or faster, e⁻³⁶ at 1.2 s.
#[test]
fn p70_dead_force_at_the_free_end_is_the_elastica() {
    for row in expected("static.elastica_dead")["rows"].as_array().expect("rows") {
        let row: Vec<f64> = row.as_array().expect("row").iter().filter_map(serde_json::Value::as_f64).collect();
        if row[0] > 5.0 {
            continue;
        }
        let [w, u, angle] = bent(LoadFrame::Root, row[0]);
        let errors = [w - row[1], u - row[2], angle - row[3]];
        println!("dead λ = {}: errors {errors:?}", row[0]);
        assert!(errors.iter().all(|error| error.abs() < 5e-6), "dead λ = {}: errors {errors:?} of L, rad", row[0]);
    }
}

/// P-71. A transverse follower force at the free end, `p` = 1 and 3 (shooting, 1e-7), and 5 by the shooting solver of these tests.
///
/// Tolerance 2e-5: errors under follower forces are about four times those under dead forces (measured on constant elements as well).
#[test]
fn p71_follower_force_at_the_free_end_is_the_elastica() {
    let reference = expected("static.elastica_follower");
    for row in reference["rows"].as_array().expect("rows") {
        let row: Vec<f64> = row.as_array().expect("row").iter().filter_map(serde_json::Value::as_f64).collect();
        if row[0] > 5.0 {
            continue;
        }
        let [w, u, angle] = bent(LoadFrame::Section, row[0]);
        let errors = [u - row[1], w - row[2], angle - row[3]];
        println!("follower p = {}: errors {errors:?}", row[0]);
        assert!(errors.iter().all(|error| error.abs() < 2e-5), "follower p = {}: errors {errors:?} of L, rad", row[0]);
    }
    let section = blade(LoadFrame::Section).bodies[0].section.at(0.0);
    let force_n = 5.0 * section.stiffness[(2, 2)] / 0.09;
    let end = Load { position_m: 0.3, force_n: Vector3::z() * force_n, moment_n_m: Vector3::zeros(), follower: true };
    let rod = Rod { segments: vec![Segment { length_m: 0.3, joint: None, loads: vec![end] }], ..Rod::of(&section) };
    let tip = rod.solve().stations[0];
    let [w, u, _] = bent(LoadFrame::Section, 5.0);
    let errors = [w - tip.z / 0.3, u - 1.0 + tip.x / 0.3];
    println!("follower p = 5: errors {errors:?}");
    assert!(errors.iter().all(|error| error.abs() < 4e-5), "follower p = 5: errors {errors:?} of L");
}

/// The latched wing, four stations per body, overdamped; dead loads on the inner body, follower loads on the outer.
fn latched_wing(pairs: usize) -> Machine {
    let mut machine = default_wing(1e-7);
    let hinge = hinge_of(&mut machine, 1);
    hinge.start_angle_rad = 0.0;
    hinge.latch = Some(Latch { initially_closed: true, ..latch(26.0) });
    hinge.motor.damping_n_m_s_rad = 0.01;
    for body in &mut machine.bodies {
        (body.elements, body.mass_damping_1_s, body.stiffness_damping_s) = (pairs, 60.0, 1e-5);
        body.station_positions_m = (0..4).map(|i| 0.15 * (f64::from(i) + 0.5) / 4.0).collect();
        body.masses.clear();
    }
    machine.bodies[1].load_frame = LoadFrame::Section;
    machine.gravity_m_s2 = Vector3::new(-3.0, 2.0, -9.0);
    machine.gauges.push(Gauge::axial("off", 0, 0.0, [0.02, -0.001]));
    machine
}

fn load_of(station: usize) -> Wrench {
    let phase = station as f64;
    Wrench {
        force_n: Vector3::new(0.05 * phase.cos(), 0.2 * phase.sin(), 0.1 + 0.05 * phase.cos()),
        moment_n_m: Vector3::new(0.004 * phase.cos(), 0.003 * phase.sin(), 0.002),
    }
}

/// The same machine for the shooting solver.
fn independent(machine: &Machine) -> Rod {
    let segments = machine.bodies.iter().enumerate().map(|(index, body)| Segment {
        length_m: body.length_m,
        joint: (index == 1).then_some(Joint { stiffness_n_m_rad: 26.0 + 0.026, constant_n_m: 0.043 }),
        loads: body
            .station_positions_m
            .iter()
            .enumerate()
            .map(|(i, &position_m)| {
                let Wrench { force_n, moment_n_m } = load_of(4 * index + i);
                Load { position_m, force_n, moment_n_m, follower: index == 1 }
            })
            .collect(),
    });
    Rod { segments: segments.collect(), gravity_m_s2: machine.gravity_m_s2, ..Rod::of(&wing_section()) }
}

fn at_rest(machine: Machine) -> Plant {
    let mut plant = start(machine);
    for (i, load) in plant.inputs_mut().stations_mut().iter_mut().enumerate() {
        *load = load_of(i);
    }
    coast(&mut plant, 1.5);
    plant
}

/// P-72. Forces and moments at all eight stations of the latched wing with gravity, after the motion has decayed, against an independent
/// shooting solution of the rod's equations: stations, root reaction, fold angle, strains at two gauges.
///
/// Concentrated loads inside a pair reduce the order to three or less: the limits follow measured errors at 4 pairs, and 8 pairs must at
/// least halve the error.
#[test]
fn p72_station_loads_bend_the_latched_wing_to_the_static_answer() {
    let solution = independent(&latched_wing(4)).solve();
    let errors_m = [4, 8].map(|pairs| {
        let plant = at_rest(latched_wing(pairs));
        let outputs = plant.outputs();
        assert!(outputs.energy().kinetic < 1e-18, "still moving: {:.1e} J", outputs.energy().kinetic);
        let places = outputs.stations().iter().zip(&solution.stations);
        let station_m = places.map(|(own, other)| (own.position_m - other).norm()).fold(0.0, f64::max);
        let force_n = (outputs.root().force_n - solution.root_force_n).norm();
        let moment_n_m = (outputs.root().moment_n_m - solution.root_moment_n_m).norm();
        let angle_rad = (outputs.joints()[0].angle_rad - solution.angles_rad[0]).abs();
        let strain_at_root = {
            let e = solution.root_strain;
            e[0] - 0.001 * e[2] - 0.02 * e[3]
        };
        let strain = (outputs.gauges()[1] / strain_at_root - 1.0).abs();
        println!(
            "{pairs} pairs: stations {station_m:.1e} m, root {force_n:.1e} N of {:.2}, {moment_n_m:.1e} N·m of {:.3}, \
             angle {angle_rad:.1e} rad of {:.1e}, root strain {strain:.1e}",
            solution.root_force_n.norm(),
            solution.root_moment_n_m.norm(),
            solution.angles_rad[0]
        );
        assert!(force_n < 1e-4 * solution.root_force_n.norm(), "root force misses by {force_n:.1e} N");
        assert!(moment_n_m < 1e-3 * solution.root_moment_n_m.norm(), "root moment misses by {moment_n_m:.1e} N·m");
        assert!(strain < 2e-3, "root strain misses by {strain:.1e} of itself");
        assert!(angle_rad < 1e-3 * solution.angles_rad[0].abs(), "fold angle misses by {angle_rad:.1e} rad");
        station_m
    });
    assert!(errors_m[0] < 3e-4 * 0.3, "stations miss by {:.1e} m", errors_m[0]);
    assert!(errors_m[1] < 0.25 * errors_m[0], "stations miss by {errors_m:?} m with 4 and 8 pairs");
}
