//! Attitudes of bodies on sliding joints: section, hinge and ball, against closed forms and formulations in other coordinates.

use crate::counting_allocator::allocations;
use crate::plant::machines::*;
use crate::plant::sliding::{rail, slender};
use foldwing::beam::profile::Profile;
use foldwing::config;
use foldwing::machine::builder::{Attitude, BodyBuilder, JointBuilder, MachineBuilder};
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

const GRAVITY_M_S2: f64 = 9.81;

fn built(builder: &MachineBuilder) -> Machine {
    builder.build().unwrap_or_else(|refused| panic!("{refused}"))
}

/// One step of the classical Runge–Kutta method for `ẏ = f(y)`.
fn runge_kutta<const N: usize>(f: &impl Fn(&SVector<f64, N>) -> SVector<f64, N>, y: &mut SVector<f64, N>, step_s: f64) {
    let k1 = f(y);
    let k2 = f(&(*y + k1 * (0.5 * step_s)));
    let k3 = f(&(*y + k2 * (0.5 * step_s)));
    let k4 = f(&(*y + k3 * step_s));
    *y += (k1 + (k2 + k3) * 2.0 + k4) * (step_s / 6.0);
}

/// A cantilever along which a body slides that hangs 0.2 m below it, by parts and by the key.
fn hanging(parts: impl IntoIterator<Item = (BodyBuilder, JointBuilder)>) -> Machine {
    let beam = body("beam", 1.0, &slender(1e4, 2.0, 1e-6), ElementKind::Linear, 4);
    let empty = Machine::builder("crane").gravity_m_s2([4.0, 1.0, -9.0]).body(beam, clamped());
    let whole = parts.into_iter().fold(empty, |machine, (body, joint)| machine.body(body, joint));
    built(&whole.solver(solver(Method::Esdirk4, 1e-8)))
}

fn bob() -> BodyBuilder {
    Body::rigid("bob").inertia(0.2, [0.0, 0.0, -0.2], Matrix3::from_diagonal(&Vector3::new(2e-4, 1e-4, 3e-4)))
}

