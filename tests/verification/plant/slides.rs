//! Prismatic joints: closed forms of sliding bodies, alone, on springs, with latches, on hinges, in loops.

use crate::agreement::agree;
use crate::plant::machines::*;
use foldwing::beam::section::{Material, Section};
use foldwing::config;
use foldwing::machine::builder::{BodyBuilder, JointBuilder};
use foldwing::machine::*;
use foldwing::plant::{Holding, Plant};
use nalgebra::{Matrix3, Rotation3, Vector3};

const MASS_KG: f64 = 2.0;
const GRAVITY_M_S2: f64 = 9.8;
const SLOPE_RAD: f64 = 0.5;

/// A block of 2 kg with its centre of mass off the joint.
fn block(name: &str) -> BodyBuilder {
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.01, 0.02, 0.03));
    Body::rigid(name).inertia(MASS_KG, [0.05, 0.02, 0.1], inertia)
}

/// Direction down a slope in the `x`–`z` plane.
fn down() -> Vector3<f64> {
    Vector3::new(SLOPE_RAD.cos(), 0.0, -SLOPE_RAD.sin())
}

/// A block on a joint that slides along `x`, without gravity.
fn on_rail(change: impl Fn(JointBuilder) -> JointBuilder) -> Machine {
    let mut machine = machine([(block("block"), change(Joint::prismatic("slide", [2.0, 0.0, 0.0])))]);
    machine.solver.tolerance = 1e-9;
    machine
}

fn slide_of(machine: &mut Machine, index: usize) -> &mut OneFreedom {
    match &mut machine.bodies[index].joint.kind {
        JointKind::Prismatic(slide) => slide,
        _ => panic!("the joint of body {index} does not slide"),
    }
}

fn spring(stiffness_n_m: f64, damping_n_s_m: f64) -> LinearSpring {
    LinearSpring { stiffness_n_m, damping_n_s_m, rest_position_m: 0.0 }
}

/// PJ-01. A block slides down a slope by `½ g sin α t²`, whatever its mount, offset and centre of mass; the joint carries `m g cos α`
/// normal to the slope, and the moment of the weight about the joint. Constant acceleration is integrated exactly in every stage:
/// round-off.
#[test]
fn pj01_a_block_slides_down_a_slope() {
    for (mount, at_m) in
        [(Vector3::zeros(), Vector3::zeros()), (Vector3::new(0.4, -1.1, 2.0), Vector3::new(1.0, 2.0, 3.0))]
    {
        let joint = Joint::prismatic("slide", down()).mount_rotation_rad(mount).at_root(at_m);
        let mut machine = machine([(block("block"), joint)]);
        machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
        let mut plant = start(machine);
        let before_j = balance_j(plant.outputs());
        coast(&mut plant, 1.0);
        let (outputs, way_m) = (plant.outputs(), 0.5 * GRAVITY_M_S2 * SLOPE_RAD.sin());
        let place = (outputs.tips()[0].position_m - at_m - down() * way_m).norm();
        let attitude =
            (outputs.tips()[0].rotation.to_rotation_matrix().matrix() - Rotation3::new(mount).matrix()).amax();
        let across = Vector3::new(SLOPE_RAD.sin(), 0.0, SLOPE_RAD.cos()) * (MASS_KG * GRAVITY_M_S2 * SLOPE_RAD.cos());
        let arm_m = Rotation3::new(mount) * Vector3::new(0.05, 0.02, 0.1);
        let reaction = outputs.joint_reactions()[0];
        let force = (reaction.force_n - across).norm();
        // the block slides without rotation: the resultant passes through its centre of mass
        let moment = (reaction.moment_n_m - arm_m.cross(&across)).norm();
        let drift = (balance_j(outputs) - before_j).abs() / outputs.energy().kinetic;
        println!(
            "PJ-01 place {place:.1e} m, attitude {attitude:.1e}, force {force:.1e} N, moment {moment:.1e} N·m, {drift:.1e}"
        );
        assert!((outputs.joints()[0].angle_rad - way_m).abs() < 1e-12 && place < 1e-12 && attitude < 1e-14);
        assert!((outputs.joints()[0].rate_rad_s - GRAVITY_M_S2 * SLOPE_RAD.sin()).abs() < 1e-12);
        assert!(force < 1e-11 && moment < 1e-11 && drift < 1e-12);
    }
}

