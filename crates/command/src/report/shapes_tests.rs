//! Shapes of modes compared with closed-form results, the mass matrix, another recursion and the eigenvector.

use super::*;
use crate::report::sample_tests::shipped;
use foldwing_engine::beam::section::{Material, Solid};
use foldwing_engine::machine::builder::BodyBuilder;
use foldwing_engine::machine::{Body, Joint, Machine};
use foldwing_engine::plant::{Holding, ModeShape, Search};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

/// Length of a beam with a height of a thousandth of its length: rotary inertia lowers the third mode by `3 (βL h/L)²/24`, 8e-6.
const LENGTH_M: f64 = 2.0;
const HEIGHT_M: f64 = 0.002;

fn beam(elements: usize) -> BodyBuilder {
    let plate = Solid::rectangle(0.04, HEIGHT_M, Material::isotropic(7e10, 0.3, 2700.0));
    Body::beam("beam", LENGTH_M, plate).elements(elements)
}

fn started(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Modes about the undeformed state, and the plant in this state.
fn bare(machine: Machine, count: usize) -> (Plant, Vec<ModeShape>) {
    let mut plant = started(machine);
    plant.study().undeformed(0.0).unwrap_or_else(|error| panic!("{error}"));
    let modes = plant.study().bare_modes(count).unwrap_or_else(|error| panic!("{error}"));
    (plant, modes)
}

fn cantilever(elements: usize) -> Machine {
    Machine::builder("Cantilever")
        .body(beam(elements), Joint::clamped("wall"))
        .build()
        .unwrap_or_else(|error| panic!("{error}"))
}

fn drawn(plant: &Plant, mode: &ModeShape) -> (Scene, Frame, DrawnMode) {
    let scene = Scene::of(plant);
    let frame = state_of(&scene, plant);
    let raw = DrawnMode {
        number: 1,
        eigenvalue_1_s: mode.eigenvalue_1_s,
        exponent_1_s: mode.eigenvalue_1_s,
        grows: false,
        words: String::new(),
        changes: vec![changes_of(&scene, plant, &mode.coordinates)],
        largest_m: 0.0,
        largest_rad: 0.0,
    };
    let mode = raw.scaled(&scene, std::slice::from_ref(&frame));
    (scene, frame, mode)
}

/// Deflection of a clamped-free beam at `x/L`, normalised to 1 at the end: Blevins, Formulas for Natural Frequency and Mode Shape (1979),
/// table 8-1.
fn deflection(beta: f64, x: f64) -> f64 {
    let sigma = (beta.sinh() - beta.sin()) / (beta.cosh() + beta.cos());
    let shape = |x: f64| (beta * x).cosh() - (beta * x).cos() - sigma * ((beta * x).sinh() - (beta * x).sin());
    shape(x) / shape(1.0)
}

/// MS-01. The first three drawn bending modes of a cantilever agree with their closed form. The deflection at all sections, relative to
/// the end, is correct to 1e-3 with 10 elements and to 1e-5 with 20, the positions of the nodes to 1e-5 and 2e-6 of the length.
#[test]
fn bending_modes_of_a_cantilever_have_their_closed_form() {
    for (elements, bounds) in [(10, [1e-3, 1e-5]), (20, [1e-5, 2e-6])] {
        compare_with_closed_form(elements, bounds);
    }
}

fn compare_with_closed_form(elements: usize, bounds: [f64; 2]) {
    let (plant, modes) = bare(cantilever(elements), 3);
    let nodes: [(f64, &[f64]); 3] =
        [(1.875_104_069, &[]), (4.694_091_133, &[0.783_444_551]), (7.854_757_438, &[0.503_547_873, 0.867_677_592])];
    for (mode, (beta, nodes)) in modes.iter().zip(nodes) {
        let (scene, _, mode) = drawn(&plant, mode);
        let places: Vec<f64> = scene.bodies[0].places_m.iter().map(|place_m| place_m / LENGTH_M).collect();
        let raised: Vec<f64> = mode.changes[0][0].iter().map(|[re, _]| re.displacement_m.z).collect();
        let tip = raised[raised.len() - 1];
        let mut worst = 0.0f64;
        for (x, z) in places.iter().zip(&raised) {
            worst = worst.max((z / tip - deflection(beta, *x)).abs());
        }
        // between sections the deflection is the cubic given by the deflections and rotations at both ends
        let step_m = LENGTH_M * (places[1] - places[0]);
        let slopes: Vec<f64> = mode.changes[0][0].iter().map(|[re, _]| -re.rotation_rad.y * step_m).collect();
        let between = |i: usize, t: f64| {
            let [t2, t3] = [t * t, t * t * t];
            raised[i - 1] * (2.0 * t3 - 3.0 * t2 + 1.0)
                + slopes[i - 1] * (t3 - 2.0 * t2 + t)
                + raised[i] * (3.0 * t2 - 2.0 * t3)
                + slopes[i] * (t3 - t2)
        };
        let root = |i: usize| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if between(i, middle) * raised[i - 1] > 0.0 { low = middle } else { high = middle }
            }
            places[i - 1] + (places[i] - places[i - 1]) * low
        };
        let found: Vec<f64> = (2..raised.len()).filter(|&i| raised[i - 1] * raised[i] < 0.0).map(root).collect();
        assert_eq!(found.len(), nodes.len(), "beta {beta}: {found:?}");
        let off = found.iter().zip(nodes).map(|(found, due)| (found - due).abs()).fold(0.0, f64::max);
        println!("MS-01 {elements} elements, beta {beta}: deflection off by {worst:.1e}, nodes by {off:.1e}");
        assert!(worst < bounds[0], "beta {beta}: {worst:.1e}");
        assert!(off < bounds[1], "beta {beta}: {found:?}");
        // at amplitude 1 the displacement of the end is a tenth of the diagonal of the box, or the largest rotation is half a radian
        let share = tip.abs() / LENGTH_M.hypot(0.04) / LARGEST_SHARE;
        let turn = mode.largest_rad / LARGEST_ROTATION_RAD;
        assert!((share.max(turn) - 1.0).abs() < 1e-4, "{share} {turn}");
    }
}