/// SJ-15. `attitude` is short for a carriage without mass and a revolute or ball joint on it: the machine is the same as with these parts, with
/// every force, latch, lock and motion along the beam; and the model file gives the same machine as the builder.
#[test]
fn sj15_an_attitude_is_short_for_two_parts() {
    let stops =
        EndStops { lower_rad: Some(0.05), upper_rad: Some(0.9), stiffness_n_m_rad: 2e3, damping_n_m_s_rad: 2.0 };
    let spring = LinearSpring { stiffness_n_m: 30.0, damping_n_s_m: 0.5, rest_position_m: 0.6 };
    let motor = LinearMotor { stiffness_n_m: 50.0, mass_kg: 0.2, command_m: 0.5, ..LinearMotor::default() };
    let at = |joint: JointBuilder| joint.start_position_m(0.35).start_rate_m_s(0.2);
    type Change<'c> = &'c dyn Fn(JointBuilder) -> JointBuilder;
    let changes: [Change; 7] = [
        &|joint| at(joint),
        &|joint| at(joint).spring(spring),
        &|joint| at(joint).end_stops(stops),
        &|joint| at(joint).motor(motor.clone()),
        &|joint| at(joint).latch(Latch::rigid().angle_rad(0.7)),
        &|joint| joint.start_position_m(0.35).locked(),
        &|joint| joint.prescribed(Motion::Polynomial(vec![0.1, 0.2, 1.0])),
    ];
    let (arm_m, mount_rad, spin) = ([0.01, -0.02, -0.03], [0.1, -0.2, 0.3], [0.4, 0.5, -0.6]);
    let carriage = |change: Change| {
        let slide = change(Joint::sliding("slide").on("beam")).offset_m(arm_m);
        (Body::rigid("slide_carriage").load_stations(0), slide)
    };
    for change in changes {
        let slide = || change(Joint::sliding("slide").on("beam")).offset_m(arm_m).mount_rotation_rad(mount_rad);
        let hinged = slide().attitude(Attitude::hinge([0.0, 2.0, 0.5])).start_angle_rad(0.3).start_rate_rad_s(-1.0);
        let hinge = Joint::revolute("slide_hinge", [0.0, 2.0, 0.5]).on("slide_carriage").mount_rotation_rad(mount_rad);
        let hinge = hinge.start_angle_rad(0.3).start_rate_rad_s(-1.0);
        assert_eq!(hanging([(bob(), hinged)]), hanging([carriage(change), (bob(), hinge)]));
        let balled = slide().attitude(Attitude::Ball).start_angular_velocity_rad_s(spin);
        let ball = Joint::ball("slide_ball").on("slide_carriage").mount_rotation_rad(mount_rad);
        let ball = ball.start_angular_velocity_rad_s(spin);
        assert_eq!(hanging([(bob(), balled)]), hanging([carriage(change), (bob(), ball)]));
        let same = hanging([(bob(), slide().attitude(Attitude::Section))]);
        assert_eq!(same, hanging([(bob(), slide())]));
        assert_eq!(same.bodies.len(), 2, "the attitude of the section needs no carriage");
    }
    for (keys, attitude, start) in [
        ("attitude = \"hinge\"\naxis = [0.0, 3.0, 0.0]\nstart_angle_deg = 20.0\nstart_rate_deg_s = 90.0", true, 20.0),
        ("attitude = \"ball\"\nstart_angular_velocity_deg_s = [10.0, 20.0, 30.0]", false, 10.0),
    ] {
        let text = include_str!("sliding.toml");
        let text = text.replace("start_position_m = 0.25", &format!("start_position_m = 0.25\n{keys}"));
        let told = config::parse(&text, "sliding.toml").unwrap_or_else(|refused| panic!("{refused}"));
        let [slide, turning] = [1, 2].map(|index| &told.bodies[index].joint);
        assert_eq!([told.bodies[1].name.as_str(), told.bodies[2].name.as_str()], ["slide_carriage", "bead"]);
        assert_eq!(slide.kind.one_freedom().map(|(_, own)| own.start_angle_rad), Some(0.25));
        match &turning.kind {
            JointKind::Revolute(own) => {
                assert!(attitude && turning.name == "slide_hinge" && own.axis == Vector3::y());
                assert_eq!([own.start_angle_rad, own.start_rate_rad_s], [start, 90.0].map(f64::to_radians));
            }
            JointKind::Spatial(own) => {
                assert!(!attitude && turning.name == "slide_ball" && own.freedom == SpatialFreedom::Ball);
                assert_eq!(own.start_angular_velocity_rad_s, Vector3::new(start, 20.0, 30.0).map(f64::to_radians));
            }
            JointKind::Clamped | JointKind::Prismatic(_) | JointKind::Sliding(_) => panic!("{:?}", turning.kind),
        }
    }
}

