//! Statics, modes and linear models of machines with sliding joints: against closed forms, motions in time, and machines without sliding joints.

use crate::linear_rows::compare::{Rows, linear_rows_agree, linear_rows_agree_at};
use crate::plant::machines::*;
use crate::plant::sliding::slender;
use foldwing::machine::builder::{Attitude, JointBuilder, MachineBuilder};
use foldwing::machine::*;
use foldwing::plant::{Holding, ModeShape, Plant};
use nalgebra::{Matrix2, Matrix3, Vector3};

const GRAVITY_M_S2: f64 = 9.81;

fn plant_of(machine: &MachineBuilder) -> Plant {
    let built = machine.clone().solver(solver(Method::Esdirk4, 1e-8)).build();
    start(built.unwrap_or_else(|refused| panic!("{refused}")))
}

fn frequencies_hz(plant: &mut Plant, count: usize) -> Vec<f64> {
    let modes = plant.study().modes(count).unwrap_or_else(|error| panic!("{error}"));
    modes.iter().map(|mode| mode.frequency_hz).collect()
}

/// A cantilever of `pairs` with a pendulum on its sliding joint.
fn hanging(pairs: usize, slide: impl Fn(JointBuilder) -> JointBuilder, attitude: Attitude) -> MachineBuilder {
    let beam = body("beam", 1.0, &slender(1e6, 2.0, 1e-6), ElementKind::Linear, pairs);
    let bob =
        Body::rigid("bob").inertia(0.2, [0.0, 0.0, -0.2], Matrix3::from_diagonal(&Vector3::new(2e-4, 1e-4, 3e-4)));
    Machine::builder("crane")
        .gravity_m_s2([0.0, 0.0, -GRAVITY_M_S2])
        .body(beam.stiffness_damping_s(1e-3), clamped())
        .body(bob, slide(Joint::sliding("slide").on("beam")).attitude(attitude))
}

/// SJ-24. Equilibrium of a pendulum that hangs from a sliding joint with a spring on a cantilever that deflects by a third of its length, found
/// from a start in another element: the spring carries the weight along the slope, the pendulum hangs vertically, and the machine stays
/// there for 1 s. Without a spring, and beyond the end of the beam, there is none.
#[test]
fn sj24_equilibrium_on_a_bent_beam() {
    let spring = LinearSpring { stiffness_n_m: 8.0, damping_n_s_m: 0.5, rest_position_m: 0.45 };
    for (attitude, from_m) in
        [(Attitude::hinge([0.0, 1.0, 0.0]), 0.1), (Attitude::hinge([0.0, 1.0, 0.0]), 0.9), (Attitude::Section, 0.2)]
    {
        let mut plant = plant_of(&hanging(4, |slide| slide.spring(spring).start_position_m(from_m), attitude));
        let effort = plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        let (slide, tips) = (plant.outputs().joints()[0], plant.outputs().tips().to_vec());
        // the section has the attitude of the bob without the angle of the hinge
        let angle_rad = plant.outputs().joints().get(1).map_or(0.0, |hinge| hinge.angle_rad);
        let along = tips[1].rotation * Vector3::new(angle_rad.cos(), 0.0, angle_rad.sin());
        let (pulls_n, due_n) = (8.0 * (slide.angle_rad - 0.45), -along.z * 0.2 * GRAVITY_M_S2);
        let upright = (tips[tips.len() - 1].rotation * Vector3::z() - Vector3::z()).norm();
        println!(
            "SJ-24 {attitude:?} from {from_m} m: s {:.6} m, tip {:.3} m down, spring {pulls_n:.6} N of {due_n:.6}, upright {upright:.1e}, {effort:?}",
            slide.angle_rad, -tips[0].position_m.z
        );
        assert!(tips[0].position_m.z < -0.2 && (slide.angle_rad - from_m).abs() > 0.25);
        if attitude != Attitude::Section {
            // the axial strain of the beam below the carriage is 1e-6
            assert!((pulls_n - due_n).abs() < 1e-5 * due_n && upright < 1e-9, "{pulls_n} {due_n} {upright:e}");
        }
        coast(&mut plant, 1.0);
        let after = plant.outputs().joints()[0];
        let moved_m = (after.angle_rad - slide.angle_rad).abs();
        assert!(moved_m < 1e-9 && after.rate_rad_s.abs() < 1e-8, "{moved_m:e} m, {:e} m/s", after.rate_rad_s);
        let judged = plant.study().stability().unwrap_or_else(|error| panic!("{error}"));
        assert!(judged.is_stable(), "{judged:?}");
    }
    let spring = LinearSpring { rest_position_m: 1.2, ..spring };
    let mut beyond = plant_of(&hanging(4, |slide| slide.spring(spring).start_position_m(0.5), Attitude::Section));
    let text = beyond.study().equilibrium(0.0, Holding::AsReleased).map(|_| ()).expect_err("off the beam").to_string();
    assert!(text.contains("joint slide") && text.contains("beyond the end of beam"), "{text}");
    let free = Attitude::hinge([0.0, 1.0, 0.0]);
    let mut level =
        Machine::builder("level").body(body("beam", 1.0, &slender(1e6, 2.0, 1e-6), ElementKind::Linear, 2), clamped());
    let bob = Body::rigid("bob").inertia(0.2, [0.0, 0.0, -0.2], Matrix3::from_diagonal_element(1e-4));
    level = level.body(bob, Joint::sliding("slide").on("beam").start_position_m(0.5).attitude(free));
    let text =
        plant_of(&level).study().equilibrium(0.0, Holding::AsReleased).map(|_| ()).expect_err("free").to_string();
    assert!(text.contains("no stiffness resists a motion of joint \"slide"), "{text}");
}

