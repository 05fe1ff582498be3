//! Sliding joints in the air of strips and of a vortex lattice: against machines without sliding joints, with invariances, the
//! energy account, rollback across borders of elements, and the order in the aerodynamic step.

use crate::counting_allocator::allocations;
use crate::linear_rows::compare::{Rows, linear_rows_agree_at};
use crate::plant::machines::*;
use crate::plant::sliding::slender;
use foldwing::beam::profile::Profile as Along;
use foldwing::machine::builder::{AirBuilder, BodyBuilder, JointBuilder, MachineBuilder};
use foldwing::machine::*;
use foldwing::plant::{Holding, Outputs, Plant, PlantError};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Strips with a step of the air in s.
fn strips(step_s: f64) -> AirBuilder {
    Air::strips()
        .density_kg_m3(1.2)
        .step_s(step_s)
        .coupling(Coupling::Iterated { tolerance: 1e-11, most_iterations: 100 })
}

/// A vortex lattice with a wake that the wind carries.
fn lattice(step_s: f64) -> AirBuilder {
    Air::lattice()
        .density_kg_m3(1.2)
        .step_s(step_s)
        .wake_rows(20)
        .coupling(Coupling::Iterated { tolerance: 1e-11, most_iterations: 100 })
}

fn surface(body: &str, chord_m: f64) -> builder::SurfaceBuilder {
    LiftingSurface::on(body, 3).chord_m(Along::constant(chord_m)).chord_panels(2)
}

/// A flexible wing of 0.4 m.
fn wing(name: &str) -> BodyBuilder {
    let mut section = slender(1e4, 2.0, 1e-3);
    section.mass_kg_m = 0.3;
    body(name, 0.4, &section, ElementKind::Linear, 2).stiffness_damping_s(1e-4)
}

/// The rail: a beam of 1 m in the wind, along `y` of the root, with `x` of its sections downwind.
fn rail(stiff: f64) -> BodyBuilder {
    body("rail", 1.0, &slender(1e4 * stiff, 5.0 * stiff, 1e-3), ElementKind::Linear, 2)
        .stiffness_damping_s(1e-4 / stiff)
}

fn built(machine: MachineBuilder, tolerance: f64) -> Machine {
    machine
        .solver(solver(Method::Esdirk4, tolerance))
        .step_s(0.01)
        .build()
        .unwrap_or_else(|refused| panic!("{refused}"))
}

/// Largest difference of tips (m, and of their velocities over 10 1/s) and of the whole force of the air, relative to its size.
fn apart(a: &Outputs, b: &Outputs) -> f64 {
    let tips = a.tips().iter().zip(b.tips());
    let moved =
        tips.map(|(a, b)| (a.position_m - b.position_m).norm().max(0.1 * (a.velocity_m_s - b.velocity_m_s).norm()));
    let (force, other) = (a.air_total().force_n, b.air_total().force_n);
    moved.fold((force - other).norm() / force.norm(), f64::max)
}

/// A flexible rail and a wing across it, both in the wind; the joint of the wing is given.
fn two_wings(air: AirBuilder, mount: JointBuilder, second: JointBuilder) -> Machine {
    let machine = Machine::builder("two")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(rail(1.0), mount)
        .body(wing("wing"), second.mount_rotation_rad([0.0, 0.2, FRAC_PI_2]))
        .air(air.wind_m_s([6.0, -9.0, 1.0]))
        .surface(surface("rail", 0.15))
        .surface(surface("wing", 0.1));
    built(machine, 1e-9)
}