/// PJ-02. A block on a spring oscillates with the period `2π√(m/k)`; the error after five periods falls with the order of the method.
#[test]
fn pj02_a_block_on_a_spring_swings() {
    let (stiffness_n_m, amplitude_m) = (50.0, 0.1);
    let rate_rad_s = f64::sqrt(stiffness_n_m / MASS_KG);
    let period_s = std::f64::consts::TAU / rate_rad_s;
    for (method, order) in [
        (Method::GeneralizedAlpha, 2.0),
        (Method::TrBdf2, 2.0),
        (Method::Sdirk2, 2.0),
        (Method::Esdirk3, 3.0),
        (Method::Esdirk4, 4.0),
        (Method::Rk4, 4.0),
    ] {
        let errors = [50.0, 100.0].map(|steps| {
            let mut machine = on_rail(|joint| joint.spring(spring(stiffness_n_m, 0.0)).start_position_m(amplitude_m));
            (machine.solver.method, machine.solver.fixed_step_s) = (method, Some(period_s / steps));
            machine.solver.max_step_s = period_s;
            // five and a quarter periods, where the position is most sensitive to an error of the period
            let end_s = 5.25 * period_s;
            let mut plant = start(machine);
            coast(&mut plant, end_s);
            let joint = plant.outputs().joints()[0];
            let exact = (rate_rad_s * end_s).sin() * rate_rad_s * amplitude_m;
            (joint.angle_rad / amplitude_m).hypot((joint.rate_rad_s + exact) / (rate_rad_s * amplitude_m))
        });
        let found = (errors[0] / errors[1]).log2();
        println!("PJ-02 {method:?}: {:.1e}, {:.1e}, order {found:.2}", errors[0], errors[1]);
        assert!((found - order).abs() < 0.25, "{method:?}: order {found:.2}");
    }
    let mut plant = start(on_rail(|joint| joint.spring(spring(stiffness_n_m, 0.0))));
    let frequency_hz = plant.study().modes(1).expect("modes")[0].frequency_hz;
    assert!((frequency_hz * period_s - 1.0).abs() < 1e-9, "{frequency_hz} Hz");
    let freedoms = plant.freedoms();
    let names: Vec<_> =
        freedoms.iter().map(|freedom| (freedom.name.as_str(), freedom.unit, freedom.rate_unit)).collect();
    assert_eq!(names, [("slide.position", "m", "m/s")]);
}

/// PJ-03. With a damper, and a motor mass that moves with the position: the oscillation decays as in the closed form, and its loss is
/// dissipated. The third-order error estimate is at most 1e-9 per step, and the error of the fourth-order solution is a hundredth of it:
/// 1e-11 in each of about ten steps. The energy balance sums products of rates and forces, with relative errors of 1e-10 in about a hundred
/// terms.
#[test]
fn pj03_a_damper_takes_the_energy() {
    let (k, c, own_kg, end_s) = (50.0, 3.0, 0.5, 2.0);
    let mut plant = start(on_rail(|joint| {
        let drive = LinearMotor { stiffness_n_m: 0.4 * k, damping_n_s_m: c, mass_kg: own_kg, ..LinearMotor::default() };
        joint.spring(spring(0.6 * k, 0.0)).motor(drive).start_position_m(0.1)
    }));
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, end_s);
    let mass_kg = MASS_KG + own_kg;
    let decay_1_s = 0.5 * c / mass_kg;
    let rate_rad_s = (k / mass_kg - decay_1_s * decay_1_s).sqrt();
    let (sine, cosine) = (rate_rad_s * end_s).sin_cos();
    let exact_m = 0.1 * (-decay_1_s * end_s).exp() * (cosine + decay_1_s / rate_rad_s * sine);
    let outputs = plant.outputs();
    let (miss, drift) = (outputs.joints()[0].angle_rad - exact_m, balance_j(outputs) - before_j);
    println!("PJ-03 misses {miss:.1e} m, drift {:.1e}", drift / before_j);
    agree("PJ-03 position in m", miss.abs(), 1e-10);
    agree("PJ-03 energy", drift.abs() / before_j, 1e-8);
    assert!(outputs.energy().dissipated > 0.5 * before_j);
}

