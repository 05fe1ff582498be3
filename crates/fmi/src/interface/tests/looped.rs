//! Closed loops in the table: with inertia they transmit accelerations, without it the forces of springs and dampers only.

use super::machine;
use crate::interface::Interface;
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{Closure, JointKind, JointMotion, LoopEnd, Motion, Revolute};
use nalgebra::Vector3;

/// Three branches on the root, the first of two bodies, and one of two bodies that floats.
const BRANCHES: &str = r#"
name = "Looped"
gravity_m_s2 = [0.3, -0.4, -9.81]
[section.plate]
shape = "rectangle"
width_m = 0.05
height_m = 0.004
density_kg_m3 = 1400
youngs_modulus_Pa = 3e9
poisson_ratio = 0.3
[body]
a = { length_m = 0.2, section = "plate", elements = 1, load_stations = 1 }
b = { length_m = 0.15, section = "plate", elements = 1, load_stations = 1 }
c = { length_m = 0.25, section = "plate", elements = 1, load_stations = 1 }
d = { length_m = 0.2, section = "plate", elements = 1, load_stations = 1 }
e = { length_m = 0.2, section = "plate", elements = 1, load_station_positions_m = [0.07] }
f = { length_m = 0.2, section = "plate", elements = 1 }
[internal_load.cut]
body = "a"
position_m = 0.03
[internal_load.flying]
body = "e"
position_m = 0.06
[joint.left]
type = "revolute"
parent = "root"
child = "a"
axis = [0.1, 1, 0.3]
start_angle_deg = 20
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.elbow]
type = "revolute"
parent = "a"
child = "b"
axis = [0.2, 1, 0.1]
start_angle_deg = -30
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.right]
type = "revolute"
parent = "root"
child = "c"
root_position_m = [0.3, 0.1, 0]
axis = [-0.1, 1, 0.2]
start_angle_deg = 40
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.alone]
type = "revolute"
parent = "root"
child = "d"
root_position_m = [0, 1, 0]
axis = [0.2, 1, 0.3]
start_angle_deg = 30
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.flight]
type = "free"
parent = "root"
child = "e"
root_position_m = [0.1, 0.2, 0.3]
mount_rotation_deg = [30, 10, -20]
[joint.tail]
type = "revolute"
parent = "e"
child = "f"
axis = [0.3, 1, -0.2]
start_angle_deg = 25
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[mass] # not damped: without them, the damping of a body that turns about its own joint only slows it down
c = { body = "c", position_m = 0.07, mass_kg = 0.02, offset_m = [0, 0.02, 0] }
d = { body = "d", position_m = 0.1, mass_kg = 0.02, offset_m = [0, 0.02, 0] }
[gauge]
b = { body = "b", position_m = 0.02, y_m = 0.01 }
c = { body = "c", position_m = 0.02, y_m = 0.01 }
"#;

/// A closed loop between sections of two bodies; it is soft because its gap is wide, also with other start angles.
fn closure(name: &str, bodies: [usize; 2], [inertia_kg, damping_n_s_m]: [f64; 2]) -> Closure {
    Closure {
        name: name.into(),
        ends: bodies.map(|index| LoopEnd::Body { index, position_m: 0.15 }),
        offsets_m: [Vector3::new(0.0, 0.01, 0.02), Vector3::new(0.03, 0.0, -0.01)],
        rigid: false,
        inertia_kg,
        damping_n_s_m,
        stiffness_n_m: 30.0,
    }
}

/// A loop between a body and the root, as soft as that of [`closure`].
fn on_root(name: &str, body: usize, penalty: [f64; 2]) -> Closure {
    let mut closure = closure(name, [body; 2], penalty);
    (closure.ends[0], closure.offsets_m[0]) = (LoopEnd::Root, Vector3::new(0.2, 0.1, 0.15));
    closure
}

/// The branches with loops and with changed fold joints.
fn joined(closures: Vec<Closure>, change: impl Fn(usize, &mut Revolute)) -> Machine {
    let mut machine = machine(BRANCHES);
    machine.closures = closures;
    for (index, body) in machine.bodies.iter_mut().enumerate() {
        if let JointKind::Revolute(revolute) = &mut body.joint.kind {
            change(index, revolute);
        }
    }
    machine
}