/// SJ-29. A wing that is locked on its sliding joint at a node of a flexible rail is the wing that is clamped there: rail and wing in the air
/// of strips and of a vortex lattice, with iterated and with staggered loads.
#[test]
fn sj29_a_locked_wing_is_a_clamped_wing() {
    for (air, what) in [
        (strips(0.01), "strips"),
        (lattice(0.01), "lattice"),
        (strips(0.01).coupling(Coupling::Staggered), "strips, staggered"),
    ] {
        let locked = Joint::sliding("slide").on("rail").start_position_m(0.5).locked();
        let [mut slides, mut clamped] = [locked, Joint::clamped("slide").on_at("rail", 0.5)]
            .map(|joint| start(two_wings(air.clone(), clamped(), joint)));
        let mut off = 0.0f64;
        for step in 1..=20 {
            [&mut slides, &mut clamped].into_iter().for_each(|plant| coast(plant, 0.01 * f64::from(step)));
            off = off.max(apart(slides.outputs(), clamped.outputs()));
        }
        let tip_m = slides.outputs().tips()[0].position_m.z;
        println!("SJ-29 {what}: apart {off:.1e}, tip at {tip_m:.3} m");
        assert!(off < 1e-9 && tip_m.abs() > 1e-3, "{what}: {off:e}");
    }
}

/// SJ-30. A wing that slides freely along a stiff rail on a hinge, over borders of its elements, against the same wing on a prismatic joint of
/// a rigid body: the difference is that of the bending, and falls with the stiffness.
#[test]
fn sj30_a_wing_on_a_stiff_rail_and_on_a_rigid_body() {
    for (air, what) in [(strips as fn(f64) -> AirBuilder, "strips"), (lattice as fn(f64) -> AirBuilder, "lattice")] {
        let mount = Rotation3::from_scaled_axis(Vector3::new(0.0, 0.2, FRAC_PI_2));
        let of = |first: BodyBuilder, second: JointBuilder| {
            let hinge = Joint::revolute("hinge", [0.2, 0.0, 1.0]).start_rate_rad_s(2.0);
            let machine = Machine::builder("rail")
                .body(first, hinge)
                .body(
                    wing("wing"),
                    second.mount_rotation_rad(mount.scaled_axis()).start_position_m(0.3).start_rate_m_s(1.0),
                )
                .air(air(0.005).wind_m_s([9.0, -3.0, 1.0]))
                .surface(surface("wing", 0.1));
            start(built(machine, 1e-9))
        };
        // the mass of the rail as pairs distribute it: exact for straight rails
        let inertia = Matrix3::from_diagonal(&Vector3::new(1e-3, 0.5 / 12.0 + 0.5e-3, 0.5 / 12.0 + 0.5e-3));
        let off = |stiff: f64| {
            let mut slides = of(rail(stiff), Joint::sliding("slide").on("rail"));
            let mut rigid = of(
                Body::rigid("rail").inertia(0.5, [0.5, 0.0, 0.0], inertia),
                Joint::prismatic("slide", [1.0, 0.0, 0.0]).on("rail"),
            );
            let (mut off, mut events) = ([0.0f64; 2], 0);
            for step in 1..=30 {
                [&mut slides, &mut rigid].into_iter().for_each(|plant| coast(plant, 0.01 * f64::from(step)));
                let joints = [&slides, &rigid].map(|plant| plant.outputs().joints().to_vec());
                for (joint, off) in off.iter_mut().enumerate() {
                    *off = off.max((joints[0][joint].angle_rad - joints[1][joint].angle_rad).abs());
                }
                events = slides.statistics().events;
            }
            let s_m = slides.outputs().joints()[1].angle_rad;
            println!(
                "SJ-30 {what}, stiffness {stiff:e}: turn {:.1e} rad, slide {:.1e} m apart at {s_m:.3} m, {events} events",
                off[0], off[1]
            );
            assert!(s_m > 0.55 && events >= 1);
            off[0].max(off[1])
        };
        let [soft, stiff] = [1e3, 1e5].map(off);
        assert!(stiff < 2e-6 && stiff < 0.1 * soft, "{what}: {soft:e}, {stiff:e}");
    }
}