/// PJ-04. A beam normal to a rail, its root on a spring: first three frequencies from the characteristic equation with `EI w'''(0) = −k
/// w(0)`, `w'(0) = 0` and a free end. 8 pairs; the Euler–Bernoulli beam has no rotary inertia, an effect of `(h/l)²`, 2.5e-5, times a
/// factor of the mode, 1e-3 in the third.
#[test]
fn pj04_a_beam_swings_on_its_spring() {
    let (length_m, k) = (1.0, 20.0);
    let material = Material { youngs_modulus_pa: 70e9, shear_modulus_pa: 26e9, density_kg_m3: 2700.0 };
    let section = Section::rectangle(0.02, 0.005, &material, None);
    let (ei, per_m) = (70e9 * 0.02 * 0.005f64.powi(3) / 12.0, 2700.0 * 0.02 * 0.005);
    let joint = Joint::prismatic("slide", Vector3::z()).spring(spring(k, 0.0));
    let mut plant = start(machine([(body("beam", length_m, &section, ElementKind::Linear, 8), joint)]));
    // w = K₁ + B K₃ − k/(EI β³) K₄ by Krylov's functions
    let free_end = |beta: f64| {
        let x = beta * length_m;
        let k1 = (x.cosh() + x.cos()) / 2.0;
        let k2 = (x.sinh() + x.sin()) / 2.0;
        let k3 = (x.cosh() - x.cos()) / 2.0;
        let k4 = (x.sinh() - x.sin()) / 2.0;
        let c = -k / (ei * beta.powi(3));
        // w''(l) = K₃ + B K₁ + c K₂ gives B, w'''(l) = K₂ + B K₄ + c K₁ the residual
        let b = -(k3 + c * k2) / k1;
        k2 + b * k4 + c * k1
    };
    let mut exact_hz = Vec::new();
    let mut beta = 0.05;
    while exact_hz.len() < 3 {
        let (mut low, mut high) = (beta, beta + 0.05);
        if free_end(low) * free_end(high) < 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if free_end(low) * free_end(middle) <= 0.0 { high = middle } else { low = middle }
            }
            exact_hz.push(low * low * (ei / per_m).sqrt() / std::f64::consts::TAU);
        }
        beta += 0.05;
    }
    let found: Vec<f64> = plant.study().modes(12).expect("modes").iter().map(|mode| mode.frequency_hz).collect();
    for exact in exact_hz {
        let miss = found.iter().map(|hz| (hz / exact - 1.0).abs()).fold(f64::INFINITY, f64::min);
        println!("PJ-04 {exact:.4} Hz: {miss:.1e}");
        assert!(miss < 1e-3, "{exact} Hz among {found:?}");
    }
}

/// PJ-05. The energy balance closes with motor, torque limit, spring, damper, command, rate limit, latch and a beam at once.
#[test]
fn pj05_the_account_closes() {
    let section = wing_section();
    let drive = LinearMotor {
        stiffness_n_m: 40.0,
        damping_n_s_m: 0.5,
        constant_force_n: 0.3,
        force_limit_n: 1.5,
        rate_limit_m_s: 0.2,
        mass_kg: 0.05,
        command_m: 0.0,
    };
    let slide = Joint::prismatic("slide", [1.0, 0.3, 0.2])
        .motor(drive)
        .spring(spring(5.0, 0.1))
        .start_position_m(-0.05)
        .latch(Latch::with_stiffness_n_m(300.0).position_m(0.02));
    let mut machine = machine([
        (body("arm", 0.2, &section, ElementKind::Linear, 1), hinged_to_root(free_hinge(0.3))),
        (body("wing", 0.15, &section, ElementKind::Linear, 1).mass_damping_1_s(1.0), slide.on("arm")),
    ]);
    machine.gravity_m_s2 = Vector3::new(1.0, 0.5, -GRAVITY_M_S2);
    machine.solver.tolerance = 1e-8;
    let mut plant = start(machine);
    let before_j = balance_j(plant.outputs());
    let (mut kinetic_j, mut worst_j) = (0f64, 0f64);
    run(
        &mut plant,
        0.2,
        20,
        |plant| plant.inputs_mut().joints_mut()[1].command_rad = if plant.time_s() > 0.05 { 0.06 } else { 0.0 },
        |outputs| {
            kinetic_j = kinetic_j.max(outputs.energy().kinetic);
            worst_j = worst_j.max((balance_j(outputs) - before_j).abs());
        },
    );
    let latched = plant.outputs().latches()[1].count.get();
    println!("PJ-05 drift {:.1e}, latched {latched} times", worst_j / kinetic_j);
    assert!(worst_j < 1e-6 * kinetic_j && latched == 1, "{worst_j:e} J of {kinetic_j} J, {latched}");
}

