//! Machines on a free joint: mass-proportional damping does not affect their flight (D12).

use crate::plant::machines::*;
use foldwing::machine::builder::JointBuilder;
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::{Matrix3, Vector3};

/// A free joint on the root with these start velocities.
fn free(velocity_m_s: Vector3<f64>, spin_rad_s: Vector3<f64>) -> JointBuilder {
    Joint::free("flight").start_velocity_m_s(velocity_m_s).start_angular_velocity_rad_s(spin_rad_s)
}

/// P-126. A damped plate that flies at 12 m/s through vacuum, rotating about its thickness direction at 2 rad/s, keeps speed and spin
/// within the integrator's tolerance. (It used to have 0.985 m/s after 1 s.)
#[test]
fn p126_a_damped_free_body_keeps_speed_and_spin() {
    let velocity_m_s = Vector3::new(0.0, 12.0, 0.0);
    let plate = body("plate", 0.3, &wing_section(), ElementKind::Linear, 2).mass_damping_1_s(2.5);
    let mut plant = start(machine([(plate, free(velocity_m_s, Vector3::new(0.0, 0.0, 2.0)))]));
    // a straight, nearly rigid plate: its middle is the centre of mass
    let momentum = |plant: &Plant| {
        let (joint, tip) = (plant.outputs().spatial()[0], plant.outputs().tips()[0]);
        let back = joint.rotation * Vector3::new(-0.15, 0.0, 0.0);
        (tip.velocity_m_s + joint.angular_velocity_rad_s.cross(&back), joint.angular_velocity_rad_s)
    };
    let before = momentum(&plant);
    let start = balance_j(plant.outputs());
    coast(&mut plant, 1.0);
    let after = momentum(&plant);
    let (speed, spin) = (after.0.norm() / before.0.norm() - 1.0, after.1.norm() / before.1.norm() - 1.0);
    println!("P-126 speed changes by {speed:.1e}, spin by {spin:.1e} of itself");
    assert!(speed.abs() < 1e-6, "speed changes by {speed:.1e}");
    assert!(spin.abs() < 1e-4, "spin changes by {spin:.1e}");
    let drift = balance_j(plant.outputs()) - start;
    assert!(drift.abs() < 1e-6, "the energy account drifts by {drift:.1e} J of {start} J");
}

/// P-127. The folding wing latches at the same instant, clamped to the root or on a heavy carrier that flies at 20 m/s, to 1e-6 of the
/// time, because of the carrier's finite mass and the tolerance. (Damping of the carrier's flight used to change it.)
#[test]
fn p127_a_wing_on_a_flying_carrier_latches_when_the_clamped_one_does() {
    let latch_time = |carrier: Option<f64>| {
        let mut machine = default_wing(1e-7);
        machine.gravity_m_s2 = Vector3::zeros();
        if let Some(speed_m_s) = carrier {
            machine.bodies[0].joint.kind = JointKind::Spatial(Box::new(Spatial {
                freedom: SpatialFreedom::Free,
                stiffness_n_m_rad: 0.0,
                damping_n_m_s_rad: 0.0,
                start_velocity_m_s: Vector3::new(0.0, speed_m_s, 0.3 * speed_m_s),
                start_angular_velocity_rad_s: Vector3::zeros(),
            }));
            let inertia_kg_m2 = Matrix3::identity() * 1e6;
            let heavy = AttachedMass { inertia_kg_m2, ..AttachedMass::point("carrier", 0.0, 1e6) };
            machine.bodies[0].masses.push(heavy);
        }
        let mut plant = start(machine);
        coast(&mut plant, 0.3);
        let status = plant.joint_statuses().next().expect("a fold");
        assert!(status.latched);
        status.latch_time_s
    };
    let clamped_s = latch_time(None);
    for speed_m_s in [0.0, 20.0] {
        let carried_s = latch_time(Some(speed_m_s));
        println!("P-127 clamped {clamped_s:.6} s, on a carrier at {speed_m_s} m/s {carried_s:.6} s");
        assert!((carried_s / clamped_s - 1.0).abs() < 1e-5, "{clamped_s} s clamped, {carried_s} s carried");
    }
}