/// SJ-31. A wing at a prescribed speed of 2 m/s along a stiff straight rail in the wind, over borders, has the loads of the wing at rest in a
/// wind that is faster by the speed: strips and lattice.
#[test]
fn sj31_a_moving_wing_and_a_moving_air() {
    for (air, what) in [(strips as fn(f64) -> AirBuilder, "strips"), (lattice as fn(f64) -> AirBuilder, "lattice")] {
        let of = |speed_m_s: f64, constant: bool| {
            let kind = if constant { ElementKind::Constant } else { ElementKind::Linear };
            let stiff = body("rail", 1.0, &slender(1e10, 1e8, 1e-3), kind, 4);
            let law = Motion::Polynomial(vec![0.12, speed_m_s]);
            let second = Joint::sliding("slide").on("rail").prescribed(law).mount_rotation_rad([0.0, 0.2, FRAC_PI_2]);
            let machine = Machine::builder("rail")
                .body(stiff, clamped())
                .body(wing("wing"), second)
                .air(air(0.005).wind_m_s([9.0 + speed_m_s, 0.5, 1.0]))
                .surface(surface("wing", 0.1));
            start(built(machine, 1e-9))
        };
        for constant in [false, true] {
            let (mut moves, mut rests) = (of(2.0, constant), of(0.0, constant));
            let mut off = 0.0f64;
            for step in 1..=40 {
                let time_s = 0.01 * f64::from(step);
                [&mut moves, &mut rests].into_iter().for_each(|plant| coast(plant, time_s));
                let (a, b) = (moves.outputs(), rests.outputs());
                let (force, other) = (a.air_total().force_n, b.air_total().force_n);
                let tip_m = a.tips()[1].position_m - Vector3::x() * (2.0 * time_s) - b.tips()[1].position_m;
                off = off.max((force - other).norm() / other.norm()).max(tip_m.norm());
            }
            println!("SJ-31 {what}, constant {constant}: {off:.1e} apart, {} events", moves.statistics().events);
            assert!(off < 1e-6 && moves.statistics().events >= 3, "{what}: {off:e}");
        }
    }
}

/// A rail in free flight with a lifting surface, along which a wing slides; everything rotated and in a frame that moves with a velocity.
fn flying(air: AirBuilder, turn: Rotation3<f64>, frame_m_s: Vector3<f64>, tolerance: f64) -> Machine {
    let velocity = turn * Vector3::new(0.5, 8.0, 0.0) - frame_m_s;
    let fly = Joint::free("fly")
        .mount_rotation_rad(turn.scaled_axis())
        .start_angular_velocity_rad_s(turn * Vector3::new(0.5, 1.0, -0.8))
        .start_velocity_m_s(velocity);
    let second =
        Joint::sliding("slide").on("rail").start_position_m(0.42).start_rate_m_s(0.9).offset_m([0.02, 0.03, -0.05]);
    let machine = Machine::builder("flying")
        .gravity_m_s2(turn * Vector3::new(0.0, 0.0, -9.81))
        .body(rail(1.0), fly)
        .body(wing("wing"), second.mount_rotation_rad([0.3, -0.2, 2.0]))
        .air(air.wind_m_s(turn * Vector3::new(1.0, -2.0, 0.5) - frame_m_s))
        .surface(surface("rail", 0.15))
        .surface(surface("wing", 0.1));
    built(machine, tolerance)
}

/// SJ-32. A flying rail with a wing that slides across a border inside an aerodynamic step: rotated as a whole, and seen from a frame that
/// moves uniformly, the motion is the same; the energy account closes with the work of the air.
#[test]
fn sj32_invariance_and_energy() {
    for (air, what) in [(strips as fn(f64) -> AirBuilder, "strips"), (lattice as fn(f64) -> AirBuilder, "lattice")] {
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.4, -1.1, 0.8));
        let frame = Vector3::new(4.0, -2.5, 1.5);
        let mut plants =
            [(Rotation3::identity(), Vector3::zeros()), (turn, Vector3::zeros()), (Rotation3::identity(), frame)]
                .map(|(turn, frame)| start(flying(air(0.013), turn, frame, 1e-9)));
        let before_j = balance_j(plants[0].outputs());
        let mut off = [0.0f64; 2];
        for step in 1..=20 {
            let time_s = 0.01 * f64::from(step);
            plants.iter_mut().for_each(|plant| coast(plant, time_s));
            let tips = plants.each_ref().map(|plant| plant.outputs().tips().to_vec());
            for ((own, turned), moved) in tips[0].iter().zip(&tips[1]).zip(&tips[2]) {
                off[0] = off[0].max((turn * own.position_m - turned.position_m).norm());
                off[1] = off[1].max((own.position_m - frame * time_s - moved.position_m).norm());
            }
        }
        let (slide, energy) = (plants[0].outputs().joints()[0], plants[0].outputs().energy());
        let drift_j = balance_j(plants[0].outputs()) - before_j;
        println!(
            "SJ-32 {what}: rotated {:.1e} m, moving frame {:.1e} m, at {:.3} m, drift {drift_j:.1e} J, work {:.2e} J, lost {:.1e} J",
            off[0], off[1], slide.angle_rad, energy.work, energy.dissipated
        );
        assert!(slide.angle_rad > 0.55 && plants[0].statistics().events >= 1);
        assert!(off[0] < 1e-9 && off[1] < 1e-9, "{what}: {off:?}");
        assert!(drift_j.abs() < 1e-7 && energy.work.abs() > 1e-2, "{what}: {drift_j:e} J");
    }
}