/// SJ-25. Modes of a trolley of 0.5 kg with a spring and a pendulum on a stiff beam: those of two degrees of freedom in closed form. A body that a
/// lock holds between two elements has the modes of one that is clamped there.
#[test]
fn sj25_modes_of_bodies_on_a_beam() {
    let (trolley_kg, bob_kg, own_kg_m2, length_m, stiffness_n_m) = (0.5, 0.2, 1e-4, 0.2, 30.0);
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        let stiff = body("beam", 1.0, &slender(1e10, 1e8, 1e-6), kind, 2);
        let inertia = Matrix3::from_diagonal(&Vector3::new(2e-4, own_kg_m2, 3e-4));
        let spring = LinearSpring { stiffness_n_m, damping_n_s_m: 0.0, rest_position_m: 0.3 };
        let slide = Joint::sliding("slide").on("beam").start_position_m(0.3).spring(spring);
        let machine = Machine::builder("trolley")
            .gravity_m_s2([0.0, 0.0, -GRAVITY_M_S2])
            .body(stiff, clamped())
            .body(
                Body::rigid("bob").inertia(bob_kg, [0.0, 0.0, -length_m], inertia),
                slide.attitude(Attitude::hinge([0.0, 1.0, 0.0])),
            )
            .mass("slide_carriage", AttachedMass::point("trolley", 0.0, trolley_kg));
        let mut plant = plant_of(&machine);
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        let coupling = -bob_kg * length_m;
        let mass = Matrix2::new(trolley_kg + bob_kg, coupling, coupling, bob_kg * length_m * length_m + own_kg_m2);
        let lower = mass.cholesky().expect("positive").l().try_inverse().expect("regular");
        let stiffness = Matrix2::new(stiffness_n_m, 0.0, 0.0, bob_kg * GRAVITY_M_S2 * length_m);
        let mut due = (lower * stiffness * lower.transpose()).symmetric_eigenvalues().map(f64::sqrt);
        due /= std::f64::consts::TAU;
        let found = frequencies_hz(&mut plant, 2);
        println!("SJ-25 {kind:?}: {found:?} Hz of {due:?}");
        assert!((found[0] / due.min() - 1.0).abs() < 1e-6 && (found[1] / due.max() - 1.0).abs() < 1e-6);
        // shapes: way of the carriage along the beam over the angle of the bob, from the first row of the equations
        for mode in plant.study().modes(2).unwrap_or_else(|error| panic!("{error}")) {
            let [carriage, bob] = [&mode.real[1][0], &mode.real[2][0]];
            let ratio_m = carriage.displacement_m.x / bob.rotation_rad.y;
            let square = (std::f64::consts::TAU * mode.frequency_hz).powi(2);
            let due_m = square * coupling / (stiffness_n_m - square * mass[(0, 0)]);
            println!("SJ-25 {kind:?}: {ratio_m} m/rad of {due_m}");
            assert!((ratio_m / due_m - 1.0).abs() < 1e-5, "{ratio_m} m/rad of {due_m}");
        }

        // a heavy body at a border, locked on its sliding joint or clamped to the beam
        let block = || Body::rigid("block").inertia(0.4, [0.03, 0.02, -0.05], Matrix3::from_diagonal_element(1e-3));
        let soft = || body("beam", 1.0, &slender(1e4, 2.0, 1e-5), kind, 2).natural_curvature_1_m([0.2, 0.5, -0.4]);
        let held = |joint: JointBuilder| {
            let machine = Machine::builder("held").gravity_m_s2([1.0, 2.0, -GRAVITY_M_S2]).body(soft(), clamped());
            let mut plant = plant_of(&machine.body(block(), joint.offset_m([0.01, -0.02, 0.04])));
            plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
            let modes = plant.study().modes(8).unwrap_or_else(|error| panic!("{error}"));
            let tip_m = plant.outputs().tips()[0].position_m;
            // relative to the tip of the beam
            let size = |part: [Vector3<f64>; 2]| (part[0].norm_squared() + part[1].norm_squared()).sqrt();
            let at = |mode: &ModeShape, body: usize, node: usize| {
                size([&mode.real, &mode.imaginary].map(|part| part[body][node].displacement_m))
            };
            let shape: Vec<f64> =
                modes.iter().map(|mode| at(mode, 1, 0) / at(mode, 0, mode.real[0].len() - 1)).collect();
            (modes.iter().map(|mode| mode.frequency_hz).collect::<Vec<_>>(), shape, tip_m)
        };
        let slides = held(Joint::sliding("slide").on("beam").start_position_m(0.5).locked());
        let clamps = held(Joint::clamped("slide").on_at("beam", 0.5));
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        let (off, shape) = (apart(&slides.0, &clamps.0), apart(&slides.1, &clamps.1));
        println!("SJ-25 {kind:?}: locked and clamped {off:.1e} apart, shapes {shape:.1e}, first {:.3} Hz", slides.0[0]);
        assert!(off < 1e-8 && shape < 1e-6 && (slides.2 - clamps.2).norm() < 1e-9, "{off:e} {shape:e}");
    }
}

