//! CJ-01 to CJ-13: cylindrical joints, one rotation and one translation about and along the same axis, against closed forms, an independent
//! integration of Lagrange's equations, and the same machines of single joints.

use crate::agreement::agree;
use crate::linear_rows::compare::{Rows, linear_rows_agree};
use crate::plant::machines::{balance_j, body, coast, machine, solver, start, wing_section};
use foldwing::config;
use foldwing::machine::builder::{BodyBuilder, JointBuilder};
use foldwing::machine::*;
use foldwing::plant::{Holding, Hybrid, Outputs, Plant, Snapshot};
use nalgebra::{Matrix3, Rotation3, SVector, Vector3};
use std::f64::consts::{PI, TAU};

const MASS_KG: f64 = 2.0;
/// Centre of mass in the body's frame, m.
const CENTRE_M: [f64; 3] = [0.05, -0.12, 0.08];

/// Inertia about the centre of mass in the body's frame, kg·m², with products.
fn inertia_kg_m2() -> Matrix3<f64> {
    Matrix3::new(0.030, 0.002, -0.001, 0.002, 0.020, 0.003, -0.001, 0.003, 0.025)
}

fn piston() -> BodyBuilder {
    Body::rigid("piston").inertia(MASS_KG, CENTRE_M, inertia_kg_m2())
}

/// An axis of no special direction, of unit length.
fn axis() -> Vector3<f64> {
    Vector3::new(0.3, -0.5, 0.8).normalize()
}

const MOUNT_RAD: [f64; 3] = [0.4, -1.1, 0.7];

/// The cylindrical joint of most tests, at an offset from the root, with a mount.
fn strut() -> JointBuilder {
    Joint::cylindrical("strut", axis() * 2.0).at_root([0.1, 0.2, -0.3]).mount_rotation_rad(MOUNT_RAD)
}

/// A piston on a cylindrical joint without gravity, at a tight tolerance.
fn on_strut(joint: JointBuilder) -> Machine {
    let mut machine = machine([(piston(), joint)]);
    machine.solver.tolerance = 1e-10;
    machine
}

/// Centre of mass relative to the joint, and inertia about the axis through the joint, at angle zero.
fn about_axis() -> (Vector3<f64>, f64) {
    let mount = Rotation3::new(Vector3::from(MOUNT_RAD));
    let (centre_m, axis) = (mount * Vector3::from(CENTRE_M), axis());
    let own = (mount.matrix() * inertia_kg_m2() * mount.matrix().transpose() * axis).dot(&axis);
    (centre_m, own + MASS_KG * centre_m.cross(&axis).norm_squared())
}

/// Position, velocity, angle and rate.
fn state(outputs: &Outputs) -> [f64; 4] {
    let [along, about] = [0, 1].map(|joint| outputs.joints()[joint]);
    [along.angle_rad, along.rate_rad_s, about.angle_rad, about.rate_rad_s]
}