/// MS-02. Modes are orthogonal with respect to the mass matrix, which is computed independently: `φᵢᵀ M φⱼ` relative to the geometric mean
/// of the modal masses. They are also orthogonal by integrals of the drawn deflections, relative to the mass of the beam.
#[test]
fn modes_are_orthogonal_over_the_mass() {
    let (mut plant, modes) = bare(cantilever(10), 6);
    let mass = plant.study().second_order().unwrap_or_else(|error| panic!("{error}")).mass;
    let product = |i: usize, j: usize| {
        let column =
            |mode: &ModeShape| nalgebra::DVector::from_iterator(mass.nrows(), mode.coordinates.iter().map(|x| x.re));
        column(&modes[i]).dot(&(&mass * column(&modes[j])))
    };
    for i in 0..6 {
        for j in 0..i {
            let share = product(i, j).abs() / (product(i, i) * product(j, j)).sqrt();
            assert!(share < 1e-9, "modes {} and {}: {share:.1e}", i + 1, j + 1);
        }
    }
    let shapes: Vec<Vec<f64>> = (0..3)
        .map(|i| drawn(&plant, &modes[i]).2.changes[0][0].iter().map(|[re, _]| re.displacement_m.z).collect())
        .collect();
    let integral = |i: usize, j: usize| {
        let n = shapes[i].len() - 1;
        // Simpson's rule on equal intervals
        (0..=n)
            .map(|k| {
                let weight = if k == 0 || k == n {
                    1.0
                } else if k % 2 == 1 {
                    4.0
                } else {
                    2.0
                };
                weight * shapes[i][k] * shapes[j][k]
            })
            .sum::<f64>()
    };
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let share = integral(i, j).abs() / (integral(i, i) * integral(j, j)).sqrt();
        println!("MS-02 deflections {} and {}: {share:.1e}", i + 1, j + 1);
        assert!(share < 1e-3, "{share:.1e}");
    }
}