/// SJ-43. In shapes of modes a locked body within an element moves with its section, not with a node: the body on 8 elements at 7/16 of the
/// length moves, relative to the tip, as one that is clamped at a node of 16 elements.
#[test]
fn sj43_shapes_of_bodies_within_elements() {
    let shapes = |pairs: usize, joint: JointBuilder| {
        let soft = body("beam", 1.0, &slender(1e4, 2.0, 1e-5), ElementKind::Linear, pairs);
        let block = Body::rigid("block").inertia(0.4, [0.03, 0.02, -0.05], Matrix3::from_diagonal_element(1e-3));
        let machine = Machine::builder("held").gravity_m_s2([1.0, 2.0, -GRAVITY_M_S2]).body(soft, clamped());
        let mut plant = plant_of(&machine.body(block, joint.offset_m([0.01, -0.02, 0.04])));
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        let modes = plant.study().modes(3).unwrap_or_else(|error| panic!("{error}"));
        let size = |mode: &ModeShape, body: usize, node: usize| {
            let part = [&mode.real, &mode.imaginary].map(|part| part[body][node].displacement_m.norm_squared());
            (part[0] + part[1]).sqrt()
        };
        let tip = |mode: &ModeShape| size(mode, 0, mode.real[0].len() - 1);
        modes.iter().map(|mode| size(mode, 1, 0) / tip(mode)).collect::<Vec<f64>>()
    };
    let slides = shapes(4, Joint::sliding("slide").on("beam").start_position_m(0.4375).locked());
    let clamps = shapes(8, Joint::clamped("slide").on_at("beam", 0.4375));
    println!("SJ-43: {slides:.5?} of {clamps:.5?}");
    for (slides, clamps) in slides.iter().zip(&clamps) {
        // 2e-3 found, from the coarser elements; with the motion of the inner node the test fails (fault 897)
        assert!((slides / clamps - 1.0).abs() < 0.02, "{slides} of {clamps}");
    }
}