/// PJ-06. Latches at a position: a rigid latch stops the block by an impulse `−m v` at the position where it is caught, and its energy is
/// dissipated; on an elastic latch the block oscillates at `√(k/m)`. Crossings are located to 1e-10 s.
#[test]
fn pj06_latches_catch_at_their_position() {
    let rate_m_s = 0.5;
    for (latch, stiffness_n_m) in [(Latch::rigid(), 0.0), (Latch::with_stiffness_n_m(800.0), 800.0)] {
        let latch = latch.position_m(0.1).capture_m(1e-4);
        let mut plant = start(on_rail(|joint| joint.start_rate_m_s(rate_m_s).latch(latch.clone())));
        coast(&mut plant, 0.3);
        let (joint, energy) = (plant.outputs().joints()[0], plant.outputs().energy());
        let latch = latch_of(&plant);
        let latch_s = (0.1 - 1e-4) / rate_m_s;
        let located = (latch.time_s - latch_s).abs();
        assert!(latch.closed.is_on() && latch.count.get() == 1 && located < 2e-10, "{joint:?}");
        if stiffness_n_m == 0.0 {
            let impulse = latch.impulse_n_m_s + MASS_KG * rate_m_s;
            let dissipated = energy.dissipated - 0.5 * MASS_KG * rate_m_s.powi(2);
            println!("PJ-06 rigid: {located:.1e} s, impulse {impulse:.1e} N·s, dissipated {dissipated:.1e} J");
            assert!(joint.rate_rad_s == 0.0 && (joint.angle_rad - (0.1 - 1e-4)).abs() < 1e-9);
            assert!(impulse.abs() < 1e-12 && dissipated.abs() < 1e-12);
        } else {
            let swing_rad_s = f64::sqrt(stiffness_n_m / MASS_KG);
            let (sine, cosine) = (swing_rad_s * (0.3 - latch_s)).sin_cos();
            let exact_m = 0.1 - 1e-4 * cosine + rate_m_s / swing_rad_s * sine;
            println!("PJ-06 elastic: {located:.1e} s, position {:.1e} m", joint.angle_rad - exact_m);
            assert!((joint.angle_rad - exact_m).abs() < 1e-7);
            assert!((joint.latch_torque_n_m + stiffness_n_m * (joint.angle_rad - 0.1)).abs() < 1e-12);
        }
    }
}

/// PJ-07. The lock carries `m g sin α`, opens on release and locks again at the current position of the block.
#[test]
fn pj07_the_stopper_holds_and_lets_go() {
    let joint = Joint::prismatic("slide", down()).start_position_m(0.2).release(false);
    let mut machine = machine([(block("block"), joint)]);
    machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
    let mut plant = start(machine);
    coast(&mut plant, 0.1);
    let (held, weight_n) = (plant.outputs().joints()[0], MASS_KG * GRAVITY_M_S2 * SLOPE_RAD.sin());
    assert!(held.angle_rad == 0.2 && (held.holding_torque_n_m + weight_n).abs() < 1e-11, "{held:?}");
    plant.inputs_mut().joints_mut()[0].release = true.into();
    coast(&mut plant, 0.4);
    let way_m = 0.5 * GRAVITY_M_S2 * SLOPE_RAD.sin() * 0.09;
    let free = plant.outputs().joints()[0];
    assert!((free.angle_rad - 0.2 - way_m).abs() < 1e-11 && free.holding_torque_n_m == 0.0, "{free:?}");
    plant.inputs_mut().joints_mut()[0].release = false.into();
    coast(&mut plant, 0.6);
    let held = plant.outputs().joints()[0];
    assert!((held.angle_rad - 0.2 - way_m).abs() < 1e-11 && held.rate_rad_s == 0.0, "{held:?}");
    assert!((plant.outputs().energy().dissipated - weight_n * way_m).abs() < 1e-10);
}

/// PJ-08. At its limit a motor exerts a constant force: `s = ½ (F/m) t²`, with F the sum of motor and external force.
#[test]
fn pj08_a_motor_pushes_with_its_limit() {
    let drive = LinearMotor { stiffness_n_m: 1e3, force_limit_n: 3.0, command_m: 5.0, ..LinearMotor::default() };
    let mut plant = start(on_rail(|joint| joint.motor(drive.clone())));
    plant.inputs_mut().joints_mut()[0].torque_n_m = -1.0;
    coast(&mut plant, 0.5);
    let joint = plant.outputs().joints()[0];
    let exact_m = 0.5 * (3.0 - 1.0) / MASS_KG * 0.25;
    assert!((joint.angle_rad - exact_m).abs() < 1e-11 && joint.motor_torque_n_m == 3.0, "{joint:?}");
    assert!(joint.torque_applied_n_m == 2.0 && joint.external_torque_n_m == -1.0);
}