/// SJ-15. Keys that do not fit the attitude, and names that the parts need, are refused with the joint's own name and line.
#[test]
fn sj15_refusals_name_the_joint() {
    let text = include_str!("sliding.toml");
    for (keys, key, allowed) in [
        ("attitude = \"hinge\"", "joint.slide.axis", "not all 0"),
        ("axis = [0.0, 1.0, 0.0]", "joint.slide.axis", "only with attitude = \"hinge\""),
        ("attitude = \"ball\"\naxis = [0.0, 1.0, 0.0]", "joint.slide.axis", "only with attitude = \"hinge\""),
        ("start_angle_deg = 3.0", "joint.slide.start_angle_deg", "only with attitude = \"hinge\""),
        ("attitude = \"ball\"\nstart_rate_deg_s = 3.0", "joint.slide.start_rate_deg_s", "attitude = \"hinge\""),
        (
            "attitude = \"hinge\"\naxis = [0, 1, 0]\nstart_angular_velocity_deg_s = [0, 1, 0]",
            "joint.slide.start_angular_velocity_deg_s",
            "only with attitude = \"ball\"",
        ),
        ("attitude = \"pin\"", "joint.slide.attitude", "\"section\" or \"hinge\" or \"ball\""),
    ] {
        let changed = text.replace("start_position_m = 0.25", &format!("start_position_m = 0.25\n{keys}"));
        let refused = config::parse(&changed, "sliding.toml").expect_err(keys).to_string();
        assert!(refused.contains(key) && refused.contains(allowed), "{keys}: {refused}");
    }
    let clamped = text.replace("type = \"clamped\"", "type = \"clamped\"\nattitude = \"ball\"");
    let refused = config::parse(&clamped, "sliding.toml").expect_err("a clamped joint").to_string();
    assert!(refused.contains("joint.mount.attitude") && refused.contains("type = \"sliding\""), "{refused}");
    let named = text.replace("[rigid_body.bead]", "[rigid_body.bead]\n[rigid_body.slide_carriage]\nmass_kg = 1.0");
    let named = named.replace("start_position_m = 0.25", "start_position_m = 0.25\nattitude = \"ball\"")
        + "\n[joint.other]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"slide_carriage\"\n";
    let refused = config::parse(&named, "sliding.toml").expect_err("two carriages").to_string();
    assert!(refused.contains("slide_carriage") && refused.contains("a name that no other body has"), "{refused}");
    let code = Machine::builder("t").body(bob(), Joint::prismatic("rail", [1.0, 0.0, 0.0]).attitude(Attitude::Ball));
    let refused = code.build().expect_err("a prismatic joint").to_string();
    assert!(refused.contains("joint \"rail\", attitude") && refused.contains("\"sliding\""), "{refused}");
}

/// A stiff rod that rotates freely about `y` at 2 rad/s, with a body of 0.3 kg and a rotary inertia, as large as that of the rod, that slides
/// along it from 0.2 m.
fn turning_rod(kind: ElementKind, attitude: Attitude) -> Machine {
    let rod = body("rod", 1.0, &slender(1e8, 1e5, 1e-8), kind, 4);
    let hinge = Joint::revolute("hinge", [0.0, 1.0, 0.0]).start_rate_rad_s(2.0);
    let block = Body::rigid("block").inertia(0.3, [0.0; 3], Matrix3::from_diagonal(&Vector3::new(0.1, 0.15, 0.1)));
    let joint = Joint::sliding("slide").on("rod").start_position_m(0.2).attitude(attitude);
    let joint = match attitude {
        Attitude::Section => joint,
        Attitude::Hinge(_) => joint.start_rate_rad_s(1.5),
        Attitude::Ball => joint.start_angular_velocity_rad_s([0.0, 1.5, 0.0]),
    };
    let mut machine = rail((rod, hinge), (block, joint), &[]);
    machine.solver.tolerance = 1e-9;
    machine
}