/// CJ-01. A cylindrical joint is short for a prismatic joint, a body without mass and a revolute joint on it: the machine is the same as with
/// these parts, with everything that acts on a joint with one degree of freedom; the order in which the degrees of freedom are described has
/// no effect; and the model file gives the same machine as the builder.
#[test]
fn cj01_a_cylindrical_joint_is_short_for_two() {
    let stops = |scale: f64| EndStops {
        lower_rad: Some(-0.3 * scale),
        upper_rad: Some(0.4 * scale),
        stiffness_n_m_rad: 2e3,
        damping_n_m_s_rad: 2.0,
    };
    let motor = Motor { stiffness_n_m_rad: 5.0, inertia_kg_m2: 0.01, gear_ratio: Some(-20.0), ..Motor::default() };
    let ram = LinearMotor { stiffness_n_m: 50.0, mass_kg: 0.2, command_m: 0.1, ..LinearMotor::default() };
    let spring = LinearSpring { stiffness_n_m: 30.0, damping_n_s_m: 0.5, rest_position_m: 0.1 };
    type Change<'c> = &'c dyn Fn(JointBuilder) -> JointBuilder;
    let changes: [(Change, Change); 6] = [
        (&|own| own, &|own| own),
        (&|own| own.start_position_m(0.1).start_rate_m_s(-0.2), &|own| own.start_angle_rad(0.3).start_rate_rad_s(2.0)),
        (&|own| own.spring(spring).end_stops(stops(0.5)), &|own| own.motor(motor.clone()).end_stops(stops(2.0))),
        (&|own| own.motor(ram.clone()).latch(Latch::rigid().angle_rad(0.2)), &|own| own.release(false)),
        (&|own| own.locked(), &|own| own.latch(Latch::with_stiffness_n_m_rad(40.0).angle_rad(0.1))),
        (&|own| own.prescribed(Motion::Polynomial(vec![0.1, 0.2])), &|own| {
            own.prescribed(Motion::Polynomial(vec![0.2]))
        }),
    ];
    for (along, about) in changes {
        let short = strut().rotation(about).translation(along);
        let slide = along(Joint::prismatic("strut_translation", axis() * 2.0)).at_root([0.1, 0.2, -0.3]);
        let hinge = about(Joint::revolute("strut_rotation", axis() * 2.0));
        let hinge = hinge.on("strut_carriage").mount_rotation_rad(MOUNT_RAD);
        let long = machine([(Body::rigid("strut_carriage").load_stations(0), slide), (piston(), hinge)]);
        assert_eq!(machine([(piston(), short)]), long);
        assert_eq!(machine([(piston(), strut().translation(along).rotation(about))]), long);
    }
    // each part of the description is added to what it has
    let twice = strut().rotation(|own| own.start_angle_rad(0.3)).rotation(|own| own.start_rate_rad_s(2.0));
    let once = strut().rotation(|own| own.start_angle_rad(0.3).start_rate_rad_s(2.0));
    assert_eq!(machine([(piston(), twice)]), machine([(piston(), once)]));

    let told =
        config::parse(include_str!("cylindrical.toml"), "cylindrical.toml").unwrap_or_else(|error| panic!("{error}"));
    let held = Body::rigid("held").inertia(1.0, [0.0, 0.0, 0.0], Matrix3::identity() * 0.01);
    let ram = LinearMotor {
        stiffness_n_m: 40.0,
        damping_n_s_m: 0.5,
        constant_force_n: 0.3,
        force_limit_n: 1.5,
        rate_limit_m_s: 0.2,
        mass_kg: 0.05,
        command_m: 0.01,
    };
    let drive = Motor {
        stiffness_n_m_rad: 4.0,
        damping_n_m_s_rad: 0.05,
        constant_torque_n_m: 0.03,
        torque_limit_n_m: 0.15,
        rate_limit_rad_s: 90f64.to_radians(),
        inertia_kg_m2: 0.005,
        gear_ratio: Some(12.0),
        command_rad: 15f64.to_radians(),
    };
    let ends = |[lower, upper]: [f64; 2], stiffness_n_m_rad, damping_n_m_s_rad| EndStops {
        lower_rad: Some(lower),
        upper_rad: Some(upper),
        stiffness_n_m_rad,
        damping_n_m_s_rad,
    };
    let joint = Joint::cylindrical("strut", [0.0, 0.6, 0.8])
        .on("held")
        .offset_m([0.1, 0.2, 0.3])
        .mount_rotation_rad([0.0, 0.5 * PI, 0.0])
        .translation(|own| {
            own.start_position_m(-0.05)
                .start_rate_m_s(0.1)
                .motor(ram)
                .spring(LinearSpring { stiffness_n_m: 5.0, damping_n_s_m: 0.1, rest_position_m: 0.02 })
                .latch(Latch::with_stiffness_n_m(300.0).position_m(0.02).capture_m(1e-3).enable(false))
                .end_stops(ends([-0.06, 0.08], 5e3, 4.0))
        })
        .rotation(|own| {
            own.start_angle_rad(20f64.to_radians())
                .start_rate_rad_s(-30f64.to_radians())
                .motor(drive)
                .spring(Spring { stiffness_n_m_rad: 0.5, damping_n_m_s_rad: 0.01, rest_angle_rad: 10f64.to_radians() })
                .latch(Latch::rigid().angle_rad(45f64.to_radians()))
                .end_stops(ends([-60f64, 90.0].map(f64::to_radians), 50.0, 0.1))
        });
    let second = Joint::cylindrical("second", Vector3::x())
        .on("piston")
        .translation(|own| own.prescribed(Motion::Table(vec![(0.0, 0.0), (0.2, 0.05)])))
        .rotation(|own| own.release(false));
    let built = Machine::builder("cylindrical")
        .body(held.clone(), Joint::clamped("mount"))
        .body(Body::rigid("piston").inertia(1.0, [0.02, 0.0, 0.0], Matrix3::identity() * 0.01), joint)
        .body(Body::rigid("wheel").inertia(1.0, [0.0, 0.0, 0.0], Matrix3::identity() * 0.01), second)
        .stop_time_s(0.3)
        .step_s(1e-3)
        .build()
        .unwrap_or_else(|refused| panic!("{refused}"));
    assert_eq!(told, built);
    let names: Vec<[&str; 2]> = told.bodies.iter().map(|body| [body.name.as_str(), body.joint.name.as_str()]).collect();
    assert_eq!(
        names,
        [
            ["held", "mount"],
            ["strut_carriage", "strut_translation"],
            ["piston", "strut_rotation"],
            ["second_carriage", "second_translation"],
            ["wheel", "second_rotation"],
        ]
    );
}

/// CJ-02. A rigid body with its centre of mass off the axis, on linear springs in rotation and translation: two uncoupled oscillations at
/// `√(k_s/m)` and `√(k_θ/I)`, with `I` about the axis; the errors after five and a quarter periods fall with the order of each method, and
/// the modes have both frequencies.
#[test]
fn cj02_two_uncoupled_oscillations() {
    let (_, inertia) = about_axis();
    let (along, about) = (80.0, 12.0);
    let rates = [f64::sqrt(along / MASS_KG), f64::sqrt(about / inertia)];
    let starts = [0.03, 0.4];
    let sprung = || {
        let spring = LinearSpring { stiffness_n_m: along, ..LinearSpring::default() };
        let twist = Spring { stiffness_n_m_rad: about, ..Spring::default() };
        on_strut(
            strut()
                .translation(|own| own.spring(spring).start_position_m(starts[0]))
                .rotation(|own| own.spring(twist).start_angle_rad(starts[1])),
        )
    };
    for (method, order) in [
        (Method::GeneralizedAlpha, 2.0),
        (Method::TrBdf2, 2.0),
        (Method::Sdirk2, 2.0),
        (Method::Esdirk3, 3.0),
        (Method::Esdirk4, 4.0),
        (Method::Rk4, 4.0),
    ] {
        let errors = [60.0, 120.0].map(|steps| {
            rates.map(|rate| {
                let period_s = TAU / rate;
                let mut machine = sprung();
                (machine.solver.method, machine.solver.fixed_step_s) = (method, Some(period_s / steps));
                machine.solver.max_step_s = period_s;
                let (end_s, which) = (5.25 * period_s, usize::from(rate == rates[1]));
                let mut plant = start(machine);
                coast(&mut plant, end_s);
                let state = state(plant.outputs());
                let (sine, cosine) = (rate * end_s).sin_cos();
                let start = starts[which];
                let [place, speed] = [state[2 * which] - start * cosine, state[2 * which + 1] + start * rate * sine];
                (place / start).hypot(speed / (start * rate))
            })
        });
        for (which, name) in ["translation", "rotation"].into_iter().enumerate() {
            let found = (errors[0][which] / errors[1][which]).log2();
            println!("CJ-02 {method:?}, {name}: {:.1e}, {:.1e}, order {found:.2}", errors[0][which], errors[1][which]);
            assert!((found - order).abs() < 0.3, "{method:?}, {name}: order {found:.2}");
        }
    }
    let mut plant = start(sprung());
    let mut due = rates.map(|rate| rate / TAU);
    due.sort_by(f64::total_cmp);
    let modes = plant.study().modes(2).expect("modes");
    for (mode, due_hz) in modes.iter().zip(due) {
        let miss = (mode.frequency_hz / due_hz - 1.0).abs();
        assert!(miss < 1e-9, "{} Hz of {due_hz} Hz", mode.frequency_hz);
    }
    let freedoms = plant.freedoms();
    let names: Vec<_> = freedoms.iter().map(|own| (own.name.as_str(), own.unit, own.rate_unit)).collect();
    assert_eq!(names, [("strut_translation.position", "m", "m/s"), ("strut_rotation.angle", "rad", "rad/s")]);
}