/// SJ-33. Communication steps do not change the run of SJ-32; every communication step, in which the border is crossed or not, taken back and
/// repeated, continues with the same bits; and a state from bytes continues in another instance. Fixed steps and real time run too.
#[test]
fn sj33_states_inside_an_aerodynamic_step() {
    for (air, what) in [(strips as fn(f64) -> AirBuilder, "strips"), (lattice as fn(f64) -> AirBuilder, "lattice")] {
        let fresh = || start(flying(air(0.013), Rotation3::identity(), Vector3::zeros(), 1e-7));
        let bits = |plant: &Plant| plant.outputs().values().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        let (mut own, mut fine, mut coarse) = (fresh(), fresh(), fresh());
        let mut saved = None;
        for step in 1..=50 {
            let time_s = 0.004 * f64::from(step);
            let before = own.snapshot();
            coast(&mut own, time_s);
            let first = bits(&own);
            own.restore(&before).expect("its own");
            if step == 20 {
                saved = Some(postcard::to_stdvec(&before).expect("serialises"));
            }
            coast(&mut own, time_s);
            assert!(first == bits(&own), "{what}, step {step}: a repeated step has other bits");
        }
        let bytes = saved.expect("a state");
        let mut other = fresh();
        other.restore(&postcard::from_bytes(&bytes).expect("deserialises")).expect("the same machine");
        (20..=50).for_each(|step| coast(&mut other, 0.004 * f64::from(step)));
        assert!(bits(&own) == bits(&other), "{what}: another instance has other bits");
        (1..=300).for_each(|step| coast(&mut fine, 0.2 * f64::from(step) / 300.0));
        coast(&mut coarse, 0.2);
        let off = [&fine, &coarse].map(|plant| apart(own.outputs(), plant.outputs()));
        println!(
            "SJ-33 {what}: {:.1e}, {:.1e} from other communication steps, {} events",
            off[0],
            off[1],
            own.statistics().events
        );
        assert!(off.iter().all(|off| *off < 1e-12) && own.statistics().events >= 1, "{what}: {off:?}");
    }
}

/// SJ-34. The motion of SJ-32 across a border converges with the aerodynamic step; the order of the tip over steps of 6 to 1.5 ms is below the 2 of
/// smooth motions.
#[test]
fn sj34_order_in_the_aerodynamic_step() {
    let at = |step_s: f64| {
        let mut plant = start(flying(strips(step_s), Rotation3::identity(), Vector3::zeros(), 1e-10));
        coast(&mut plant, 0.18);
        assert!(plant.statistics().events >= 1);
        (plant.outputs().tips()[1].position_m, plant.outputs().joints()[0].angle_rad)
    };
    let [coarse, medium, fine, finest] = [0.012, 0.006, 0.003, 0.0015].map(at);
    let order = |near: f64, far: f64| (far / near).log2();
    let tips = [(coarse.0 - medium.0).norm(), (medium.0 - fine.0).norm(), (fine.0 - finest.0).norm()];
    let slides = [(coarse.1 - medium.1).abs(), (medium.1 - fine.1).abs(), (fine.1 - finest.1).abs()];
    let orders = [tips, slides].map(|own| [order(own[1], own[0]), order(own[2], own[1])]);
    println!("SJ-34 tip {tips:?}, slide {slides:?}, orders {orders:.2?}");
    assert!(orders[0][1] > 1.6 && orders[1][1] > 1.7, "{orders:?}");
}

