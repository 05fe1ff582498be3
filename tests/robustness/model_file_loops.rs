//! Closed loops: errors with their whole messages, and the meaning of an accepted file.

use crate::model_file::{MODEL, message_of};
use foldwing::config;
use foldwing::machine::{Closure, LoopEnd};
use nalgebra::Vector3;

fn on(index: usize, position_m: f64) -> LoopEnd {
    LoopEnd::Body { index, position_m }
}

/// A loop appended to the small model, whose fold joint starts at `fold_deg`; its table is on line 55.
fn model(fold_deg: f64, lines: &str) -> String {
    let model = MODEL.replace("start_angle_deg = 170", &format!("start_angle_deg = {fold_deg}"));
    format!("{model}[loop.pin]\n{lines}\n")
}

fn message(lines: &str) -> String {
    message_of(&model(0.0, lines))
}

/// From 0.05 m on the inner body to the end of the outer one at 0.25 m: closed for the stretched-out wing.
const CLOSED: &str = "bodies = [\"inner\", \"outer\"]\npositions_m = [0.05, 0.1]\noffsets_m = [[0, 0, 0.01], [-0.2, 0, \
                      0.01]]\nstiffness_N_m = 1e5";

#[test]
fn accepted_loops_mean_what_they_say() {
    let text = model(0.0, &format!("{CLOSED}\ndamping_N_s_m = 20\ninertia_kg = 0.001"));
    let machine = config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        machine.closures,
        [Closure {
            name: "pin".into(),
            ends: [on(0, 0.05), on(1, 0.1)],
            offsets_m: [Vector3::new(0.0, 0.0, 0.01), Vector3::new(-0.2, 0.0, 0.01)],
            rigid: false,
            inertia_kg: 1e-3,
            damping_n_s_m: 20.0,
            stiffness_n_m: 1e5,
        }]
    );
}