/// One step of the classical Runge–Kutta method for `ẏ = f(y)`.
fn runge_kutta<const N: usize>(f: &impl Fn(&SVector<f64, N>) -> SVector<f64, N>, y: &mut SVector<f64, N>, step_s: f64) {
    let k1 = f(y);
    let k2 = f(&(*y + k1 * (0.5 * step_s)));
    let k3 = f(&(*y + k2 * (0.5 * step_s)));
    let k4 = f(&(*y + k3 * step_s));
    *y += (k1 + (k2 + k3) * 2.0 + k4) * (step_s / 6.0);
}

/// CJ-03. A helicoidal pendulum: the axis is inclined to gravity. Along it the body falls by `½ g·a t²`; about it it is a pendulum in the part
/// of gravity normal to the axis, `I θ̈ = m (g × c(θ))·a`, here integrated on its own. Neither acts on the other, whatever its inertia.
#[test]
fn cj03_a_helicoidal_pendulum() {
    let gravity = Vector3::new(1.0, -2.0, -9.0);
    let mut machine =
        on_strut(strut().rotation(|own| own.start_angle_rad(2.0)).translation(|own| own.start_rate_m_s(0.7)));
    machine.gravity_m_s2 = gravity;
    let mut plant = start(machine);
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, 1.5);
    let (centre_m, inertia) = about_axis();
    let moment = |angle: f64| {
        let c = Rotation3::from_scaled_axis(axis() * angle) * centre_m;
        MASS_KG * c.cross(&gravity).dot(&axis())
    };
    let mut pendulum = SVector::<f64, 2>::new(2.0, 0.0);
    let (steps, mut swing) = (15_000, 0.0f64);
    for _ in 0..steps {
        swing = swing.max((pendulum[0] - 2.0).abs());
        runge_kutta(&|y| SVector::<f64, 2>::new(y[1], moment(y[0]) / inertia), &mut pendulum, 1.5 / f64::from(steps));
    }
    let fall = gravity.dot(&axis());
    let due = [0.7 * 1.5 + 0.5 * fall * 1.5 * 1.5, 0.7 + fall * 1.5, pendulum[0], pendulum[1]];
    let found = state(plant.outputs());
    let miss = (0..4).map(|i| (found[i] - due[i]).abs()).fold(0.0, f64::max);
    let drift = (balance_j(plant.outputs()) - before_j).abs();
    println!("CJ-03 {found:?}, misses {miss:.1e}, drift {drift:.1e} J");
    assert!(swing > 1.0, "the pendulum swings by {swing} rad");
    // the step control permits 1e-10 per step, in a few hundred steps
    agree("CJ-03", miss, 5e-8);
    agree("CJ-03 energy in J", drift, 4e-8);
}

/// A turntable on a vertical axis with a cylindrical joint whose axis is inclined: inertia of the table about its axis in kg·m², and position
/// of the joint on it in m.
const TABLE: (f64, [f64; 3]) = (0.4, [0.25, 0.1, 0.05]);

fn on_table(gravity_m_s2: [f64; 3]) -> Machine {
    let table = Body::rigid("table").inertia(3.0, [0.0, 0.0, 0.0], Matrix3::identity() * TABLE.0);
    let spring = LinearSpring { stiffness_n_m: 60.0, damping_n_s_m: 0.0, rest_position_m: 0.05 };
    let strut = Joint::cylindrical("strut", axis())
        .on("table")
        .offset_m(TABLE.1)
        .mount_rotation_rad(MOUNT_RAD)
        .translation(|own| own.spring(spring).start_position_m(0.1).start_rate_m_s(-0.5))
        .rotation(|own| own.start_angle_rad(0.2).start_rate_rad_s(3.0));
    let mut machine =
        machine([(table, Joint::revolute("vertical", [0.0, 0.0, 1.0]).start_rate_rad_s(-1.5)), (piston(), strut)]);
    (machine.gravity_m_s2, machine.solver.tolerance) = (gravity_m_s2.into(), 1e-10);
    machine
}

/// Position of the centre of mass of the piston in the root frame and its attitude, for the angle of the table, the position and the angle of
/// the strut.
fn pose(q: &SVector<f64, 3>) -> (Vector3<f64>, Matrix3<f64>) {
    let table = Rotation3::from_scaled_axis(Vector3::z() * q[0]);
    let attitude = table * Rotation3::from_scaled_axis(axis() * q[2]) * Rotation3::new(Vector3::from(MOUNT_RAD));
    let place_m = table * (Vector3::from(TABLE.1) + axis() * q[1]) + attitude * Vector3::from(CENTRE_M);
    (place_m, *attitude.matrix())
}

/// Derivative of a function of the three coordinates by one of them: central differences of eighth order.
fn slope<T>(f: &impl Fn(&SVector<f64, 3>) -> T, q: &SVector<f64, 3>, which: usize) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Sub<Output = T> + std::ops::Add<Output = T>,
{
    let h = 0.02;
    let side = |k: f64| {
        let mut there = *q;
        there[which] += k * h;
        f(&there)
    };
    let pair = |k: f64, weight: f64| (side(k) - side(-k)) * (weight / h);
    pair(1.0, 0.8) + pair(2.0, -0.2) + pair(3.0, 4.0 / 105.0) + pair(4.0, -1.0 / 280.0)
}