/// PJ-09. A prescribed position is followed to round-off, and the joint force gives the block its acceleration.
#[test]
fn pj09_a_prescribed_position_is_followed() {
    let motion = Motion::Polynomial(vec![0.1, 0.2, 0.3, -0.4]);
    let mut plant = start(on_rail(|joint| joint.prescribed(motion.clone())));
    coast(&mut plant, 0.5);
    let (joint, tip) = (plant.outputs().joints()[0], plant.outputs().tips()[0].position_m);
    let (position_m, acceleration_m_s2) = (0.1 + 0.1 + 0.075 - 0.05, 0.6 - 2.4 * 0.5);
    assert!((joint.angle_rad - position_m).abs() < 1e-14 && (tip.x - position_m).abs() < 1e-14);
    assert!((joint.holding_torque_n_m - MASS_KG * acceleration_m_s2).abs() < 1e-9, "{joint:?}");
    // the work of the motion equals the kinetic energy
    let energy = plant.outputs().energy();
    let begin_j = 0.5 * MASS_KG * 0.04;
    assert!((energy.kinetic - begin_j - energy.work).abs() < 1e-9, "{energy:?}");
}

/// A rod of inertia 0.3 kg·m² on a hinge about `z`, and a bead that slides along it.
fn telescope(hinge: OneFreedom, slide: JointBuilder) -> Machine {
    let rod = Body::rigid("rod").inertia(1.0, [0.0, 0.0, 0.0], Matrix3::from_diagonal(&Vector3::new(0.1, 0.3, 0.3)));
    let bead = Body::rigid("bead").inertia(MASS_KG, [0.0; 3], Matrix3::from_diagonal(&Vector3::repeat(0.02)));
    let mut machine = machine([(rod, Joint::hinge("turn", hinge)), (bead, slide.on("rod"))]);
    machine.solver.tolerance = 1e-9;
    machine
}

/// PJ-10. A bead on a rotating rod. At a constant rate `r = r₀ cosh Ωt`, and the hinge carries the moment of the Coriolis force, `2 m r ṙ
/// Ω`. On a free hinge angular momentum and energy are conserved.
#[test]
fn pj10_a_bead_on_a_turning_rod() {
    let (rate_rad_s, start_m, end_s) = (3.0, 0.4, 0.5);
    let slide = Joint::prismatic("slide", [1.0, 0.0, 0.0]).start_position_m(start_m);
    let about = OneFreedom::about(Vector3::z());
    let motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.0, rate_rad_s]));
    let mut plant = start(telescope(OneFreedom { motion, ..about.clone() }, slide.clone()));
    coast(&mut plant, end_s);
    let [turn, bead] = [plant.outputs().joints()[0], plant.outputs().joints()[1]];
    let (r_m, r_m_s) = ((rate_rad_s * end_s).cosh() * start_m, (rate_rad_s * end_s).sinh() * start_m * rate_rad_s);
    let coriolis = turn.holding_torque_n_m - 2.0 * MASS_KG * r_m * r_m_s * rate_rad_s;
    println!("PJ-10 forced: {:.1e} m, torque {coriolis:.1e} N·m", bead.angle_rad - r_m);
    // the tolerance of 1e-9 per step, a few steps, each error growing by cosh 1.5 = 2.4; the error of rates is larger by Ω, that of the
    // torque by 2 m Ω (r + ṙ/Ω)
    agree("PJ-10 place in m", (bead.angle_rad - r_m).abs(), 1e-8);
    agree("PJ-10 rate in m/s", (bead.rate_rad_s - r_m_s).abs(), 3e-8);
    agree("PJ-10 torque in N·m", coriolis.abs(), 3e-7);

    let mut plant = start(telescope(OneFreedom { start_rate_rad_s: rate_rad_s, ..about }, slide));
    let inertia = |r_m: f64| 0.3 + 0.02 + MASS_KG * r_m * r_m;
    let momentum = inertia(start_m) * rate_rad_s;
    let energy_j = plant.outputs().energy().kinetic;
    coast(&mut plant, end_s);
    let [turn, bead] = [plant.outputs().joints()[0], plant.outputs().joints()[1]];
    let lost = (inertia(bead.angle_rad) * turn.rate_rad_s / momentum - 1.0).abs();
    let drift = (plant.outputs().energy().kinetic / energy_j - 1.0).abs();
    println!("PJ-10 free: momentum {lost:.1e}, energy {drift:.1e}, bead at {:.3} m", bead.angle_rad);
    agree("PJ-10 momentum", lost, 1e-8);
    agree("PJ-10 energy", drift, 1e-8);
    assert!(bead.angle_rad > 1.5 * start_m);
}