/// SJ-16. A body with rotary inertia `I` on a stiff rod that rotates freely: with the attitude of the section `(J + I + m s²) ω` is constant, on
/// a hinge or ball `(J + m s²) ω`, and the body keeps its own rate. In all cases `s̈ = s ω²`, here by Runge–Kutta.
#[test]
fn sj16_a_body_on_a_turning_rod() {
    let (rod_kg_m2, mass_kg, own_kg_m2) = (0.5 / 3.0, 0.3, 0.15);
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        for attitude in [Attitude::Section, Attitude::hinge([0.0, 1.0, 0.0]), Attitude::Ball] {
            let carried = if attitude == Attitude::Section { own_kg_m2 } else { 0.0 };
            let inertia = |s_m: f64| rod_kg_m2 + carried + mass_kg * s_m * s_m;
            let momentum = inertia(0.2) * 2.0;
            let rate = |y: &SVector<f64, 4>| {
                let spin = momentum / inertia(y[0]);
                SVector::<f64, 4>::new(y[1], y[0] * spin * spin, spin, 3.5 - spin)
            };
            // position and rate along the rod, angles of the rod and of the body on it
            let mut due = SVector::<f64, 4>::new(0.2, 0.0, 0.0, 0.0);
            let mut plant = start(turning_rod(kind, attitude));
            let end_s = if carried > 0.0 { 1.0 } else { 1.2 };
            (0..1200).for_each(|_| runge_kutta(&rate, &mut due, end_s / 1200.0));
            coast(&mut plant, end_s);
            let [turn, slide] = [0, 1].map(|joint| plant.outputs().joints()[joint]);
            let spin = momentum / inertia(due[0]);
            let mut off = [slide.angle_rad - due[0], slide.rate_rad_s - due[1], turn.angle_rad - due[2]];
            let body = match attitude {
                Attitude::Section => turn.rate_rad_s - spin,
                Attitude::Hinge(_) => {
                    let own = plant.outputs().joints()[2];
                    (own.angle_rad - due[3]).abs().max((own.rate_rad_s + turn.rate_rad_s - 3.5).abs())
                }
                Attitude::Ball => {
                    let own = plant.outputs().spatial()[0];
                    let turned = Vector3::y() * due[3] - own.rotation.scaled_axis();
                    turned.amax().max((own.angular_velocity_rad_s.y + turn.rate_rad_s - 3.5).abs())
                }
            };
            off.iter_mut().for_each(|off| *off = off.abs());
            println!(
                "SJ-16 {kind:?} {attitude:?}: s {:.4} m off by {:.1e} m, {:.1e} m/s, {:.1e} rad, body {body:.1e}",
                slide.angle_rad, off[0], off[1], off[2]
            );
            assert!(plant.statistics().events >= 2 && slide.angle_rad > 0.55, "{}", slide.angle_rad);
            assert!(off.iter().all(|off| *off < 1e-6) && body.abs() < 3e-6, "{off:?} {body}");
        }
    }
}

/// SJ-17. Impulse at a border where the curvature jumps from `κ⁻` to `κ⁺`: a body with rotary inertia `I` slides along a heavy stiff beam at
/// `ṡ⁻`. With the attitude of the section its angular velocity has to jump: `ṡ⁺ = ṡ⁻ (m + I κ⁻κ⁺)/(m + I κ⁺²)` and
/// `½ m I (κ⁺ − κ⁻)² ṡ⁻²/(m + I κ⁺²)` is lost. On a hinge or ball it keeps its angular velocity, its speed and its energy: only the rate on the
/// carriage jumps, by `−ṡ (κ⁺ − κ⁻)`.
#[test]
fn sj17_the_impulse_where_the_curvature_jumps() {
    let mut heavy = slender(1e13, 1e13, 1e6);
    heavy.mass_kg_m = 1e7;
    let (mass_kg, own_kg_m2, speed_m_s) = (0.2, 0.03, 0.5);
    // means of 0.5 + s over both elements, in 1/m
    let (inner, outer) = (0.75, 1.25);
    for attitude in [Attitude::Section, Attitude::hinge([0.0, 1.0, 0.0]), Attitude::Ball] {
        let straight = Profile::constant(0.0);
        let curved = Profile::Polynomial(vec![0.5, 1.0]);
        let arc = body("arc", 1.0, &heavy, ElementKind::Constant, 2);
        let arc = arc.natural_curvature_along_1_m([straight.clone(), curved, straight]);
        let block =
            Body::rigid("block").inertia(mass_kg, [0.0; 3], Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.02)));
        let joint =
            Joint::sliding("slide").on("arc").start_position_m(0.4).start_rate_m_s(speed_m_s).attitude(attitude);
        let joint = match attitude {
            Attitude::Section => joint,
            Attitude::Hinge(_) => joint.start_rate_rad_s(-inner * speed_m_s),
            Attitude::Ball => joint.start_angular_velocity_rad_s([0.0, -inner * speed_m_s, 0.0]),
        };
        let mut machine = rail((arc, clamped()), (block, joint), &[]);
        machine.solver.tolerance = 1e-10;
        let mut plant = start(machine);
        coast(&mut plant, 0.3);
        let (slide, energy) = (plant.outputs().joints()[0], plant.outputs().energy());
        let carried = if attitude == Attitude::Section { own_kg_m2 } else { 0.0 };
        let due_m_s = speed_m_s * (mass_kg + carried * inner * outer) / (mass_kg + carried * outer * outer);
        let due_j =
            0.5 * mass_kg * carried * ((outer - inner) * speed_m_s).powi(2) / (mass_kg + carried * outer * outer);
        let own = match attitude {
            Attitude::Section => 0.0,
            Attitude::Hinge(_) => plant.outputs().joints()[1].rate_rad_s + outer * speed_m_s,
            Attitude::Ball => plant.outputs().spatial()[0].angular_velocity_rad_s.y + outer * speed_m_s,
        };
        println!(
            "SJ-17 {attitude:?}: {:.9} m/s of {due_m_s:.9}, lost {:.6e} J of {due_j:.6e}, rate on the carriage {own:.1e}",
            slide.rate_rad_s, energy.dissipated
        );
        assert!(slide.angle_rad > 0.5 && plant.statistics().events == 1);
        // the beam moves by 1e-7 of the speed
        assert!((slide.rate_rad_s - due_m_s).abs() < 1e-6 * speed_m_s, "{}", slide.rate_rad_s - due_m_s);
        assert!((energy.dissipated - due_j).abs() < 1e-6 * due_j + 1e-9, "{} J", energy.dissipated);
        assert!(own.abs() < 1e-6, "{own}");
    }
}