/// MS-03. A rigid arm on a hinge rotates as a whole: at amplitude 1 at most by the largest rotation, and at any amplitude its points move
/// on circles.
#[test]
fn a_hinge_is_a_pure_rotation() {
    let spring =
        foldwing_engine::machine::Spring { stiffness_n_m_rad: 5.0, damping_n_m_s_rad: 0.0, rest_angle_rad: 0.3 };
    let stiff = Solid::rectangle(0.1, 0.1, Material::isotropic(7e16, 0.3, 2700.0));
    let arm = Body::beam("arm", 1.5, stiff).elements(2);
    let joint = Joint::revolute("hinge", [0.0, 1.0, 0.0]).at_root([0.2, 0.1, 0.5]).start_angle_rad(0.3).spring(spring);
    let machine = Machine::builder("Arm").body(arm, joint).build().unwrap_or_else(|error| panic!("{error}"));
    let (plant, modes) = bare(machine, 1);
    let (scene, frame, mode) = drawn(&plant, &modes[0]);
    let hinge_m = Vector3::new(0.2, 0.1, 0.5);
    let axis = Vector3::y();
    for (section, [re, im]) in frame.sections[0].iter().zip(&mode.changes[0][0]) {
        let due = re.rotation_rad.cross(&(section.position_m - hinge_m));
        assert!((re.displacement_m - due).norm() < 1e-9 && im.displacement_m.norm() < 1e-12, "{re:?}");
        // the arm itself bends by the ratio of the stiffnesses, 1e-11
        assert!((re.rotation_rad - axis * re.rotation_rad.y).norm() < 1e-9, "{re:?}");
    }
    for amplitude in [0.1, 1.0, 3.0] {
        let angle_rad = amplitude * mode.changes[0][0][0][0].rotation_rad.y;
        let moved = displaced(&scene, &frame, &mode.changes[0], Complex::new(amplitude, 0.0), Complex::default());
        for (before, after) in frame.sections[0].iter().zip(&moved.sections[0]) {
            let due = hinge_m + rotation_about(&axis, angle_rad) * (before.position_m - hinge_m);
            assert!((after.position_m - due).norm() < 1e-8, "amplitude {amplitude}: {due} {}", after.position_m);
        }
    }
    // with a length of 1.5 m, a tenth of the diagonal of the box corresponds to less than half a radian
    assert!((mode.largest_m / size_m(&scene, &frame) - LARGEST_SHARE).abs() < 1e-12, "{mode:?}");
}

/// MS-04. At amplitude 1 the largest displacement of the drawn points over a cycle is a tenth of the model's size, or the largest
/// rotation is half a radian; also for complex modes with a lifting surface.
#[test]
fn amplitude_one_has_its_size() {
    let mut plant = started(shipped("goland_wing"));
    plant.study().rest(0.0, Holding::AsReleased, Search::default()).unwrap_or_else(|error| panic!("{error}"));
    let modes = plant.study().modes(3).unwrap_or_else(|error| panic!("{error}"));
    for mode in &modes {
        let (scene, frame, mode) = drawn(&plant, mode);
        let mut largest_m = 0.0f64;
        for k in 0..720 {
            let phase = Complex::from_polar(1e-6, TAU * f64::from(k) / 720.0);
            let moved = displaced(&scene, &frame, &mode.changes[0], phase, Complex::default());
            for (before, after) in
                frame.edges_m.iter().flatten().flatten().zip(moved.edges_m.iter().flatten().flatten())
            {
                largest_m = largest_m.max((after - before).norm() * 1e6);
            }
        }
        // phases in steps of half a degree, and second-order terms of the rotation
        assert!((largest_m / mode.largest_m - 1.0).abs() < 1e-4, "{largest_m} {}", mode.largest_m);
        let share = largest_m / size_m(&scene, &frame);
        assert!((share / LARGEST_SHARE - 1.0).abs() < 1e-4, "{share}");
    }
    // a twisting rod moves no drawn point far, so its rotation is the limit
    let rod = Solid::ellipse(0.01, 0.01, Material::isotropic(7e10, 0.3, 2700.0)).with_torsional_rigidity_n_m2(1e-4);
    let machine = Machine::builder("Rod").body(Body::beam("rod", 1.0, rod).elements(4), Joint::clamped("wall"));
    let (plant, modes) = bare(machine.build().unwrap_or_else(|error| panic!("{error}")), 1);
    let (_, _, mode) = drawn(&plant, &modes[0]);
    assert!((mode.largest_rad - LARGEST_ROTATION_RAD).abs() < 1e-12 && mode.largest_m < 0.01, "{mode:?}");
}