/// PJ-11. A pendulum on a trolley: its frequency about equilibrium is `√((1 + m/M) g/l)`, and over a large swing the horizontal position of
/// the centre of mass and the energy are constant.
#[test]
fn pj11_a_pendulum_on_a_trolley() {
    let (bob_kg, length_m) = (1.5, 0.8);
    let trolley = Body::rigid("trolley").inertia(MASS_KG, [0.0; 3], Matrix3::identity() * 0.01);
    let bob = Body::rigid("bob").inertia(bob_kg, [0.0, 0.0, -length_m], Matrix3::zeros());
    let pendulum = |angle_rad: f64| {
        let hinge = Joint::hinge("pivot", free_hinge(angle_rad)).on("trolley");
        let mut machine = machine([(trolley.clone(), Joint::prismatic("rail", Vector3::x())), (bob.clone(), hinge)]);
        machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
        machine.solver.tolerance = 1e-9;
        machine
    };
    let mut plant = start(pendulum(0.0));
    let exact_hz = ((1.0 + bob_kg / MASS_KG) * GRAVITY_M_S2 / length_m).sqrt() / std::f64::consts::TAU;
    let found: Vec<f64> = plant.study().modes(2).expect("modes").iter().map(|mode| mode.frequency_hz).collect();
    assert!(found.iter().any(|hz| (hz / exact_hz - 1.0).abs() < 1e-9), "{found:?}, {exact_hz} Hz");

    let mut plant = start(pendulum(2.0));
    // a rotation by +θ about y moves the bob, at −l along z, to −l sin θ along x
    let centre_m = |plant: &Plant| {
        let [rail, pivot] = [plant.outputs().joints()[0], plant.outputs().joints()[1]];
        rail.angle_rad - bob_kg / (MASS_KG + bob_kg) * length_m * pivot.angle_rad.sin()
    };
    let (before_m, before_j) = (centre_m(&plant), balance_j(plant.outputs()));
    coast(&mut plant, 3.0);
    let (moved_m, drift_j) = (centre_m(&plant) - before_m, balance_j(plant.outputs()) - before_j);
    let scale_j = bob_kg * GRAVITY_M_S2 * length_m;
    println!("PJ-11 centre of mass moves {moved_m:.1e} m, energy {:.1e}", drift_j / scale_j);
    assert!(moved_m.abs() < 1e-7 && drift_j.abs() < 1e-6 * scale_j);
}

/// PJ-12. A slider-crank: the loop is closed between rod and slider, and the slider is at `r cos θ + √(l² − r² sin² θ)`, apart from the
/// gap, which falls as the penalty stiffness rises.
#[test]
fn pj12_a_slider_crank_follows_its_kinematics() {
    let (crank_m, rod_m, rate_rad_s) = (0.2, 0.5, 6.0);
    let light = |name: &str| Body::rigid(name).inertia(0.5, [0.0; 3], Matrix3::identity() * 0.01);
    let mut gaps = Vec::new();
    for stiffness_n_m in [1e5, 1e6] {
        // positive angles about −y rotate x towards z
        let turn = |start: f64| OneFreedom { start_angle_rad: start, ..OneFreedom::about(-Vector3::y()) };
        let crank =
            Joint::revolute("crank", -Vector3::y()).prescribed(Motion::Polynomial(vec![0.0, 0.0, 0.5 * rate_rad_s]));
        let machine = Machine::builder("engine")
            .body(light("wheel"), crank)
            .body(light("rod"), Joint::hinge("pin", turn(0.0)).on("wheel").offset_m([crank_m, 0.0, 0.0]))
            .body(light("piston"), Joint::prismatic("bore", Vector3::x()).start_position_m(crank_m + rod_m))
            .closure(
                Closure::between("wrist", ["rod", "piston"], stiffness_n_m)
                    .offsets_m([[rod_m, 0.0, 0.0], [0.0; 3]])
                    .damping_n_s_m(2e-4 * stiffness_n_m),
            )
            .solver(solver(Method::Esdirk4, 1e-7))
            .stop_time_s(1.0)
            .step_s(1e-2)
            .build();
        let mut plant = start(machine.unwrap_or_else(|refused| panic!("{refused}")));
        let (mut miss_m, mut gap_m) = (0f64, 0f64);
        for step in 1..=100 {
            let time_s = 0.015 * f64::from(step);
            coast(&mut plant, time_s);
            let (sine, cosine) = (0.5 * rate_rad_s * time_s * time_s).sin_cos();
            let exact_m = crank_m * cosine + (rod_m.powi(2) - (crank_m * sine).powi(2)).sqrt();
            let bore = plant.outputs().joints()[2];
            miss_m = miss_m.max((bore.angle_rad - exact_m).abs());
            gap_m = gap_m.max(plant.outputs().loops()[0].gap_m.norm());
        }
        println!("PJ-12 {stiffness_n_m:.0e} N/m: gap {gap_m:.1e} m, piston misses {miss_m:.1e} m");
        // the gap normal to the rod is larger than that along it, by at most r/√(l² − r²), the tangent of the rod's angle
        assert!(miss_m < 2.0 * gap_m && gap_m < 200.0 / stiffness_n_m, "{miss_m:e} m, gap {gap_m:e} m");
        gaps.push(gap_m);
    }
    let ratio = gaps[0] / gaps[1];
    assert!((8.0..12.0).contains(&ratio), "ten times the penalty divides the gap by {ratio:.2}");
}