/// SJ-18. A pendulum with rotary inertia whose pivot slides along a stiff arc, against Cartesian coordinates: position and attitude of the body,
/// with the constraint force that keeps the pivot on the circle as a Lagrange multiplier, by Runge–Kutta.
#[test]
fn sj18_a_pendulum_slides_along_an_arc() {
    let (curvature_1_m, mass_kg, own_kg_m2, length_m) = (1.25, 0.2, 2e-3, 0.15);
    let centre_m = Vector2::new(0.0, -1.0 / curvature_1_m);
    // x, z, φ and their rates; the pivot is above the centre of mass by the length, turned by φ about y
    let arm = |turn: f64| Vector2::new(turn.sin(), turn.cos()) * length_m;
    let rates = |y: &SVector<f64, 6>| {
        let (turn, spin) = (y[2], y[5]);
        let from_centre = Vector2::new(y[0], y[1]) + arm(turn) - centre_m;
        let tangent = Vector2::new(turn.cos(), -turn.sin()) * length_m;
        let velocity = Vector2::new(y[3], y[4]) + tangent * spin;
        // (p − c)² = R²; twice differentiated: (p − c)·p¨ + ṗ² = 0, p¨ = r¨ + t φ¨ − a φ˙²
        let weight = Vector2::new(0.0, -GRAVITY_M_S2);
        let lever = from_centre.dot(&tangent);
        let free = from_centre.dot(&(weight - arm(turn) * spin * spin)) + velocity.norm_squared();
        let multiplier = free / (from_centre.norm_squared() / mass_kg + lever * lever / own_kg_m2);
        let push = weight - from_centre * (multiplier / mass_kg);
        SVector::<f64, 6>::new(y[3], y[4], y[5], push.x, push.y, -multiplier * lever / own_kg_m2)
    };
    let start_m = 0.1;
    for (kind, elements) in [(ElementKind::Constant, 6), (ElementKind::Linear, 3)] {
        for attitude in [Attitude::hinge([0.0, 1.0, 0.0]), Attitude::Ball] {
            let arc = body("arc", 1.0, &slender(1e10, 1e7, 1e-8), kind, elements);
            let arc = arc.natural_curvature_1_m([0.0, curvature_1_m, 0.0]);
            let inertia = Matrix3::from_diagonal(&Vector3::new(2e-3, own_kg_m2, 1e-3));
            let bob = Body::rigid("bob").inertia(mass_kg, [0.0, 0.0, -length_m], inertia);
            let joint = Joint::sliding("slide").on("arc").start_position_m(start_m).attitude(attitude);
            let mut machine = rail((arc, clamped()), (bob, joint), &[]);
            machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
            machine.solver.tolerance = 1e-9;
            let mut plant = start(machine);
            let turn = curvature_1_m * start_m;
            let pivot_m = centre_m + Vector2::new(turn.sin(), turn.cos()) / curvature_1_m;
            let from_m = pivot_m - arm(turn);
            let mut due = SVector::<f64, 6>::from_column_slice(&[from_m.x, from_m.y, turn, 0.0, 0.0, 0.0]);
            let mut off = [0.0f64; 2];
            for step in 1..=80 {
                (0..100).for_each(|_| runge_kutta(&rates, &mut due, 1e-4));
                coast(&mut plant, 0.01 * f64::from(step));
                let outward = Vector2::new(due[0], due[1]) + arm(due[2]) - centre_m;
                let due_m = outward.x.atan2(outward.y) / curvature_1_m;
                off[0] = off[0].max((plant.outputs().joints()[0].angle_rad - due_m).abs());
                let turned = plant.outputs().tips()[1].rotation.scaled_axis();
                off[1] = off[1].max((turned - Vector3::y() * due[2]).amax());
            }
            let s_m = plant.outputs().joints()[0].angle_rad;
            println!(
                "SJ-18 {kind:?} {attitude:?}: s {s_m:.4} m, off by {:.1e} m, {:.1e} rad, {} events",
                off[0],
                off[1],
                plant.statistics().events
            );
            assert!(s_m > 0.5 && plant.statistics().events >= 1);
            assert!(off[0] < 1e-6 && off[1] < 1e-5, "{off:?}");
        }
    }
}