/// MS-05. At the mesh, the drawn sections agree with the mode shapes, which are computed by another recursion, for curved, branched,
/// folding and flying models; the drawn motion at a small amplitude agrees with the sections.
#[test]
fn drawn_motions_are_those_of_the_modes() {
    for name in ["curved_blade", "branched", "folding_wing_constant", "four_bar", "flying_wing", "roll_fold"] {
        let (plant, modes) = match name {
            // models without a static equilibrium
            "flying_wing" | "four_bar" | "roll_fold" => bare(shipped(name), 8),
            _ => {
                let mut plant = started(shipped(name));
                let rest = plant.study().rest(0.0, Holding::AsReleased, Search::default());
                rest.unwrap_or_else(|error| panic!("{name}: {error}"));
                let modes = plant.study().modes(6).unwrap_or_else(|error| panic!("{name}: {error}"));
                (plant, modes)
            }
        };
        let places_m: Vec<Vec<f64>> = (0..plant.machine().bodies.len()).map(|body| plant.mesh_m(body)).collect();
        let still = vec![0.0; plant.freedoms().len()];
        let nothing = plant.section_changes(&still, &places_m).into_iter().flatten();
        assert!(nothing.map(|change| change.measures.norm()).all(|size| size == 0.0), "{name}: natural strain");
        for mode in &modes {
            let parts: [Vec<f64>; 2] = [|x: &Complex<f64>| x.re, |x: &Complex<f64>| x.im]
                .map(|read| mode.coordinates.iter().map(read).collect());
            let sections = parts.map(|part| plant.section_changes(&part, &places_m));
            for (sections, nodes) in sections.iter().zip([&mode.real, &mode.imaginary]) {
                for (section, node) in sections.iter().flatten().zip(nodes.iter().flatten()) {
                    let off_m = (section.displacement_m - node.displacement_m).norm() / mode.length_m;
                    let off_rad = (section.rotation_rad - node.rotation_rad).norm();
                    assert!(off_m < 1e-9 && off_rad < 1e-9, "{name}: {off_m:.1e} {off_rad:.1e}");
                }
            }
            let (scene, frame, mode) = drawn(&plant, mode);
            let step = 1e-5;
            let factor = |sign: f64| Complex::from_polar(sign * step, 0.7);
            let [above, below] = [1.0, -1.0]
                .map(|sign| displaced(&scene, &frame, &mode.changes[0], factor(sign), Complex::default()).sections);
            let changes = mode.changes[0].iter().flatten();
            for ((above, below), [re, im]) in above.iter().flatten().zip(below.iter().flatten()).zip(changes) {
                let found = (above.position_m - below.position_m) / (2.0 * step);
                let due = re.displacement_m * 0.7f64.cos() - im.displacement_m * 0.7f64.sin();
                // round-off of a position divided by the step
                assert!((found - due).norm() < 1e-8 * mode.largest_m.max(1.0), "{name}: {found} {due}");
            }
        }
    }
}

/// MS-06. A beam drawn at a large amplitude keeps its length, within the strain of the mode, and its sections remain perpendicular to its
/// axis.
#[test]
fn bodies_keep_their_length_at_any_amplitude() {
    let (plant, modes) = bare(cantilever(10), 2);
    for mode in &modes {
        let (scene, frame, mode) = drawn(&plant, mode);
        let moved = displaced(&scene, &frame, &mode.changes[0], Complex::new(3.0, 0.0), Complex::default());
        let length_m: f64 =
            moved.sections[0].windows(2).map(|pair| (pair[1].position_m - pair[0].position_m).norm()).sum();
        // sum of chords relative to the arc length: a linear drawing of the first mode would be 5 % longer
        assert!((length_m / LENGTH_M - 1.0).abs() < 1e-4, "{length_m}");
        let off = moved.sections[0].iter().map(|s| (s.rotation.transpose() * s.rotation - Matrix3::identity()).norm());
        assert!(off.fold(0.0, f64::max) < 1e-12);
    }
}