/// SJ-35. Steps in air allocate no memory across borders; fixed steps, generalised-α and real time run across them.
#[test]
fn sj35_methods_and_allocation() {
    let mut ends = Vec::new();
    for (method, fixed_step_s, real_time) in [
        (Method::Esdirk4, None, false),
        (Method::GeneralizedAlpha, None, false),
        (Method::Esdirk4, Some(1e-3), false),
        (Method::Sdirk2, Some(2.5e-4), true),
    ] {
        let mut machine = flying(strips(0.005), Rotation3::identity(), Vector3::zeros(), 1e-7);
        machine.solver = Solver { method, fixed_step_s, most_iterations: real_time.then_some(2), ..machine.solver };
        if let (Some(air), true) = (&mut machine.air, real_time) {
            air.coupling = Coupling::Staggered;
        }
        let mut plant = start(machine);
        coast(&mut plant, 0.01);
        let before = allocations();
        (2..=20).for_each(|step| coast(&mut plant, 0.01 * f64::from(step)));
        let allocated = allocations() - before;
        let slide = plant.outputs().joints()[0];
        println!(
            "SJ-35 {method:?}, real time {real_time}: at {:.6} m, {} events",
            slide.angle_rad,
            plant.statistics().events
        );
        assert_eq!(allocated, 0, "{method:?}: allocations");
        assert!(slide.angle_rad > 0.55 && plant.statistics().events >= 1);
        ends.push(slide.angle_rad);
    }
    // the staggered loads of real time are of first order in the aerodynamic step
    assert!(ends[1..3].iter().all(|end| (end - ends[0]).abs() < 1e-5) && (ends[3] - ends[0]).abs() < 2e-3, "{ends:?}");
}

/// A wing on a sprung sliding joint of a cantilever, both in the wind.
fn sprung(air: AirBuilder, from_m: f64) -> Machine {
    let spring = LinearSpring { stiffness_n_m: 20.0, damping_n_s_m: 2.0, rest_position_m: 0.62 };
    let slide = Joint::sliding("slide").on("rail").start_position_m(from_m).spring(spring);
    let mut machine = two_wings(air, clamped(), slide);
    machine.solver.tolerance = 1e-9;
    machine
}

/// SJ-36. The equilibrium of a wing on a sprung sliding joint of a cantilever, both in the wind, found from a start in another element: the
/// machine stays there for 0.5 s, from either side the state is the same, and it is stable.
#[test]
fn sj36_equilibrium_in_air() {
    for (air, what) in [(strips as fn(f64) -> AirBuilder, "strips"), (lattice as fn(f64) -> AirBuilder, "lattice")] {
        // the wake of the equilibrium is infinite, that of the run has 20 rows
        let limit = if what == "lattice" { 1e-4 } else { 1e-7 };
        let mut found = Vec::new();
        for from_m in [0.2, 0.8] {
            let mut plant = start(sprung(air(0.005), from_m));
            plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{what}: {error}"));
            let (rest, slide) = (plant.outputs().clone(), plant.outputs().joints()[0].angle_rad);
            let stability = plant.study().stability().unwrap_or_else(|error| panic!("{what}: {error}"));
            assert!(stability.is_stable(), "{what}: {stability:?}");
            coast(&mut plant, 0.5);
            let off = apart(&rest, plant.outputs());
            println!("SJ-36 {what} from {from_m} m: at {slide:.6} m, leaves by {off:.1e}");
            assert!(off < limit && (slide - from_m).abs() > 0.1, "{what}: {off:e}");
            found.push(rest);
        }
        let off = apart(&found[0], &found[1]);
        assert!(off < 1e-8, "{what}: {off:e} apart");
    }
}

