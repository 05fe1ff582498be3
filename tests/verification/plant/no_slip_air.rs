//! Skates and wheels in the air of strips and of a vortex lattice, and on bodies that slide along a beam.

use crate::plant::machines::*;
use crate::plant::sliding::slender;
use foldwing::beam::profile::Profile as Along;
use foldwing::machine::builder::{AirBuilder, JointBuilder, NoSlipBuilder};
use foldwing::machine::*;
use nalgebra::{Matrix3, Vector3};

fn strips() -> AirBuilder {
    Air::strips()
        .density_kg_m3(1.2)
        .step_s(0.01)
        .coupling(Coupling::Iterated { tolerance: 1e-11, most_iterations: 100 })
}

fn lattice() -> AirBuilder {
    Air::lattice()
        .density_kg_m3(1.2)
        .step_s(0.01)
        .wake_rows(20)
        .coupling(Coupling::Iterated { tolerance: 1e-11, most_iterations: 100 })
}

/// A hull whose heading is `y`, with two flexible wings 0.3 m above the runway, which it follows at 12 m/s against a wind of 2 m/s.
fn taxiing(air: &AirBuilder, joint: JointBuilder, gear: Vec<NoSlipBuilder>) -> Machine {
    let mut section = slender(1e4, 3.0, 1e-3);
    section.mass_kg_m = 0.3;
    let half = |name: &str| body(name, 0.8, &section, ElementKind::Linear, 2).stiffness_damping_s(1e-3);
    let hull =
        Body::rigid("hull").inertia(3.0, [0.0, 0.02, 0.05], Matrix3::from_diagonal(&Vector3::new(0.2, 0.1, 0.25)));
    let wing = |name: &str| {
        LiftingSurface::on(name, 4).chord_m(Along::constant(0.2)).chord_panels(2).incidence_deg(Along::constant(4.0))
    };
    let machine = Machine::builder("taxi")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(hull, joint)
        .body(half("right"), Joint::clamped("right_mount").on("hull"))
        .body(
            half("left"),
            Joint::clamped("left_mount").on("hull").mount_rotation_rad([0.0, 0.0, std::f64::consts::PI]),
        )
        .air(air.clone().wind_m_s([0.5, -2.0, 0.3]))
        .surface(wing("right"))
        .surface(wing("left").leading_edge_minus_y());
    let machine = gear.into_iter().fold(machine, builder::MachineBuilder::no_slip);
    machine.solver(solver(Method::Esdirk4, 1e-9)).step_s(0.01).build().unwrap_or_else(|refused| panic!("{refused}"))
}

/// The three skates of the hull, whose forces are a support in all directions but its heading.
fn skates() -> Vec<NoSlipBuilder> {
    let at = |name: &str, offset_m: [f64; 3]| {
        NoSlip::skate(name, "hull", [0.0, 1.0, 0.0]).offset_m(offset_m).plane([0.0, 0.0, 1.0], [0.0, 0.0, -0.3])
    };
    vec![at("nose", [0.0, 0.5, -0.3]), at("port", [-0.3, -0.1, -0.3]), at("starboard", [0.3, -0.1, -0.3])]
}