/// MS-07. In the drawn cycle of a fluttering wing, bending and twist have the phase of the eigenvector: the first harmonic of the drawn
/// end, at a small amplitude, is compared with the components of the mode at the mesh.
#[test]
fn bending_and_twist_have_the_phase_of_the_eigenvector() {
    let mut plant = started(shipped("goland_wing"));
    *plant.inputs_mut().wind_m_s_mut() = Vector3::new(0.0, -140.0, 0.0);
    plant.study().rest(0.0, Holding::AsReleased, Search::default()).unwrap_or_else(|error| panic!("{error}"));
    let modes = plant.study().modes(4).unwrap_or_else(|error| panic!("{error}"));
    let mode = modes.iter().find(|mode| mode.grows()).unwrap_or_else(|| panic!("no mode grows at 140 m/s"));
    let last = mode.real[0].len() - 1;
    let at = |read: fn(&foldwing_engine::plant::NodeMotion) -> f64| {
        Complex::new(read(&mode.real[0][last]), read(&mode.imaginary[0][last]))
    };
    let due = at(|node| node.displacement_m.z) / at(|node| node.rotation_rad.x);
    let (scene, frame, drawn) = drawn(&plant, mode);
    let (mut bending, mut twist) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
    for k in 0..48 {
        let phase = Complex::from_polar(1.0, TAU * f64::from(k) / 48.0);
        let moved = displaced(&scene, &frame, &drawn.changes[0], phase * 1e-4, Complex::default());
        let (section, before) = (moved.sections[0].last().unwrap(), frame.sections[0].last().unwrap());
        bending += phase.conj() * (section.position_m.z - before.position_m.z);
        let turned = section.rotation * before.rotation.transpose();
        twist += phase.conj() * (0.5 * (turned[(2, 1)] - turned[(1, 2)]));
    }
    let found = bending / twist;
    println!(
        "MS-07 phase of bending before twist {:.3} deg, of the eigenvector {:.3} deg",
        found.arg().to_degrees(),
        due.arg().to_degrees()
    );
    assert!((found / due - 1.0).norm() < 1e-6, "{found} {due}");
    // neither in phase nor in antiphase, which is the cause of flutter
    assert!(due.arg().abs() > 0.2 && due.arg().abs() < FRAC_PI_2 + 1.2, "{due}");
}

/// A conjugate pair is drawn once, also for a spinning rotor: every mode of the supplied models has a different eigenvalue in the upper
/// half plane.
#[test]
fn conjugate_pairs_are_drawn_once() {
    let mut plant = started(shipped("goland_wing"));
    plant.study().rest(0.0, Holding::AsReleased, Search::default()).unwrap_or_else(|error| panic!("{error}"));
    let modes = plant.study().modes(8).unwrap_or_else(|error| panic!("{error}"));
    for (i, mode) in modes.iter().enumerate() {
        assert!(mode.eigenvalue_1_s.im >= 0.0, "{}", mode.eigenvalue_1_s);
        for other in &modes[..i] {
            let apart = (mode.eigenvalue_1_s - other.eigenvalue_1_s).norm();
            assert!(apart > 1e-6 * mode.eigenvalue_1_s.norm(), "{}", mode.eigenvalue_1_s);
        }
    }
}

/// The largest displacement of a point on a circle is its radius; on a line it is the root of the sum of squares of both parts.
#[test]
fn points_that_circle_reach_their_radius() {
    assert_eq!(largest(&[Vector3::x(), Vector3::y()]), 1.0);
    assert_eq!(largest(&[Vector3::x() * 3.0, Vector3::x() * 4.0]), 5.0);
}

/// A body attached with an offset from the end of its parent moves with it: at a small amplitude by the displacements of the mode.
#[test]
fn bodies_at_an_offset_go_with_their_carrier() {
    let tip = Body::rigid("tip").inertia(0.05, [0.0; 3], Matrix3::identity() * 1e-4);
    let joint = Joint::clamped("bracket").on("beam").offset_m([0.0, 0.3, 0.2]);
    let builder = Machine::builder("Offset").body(beam(4), Joint::clamped("wall")).body(tip, joint);
    let (plant, modes) = bare(builder.build().unwrap_or_else(|error| panic!("{error}")), 4);
    for mode in &modes {
        let (scene, frame, mode) = drawn(&plant, mode);
        let step = 1e-5;
        let factor = Complex::new(step, 0.0);
        let moved = displaced(&scene, &frame, &mode.changes[0], factor, Complex::default());
        let found = (moved.sections[1][0].position_m - frame.sections[1][0].position_m) / step;
        let due = mode.changes[0][1][0][0].displacement_m;
        // second-order terms of rotations of 5e-6 rad
        assert!((found - due).norm() < 1e-5, "{found} {due}");
    }
}