/// Modes of SJ-19.
const MODES: usize = 6;

/// Shape of a mode of a cantilever of 1 m, or a derivative of it by the position.
fn shape(root: f64, x_m: f64, slope: i32) -> f64 {
    let sigma = (root.cos() + root.cosh()) / (root.sin() + root.sinh());
    let grows = (1.0 - sigma) * (root * x_m).exp() / 2.0;
    let decays = (1.0 + sigma) * (-root * x_m).exp() / 2.0 * if slope == 1 { -1.0 } else { 1.0 };
    let (sin, cos) = (root * x_m).sin_cos();
    let swings = match slope {
        0 => -cos + sigma * sin,
        1 => sin + sigma * cos,
        _ => cos - sigma * sin,
    };
    (grows + decays + swings) * root.powi(slope)
}

/// SJ-19. A pendulum that swings by 60° from a pivot that slides freely along a cantilever, against Lagrange's equations of position, angle and
/// six modes of the linear beam. The beam deflects by 1e-3 of its length; terms of second order in its slope are left out there.
#[test]
fn sj19_a_pendulum_slides_along_a_flexible_beam() {
    const ALL: usize = MODES + 2;
    const ROOTS: [f64; MODES] = [
        1.875_104_068_711_961,
        4.694_091_132_974_175,
        7.854_757_438_237_613,
        10.995_540_734_875_467,
        14.137_168_391_046_47,
        17.278_759_532_088_237,
    ];
    let (mass_kg, own_kg_m2, length_m, bending_n_m2) = (0.2, 1e-3, 0.15, 400.0);
    let rates = |y: &SVector<f64, { 2 * ALL }>| {
        let (s, turn, q) = (y[0], y[1], y.fixed_rows::<MODES>(2));
        let (s_rate, spin, v) = (y[ALL], y[ALL + 1], y.fixed_rows::<MODES>(ALL + 2));
        let at = |slope| SVector::<f64, MODES>::from_fn(|n, _| shape(ROOTS[n], s, slope));
        let [own, first, second] = [at(0), at(1), at(2)];
        // position of the centre of mass: (s − l sin φ, w(s) − l cos φ), φ about y
        let (sin, cos) = turn.sin_cos();
        let mut column = SMatrix::<f64, 2, ALL>::zeros();
        column.set_column(0, &Vector2::new(1.0, first.dot(&q)));
        column.set_column(1, &Vector2::new(-length_m * cos, length_m * sin));
        (0..MODES).for_each(|n| column[(1, n + 2)] = own[n]);
        let bias = Vector2::new(
            length_m * sin * spin * spin,
            2.0 * first.dot(&v) * s_rate + second.dot(&q) * s_rate * s_rate + length_m * cos * spin * spin,
        );
        let mut mass = column.transpose() * column * mass_kg;
        mass[(1, 1)] += own_kg_m2;
        let weight = Vector2::new(0.0, -GRAVITY_M_S2);
        let mut force = column.transpose() * ((weight - bias) * mass_kg);
        for n in 0..MODES {
            let root = ROOTS[n];
            let sigma = (root.cos() + root.cosh()) / (root.sin() + root.sinh());
            mass[(n + 2, n + 2)] += 0.5;
            force[n + 2] -= bending_n_m2 * root.powi(4) * q[n] + 0.5 * GRAVITY_M_S2 * 2.0 * sigma / root;
        }
        let second = mass.cholesky().expect("positive").solve(&force);
        let mut rate = SVector::<f64, { 2 * ALL }>::zeros();
        rate.fixed_rows_mut::<ALL>(0).copy_from(&y.fixed_rows::<ALL>(ALL));
        rate.fixed_rows_mut::<ALL>(ALL).copy_from(&second);
        rate
    };
    let beam = body("beam", 1.0, &slender(1e6, bending_n_m2, 1e-8), ElementKind::Linear, 8);
    let inertia = Matrix3::from_diagonal(&Vector3::new(1e-3, own_kg_m2, 1e-3));
    let bob = Body::rigid("bob").inertia(mass_kg, [0.0, 0.0, -length_m], inertia);
    let joint = Joint::sliding("slide").on("beam").start_position_m(0.3).start_rate_m_s(0.6);
    let joint = joint.attitude(Attitude::hinge([0.0, 1.0, 0.0])).start_angle_rad(1.0);
    let mut machine = rail((beam, clamped()), (bob, joint), &[]);
    machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
    machine.solver.tolerance = 1e-8;
    let mut plant = start(machine);
    let mut due = SVector::<f64, { 2 * ALL }>::zeros();
    (due[0], due[1], due[ALL]) = (0.3, 1.0, 0.6);
    let (mut off, mut tip_m) = ([0.0f64; 3], 0.0f64);
    for step in 1..=40 {
        (0..400).for_each(|_| runge_kutta(&rates, &mut due, 5e-5));
        coast(&mut plant, 0.02 * f64::from(step));
        let [slide, hinge] = [0, 1].map(|joint| plant.outputs().joints()[joint]);
        let slope: f64 = (0..MODES).map(|n| shape(ROOTS[n], due[0], 1) * due[n + 2]).sum();
        let tip: f64 = (0..MODES).map(|n| shape(ROOTS[n], 1.0, 0) * due[n + 2]).sum();
        off[0] = off[0].max((slide.angle_rad - due[0]).abs());
        // the section turns by −w' about y
        off[1] = off[1].max((hinge.angle_rad - due[1] - slope).abs());
        off[2] = off[2].max((plant.outputs().tips()[0].position_m.z - tip).abs());
        tip_m = tip_m.max(tip.abs());
    }
    println!(
        "SJ-19 s {:.4} m off by {:.1e} m, angle {:.1e} rad, tip {:.1e} m of {tip_m:.1e} m, {} events",
        due[0],
        off[0],
        off[1],
        off[2],
        plant.statistics().events
    );
    assert!(plant.statistics().events >= 2);
    assert!(off[0] < 1e-4 && off[1] < 1e-3 && off[2] < 5e-3 * tip_m, "{off:?}");
}