/// SJ-26. Parts of a machine without sliding joints keep their equilibrium and modes beside a sliding joint elsewhere, with which stiffness and
/// equilibrium are computed by differences: a bent beam with a spring on a ball joint, and a loop with a stiffness.
#[test]
fn sj26_other_parts_beside_a_sliding_joint() {
    let base = || {
        let motor = Motor { stiffness_n_m_rad: 0.8, ..Motor::default() };
        let other = Body::rigid("other").inertia(0.3, [0.05, 0.1, -0.02], Matrix3::from_diagonal_element(2e-3));
        Machine::builder("parts")
            .gravity_m_s2([1.0, 2.0, -GRAVITY_M_S2])
            .body(body("beam", 1.0, &slender(1e4, 2.0, 1e-5), ElementKind::Linear, 2), clamped())
            .body(other, Joint::ball("ball").on("beam").motor(motor))
            .closure(Closure::between("tie", ["other", "root"], 1e5).offsets_m([[0.1, 0.0, 0.0], [1.1, 0.0, 0.0]]))
    };
    let mut alone = plant_of(&base());
    let rail = Body::beam("rail", 0.3, slender(1e9, 1e6, 1e-6)).elements(1);
    let bead = Body::rigid("bead").inertia(0.1, [0.0; 3], Matrix3::from_diagonal_element(1e-3));
    let slide = Joint::sliding("slide").on("rail").start_position_m(0.1).locked();
    let mut beside = plant_of(&base().body(rail, Joint::clamped("post")).body(bead, slide));
    for plant in [&mut alone, &mut beside] {
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    }
    let apart_m = (alone.outputs().tips()[0].position_m - beside.outputs().tips()[0].position_m).norm();
    let moved_m = (alone.outputs().tips()[0].position_m - Vector3::x()).norm();
    let [one, other] = [&mut alone, &mut beside].map(|plant| frequencies_hz(plant, 6));
    let off = one.iter().zip(&other).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    println!("SJ-26 equilibria {apart_m:.1e} m apart after {moved_m:.2} m, modes {off:.1e}: {one:.3?} Hz");
    assert!(apart_m < 1e-9 && moved_m > 0.005 && off < 1e-8, "{apart_m:e} {off:e}");
}

/// SJ-27. Every row of the linear models, states and outputs, against differences of the nonlinear machine: about a moving start, about
/// equilibria, and about a motion that has crossed a border.
#[test]
fn sj27_rows_of_linear_models() {
    let agree = |rows: Rows, what: &str| match rows {
        Rows::Agree(off) => println!("SJ-27 {what}: off by {off:.1e} of a row's scale"),
        Rows::Miss(why) | Rows::Refused(why) => panic!("{what}: {why}"),
    };
    let spring = LinearSpring { stiffness_n_m: 8.0, damping_n_s_m: 0.0, rest_position_m: 0.45 };
    let slide = |joint: JointBuilder| joint.start_position_m(0.495).start_rate_m_s(2.0).spring(spring);
    for (attitude, what) in [
        (Attitude::Section, "section"),
        (Attitude::hinge([0.1, 1.0, 0.2]), "hinge"),
        (Attitude::hinge([1.0, 0.0, 0.3]), "hinge along"),
    ] {
        let machine = hanging(2, slide, attitude);
        let built = machine.clone().solver(solver(Method::Esdirk4, 1e-8)).build();
        agree(linear_rows_agree(&built.unwrap_or_else(|refused| panic!("{refused}"))), what);
        let mut plant = plant_of(&machine);
        coast(&mut plant, 5e-3);
        assert!(plant.outputs().joints()[0].angle_rad > 0.5 && plant.statistics().events >= 1);
        agree(linear_rows_agree_at(&mut plant), &format!("{what}, moving beyond a border"));
    }
}