/// Mass matrix of the table with the piston, from the kinetic energy of both.
fn mass_matrix(q: &SVector<f64, 3>) -> Matrix3<f64> {
    let mut mass = Matrix3::zeros();
    mass[(0, 0)] = TABLE.0;
    let table = Rotation3::from_scaled_axis(Vector3::z() * q[0]);
    let axis = table * axis();
    let attitude = pose(q).1;
    let spins = [Vector3::z(), Vector3::zeros(), axis];
    let moves: [Vector3<f64>; 3] = std::array::from_fn(|i| slope(&|q| pose(q).0, q, i));
    let inertia = attitude * inertia_kg_m2() * attitude.transpose();
    for i in 0..3 {
        for j in 0..3 {
            mass[(i, j)] += MASS_KG * moves[i].dot(&moves[j]) + spins[i].dot(&(inertia * spins[j]));
        }
    }
    mass
}

/// Lagrange's equations: `M q̈ = ½ ∂(q̇ᵀ M q̇)/∂q − Ṁ q̇ − ∂V/∂q`.
fn lagrange(y: &SVector<f64, 6>, gravity_m_s2: &Vector3<f64>) -> SVector<f64, 6> {
    let (q, v): (SVector<f64, 3>, SVector<f64, 3>) = (y.fixed_rows::<3>(0).into(), y.fixed_rows::<3>(3).into());
    let by: [Matrix3<f64>; 3] = std::array::from_fn(|i| slope(&mass_matrix, &q, i));
    let spring = 60.0 * (q[1] - 0.05);
    let right = SVector::<f64, 3>::from_fn(|i, _| {
        let changing: f64 = (0..3).map(|k| (by[k] * v)[i] * v[k]).sum();
        let weight = MASS_KG * gravity_m_s2.dot(&slope(&|q| pose(q).0, &q, i));
        0.5 * v.dot(&(by[i] * v)) - changing + weight - if i == 1 { spring } else { 0.0 }
    });
    let a = mass_matrix(&q).lu().solve(&right).expect("a regular mass matrix");
    SVector::<f64, 6>::from_fn(|i, _| if i < 3 { v[i] } else { a[i - 3] })
}

/// CJ-04. A body on a cylindrical joint with an inclined axis, on a turntable, under gravity and a spring: all three motions are coupled. Against
/// Lagrange's equations of the three coordinates, whose mass matrix and derivatives follow from positions alone.
#[test]
fn cj04_the_coupled_motion_is_that_of_lagrange() {
    let gravity = [1.0, -2.0, -9.0];
    let mut plant = start(on_table(gravity));
    let before_j = balance_j(plant.outputs());
    let mut due = SVector::<f64, 6>::from([0.0, 0.1, 0.2, -1.5, -0.5, 3.0]);
    let (mut miss, steps) = (0.0f64, 400);
    let mut swings = 0.0f64;
    for part in 1..=4 {
        for _ in 0..steps {
            runge_kutta(&|y| lagrange(y, &gravity.into()), &mut due, 0.2 / f64::from(steps));
        }
        coast(&mut plant, 0.2 * f64::from(part));
        for (i, joint) in plant.outputs().joints().iter().enumerate() {
            miss = miss.max((joint.angle_rad - due[i]).abs()).max((joint.rate_rad_s - due[i + 3]).abs());
            swings = swings.max(joint.rate_rad_s.abs());
        }
    }
    let drift = (balance_j(plant.outputs()) - before_j).abs();
    println!("CJ-04 {due}, misses {miss:.1e} of {swings}, drift {drift:.1e} J");
    agree("CJ-04", miss, 2e-8);
    agree("CJ-04 energy in J", drift, 1e-7);
}

/// CJ-05. A prismatic joint followed by a revolute joint on a body of small mass tends to the cylindrical joint: the difference of the motion
/// is proportional to the mass, over three decades.
#[test]
fn cj05_a_light_intermediate_body_tends_to_it() {
    let gravity = [1.0, -2.0, -9.0];
    let last = |machine: Machine| {
        let mut plant = start(machine);
        coast(&mut plant, 0.4);
        plant.outputs().joints().iter().map(|joint| joint.angle_rad).collect::<Vec<_>>()
    };
    let limit = last(on_table(gravity));
    let off = [1e-2, 1e-3, 1e-4].map(|mass_kg| {
        let mut machine = on_table(gravity);
        machine.bodies[1].masses.push(AttachedMass::point("light", 0.0, mass_kg));
        let found = last(machine);
        (0..3).map(|i| (found[i] - limit[i]).abs()).fold(0.0, f64::max)
    });
    println!("CJ-05 {off:?}");
    assert!(off[0] > 1e-5, "the mass has an effect");
    for pair in off.windows(2) {
        let order = (pair[0] / pair[1]).log10();
        // the second power of the mass, 1e-2 of 2 kg, is in the first difference
        assert!((order - 1.0).abs() < 0.01, "order {order}");
    }
}