/// The pendulum of SJ-15 on a beam with `pairs` elements, released at 0.25 m.
fn released(pairs: usize, tolerance: f64, attitude: Attitude) -> Plant {
    let beam = body("beam", 1.0, &slender(1e4, 1.0, 1e-6), ElementKind::Linear, pairs);
    let joint = Joint::sliding("slide").on("beam").start_position_m(0.25).attitude(attitude);
    let mut machine = rail((beam, clamped()), (bob(), joint), &[]);
    machine.gravity_m_s2 = Vector3::new(4.0, 0.5, -8.0);
    machine.solver.tolerance = tolerance;
    start(machine)
}

/// SJ-20. A pendulum slides along a cantilever that deflects by a third of its length: position and attitude converge with the number of pairs,
/// with at least the second order; the energy account closes, and the loss at borders is not negative.
#[test]
fn sj20_order_over_pairs_and_energy() {
    for attitude in [Attitude::hinge([0.0, 1.0, 0.0]), Attitude::Ball] {
        let ends: Vec<(f64, Vector3<f64>)> = [2, 3, 4, 12]
            .into_iter()
            .map(|pairs| {
                let mut plant = released(pairs, 1e-8, attitude);
                let before_j = balance_j(plant.outputs());
                coast(&mut plant, 0.4);
                let (energy, tips) = (plant.outputs().energy(), plant.outputs().tips());
                let drift_j = balance_j(plant.outputs()) - before_j;
                println!(
                    "SJ-20 {attitude:?} {pairs} pairs: s {:.4} m, tip {:.3} m down, drift {drift_j:.1e} J, lost {:.1e} J, {} events",
                    plant.outputs().joints()[0].angle_rad,
                    -tips[0].position_m.z,
                    energy.dissipated,
                    plant.statistics().events
                );
                assert!(drift_j.abs() < 1e-6 && energy.dissipated > -1e-12, "{drift_j:e} J");
                assert!(plant.statistics().events >= 1 && tips[0].position_m.z < -0.2);
                (plant.outputs().joints()[0].angle_rad, tips[1].rotation * Vector3::new(0.0, 0.0, -0.2) + tips[1].position_m)
            })
            .collect();
        let off = |index: usize| (ends[index].1 - ends[3].1).norm().max((ends[index].0 - ends[3].0).abs());
        let order = (off(0) / off(2)).ln() / 2f64.ln();
        println!("SJ-20 {attitude:?}: {:.1e}, {:.1e}, {:.1e} m, order {order:.2}", off(0), off(1), off(2));
        assert!(order > 2.0 && off(2) < 2e-3, "{order}");
    }
}