/// Loops with every term of the penalty force: between held branches, within one branch, and with a floating branch.
pub(super) fn machines() -> Vec<(&'static str, Machine)> {
    let spinning = |_: usize, revolute: &mut Revolute| revolute.start_rate_rad_s = 0.7;
    let moved = |body: usize| {
        move |index: usize, revolute: &mut Revolute| {
            if index == body {
                revolute.motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.3, 0.5, 1.5]));
            }
        }
    };
    let prescribed = moved(2);
    vec![
        ("loop of springs", joined(vec![closure("pin", [1, 2], [0.0, 0.0])], |_, _| ())),
        ("loop of springs and dampers, turning", joined(vec![closure("pin", [1, 2], [0.0, 2.0])], spinning)),
        ("loop with inertia", joined(vec![closure("pin", [1, 2], [0.05, 2.0])], |_, _| ())),
        ("loop with inertia, turning", joined(vec![closure("pin", [1, 2], [0.05, 2.0])], spinning)),
        ("loop, prescribed", joined(vec![closure("pin", [1, 2], [0.0, 2.0])], prescribed)),
        ("loop with inertia, prescribed", joined(vec![closure("pin", [1, 2], [0.05, 0.0])], prescribed)),
        ("loop within a branch", joined(vec![closure("pin", [0, 1], [0.0, 2.0])], |_, _| ())),
        ("springs to what floats", joined(vec![closure("pin", [4, 2], [0.0, 2.0])], |_, _| ())),
        ("inertia to what would float", joined(vec![closure("pin", [4, 2], [0.05, 2.0])], |_, _| ())),
        ("springs to the root", joined(vec![on_root("tie", 1, [0.0, 2.0])], |_, _| ())),
        ("inertia to the root, turning", joined(vec![on_root("tie", 1, [0.05, 2.0])], spinning)),
        ("springs from what floats to the root", joined(vec![on_root("tie", 4, [0.0, 2.0])], |_, _| ())),
        ("springs from a fold of what floats to the root", joined(vec![on_root("tie", 5, [0.0, 2.0])], |_, _| ())),
        ("springs from a prescribed fold of what floats", joined(vec![on_root("tie", 5, [0.0, 2.0])], moved(5))),
        ("inertia from what would float to the root", joined(vec![on_root("tie", 4, [0.05, 2.0])], |_, _| ())),
        ("to the root, prescribed", joined(vec![on_root("tie", 2, [0.05, 0.0])], prescribed)),
        (
            "two branches to the root",
            joined(vec![on_root("first", 2, [0.05, 2.0]), closure("second", [4, 1], [0.0, 2.0])], |_, _| ()),
        ),
        (
            "two loops in a row",
            joined(vec![closure("first", [1, 2], [0.0, 2.0]), closure("second", [2, 4], [0.05, 2.0])], |_, _| ()),
        ),
    ]
}

#[test]
fn loops_have_the_promised_names() {
    let machine = joined(vec![closure("pin", [1, 2], [0.0, 2.0])], |_, _| ());
    let interface = Interface::new(&machine);
    for name in "loop.pin.gap.x loop.pin.gap.z loop.pin.force.y loop.pin.force.z".split(' ') {
        assert!(interface.find(name).is_some(), "{name} is missing");
    }
    let unit = |name: &str| interface.find(name).unwrap().unit();
    assert_eq!((unit("loop.pin.gap.x"), unit("loop.pin.force.x")), ("m", "N"));
}

/// The branches of a loop with inertia depend on each other's loads instantaneously; those of a loop of springs do not, nor does a branch
/// outside the loop.
#[test]
fn loops_join_branches() {
    let says = |machine: &Machine, output: &str, input: &str| {
        let interface = Interface::new(machine);
        let known = interface.find(input).unwrap().value_reference;
        let output = interface.find(output).unwrap().value_reference;
        interface.dependencies(machine)[output as usize].running.iter().any(|(row, _)| *row == known)
    };
    let with = |inertia_kg: f64| joined(vec![closure("pin", [1, 2], [inertia_kg, 1.0])], |_, _| ());
    let (springs, looped) = (with(0.0), with(0.01));
    for (output, input) in
        [("tip.b.acceleration.x", "load.c[1].force.z"), ("tip.c.acceleration.z", "elbow.external_torque")]
    {
        assert!(!says(&springs, output, input), "{output} does not feel {input} through springs");
        assert!(says(&looped, output, input), "{output} feels {input} through the loop");
    }
    assert!(!says(&looped, "tip.d.acceleration.x", "load.c[1].force.z"));
    assert!(!says(&looped, "tip.b.acceleration.x", "alone.external_torque"));
}