/// Without positions the loop joins the outer ends; inertia and damping are optional. The order of the bodies in the file need not be that
/// of the tree.
#[test]
fn defaults_of_a_loop() {
    let lines = "bodies = [\"outer\", \"inner\"]\noffsets_m = [[-0.1, 0, 0], [0, 0, 0]]\nstiffness_N_m = 1e5";
    let machine = config::parse(&model(0.0, lines), "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    let closure = &machine.closures[0];
    assert_eq!(closure.ends, [on(1, 0.1), on(0, 0.15)]);
    assert_eq!((closure.inertia_kg, closure.damping_n_s_m), (0.0, 0.0));
}

/// Bodies that do not exist, the root, the same section twice.
#[test]
fn bodies_of_a_loop() {
    assert_eq!(
        message(&CLOSED.replace("outer", "outr")),
        "wing.toml:57: key 'loop.pin.bodies': [\"inner\", \"outr\"] is not allowed; allowed: names of \
         bodies: \"inner\" or \"outer\" (did you mean \"outer\"?)"
    );
    assert_eq!(
        message(&CLOSED.replace("outer", "root")),
        "wing.toml:58: key 'loop.pin.positions_m': [0.05, 0.1] is not allowed; allowed: 0 for the root: the point is \
         fixed in the root frame at its offset in offsets_m"
    );
    assert_eq!(
        message(&CLOSED.replace("outer", "root").replace("inner", "root").replace("[0.05, 0.1]", "[0, 0]")),
        "wing.toml:57: key 'loop.pin.bodies': [\"root\", \"root\"] is not allowed; allowed: one body at least: both \
         points are on the root"
    );
    assert_eq!(
        message("bodies = [\"inner\", \"inner\"]\nstiffness_N_m = 1e5"),
        "wing.toml:57: key 'loop.pin.bodies': [\"inner\", \"inner\"] is not allowed; allowed: two different points; \
         this one is joined to itself"
    );
    assert_eq!(
        message("bodies = [\"outer\", \"outer\"]\npositions_m = [0.1, 0.1]\nstiffness_N_m = 1e5"),
        "wing.toml:58: key 'loop.pin.positions_m': [0.1, 0.1] is not allowed; allowed: two different points; this one \
         is joined to itself"
    );
    assert_eq!(
        message(&CLOSED.replace("[\"inner\", \"outer\"]", "[\"inner\"]")),
        "wing.toml:57: key 'loop.pin.bodies': [\"inner\"] is not allowed; allowed: an array of 2 names of \
         bodies, or of a body and \"root\""
    );
}

/// Positions beyond the bodies and keys of the wrong kind.
#[test]
fn places_of_a_loop() {
    assert_eq!(
        message(&CLOSED.replace("[0.05, 0.1]", "[0.05, 0.11]")),
        "wing.toml:58: key 'loop.pin.positions_m': [0.05, 0.11] is not allowed; allowed: positions from 0 to the \
         length of each body; \"outer\" is 0.1 m long"
    );
    assert_eq!(
        message(&CLOSED.replace("[0.05, 0.1]", "[-0.05, 0.1]")),
        "wing.toml:58: key 'loop.pin.positions_m': [-0.05, 0.1] is not allowed; allowed: an array of 2 \
         finite lengths >= 0 m"
    );
    assert_eq!(
        message(&CLOSED.replace("[-0.2, 0, 0.01]", "[-0.2, 0]")),
        "wing.toml:59: key 'loop.pin.offsets_m': [[0, 0, 0.01], [-0.2, 0]] is not allowed; allowed: an array \
         of 2 arrays of 3 finite lengths in m"
    );
}

/// Invalid penalty stiffnesses.
#[test]
fn penalties_of_a_loop() {
    assert_eq!(
        message(&CLOSED.replace("1e5", "0")),
        "wing.toml:60: key 'loop.pin.stiffness_N_m': 0 is not allowed; allowed: a finite stiffness > 0 N/m"
    );
    assert_eq!(
        message(&CLOSED.replace("1e5", "inf")),
        "wing.toml:60: key 'loop.pin.stiffness_N_m': inf is not allowed; allowed: a finite stiffness > 0 \
         N/m"
    );
    assert_eq!(
        message(&CLOSED.replace("stiffness_N_m", "stiffness")),
        "wing.toml:60: key 'loop.pin.stiffness' is unknown; write stiffness_N_m (N/m); allowed keys: bodies, \
         positions_m, offsets_m, rigid, stiffness_N_m, damping_N_s_m, inertia_kg"
    );
    assert_eq!(
        message(&format!("{CLOSED}\ndamping_N_s_m = -1")),
        "wing.toml:61: key 'loop.pin.damping_N_s_m': -1 is not allowed; allowed: a finite damping >= 0 \
         N·s/m"
    );
    assert_eq!(
        message(&format!("{CLOSED}\ninertia_kg = -1e-3")),
        "wing.toml:61: key 'loop.pin.inertia_kg': -1e-3 is not allowed; allowed: a finite mass >= 0 kg"
    );
    assert_eq!(
        message(&format!("{CLOSED}\ninertia_kg = nan")),
        "wing.toml:61: key 'loop.pin.inertia_kg': nan is not allowed; allowed: a finite mass >= 0 kg"
    );
}

/// A loop that is open at the start: the message gives the gap. A joint's start angle opens it, and so does the natural curvature of a
/// body: the half circle rotates its outboard bodies.
#[test]
fn loops_that_are_open_at_the_start() {
    assert_eq!(
        message_of(&model(1.0, CLOSED)),
        "wing.toml:56: key 'loop.pin': a gap of 0.001754 m, from the first point to the second [0.000190, 0.000000, \
         0.001744], is not allowed; allowed: points that coincide in the unstrained model at its start angles within \
         1.5e-4 m, 0.001 of the length of the longer body"
    );
    let curved =
        model(0.0, CLOSED).replace("load_stations = 4", "load_stations = 4\nnatural_curvature_1_m = [0, 0, 20.943951]");
    assert_eq!(
        message_of(&curved),
        "wing.toml:57: key 'loop.pin': a gap of 0.092571 m, from the first point to the second [0.058650, 0.071621, \
         0.000000], is not allowed; allowed: points that coincide in the unstrained model at its start angles within \
         1.5e-4 m, 0.001 of the length of the longer body"
    );
}

/// The outer end of a body whose natural curvature is that of a full circle coincides with its inner end.
#[test]
fn a_ring_is_a_loop() {
    let ring = model(0.0, "bodies = [\"inner\", \"inner\"]\npositions_m = [0, 0.15]\nstiffness_N_m = 1e5")
        .replace("load_stations = 4", "load_stations = 4\nnatural_curvature_1_m = [0, 0, 41.887902]");
    let machine = config::parse(&ring, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(machine.closures[0].ends, [on(0, 0.0), on(0, 0.15)]);
}

/// A point on the root is at its offset in the root frame, in either place; positions are optional, and 0 for the root.
#[test]
fn a_loop_ends_on_the_root() {
    for (lines, ends) in [
        ("bodies = [\"outer\", \"root\"]\noffsets_m = [[0, 0, 0.01], [0.25, 0, 0.01]]", [on(1, 0.1), LoopEnd::Root]),
        (
            "bodies = [\"root\", \"inner\"]\npositions_m = [0, 0.1]\noffsets_m = [[0.1, 0, 0], [0, 0, 0]]",
            [LoopEnd::Root, on(0, 0.1)],
        ),
    ] {
        let text = model(0.0, &format!("{lines}\nstiffness_N_m = 1e5"));
        let machine = config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(machine.closures[0].ends, ends);
    }
    // the point on the root is 0.01 m below that of the wing
    let lines = "bodies = [\"outer\", \"root\"]\noffsets_m = [[0, 0, 0.01], [0.25, 0, 0]]\nstiffness_N_m = 1e5";
    let text = message(lines);
    let gap = "a gap of 0.010000 m, from the first point to the second [0.000000, 0.000000, -0.010000],";
    assert!(text.contains("'loop.pin'") && text.contains(gap), "{text}");
}

/// No joint may have the name of the group of the loops' outputs.
#[test]
fn no_joint_is_named_loop() {
    let text = MODEL.replace("[joint.mount]", "[joint.loop]");
    assert_eq!(
        message_of(&text),
        "wing.toml:24: key 'joint.loop': the name \"loop\" is not allowed; allowed: a name that is not one of load, gravity, root, wind, gauge, internal_load, loop, tip, station, aero, energy, \
         failure, solver, body, time, der"
    );
}