/// CJ-06. A free axis transmits neither force along it nor moment about it: momentum along the axis and angular momentum about it are constant
/// while a second body swings on the first, and the reaction of the joint has no such part.
#[test]
fn cj06_momenta_of_the_free_axis_are_constant() {
    let arm =
        Body::rigid("arm").inertia(0.6, [0.2, 0.02, -0.03], Matrix3::from_diagonal(&Vector3::new(1e-3, 3e-3, 3e-3)));
    let hinge =
        Joint::revolute("elbow", [0.2, 1.0, -0.4]).on("piston").offset_m([0.1, 0.05, 0.0]).start_rate_rad_s(9.0);
    let joint = strut().translation(|own| own.start_rate_m_s(0.3)).rotation(|own| own.start_rate_rad_s(-2.0));
    let mut machine = machine([(piston(), joint), (arm, hinge)]);
    machine.solver.tolerance = 1e-10;
    let parts: Vec<(f64, Vector3<f64>, Matrix3<f64>)> = machine.bodies[1..]
        .iter()
        .map(|body| (body.masses[0].mass_kg, body.masses[0].offset_m, body.masses[0].inertia_kg_m2))
        .collect();
    let through = Vector3::new(0.1, 0.2, -0.3);
    // the stations of rigid bodies are at their origins; the carriage has none
    let momenta = |outputs: &Outputs| {
        let mut sum = [0.0; 2];
        for ((mass_kg, centre_m, inertia), at) in parts.iter().zip(outputs.stations()) {
            let turn = at.rotation.to_rotation_matrix();
            let arm_m = turn * centre_m;
            let velocity = at.velocity_m_s + at.angular_velocity_rad_s.cross(&arm_m);
            let spin = turn.matrix() * inertia * turn.matrix().transpose() * at.angular_velocity_rad_s;
            let place_m = at.position_m + arm_m - through;
            sum[0] += mass_kg * velocity.dot(&axis());
            sum[1] += (place_m.cross(&(velocity * *mass_kg)) + spin).dot(&axis());
        }
        sum
    };
    let mut plant = start(machine);
    assert_eq!(plant.outputs().stations().len(), 2);
    let before = momenta(plant.outputs());
    let (mut miss, mut carried, mut between, mut swing) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for part in 1..=20 {
        coast(&mut plant, 0.05 * f64::from(part));
        let now = momenta(plant.outputs());
        miss = miss.max((now[0] - before[0]).abs()).max((now[1] - before[1]).abs());
        let reactions = plant.outputs().joint_reactions();
        carried = carried.max(reactions[0].force_n.dot(&axis()).abs()).max(reactions[1].moment_n_m.dot(&axis()).abs());
        // the carriage passes on what it bears
        let [inner, outer] = [reactions[0], reactions[1]];
        between = between.max((inner.force_n - outer.force_n).norm()).max((inner.moment_n_m - outer.moment_n_m).norm());
        swing = swing.max(reactions[0].force_n.norm());
    }
    println!(
        "CJ-06 momenta {before:?} off by {miss:.1e}, carried along and about the axis {carried:.1e}, {between:.1e} of {swing} N"
    );
    assert!(swing > 1.0);
    agree("CJ-06 momenta", miss, 1e-8);
    agree("CJ-06 reaction", carried, 5e-14);
    // accelerations inside of steps are interpolated; the components above follow from the forces on the joints
    agree("CJ-06 both reactions", between, 2e-6);
}

/// CJ-07. Latches and end stops of each degree of freedom leave the other alone, since both are about and along one fixed axis: a rigid latch
/// stops the translation at its position while the rotation continues at its rate, and the reverse; the energy of the stopped motion is
/// dissipated; an elastic end stop reverses one rate.
#[test]
fn cj07_latches_and_stops_of_each_freedom() {
    let (_, inertia) = about_axis();
    let moving = |along: &dyn Fn(JointBuilder) -> JointBuilder, about: &dyn Fn(JointBuilder) -> JointBuilder| {
        let joint =
            strut().translation(|own| along(own.start_rate_m_s(0.5))).rotation(|own| about(own.start_rate_rad_s(2.0)));
        start(on_strut(joint))
    };
    let as_is = |own: JointBuilder| own;
    let mut plant = moving(&|own| own.latch(Latch::rigid().position_m(0.1)), &as_is);
    coast(&mut plant, 1.0);
    let [s, v, angle, rate] = state(plant.outputs());
    let lost_j = 0.5 * MASS_KG * 0.25;
    assert!((s - 0.1).abs() < 2e-6 && v == 0.0, "{s} m, {v} m/s");
    assert!((angle - 2.0).abs() < 1e-9 && (rate - 2.0).abs() < 1e-9, "{angle} rad, {rate} rad/s");
    assert!((plant.outputs().energy().dissipated - lost_j).abs() < 1e-9 * lost_j);
    assert!((plant.outputs().latches()[0].time_s - 0.2).abs() < 3e-6);

    let mut plant = moving(&as_is, &|own| own.latch(Latch::rigid().angle_rad(0.6)));
    coast(&mut plant, 1.0);
    let [s, v, angle, rate] = state(plant.outputs());
    let lost_j = 0.5 * inertia * 4.0;
    assert!((s - 0.5).abs() < 1e-9 && (v - 0.5).abs() < 1e-9, "{s} m, {v} m/s");
    assert!((angle - 0.6).abs() < 2e-6 && rate == 0.0, "{angle} rad, {rate} rad/s");
    assert!((plant.outputs().energy().dissipated - lost_j).abs() < 1e-9 * lost_j);

    let stops = |upper: f64, stiffness_n_m_rad: f64| EndStops {
        lower_rad: None,
        upper_rad: Some(upper),
        stiffness_n_m_rad,
        damping_n_m_s_rad: 0.0,
    };
    // half a period of contact, then the reversed rate
    let contact_s = PI * f64::sqrt(MASS_KG / 2e4);
    let mut plant = moving(&|own| own.end_stops(stops(0.1, 2e4)), &as_is);
    coast(&mut plant, 1.0);
    let [s, v, angle, rate] = state(plant.outputs());
    let due_m = 0.1 - 0.5 * (1.0 - 0.2 - contact_s);
    assert!((s - due_m).abs() < 1e-7 && (v + 0.5).abs() < 1e-7, "{s} m of {due_m} m, {v} m/s");
    assert!((angle - 2.0).abs() < 1e-9 && (rate - 2.0).abs() < 1e-9, "{angle} rad, {rate} rad/s");

    let contact_s = PI * f64::sqrt(inertia / 500.0);
    let mut plant = moving(&as_is, &|own| own.end_stops(stops(0.6, 500.0)));
    coast(&mut plant, 1.0);
    let [s, v, angle, rate] = state(plant.outputs());
    let due_rad = 0.6 - 2.0 * (1.0 - 0.3 - contact_s);
    assert!((angle - due_rad).abs() < 1e-6 && (rate + 2.0).abs() < 1e-6, "{angle} rad of {due_rad} rad, {rate} rad/s");
    assert!((s - 0.5).abs() < 1e-9 && (v - 0.5).abs() < 1e-9, "{s} m, {v} m/s");

    // the release input of each holds it alone
    let mut plant = moving(&as_is, &as_is);
    coast(&mut plant, 0.2);
    plant.inputs_mut().joints_mut()[0].release = false.into();
    coast(&mut plant, 0.5);
    let [s, v, angle, rate] = state(plant.outputs());
    assert!((s - 0.1).abs() < 1e-9 && v == 0.0 && (angle - 1.0).abs() < 1e-9 && (rate - 2.0).abs() < 1e-9);
}