/// SJ-44. A soft rail turns by more than a radian in the wind and lifts the carriage of a bead, on a spring, into another element than in still
/// air: the equilibrium is found from either side, is stable, and the machine stays there for 0.5 s. Above the divergence speed of the rail with
/// the carriage held, which the path from still air finds, the search ends with an error.
#[test]
fn sj44_equilibrium_of_a_rail_that_bends_far() {
    let rest_or_error = |from_m: f64, wind_m_s: f64| {
        let text = include_str!("sliding_air.toml")
            .replace("start_position_m = 0.3", &format!("start_position_m = {from_m:?}"))
            .replace("wind_m_s = [11.0,", &format!("wind_m_s = [{wind_m_s:?},"));
        let machine = foldwing::config::parse(&text, "sliding_air.toml").unwrap_or_else(|error| panic!("{error}"));
        let mut plant = start(machine);
        plant.study().equilibrium(0.0, Holding::AsReleased).map(|_| plant)
    };
    let rest_from = |from_m, wind_m_s| rest_or_error(from_m, wind_m_s).unwrap_or_else(|error| panic!("{error}"));
    let still_m = rest_from(0.3, 0.0).outputs().joints()[0].angle_rad;
    let mut found: Vec<Outputs> = Vec::new();
    for from_m in [0.3, 0.8] {
        let mut plant = rest_from(from_m, 11.0);
        let rest = plant.outputs().clone();
        let carriage_m = rest.joints()[0].angle_rad;
        // the sections of the unstrained rail are turned by 90° about z
        let turned_rad =
            rest.tips()[0].rotation.angle_to(&UnitQuaternion::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2));
        let stability = plant.study().stability().unwrap_or_else(|error| panic!("{error}"));
        assert!(stability.is_stable(), "{stability:?}");
        coast(&mut plant, 0.5);
        let off = apart(&rest, plant.outputs());
        println!(
            "SJ-44 from {from_m} m: at {carriage_m:.6} m, in still air at {still_m:.6} m, turned {turned_rad:.2} rad, leaves by {off:.1e}"
        );
        assert!(off < 1e-7 && turned_rad > 1.0, "{off:e}, {turned_rad} rad");
        assert!(carriage_m < 0.5 && still_m > 0.5, "a boundary of elements at 0.5 m: {carriage_m} m, {still_m} m");
        found.push(rest);
    }
    let off = apart(&found[0], &found[1]);
    assert!(off < 1e-8, "{off:e} apart");
    let Err(error) = rest_or_error(0.3, 24.0) else { panic!("beyond divergence") };
    // that speed is not one of the machine, whose carriage moves
    assert!(matches!(error, PlantError::Equilibrium { diverges_m_s: None, .. }), "{error:?}");
    let error = error.to_string();
    println!("SJ-44 {error}");
    assert!(error.contains("static divergence") && error.contains("slide at 0.3000 m"), "{error}");
}

/// SJ-37. Every row of the linear models with the lag states of strips: about a moving state beyond a border, and about the equilibrium.
#[test]
fn sj37_rows_of_linear_models_in_air() {
    let agree = |rows: Rows, what: &str| match rows {
        Rows::Agree(off) => println!("SJ-37 {what}: off by {off:.1e} of a row's scale"),
        Rows::Miss(why) | Rows::Refused(why) => panic!("{what}: {why}"),
    };
    let mut machine = sprung(strips(0.005).apparent_mass(false), 0.45);
    if let JointKind::Sliding(slide) = &mut machine.bodies[1].joint.kind {
        slide.start_rate_rad_s = 2.0;
    }
    let mut plant = start(machine.clone());
    coast(&mut plant, 0.05);
    assert!(plant.outputs().joints()[0].angle_rad > 0.5 && plant.statistics().events >= 1);
    agree(linear_rows_agree_at(&mut plant), "moving beyond a border");
    let mut plant = start(machine);
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    agree(linear_rows_agree_at(&mut plant), "equilibrium");
}