/// WH-16. A winged hull on three skates that follows a runway in the wind is the hull on a prismatic joint: way, wings, and the sum of the
/// normal forces beside the joint's reaction; strips and lattice.
#[test]
fn wh16_a_hull_on_skates_is_a_hull_on_a_slide() {
    for (air, what) in [(strips(), "strips"), (lattice(), "lattice")] {
        let free = Joint::free("gear").start_velocity_m_s([0.0, 12.0, 0.0]);
        let slide = Joint::prismatic("gear", [0.0, 1.0, 0.0]).start_rate_m_s(12.0);
        let mut on_skates = start(taxiing(&air, free, skates()));
        let mut on_slide = start(taxiing(&air, slide, Vec::new()));
        let mut off = [0.0f64; 3];
        for step in 1..=30 {
            [&mut on_skates, &mut on_slide].into_iter().for_each(|plant| coast(plant, 0.01 * f64::from(step)));
            let (a, b) = (on_skates.outputs(), on_slide.outputs());
            for (one, other) in a.tips().iter().zip(b.tips()) {
                off[0] = off[0].max((one.position_m - other.position_m).norm());
                off[1] = off[1].max((one.velocity_m_s - other.velocity_m_s).norm());
            }
            let (own, other) = (a.air_total().force_n, b.air_total().force_n);
            let [own_root, other_root] = [a, b].map(|outputs| outputs.root().force_n);
            off[2] =
                off[2].max((own - other).norm() / other.norm()).max((own_root - other_root).norm() / other_root.norm());
        }
        let slip =
            on_skates.outputs().no_slips().iter().map(|own| own.slip_m_s.max(own.height_m.abs())).fold(0.0, f64::max);
        let normal_n: f64 = on_skates.outputs().no_slips().iter().map(|own| own.normal_force_n).sum();
        println!(
            "WH-16 {what}: {:.1e} m, {:.1e} m/s, forces {:.1e}, slip {slip:.1e}, normal forces {normal_n:.3} N, speed {:.3} m/s",
            off[0],
            off[1],
            off[2],
            on_slide.outputs().joints()[0].rate_rad_s
        );
        assert!(off[0] < 1e-8 && off[1] < 1e-6 && off[2] < 1e-6 && slip < 1e-12, "{what}: {off:?}");
        assert!(normal_n > 1.0 && normal_n < 33.0, "lift relieves the gear: {normal_n} N");
    }
}

/// WH-17. A hull on a nose wheel and two main wheels that roll, with the inertia of the wheels at rest, in a cross wind: the energy account
/// closes with the work of the air, nothing slips, communication steps do not matter, and a repeated step has the same bits.
#[test]
fn wh17_wheels_in_a_cross_wind() {
    let rims = |name: &str, wheel: &str| {
        NoSlip::wheel(name, wheel, [1.0, 0.0, 0.0], 0.1).plane([0.0, 0.0, 1.0], [0.0, 0.0, -0.3])
    };
    for (air, what) in [(strips(), "strips"), (lattice(), "lattice")] {
        let fresh = || {
            let mut machine = builder_of(&air);
            for (name, at_m) in
                [("nose", [0.0, 0.5, -0.2]), ("port", [-0.3, -0.1, -0.2]), ("starboard", [0.3, -0.1, -0.2])]
            {
                let disc =
                    Body::rigid(name).inertia(0.1, [0.0; 3], Matrix3::from_diagonal(&Vector3::new(6e-4, 3e-4, 3e-4)));
                let axle = Joint::revolute(format!("{name}_axle"), [1.0, 0.0, 0.0]).on("hull").offset_m(at_m);
                machine = machine.body(disc, axle.start_rate_rad_s(-120.0)).no_slip(rims(&format!("{name}_rim"), name));
            }
            start(
                machine
                    .solver(solver(Method::Esdirk4, 1e-9))
                    .step_s(0.01)
                    .build()
                    .unwrap_or_else(|refused| panic!("{refused}")),
            )
        };
        let bits = |plant: &foldwing::plant::Plant| {
            plant.outputs().values().iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        };
        let (mut plant, mut coarse) = (fresh(), fresh());
        let before_j = balance_j(plant.outputs());
        let mut slip = 0.0f64;
        for step in 1..=25 {
            let before = plant.snapshot();
            coast(&mut plant, 0.008 * f64::from(step));
            let first = bits(&plant);
            plant.restore(&before).expect("its own");
            coast(&mut plant, 0.008 * f64::from(step));
            assert!(first == bits(&plant), "{what}: a repeated step has other bits");
            let own = plant.outputs().no_slips().iter();
            slip = own.map(|own| own.slip_m_s.max(own.height_m.abs())).fold(slip, f64::max);
        }
        coast(&mut coarse, 0.2);
        let off_m = (coarse.outputs().tips()[0].position_m - plant.outputs().tips()[0].position_m).norm();
        let (drift_j, energy) = (balance_j(plant.outputs()) - before_j, plant.outputs().energy());
        println!(
            "WH-17 {what}: slip {slip:.1e}, drift {drift_j:.1e} J of {:.1} J, work {:.2e} J, steps {off_m:.1e} m",
            energy.kinetic, energy.work
        );
        assert!(
            slip < 1e-12 && off_m < 1e-12 && drift_j.abs() < 1e-6 && energy.work.abs() > 0.05,
            "{what}: {drift_j:e} J"
        );
    }
}