/// A wing with a strut of every kind of force, at an angle to gravity: a flexible body on the joint.
fn busy() -> Machine {
    let spring = LinearSpring { stiffness_n_m: 20.0, damping_n_s_m: 0.05, rest_position_m: 0.01 };
    let stops =
        EndStops { lower_rad: Some(-0.02), upper_rad: Some(0.02), stiffness_n_m_rad: 4e3, damping_n_m_s_rad: 1.0 };
    let motor = Motor {
        stiffness_n_m_rad: 0.05,
        damping_n_m_s_rad: 2e-4,
        inertia_kg_m2: 1e-5,
        gear_ratio: Some(-15.0),
        ..Motor::default()
    };
    let joint = Joint::cylindrical("strut", [1.0, 0.2, 0.1])
        .on("table")
        .offset_m([0.05, 0.02, 0.0])
        .mount_rotation_rad([0.1, -0.2, 0.05])
        .translation(|own| own.spring(spring).end_stops(stops).start_rate_m_s(0.6))
        .rotation(|own| {
            own.motor(motor).latch(Latch::with_stiffness_n_m_rad(3.0).angle_rad(-0.1)).start_rate_rad_s(-14.0)
        });
    let blade =
        body("blade", 0.2, &wing_section(), ElementKind::Linear, 2).mass_damping_1_s(0.5).stiffness_damping_s(1e-4);
    let table = Body::rigid("table").inertia(0.3, [0.01, 0.0, 0.02], Matrix3::identity() * 1e-3);
    let built = Machine::builder("busy")
        .gravity_m_s2([0.0, 3.0, -9.0])
        .body(table, Joint::revolute("vertical", [0.0, 0.1, 1.0]).start_rate_rad_s(2.0))
        .body(blade, joint)
        .mass("blade", AttachedMass::point("tip", 0.2, 0.01))
        .solver(solver(Method::Esdirk4, 1e-8))
        .build();
    built.unwrap_or_else(|refused| panic!("{refused}"))
}