/// SJ-38. Modes in strips of a wing that is locked on its sliding joint are those of the wing that is clamped there.
#[test]
fn sj38_modes_in_air() {
    let locked = Joint::sliding("slide").on("rail").start_position_m(0.5).locked();
    let [slides, clamped] = [locked, Joint::clamped("slide").on_at("rail", 0.5)].map(|joint| {
        let mut plant = start(two_wings(strips(0.005), clamped(), joint));
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        let modes = plant.study().modes(6).unwrap_or_else(|error| panic!("{error}"));
        modes.into_iter().map(|mode| mode.eigenvalue_1_s).collect::<Vec<_>>()
    });
    let off = slides.iter().zip(&clamped).map(|(a, b)| (a - b).norm() / b.norm()).fold(0.0, f64::max);
    println!("SJ-38 eigenvalues {off:.1e} apart; {:.3?}", slides[0]);
    assert!(slides.len() == clamped.len() && off < 1e-7, "{off:e}");
}

/// SJ-39. A flexible rail that the wind pushes through a sleeve held by rigid loops: the energy account closes across borders, and the loops have
/// no gap.
#[test]
fn sj39_a_sleeve_in_air() {
    for (air, what) in [(strips as fn(f64) -> AirBuilder, "strips"), (lattice as fn(f64) -> AirBuilder, "lattice")] {
        let points_m = [[0.0; 3], [0.05, 0.0, 0.0], [0.0, 0.05, 0.0]];
        let sleeve = Body::rigid("sleeve").inertia(0.1, [0.0; 3], Matrix3::from_diagonal_element(1e-3));
        let machine = Machine::builder("sleeve")
            .body(rail(1.0), Joint::free("fly").at_root([-0.6, 0.0, 0.0]).start_velocity_m_s([0.8, 0.0, 0.0]))
            .body(sleeve, Joint::sliding("slide").on("rail").start_position_m(0.6).start_rate_m_s(-0.8))
            .air(air(0.007).wind_m_s([2.0, -9.0, 1.5]))
            .surface(surface("rail", 0.15));
        let hold = |(i, point_m)| Closure::rigid(format!("hold{i}"), ["sleeve", "root"]).offsets_m([point_m, point_m]);
        let machine = points_m.into_iter().enumerate().map(hold).fold(machine, |machine, hold| machine.closure(hold));
        let mut plant = start(built(machine, 1e-9));
        let before_j = balance_j(plant.outputs());
        let mut gap_m = 0.0f64;
        for step in 1..=25 {
            coast(&mut plant, 0.01 * f64::from(step));
            let loops = plant.outputs().loops().iter();
            gap_m = loops.map(|closure| closure.gap_m.norm()).fold(gap_m, f64::max);
        }
        let (slide, energy) = (plant.outputs().joints()[0], plant.outputs().energy());
        let drift_j = balance_j(plant.outputs()) - before_j;
        println!(
            "SJ-39 {what}: at {:.3} m, gap {gap_m:.1e} m, drift {drift_j:.1e} J, work {:.2e} J, {} events",
            slide.angle_rad,
            energy.work,
            plant.statistics().events
        );
        assert!(slide.angle_rad < 0.5 && plant.statistics().events >= 1, "{}", slide.angle_rad);
        assert!(gap_m < 1e-12 && drift_j.abs() < 1e-7 && energy.work.abs() > 1e-3, "{what}: {drift_j:e} J");
    }
}

/// SJ-42. A rotor in a model with a sliding joint is refused by the name of the joint.
#[test]
fn sj42_rotors_are_refused() {
    let bead = "\n[rigid_body.bead]\nmass_kg = 0.1\ncentre_of_mass_m = [0.0, 0.0, 0.0]\ninertia_kg_m2 = [1e-4, 1e-4, 1e-4, 0.0, 0.0, 0.0]\n\
                [joint.rail]\ntype = \"sliding\"\nparent = \"right_wing\"\nchild = \"bead\"\nstart_position_m = 0.5\n";
    let text = include_str!("../../../examples/airs/wing_with_propellers.toml").to_owned() + bead;
    let error = foldwing::config::parse(&text, "airs.toml").expect_err("a rotor").to_string();
    assert!(error.contains("no rotor in a model with a sliding joint (\"rail\")"), "{error}");
}