/// The hull of [`taxiing`] with a free joint and without gear.
fn builder_of(air: &AirBuilder) -> builder::MachineBuilder {
    let mut section = slender(1e4, 3.0, 1e-3);
    section.mass_kg_m = 0.3;
    let hull =
        Body::rigid("hull").inertia(3.0, [0.0, 0.02, 0.05], Matrix3::from_diagonal(&Vector3::new(0.2, 0.1, 0.25)));
    let free = Joint::free("gear").start_velocity_m_s([0.0, 12.0, 0.0]);
    Machine::builder("taxi")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(hull, free)
        .body(
            body("right", 0.8, &section, ElementKind::Linear, 2).stiffness_damping_s(1e-3),
            Joint::clamped("right_mount").on("hull"),
        )
        .air(air.clone().wind_m_s([3.0, -2.0, 0.3]))
        .surface(LiftingSurface::on("right", 4).chord_m(Along::constant(0.2)).chord_panels(2))
}

/// WH-18. A bead on a stiff rod that turns about a pivot, with a skate at 45° to the rod: `ṙ = r ω`, so that `ω² (J + 2 m r²)` is constant, over
/// three borders, with the energy account of the impulses; a rod with a natural curvature, whose bead loses energy at each border.
#[test]
fn wh18_a_skate_on_a_sliding_body() {
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        for curved in [false, true] {
            let rod = body("rod", 1.0, &slender(1e8, 1e5, 1e-8), kind, 4).natural_curvature_1_m([
                0.0,
                0.0,
                if curved { 0.6 } else { 0.0 },
            ]);
            let (r_m, spin_rad_s) = (0.2, 2.0);
            let hinge = Joint::revolute("hinge", [0.0, 0.0, 1.0]).start_rate_rad_s(spin_rad_s);
            let slide = Joint::sliding("slide").on("rod").start_position_m(r_m).start_rate_m_s(r_m * spin_rad_s);
            // the rod turns towards +y
            let heading = [0.5f64.sqrt(), 0.5f64.sqrt(), 0.0];
            let blade = NoSlip::skate("blade", "bead", heading).plane([0.0, 0.0, 1.0], [0.0; 3]).hold_normal(false);
            let machine = Machine::builder("spiral")
                .body(rod, hinge)
                .body(Body::rigid("bead"), slide)
                .mass("bead", AttachedMass::point("mass", 0.0, 0.3))
                .no_slip(blade)
                .solver(solver(Method::Esdirk4, 1e-9))
                .build()
                .unwrap_or_else(|refused| panic!("{refused}"));
            let mut plant = start(machine);
            let before_j = balance_j(plant.outputs());
            let inertia = |r_m: f64| 0.5 / 3.0 + 2.0 * 0.3 * r_m * r_m;
            let constant = inertia(r_m) * spin_rad_s * spin_rad_s;
            let rate = |r_m: f64| r_m * (constant / inertia(r_m)).sqrt();
            // Runge–Kutta steps of the closed form
            let (mut due_m, steps, end_s) = (r_m, 2000, 0.65);
            for _ in 0..steps {
                let h = end_s / f64::from(steps);
                let k1 = rate(due_m);
                let k2 = rate(due_m + 0.5 * h * k1);
                let k3 = rate(due_m + 0.5 * h * k2);
                let k4 = rate(due_m + h * k3);
                due_m += h * (k1 + 2.0 * (k2 + k3) + k4) / 6.0;
            }
            coast(&mut plant, end_s);
            let joint = plant.outputs().joints()[1];
            let (drift_j, energy) = (balance_j(plant.outputs()) - before_j, plant.outputs().energy());
            let slip = plant.outputs().no_slips()[0].slip_m_s;
            println!(
                "WH-18 {kind:?} curved {curved}: s {:.4} m off by {:.1e} m, drift {drift_j:.1e} J, lost {:.1e} J, slip {slip:.1e}, {} events",
                joint.angle_rad,
                joint.angle_rad - due_m,
                energy.dissipated,
                plant.statistics().events
            );
            assert!(joint.angle_rad > if curved { 0.3 } else { 0.5 } && plant.statistics().events >= 1 && slip < 1e-12);
            assert!(curved || (joint.angle_rad - due_m).abs() < 2e-6, "{} for {due_m}", joint.angle_rad);
            assert!(drift_j.abs() < 1e-7 && energy.dissipated > -1e-12, "{drift_j:e} J");
        }
    }
}