/// PJ-13. In equilibrium the spring carries the weight: `s = m g sin α/k`; a latch before this position catches the block; a free prismatic
/// joint without restraint has no equilibrium, which is an error.
#[test]
fn pj13_a_block_comes_to_rest_on_its_spring() {
    let build = |joint: JointBuilder| {
        let mut machine = machine([(block("block"), joint)]);
        machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
        machine
    };
    let sprung = Joint::prismatic("slide", down()).spring(spring(200.0, 0.0));
    let mut plant = Plant::new(std::sync::Arc::new(build(sprung.clone())));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("a state of rest");
    let sag_m = MASS_KG * GRAVITY_M_S2 * SLOPE_RAD.sin() / 200.0;
    assert!((plant.outputs().joints()[0].angle_rad / sag_m - 1.0).abs() < 1e-9, "{:?}", plant.outputs().joints()[0]);

    let mut plant = Plant::new(std::sync::Arc::new(build(sprung.latch(Latch::rigid().position_m(0.5 * sag_m)))));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("a state of rest");
    let joint = plant.outputs().joints()[0];
    let latch = latch_of(&plant);
    assert!(latch.closed.is_on() && (joint.angle_rad - 0.5 * sag_m).abs() < 1.1e-6, "{joint:?}");
    assert!((joint.latch_torque_n_m + 0.5 * 200.0 * sag_m).abs() < 1e-3, "{joint:?}");

    let mut plant = Plant::new(std::sync::Arc::new(build(Joint::prismatic("slide", down()))));
    let refused = plant.study().equilibrium(0.0, Holding::AsReleased).expect_err("nothing holds it").to_string();
    assert!(refused.contains("slide"), "{refused}");
}

/// PJ-14. The same machine from a file and built in code, field by field: all keys of a prismatic joint.
#[test]
fn pj14_the_file_says_what_the_builder_says() {
    let text = include_str!("slides.toml");
    let told = config::parse(text, "slides.toml").unwrap_or_else(|error| panic!("{error}"));
    let drive = LinearMotor {
        stiffness_n_m: 40.0,
        damping_n_s_m: 0.5,
        constant_force_n: 0.3,
        force_limit_n: 1.5,
        rate_limit_m_s: 0.2,
        mass_kg: 0.05,
        command_m: 0.01,
    };
    let slide = Joint::prismatic("slide", [1.0, 0.3, 0.2])
        .at_root([0.1, 0.2, 0.3])
        .mount_rotation_rad([0.0, 90f64.to_radians(), 0.0])
        .start_position_m(-0.05)
        .start_rate_m_s(0.1)
        .motor(drive)
        .spring(LinearSpring { stiffness_n_m: 5.0, damping_n_s_m: 0.1, rest_position_m: 0.02 })
        .latch(Latch::with_stiffness_n_m(300.0).position_m(0.02).capture_m(1e-3).enable(false));
    let pump = Joint::prismatic("pump", [0.0, 1.0, 0.0])
        .on("block")
        .offset_m([0.1, 0.0, 0.0])
        .prescribed(Motion::Table(vec![(0.0, 0.0), (0.2, 0.05)]));
    let hammer =
        Joint::prismatic("ram", Vector3::z()).on("piston").release(false).latch(Latch::rigid().position_m(0.1));
    let body = |name: &str| Body::rigid(name).inertia(1.0, [0.0; 3], Matrix3::identity() * 0.01);
    let mut built = Machine::builder("slides")
        .body(body("block"), slide)
        .body(body("piston"), pump)
        .body(body("hammer"), hammer)
        .solver(told.solver.clone())
        .stop_time_s(0.3)
        .step_s(1e-3)
        .build()
        .unwrap_or_else(|refused| panic!("{refused}"));
    assert_eq!(slide_of(&mut built, 0), slide_of(&mut told.clone(), 0));
    assert_eq!(built.bodies, told.bodies);
    let mut plant = start(told);
    coast(&mut plant, 0.3);
}

