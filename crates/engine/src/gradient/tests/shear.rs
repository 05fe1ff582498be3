//! Gradients of machines with bodies with shear.

use super::air::{AIR_PLACES, Kind, compare_in_air};
use super::folding::{agree, flap, fold, hold, without};
use super::rigid::hardened;
use super::*;
use crate::load::LoadFrame;
use crate::machine::builder::{BodyBuilder, JointBuilder};

fn beam(numbers: Numbers, name: &str, length_m: f64, sheared: bool) -> BodyBuilder {
    // soft in shear, so that it matters
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1e8, density_kg_m3: numbers.density };
    let solid = Solid::rectangle(0.05, numbers.thickness, material);
    Body::beam(name, length_m, if sheared { solid.with_shear() } else { solid })
        .elements(2)
        .mass_damping_1_s(0.5)
        .stiffness_damping_s(numbers.beta)
        .load_stations(2)
        .load_frame(LoadFrame::Section)
}

/// A folding wing with shear in either or both bodies on a root joint, with a follower load inside an element.
fn wing(numbers: Numbers, sheared: [bool; 2], root: JointBuilder) -> Result<Machine, String> {
    let wrench = crate::load::Wrench { force_n: [0.0, 0.0, numbers.load].into(), ..Default::default() };
    Machine::builder("Sheared")
        .gravity_m_s2([0.0, 0.5, -9.81])
        .body(beam(numbers, "inner", numbers.length, sheared[0]), root)
        .body(beam(numbers, "outer", 0.3, sheared[1]), fold(numbers, "inner"))
        .mass("outer", AttachedMass::point("tip", 0.3, numbers.mass))
        .load("pull", "inner", 1, wrench)
        .gauge(Gauge::on("root", "inner", 0.05))
        .solver(Solver { tolerance: 1e-12, ..solver() })
        .build()
        .map_err(|refused| refused.to_string())
}

fn compare(
    machine: impl Fn(Numbers) -> Result<Machine, String>,
    leave: &[&str],
    joint: usize,
    (same, words): (f64, &str),
) {
    let compared = compare_results(machine, &InputRows::default(), &without(leave), |plant| {
        let layout = *plant.outputs().layout();
        let indices = [
            layout.gauges.place(0, 0),
            layout.tips.place(0, 0) + 2,
            layout.energy.place(0, 0),
            layout.root.place(0, 0) + 2,
        ];
        let outputs = (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time }));
        let accounts = layout.accounts().map(|index| RunResult::Output { index, time: 1 });
        outputs.chain(accounts).chain([RunResult::LatchTime { joint }]).collect()
    });
    assert!(compared.events > 0, "{words}: no event");
    agree(&compared, same, words);
}

/// GR-64: a folding wing with shear in both bodies, through an elastic latch.
#[test]
#[ignore = "long; `make long` runs it"]
fn gradients_of_bodies_with_shear() {
    compare(|numbers| wing(numbers, [true; 2], flap()), &["stop", "command"], 1, (1e-9, "both"));
}

/// GR-65: with shear in the inner body, through a rigid latch.
#[test]
fn gradients_of_a_body_with_shear_through_a_rigid_latch() {
    let leave = ["stop", "command", "latch_stiffness"];
    // found 8.4e-10: the impulse starts waves of the stiff strains, whose accelerations multiply round-off of the solutions
    compare(|numbers| wing(numbers, [true, false], flap()).map(hardened), &leave, 1, (5e-9, "rigid latch"));
}

/// GR-66: with shear in the outer body, on a ball joint.
#[test]
#[ignore = "long; `make long` runs it"]
fn gradients_of_a_body_with_shear_on_a_ball_joint() {
    let ball = |numbers: Numbers| {
        let ball = Joint::ball("hook").motor(hold(numbers));
        ball.start_angular_velocity_rad_s([numbers.start_rate, 1.0, -0.7])
    };
    compare(|numbers| wing(numbers, [false, true], ball(numbers)), &["stop", "command"], 0, (1e-9, "ball"));
}

/// GR-111: with shear in both bodies, in air: loads act inside the elements.
#[test]
fn gradients_of_a_wing_with_shear_in_air() {
    let times_s = [0.1213, 0.159];
    for (staggered, latched) in [(false, false), (true, true)] {
        let kind = Kind { sheared: true, latched, staggered, ..Kind::FULL };
        let places = [0, 2, 5, 9, 10].map(|place| AIR_PLACES[place]);
        let (both, differences, events) = compare_in_air(kind, (&times_s, &places), |tape, machine, results| {
            retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
        });
        println!("GR-111 {staggered}: {both:.1e} {differences:.1e}");
        assert!(events > 0, "{staggered}: no event");
        // found 5.0e-10 behind the latch, which starts waves of the stiff strains, as in GR-65
        assert!(both < 1e-9, "{staggered}: {both:.1e}");
        assert!(differences < 1e-6, "{staggered}: {differences:.1e}");
    }
}