/// CJ-08. Energy with all of it at once, on a flexible body, through stops and a latch; communication steps leave the run; rollback and saved
/// states are bit-identical, in the same and in another instance.
#[test]
fn cj08_energy_and_saved_states() {
    let mut plant = start(busy());
    let before_j = balance_j(plant.outputs());
    let (mut largest_j, mut contact) = (0.0f64, false);
    for k in 1..=60 {
        coast(&mut plant, 5e-3 * f64::from(k));
        largest_j = largest_j.max(plant.outputs().energy().kinetic);
        contact |= plant.outputs().joints()[1].angle_rad.abs() > 0.02;
    }
    let drift = (balance_j(plant.outputs()) - before_j).abs() / largest_j;
    println!("CJ-08 drift {drift:.1e} of {largest_j} J, {:?}", plant.outputs().energy());
    assert!(contact && plant.outputs().latches()[2].time_s > 0.0, "the stop and the latch act");
    agree("CJ-08", drift, 1e-5);

    let mut plant = start(busy());
    coast(&mut plant, 0.0123);
    let snapshot = plant.snapshot();
    let bytes = postcard::to_stdvec(&snapshot).expect("serialises");
    let run_on = |plant: &mut Plant| {
        coast(plant, 0.05);
        plant.inputs_mut().joints_mut()[1].torque_n_m = 3.0;
        plant.inputs_mut().joints_mut()[2].command_rad = 0.4;
        coast(plant, 0.2);
        plant.outputs().values().iter().map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    let first = run_on(&mut plant);
    plant.restore(&snapshot).expect("the same machine");
    assert_eq!(run_on(&mut plant), first, "after a rollback");
    let mut other = start(busy());
    let saved: Snapshot = postcard::from_bytes(&bytes).expect("deserialises");
    other.restore(&saved).expect("the same machine");
    assert_eq!(run_on(&mut other), first, "in another instance");
}

/// CJ-09. Statics: the spring of the translation carries the weight along the axis, and that of the rotation its moment about the axis; the
/// motion about this state has both frequencies; the rows of linear models agree with differences, at rest and in motion; locks hold both.
#[test]
fn cj09_statics_and_linear_models() {
    let gravity = Vector3::new(1.0, -2.0, -9.0);
    let (along, about) = (400.0, 9.0);
    let spring = LinearSpring { stiffness_n_m: along, ..LinearSpring::default() };
    let twist = Spring { stiffness_n_m_rad: about, ..Spring::default() };
    let mut machine = on_strut(strut().translation(|own| own.spring(spring)).rotation(|own| own.spring(twist)));
    machine.gravity_m_s2 = gravity;
    let mut plant = Plant::new(std::sync::Arc::new(machine.clone()));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let [s, v, angle, rate] = state(plant.outputs());
    let (centre_m, inertia) = about_axis();
    let arm = |angle: f64| Rotation3::from_scaled_axis(axis() * angle) * centre_m;
    let left = about * angle - MASS_KG * arm(angle).cross(&gravity).dot(&axis());
    assert!((s - MASS_KG * gravity.dot(&axis()) / along).abs() < 1e-12 && v == 0.0 && rate == 0.0, "{s} m");
    assert!(angle.abs() > 0.02 && left.abs() < 1e-11, "{angle} rad, {left} N·m left");
    // stiffness of the weight about the axis: its moment by the angle
    let weight = MASS_KG * axis().cross(&arm(angle)).cross(&gravity).dot(&axis());
    let mut due = [along / MASS_KG, (about - weight) / inertia].map(|square| square.sqrt() / TAU);
    due.sort_by(f64::total_cmp);
    let modes = plant.study().modes(2).expect("modes");
    for (mode, due_hz) in modes.iter().zip(due) {
        assert!((mode.frequency_hz / due_hz - 1.0).abs() < 1e-9, "{} Hz of {due_hz} Hz", mode.frequency_hz);
    }
    for (name, machine) in [("sprung", machine), ("turntable", on_table([1.0, -2.0, -9.0])), ("busy", busy())] {
        match linear_rows_agree(&machine) {
            Rows::Agree(worst) => println!("CJ-09 {name}: {worst:.1e}"),
            other => panic!("{name}: {other:?}"),
        }
    }
}

/// CJ-10. Under an external integrator, Runge–Kutta with 50 µs, the coupled motion on the turntable is that of the internal one; both
/// coordinates and their rates are states.
#[test]
fn cj10_an_external_integrator_finds_the_same_run() {
    let mut own = start(on_table([1.0, -2.0, -9.0]));
    coast(&mut own, 0.1);
    let mut plant = start(on_table([1.0, -2.0, -9.0]));
    let mut hybrid: Hybrid = plant.hybrid().expect("a hybrid system");
    assert_eq!(hybrid.states(), 6);
    let mut states = vec![0.0; 6];
    hybrid.read(&mut states);
    let step_s = 5e-5;
    for k in 0..2000 {
        let (mut end, mut slope) = (states.clone(), vec![0.0; 6]);
        for (place, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let at: Vec<f64> = states.iter().zip(&slope).map(|(x, slope)| x + place * step_s * slope).collect();
            hybrid.set((f64::from(k) + place) * step_s, &at);
            hybrid.derivatives(&mut slope).expect("derivatives");
            end.iter_mut().zip(&slope).for_each(|(x, slope)| *x += weight / 6.0 * step_s * slope);
        }
        states = end;
        hybrid.complete();
    }
    hybrid.set(0.1, &states);
    let found = hybrid.outputs();
    let miss = found
        .joints()
        .iter()
        .zip(own.outputs().joints())
        .map(|(a, b)| (a.angle_rad - b.angle_rad).abs().max((a.rate_rad_s - b.rate_rad_s).abs()));
    let miss = miss.fold(0.0, f64::max);
    println!("CJ-10 {miss:.1e}");
    agree("CJ-10", miss, 1e-8);
}

/// CJ-11. Messages name the table and key of the degree of freedom, or of the joint, with line and cure; also in copies of a body.
#[test]
fn cj11_refusals_name_the_table() {
    let text = include_str!("cylindrical.toml");
    for (from, to, key, allowed) in [
        ("start_angle_deg = 20.0", "start_angle_deg = 400.0", "joint.strut.rotation.start_angle_deg", "-360 to 360"),
        ("start_angle_deg = 20.0", "start_position_m = 0.1", "joint.strut.rotation.start_position_m", "is unknown"),
        ("gear_ratio = 12.0", "gear_ratio = 0.0", "joint.strut.rotation.motor.gear_ratio", "a magnitude from 1e-6"),
        ("motor.mass_kg = 0.05", "motor.gear_ratio = 2.0", "joint.strut.translation.motor.gear_ratio", "revolute"),
        ("motor.mass_kg = 0.05", "motor.inertia_kg_m2 = 2.0", "joint.strut.translation.motor.inertia_kg_m2", "mass_kg"),
        ("lower_m = -0.06", "lower_m = 0.2", "joint.strut.translation.end_stops.upper_m", "above lower_m"),
        (
            "latch.kind = \"rigid\"",
            "latch.kind = \"elastic\"",
            "joint.strut.rotation.latch.stiffness_ratio",
            "kind = \"rigid\"",
        ),
        ("axis = [0.0, 0.6, 0.8]", "", "joint.strut.axis", "not all 0"),
        ("axis = [0.0, 0.6, 0.8]", "axis = [0.0, 0.0, 0.0]", "joint.strut.axis", "not all 0"),
        ("parent = \"held\"", "parent = \"hold\"", "joint.strut.parent", "did you mean \"held\"?"),
        ("parent_offset_m = [0.1, 0.2, 0.3]", "body_axis = [0.1, 0.2, 0.3]", "joint.strut.body_axis", "\"universal\""),
        (
            "parent_offset_m = [0.1, 0.2, 0.3]",
            "start_angle_deg = 3.0",
            "joint.strut.start_angle_deg",
            "only in its \"rotation\"",
        ),
        (
            "parent_offset_m = [0.1, 0.2, 0.3]",
            "polynomial_m = [3.0]",
            "joint.strut.polynomial_m",
            "only in its \"translation\"",
        ),
        (
            "parent_offset_m = [0.1, 0.2, 0.3]",
            "spring.stiffness_N_m = 3.0",
            "joint.strut.spring",
            "only in its \"translation\" or \"rotation\"",
        ),
        ("type = \"cylindrical\"", "type = \"revolute\"", "joint.strut.rotation", "type = \"cylindrical\""),
        (
            "motion = \"prescribed\"",
            "motion = \"prescribed\"\nstart_position_m = 0.1",
            "joint.second.translation.start_position_m",
            "determines it",
        ),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        let refused = config::parse(&changed, "cylindrical.toml").expect_err(to).to_string();
        assert!(refused.contains(key) && refused.contains(allowed), "{to}: {refused}");
        if let Some(line) = changed
            .lines()
            .position(|line| line == to && !to.is_empty() && key.ends_with(to.split(' ').next().expect("a key")))
        {
            assert!(refused.contains(&format!("cylindrical.toml:{}:", line + 1)), "{to}: {refused}");
        }
    }
    // the parts take their names from the joint
    let named = text.replacen("[joint.mount]", "[rigid_body.strut_carriage]\nmass_kg = 1.0\n[joint.strut_rotation]\ntype = \"clamped\"\nparent = \"held\"\nchild = \"strut_carriage\"\n[joint.mount]", 1);
    let refused = config::parse(&named, "cylindrical.toml").expect_err("names in use").to_string();
    assert!(
        refused.contains("a name that no other body has") && refused.contains("a name that no other joint has"),
        "{refused}"
    );
    let code = Machine::builder("t").body(piston(), Joint::revolute("pin", [1.0, 0.0, 0.0]).translation(|own| own));
    let refused = code.build().expect_err("a revolute joint").to_string();
    assert!(refused.contains("joint \"pin\", translation") && refused.contains("\"cylindrical\""), "{refused}");
    let code = Machine::builder("t").body(piston(), strut().spring(Spring::default()));
    let refused = code.build().expect_err("a spring of neither").to_string();
    assert!(
        refused.contains("joint \"strut\", spring") && refused.contains("only in its \"translation\" or \"rotation\""),
        "{refused}"
    );
    // failures are those of one degree of freedom
    let fails = format!("{text}\n[failure.lost]\nkind = \"spring_break\"\njoint = \"strut\"\nat_time_s = 0.1\n");
    let refused = config::parse(&fails, "cylindrical.toml").expect_err("a failure of both").to_string();
    assert!(
        refused.contains("failure.lost.joint")
            && refused.contains("\"strut_translation\"")
            && refused.contains("\"strut_rotation\""),
        "{refused}"
    );
    let bound = "when = { joint = \"strut_translation\", position_above_m = 0.1 }";
    let fails = format!("{text}\n[failure.lost]\nkind = \"spring_break\"\njoint = \"strut_rotation\"\n{bound}\n");
    config::parse(&fails, "cylindrical.toml").unwrap_or_else(|error| panic!("{error}"));

    // copies of a blade, each on a joint of its own, and errors of the original
    let blades = "name = \"hub\"\n[section.s]\nshape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\ndensity_kg_m3 = 1425.0\n\
                  youngs_modulus_Pa = 2.8e9\npoisson_ratio = 0.3\n[rigid_body.hub]\nmass_kg = 1.0\n[joint.mount]\ntype = \"clamped\"\n\
                  parent = \"root\"\nchild = \"hub\"\n[body.blade]\ncount = 2\nlength_m = 0.3\nsection = \"s\"\nelements = 1\n\
                  [joint.root]\ntype = \"cylindrical\"\nparent = \"hub\"\nchild = \"blade\"\naxis = [0.0, 0.0, 1.0]\n\
                  mount_rotation_deg = [0.0, -90.0, 0.0]\n[joint.root.translation]\nspring.stiffness_N_m = 1e4\n[joint.root.rotation]\n\
                  start_angle_deg = 5.0\nspring.stiffness_N_m_rad = 10.0\n";
    let blades = blades.replace("joint.root", "joint.pitch");
    let hub = config::parse(&blades, "hub.toml").unwrap_or_else(|error| panic!("{error}"));
    let mut names: Vec<&str> = hub.bodies.iter().map(|body| body.joint.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["mount", "pitch1_rotation", "pitch1_translation", "pitch2_rotation", "pitch2_translation"]);
    let axes: Vec<Vector3<f64>> = hub.one_freedoms().map(|(_, own)| own.axis).collect();
    assert_eq!(axes.len(), 4);
    assert!(
        (axes[0] - axes[1]).norm() < 1e-15 && (axes[2] - axes[3]).norm() < 1e-15 && (axes[0] + axes[2]).norm() < 1e-15
    );
    let wrong = blades.replace("start_angle_deg = 5.0", "motor.gear_ratio = 0.0");
    let refused = config::parse(&wrong, "hub.toml").expect_err("a ratio of 0").to_string();
    assert!(
        refused.contains("joint.pitch.rotation.motor.gear_ratio") && refused.matches("gear_ratio").count() == 1,
        "{refused}"
    );
}

/// CJ-13. The nose gear of `examples/gear/oleo.toml` at touchdown: the rig on gas spring and damper of the strut is an oscillator of one mass,
/// whatever the wheel does, which swings into its direction of travel meanwhile; the energy balance closes.
#[test]
fn cj13_the_shipped_nose_gear() {
    let text = include_str!("../../../examples/gear/oleo.toml");
    let text = text.replace("[simulation]", "[solver]\ntolerance = 1e-8\n[simulation]");
    let mut plant = start(config::parse(&text, "oleo.toml").unwrap_or_else(|error| panic!("{error}")));
    let before_j = balance_j(plant.outputs());
    let (mass_kg, stiffness, damping, slack_m) = (250.0, 16e3, 1500.0, 0.02);
    let rest_m = mass_kg * 9.81 / stiffness - slack_m;
    let decay_1_s = 0.5 * damping / mass_kg;
    let rate_rad_s = f64::sqrt(stiffness / mass_kg - decay_1_s * decay_1_s);
    let (mut miss, mut largest_m) = (0.0f64, 0.0f64);
    for part in 1..=30 {
        let time_s = 0.05 * f64::from(part);
        coast(&mut plant, time_s);
        let (sine, cosine) = (rate_rad_s * time_s).sin_cos();
        let swing_m = -rest_m * cosine + (1.2 - decay_1_s * rest_m) / rate_rad_s * sine;
        let [found_m, _] = state_of(plant.outputs(), 2);
        miss = miss.max((found_m - rest_m - (-decay_1_s * time_s).exp() * swing_m).abs());
        largest_m = largest_m.max(found_m);
    }
    let [angle_rad, _] = state_of(plant.outputs(), 3);
    let drift = (balance_j(plant.outputs()) - before_j).abs();
    println!("CJ-13 travel {largest_m} m, misses {miss:.1e} m, swivel {angle_rad:.1e} rad, drift {drift:.1e} J");
    assert!(largest_m > 0.2 && angle_rad.abs() < 1e-6);
    agree("CJ-13", miss, 1e-8);
    agree("CJ-13 energy in J", drift, 1e-4);
}

/// Coordinate and rate of a joint.
fn state_of(outputs: &Outputs, joint: usize) -> [f64; 2] {
    [outputs.joints()[joint].angle_rad, outputs.joints()[joint].rate_rad_s]
}