/// PJ-15. One flow in two descriptions: a wing moved upstream at 1 m/s by a prismatic joint in a wind of 10 m/s, and the same wing on a
/// fixed prismatic joint in 11 m/s, unfold equally, with strips and with a lattice. Without mass damping, which acts relative to the root.
#[test]
fn pj15_a_slide_through_the_air_is_wind() {
    let shipped = include_str!("../../../examples/models/folding_wing_in_tunnel.toml");
    let (head, surfaces) = shipped.split_once("[aerodynamics]").expect("a table");
    let (_, surfaces) = surfaces.split_once("[surface.inner]").expect("a table");
    let text = |air: &str, wind_m_s: f64, speed_m_s: f64| {
        let surfaces =
            if air.contains("strip") { surfaces.replace("chord_panels", "# chord_panels") } else { surfaces.into() };
        let slide = format!(
            "[joint.mount]\ntype = \"prismatic\"\naxis = [0.0, 1.0, 0.0]\nmotion = \"prescribed\"\npolynomial_m = [0.0, {speed_m_s}]"
        );
        format!(
            "{head}[aerodynamics]\n{air}\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, {}, 0.0]\nstep_s = 1.25e-3\n[surface.inner]{surfaces}",
            -wind_m_s
        )
        .replace("mass_damping_1_s = 2.5", "mass_damping_1_s = 0.0")
        .replace("[joint.mount]\ntype = \"clamped\"", &slide)
    };
    for air in ["model = \"strip\"", "model = \"uvlm\"\nwake_rows = 10\nmirror_normal = [1.0, 0.0, 0.0]"] {
        let [carried, blown] = [(10.0, 1.0), (11.0, 0.0)].map(|(wind_m_s, speed_m_s)| {
            let machine = foldwing::config::parse(&text(air, wind_m_s, speed_m_s), "slide.toml")
                .unwrap_or_else(|error| panic!("{error}"));
            let mut plant = start(machine);
            plant.step(0.01).expect("a step");
            (plant.outputs().joints()[1].angle_rad, plant.outputs().air_total().force_n)
        });
        println!("PJ-15 {air:?}: {:.1e} rad, {:.1e} N apart", carried.0 - blown.0, (carried.1 - blown.1).norm());
        // equal results except for the round-off of positions that differ by 1 cm, over eight aerodynamic steps
        agree("PJ-15 angle in rad", (carried.0 - blown.0).abs(), 1e-14);
        agree("PJ-15 force in N", (carried.1 - blown.1).norm(), 1e-12);
        assert!(carried.1.norm() > 0.05, "the air acts: {carried:?}");
    }
}

/// PJ-16. Along a free prismatic joint, the joint force equals the applied force at every communication point inside long internal steps: a
/// beam normal to its rail, on a spring and under an external force.
#[test]
fn pj16_a_slide_carries_along_itself_what_pushes_on_it() {
    let joint = Joint::prismatic("slide", Vector3::z()).spring(spring(50.0, 0.3)).start_position_m(0.1);
    let mut machine = machine([(body("beam", 0.5, &wing_section(), ElementKind::Linear, 2), joint)]);
    machine.solver.tolerance = 1e-3;
    let mut plant = start(machine);
    plant.inputs_mut().joints_mut()[0].torque_n_m = 1.5;
    let (mut apart_n, mut largest_n) = (0f64, 0f64);
    for step in 1..=400 {
        plant.step(1e-3 * f64::from(step)).expect("a step");
        let outputs = plant.outputs();
        let (pushes_n, carried_n) = (outputs.joints()[0].torque_applied_n_m, outputs.joint_reactions()[0].force_n.z);
        apart_n = apart_n.max((carried_n - pushes_n).abs());
        largest_n = largest_n.max(pushes_n.abs());
    }
    println!("PJ-16 {apart_n:.1e} N of {largest_n:.1} N in {} steps", plant.statistics().steps);
    assert!(apart_n < 1e-12 * largest_n && largest_n > 1.0, "{apart_n} N of {largest_n} N");
    assert!(plant.statistics().steps < 200, "communication points lie inside of steps: {:?}", plant.statistics());
}