/// P-128. A nearly rigid rod of inertia `J` on a hinge with the drive's inertia `I` and a spring `k`: its frequency is `√(k/(J + I))/2π`,
/// the energy balance closes, a constant torque gives the angular acceleration `τ/(J + I)`, and the torque of a prescribed joint
/// accelerates both. 1e-5: the rod's elasticity.
#[test]
fn p128_inertia_that_turns_with_the_angle_only() {
    let section = stout_section();
    let (own, drive) = (0.3f64.powi(3) / 3.0 * section.mass_kg_m + 0.3 * section.second_moment_kg_m[2], 0.02);
    let rod = |change: &dyn Fn(&mut Revolute)| {
        let mut hinge = free_hinge(0.2);
        hinge.motor.inertia_kg_m2 = drive;
        change(&mut hinge);
        machine([(body("rod", 0.3, &section, ElementKind::Linear, 1), hinged_to_root(hinge))])
    };
    let mut plant = start(rod(&|hinge| hinge.motor.stiffness_n_m_rad = 2.0));
    let right_hz = (2.0 / (own + drive)).sqrt() / std::f64::consts::TAU;
    let account = balance_j(plant.outputs());
    for (share, right) in [(0.25, 0.0), (0.5, -0.2)] {
        coast(&mut plant, share / right_hz);
        let angle = plant.outputs().joints()[0].angle_rad;
        assert!((angle - right).abs() < 1e-5, "after {share} periods at {angle} rad, right {right} rad");
        // error for the tolerance of 1e-6; after a quarter of the period half of the energy is in the drive
        let drift = balance_j(plant.outputs()) / account - 1.0;
        assert!(drift.abs() < 1e-4, "the account drifts by {drift:.1e}");
    }
    plant.study().equilibrium(0.0, foldwing::plant::Holding::AsReleased).expect("the slack spring");
    let found_hz = plant.study().modes(1).expect("modes")[0].frequency_hz;
    assert!((found_hz / right_hz - 1.0).abs() < 1e-5, "{found_hz} Hz, right {right_hz} Hz");

    let mut plant = start(rod(&|hinge| hinge.motor.constant_torque_n_m = -0.5));
    coast(&mut plant, 0.2);
    let turned = plant.outputs().joints()[0].angle_rad - 0.2;
    let right = 0.5 * 0.5 / (own + drive) * 0.04;
    assert!((turned / right - 1.0).abs() < 1e-5, "turned by {turned} rad, right {right} rad");

    let law = foldwing::force::prescribed::Motion::Polynomial(vec![0.0, 0.0, 1.5]);
    let mut plant = start(rod(&|hinge| hinge.motion = JointMotion::Prescribed(law.clone())));
    coast(&mut plant, 0.2);
    let work = plant.outputs().energy().work;
    let right = 0.5 * (own + drive) * 0.6f64.powi(2);
    assert!((work / right - 1.0).abs() < 1e-4, "the motion takes {work} J, right {right} J");
}

/// A stout bar: 1 kg/m, first bending frequency far above the frequencies in these tests.
fn stout_section() -> foldwing::beam::section::Section {
    let material =
        foldwing::beam::section::Material { youngs_modulus_pa: 2e11, shear_modulus_pa: 8e10, density_kg_m3: 2500.0 };
    foldwing::beam::section::Section::rectangle(0.02, 0.02, &material, None)
}

/// P-129. A bar with a mass at its tip on a free hinge, damped in proportion to mass: with `damp_attached_masses` the rate of the whole
/// machine decays as `exp(−αt)`, without it only in proportion to the bar's fraction of the inertia.
#[test]
fn p129_attached_masses_are_damped_where_told() {
    let section = stout_section();
    let own = 0.3f64.powi(3) / 3.0 * section.mass_kg_m + 0.3 * section.second_moment_kg_m[2];
    for (damps, share) in [(true, 1.0), (false, own / (own + 0.5 * 0.09))] {
        let mut hinge = free_hinge(0.0);
        hinge.start_rate_rad_s = 2.0;
        let bar = body("bar", 0.3, &section, ElementKind::Linear, 2).mass_damping_1_s(3.0).damp_attached_masses(damps);
        let mut machine = machine([(bar, hinged_to_root(hinge))]);
        machine.bodies[0].masses = vec![AttachedMass::point("tip", 0.3, 0.5)];
        let mut plant = start(machine);
        let account = balance_j(plant.outputs());
        coast(&mut plant, 0.4);
        let rate = plant.outputs().joints()[0].rate_rad_s;
        let right = 2.0 * (-3.0 * share * 0.4f64).exp();
        assert!((rate / right - 1.0).abs() < 1e-4, "damped masses {damps}: {rate} rad/s, right {right} rad/s");
        assert!((balance_j(plant.outputs()) - account).abs() < 1e-6 * account, "the account drifts");
    }
}