/// SJ-21. A run across borders continues bit-identically from a saved state, does not depend on the communication step, and its steps allocate
/// nothing.
#[test]
fn sj21_states_are_restored() {
    for attitude in [Attitude::hinge([0.0, 1.0, 0.0]), Attitude::Ball] {
        let mut plant = released(4, 1e-6, attitude);
        coast(&mut plant, 0.1);
        let (saved, s_m) = (plant.snapshot(), plant.outputs().joints()[0].angle_rad);
        let before = allocations();
        coast(&mut plant, 0.4);
        assert_eq!(allocations() - before, 0, "{attitude:?}: allocations");
        let (late, at) = (plant.outputs().joints()[0], plant.outputs().tips()[1]);
        assert!(s_m < 0.5 && late.angle_rad > 0.5, "{s_m} {}", late.angle_rad);
        plant.restore(&saved).expect("the state of this plant");
        coast(&mut plant, 0.4);
        assert_eq!(plant.outputs().joints()[0].angle_rad.to_bits(), late.angle_rad.to_bits());
        assert_eq!(plant.outputs().tips()[1], at);
        let mut other = released(4, 1e-6, attitude);
        (1..=40).for_each(|step| coast(&mut other, 0.01 * f64::from(step)));
        let differs_m = (other.outputs().tips()[1].position_m - at.position_m).amax();
        println!("SJ-21 {attitude:?}: {differs_m:.1e} m");
        assert!(differs_m < 1e-12);
    }
}
