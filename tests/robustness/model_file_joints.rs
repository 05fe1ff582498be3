//! Universal, ball and free joints: errors with their whole messages, and the meaning of an accepted file.

use crate::model_file::{message_of, with};
use foldwing::config;
use foldwing::machine::{JointKind, Method, Spatial, SpatialFreedom};
use nalgebra::Vector3;

/// The fold joint of the small model, lines 29 to 37.
const FOLD: &str = "type = \"revolute\"\nparent = \"inner\"\nchild = \"outer\"\naxis = [0, 2, 0]\nstart_angle_deg = \
                    170\n[joint.fold.motor]\nstiffness_N_m_rad = 0.026\n[joint.fold.latch]\nstiffness_ratio = 1e4\n";

/// The small model with another joint between its bodies: lines from 29 on.
fn model(joint: &str) -> String {
    with(FOLD, &format!("{joint}\nchild = \"outer\"\n"))
}

fn message(joint: &str) -> String {
    message_of(&model(joint))
}

/// The joint of an accepted file.
#[track_caller]
fn spatial(joint: &str) -> Spatial {
    let machine = config::parse(&model(joint), "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    let body = machine.bodies.iter().find(|body| body.name == "outer").unwrap();
    let JointKind::Spatial(spatial) = &body.joint.kind else { panic!("{:?}", body.joint.kind) };
    (**spatial).clone()
}

const UNIVERSAL: &str = "type = \"universal\"\nparent = \"inner\"\naxis = [0, 3, 0]";
const BALL: &str = "type = \"ball\"\nparent = \"inner\"";
const FREE: &str = "type = \"free\"\nparent = \"root\"";

#[test]
fn accepted_joints_mean_what_they_say() {
    let universal = spatial(&format!(
        "{UNIVERSAL}\nbody_axis = [0, 0, 0.5]\nmount_rotation_deg = [0, 90, 0]\nstart_angular_velocity_deg_s = [0, 180, \
         0]\nmotor = {{ stiffness_N_m_rad = 2, damping_N_m_s_rad = 0.5 }}"
    ));
    assert_eq!(
        universal,
        Spatial {
            freedom: SpatialFreedom::Universal { parent_axis: Vector3::y(), body_axis: Vector3::z() },
            stiffness_n_m_rad: 2.0,
            damping_n_m_s_rad: 0.5,
            start_angular_velocity_rad_s: Vector3::y() * std::f64::consts::PI,
            start_velocity_m_s: Vector3::zeros(),
        }
    );
    let ball = spatial(&format!("{BALL}\nstart_angular_velocity_deg_s = [0, 0, 360]"));
    assert_eq!(ball.freedom, SpatialFreedom::Ball);
    assert_eq!((ball.stiffness_n_m_rad, ball.damping_n_m_s_rad), (0.0, 0.0));
    assert_eq!(ball.start_angular_velocity_rad_s, Vector3::z() * std::f64::consts::TAU);
    let free = spatial(&format!("{FREE}\nroot_position_m = [0, 0, 5]\nstart_velocity_m_s = [10, 0, 1]"));
    assert_eq!((free.freedom, free.start_velocity_m_s), (SpatialFreedom::Free, Vector3::new(10.0, 0.0, 1.0)));
}

/// Round-off of a velocity normal to both axes is removed: the start is consistent.
#[test]
fn rounded_start_velocities_are_made_consistent() {
    let joint = spatial(&format!("{UNIVERSAL}\nbody_axis = [0, 0, 1]\nstart_angular_velocity_deg_s = [1e-4, 30, 40]"));
    let spin = joint.start_angular_velocity_rad_s.map(f64::to_degrees);
    assert!((spin - Vector3::new(0.0, 30.0, 40.0)).amax() < 1e-12, "{spin}");
}

/// Axes of a universal joint: both given, none zero, not parallel in the start attitude.
#[test]
fn universal_axes() {
    assert_eq!(
        message(UNIVERSAL),
        "wing.toml:28: key 'joint.fold.body_axis' is missing; allowed: an array of 3 finite numbers, not all 0"
    );
    assert_eq!(
        message("type = \"universal\"\nparent = \"inner\"\nbody_axis = [0, 0, 1]"),
        "wing.toml:28: key 'joint.fold.axis' is missing; allowed: an array of 3 finite numbers, not all 0"
    );
    assert_eq!(
        message(&format!("{UNIVERSAL}\nbody_axis = [0, 0, 0]")),
        "wing.toml:32: key 'joint.fold.body_axis': [0, 0, 0] is not allowed; allowed: an array of 3 finite numbers, not \
         all 0"
    );
    assert_eq!(
        message("type = \"universal\"\nparent = \"inner\"\naxis = [0, 0, 0]\nbody_axis = [0, 0, 1]"),
        "wing.toml:31: key 'joint.fold.axis': [0, 0, 0] is not allowed; allowed: an array of 3 finite numbers, not all 0"
    );
    assert_eq!(
        message(&format!("{UNIVERSAL}\nbody_axis = [0, 1, 0.04]")),
        "wing.toml:32: key 'joint.fold.body_axis': [0, 1, 0.04] is not allowed; allowed: an array of 3 finite numbers that after mount_rotation_deg is not parallel to axis"
    );
    // a rotation by 90° about x moves the body's −z onto the parent's y
    assert_eq!(
        message(&format!("{UNIVERSAL}\nmount_rotation_deg = [90, 0, 0]\nbody_axis = [0, 0, -1]")),
        "wing.toml:33: key 'joint.fold.body_axis': [0, 0, -1] is not allowed; allowed: an array of 3 finite numbers that after mount_rotation_deg is not parallel to axis"
    );
}

/// A universal joint cannot rotate about the normal to both of its axes.
#[test]
fn universal_start_velocity() {
    assert_eq!(
        message(&format!("{UNIVERSAL}\nbody_axis = [0, 0, 1]\nstart_angular_velocity_deg_s = [1, 30, 40]")),
        "wing.toml:33: key 'joint.fold.start_angular_velocity_deg_s': [1, 30, 40] is not allowed; allowed: rates in \
         deg/s about axis and body_axis only: the component must be zero along [1, 0, 0]"
    );
}

/// A free joint can attach a body only to the root frame.
#[test]
fn free_parent() {
    assert_eq!(
        message("type = \"free\"\nparent = \"inner\""),
        "wing.toml:30: key 'joint.fold.parent': \"inner\" is not allowed; allowed: \"root\" (a free joint cannot have \
         a body as its parent; use another joint type to attach one body to another)"
    );
}

/// Keys that a joint of this type does not have are each rejected by name.
#[test]
fn foreign_keys() {
    let refusal = |line: usize, key: &str, value: &str, types: &str| {
        format!(
            "wing.toml:{line}: key 'joint.fold.{key}': {value} is not allowed; allowed: this key only with type = {types}"
        )
    };
    for (key, value) in [
        ("start_angle_deg", "5"),
        ("start_rate_deg_s", "5"),
        ("release", "true"),
        ("motion", "\"free\""),
        ("polynomial_deg", "[1, 2]"),
        ("table_s_deg", "[[0, 0], [1, 1]]"),
    ] {
        for (joint, line) in [(format!("{UNIVERSAL}\nbody_axis = [0, 0, 1]"), 33), (BALL.into(), 31), (FREE.into(), 31)]
        {
            let types = match key {
                "release" | "motion" => "\"revolute\" or \"prismatic\" or \"sliding\"",
                _ => "\"revolute\"",
            };
            assert_eq!(message(&format!("{joint}\n{key} = {value}")), refusal(line, key, value, types));
        }
    }
    for (joint, line) in [(format!("{UNIVERSAL}\nbody_axis = [0, 0, 1]"), 33), (BALL.into(), 31), (FREE.into(), 31)] {
        let latch = "latch = { stiffness_N_m_rad = 200 }";
        assert_eq!(
            message(&format!("{joint}\n{latch}")),
            refusal(line, "latch", "a table", "\"revolute\" or \"prismatic\" or \"sliding\"")
        );
    }
    for joint in [BALL, FREE] {
        assert_eq!(
            message(&format!("{joint}\naxis = [0, 1, 0]")),
            refusal(31, "axis", "[0, 1, 0]", "\"revolute\" or \"prismatic\" or \"universal\" or \"cylindrical\"")
        );
        assert_eq!(
            message(&format!("{joint}\nbody_axis = [0, 1, 0]")),
            refusal(31, "body_axis", "[0, 1, 0]", "\"universal\"")
        );
    }
    assert_eq!(
        message(&format!("{BALL}\nstart_velocity_m_s = [0, 1, 0]")),
        refusal(31, "start_velocity_m_s", "[0, 1, 0]", "\"free\"")
    );
    assert_eq!(
        message(&format!("{FREE}\nmotor = {{ stiffness_N_m_rad = 1 }}")),
        refusal(31, "motor", "a table", "\"revolute\" or \"prismatic\" or \"sliding\" or \"universal\" or \"ball\"")
    );
    assert_eq!(
        message("type = \"revolute\"\nparent = \"inner\"\naxis = [0, 1, 0]\nstart_angular_velocity_deg_s = [0, 1, 0]"),
        refusal(32, "start_angular_velocity_deg_s", "[0, 1, 0]", "\"universal\" or \"ball\" or \"free\"")
    );
}

/// Keys in m and N on a joint that rotates, in deg and N·m on one that slides: rejected, with the correct key.
#[test]
fn keys_of_the_other_travel() {
    let slide = |keys: &str| message(&format!("type = \"prismatic\"\nparent = \"inner\"\naxis = [0, 1, 0]\n{keys}"));
    let hinge = |keys: &str| message(&format!("type = \"revolute\"\nparent = \"inner\"\naxis = [0, 1, 0]\n{keys}"));
    assert_eq!(slide("start_position_m = 0.1\nmotor.stiffness_N_m = 1\nlatch.stiffness_ratio = 10"), "accepted");
    for (found, key, value, allowed) in [
        (slide("start_angle_deg = 5"), "start_angle_deg", "5", "this key only with type = \"revolute\""),
        (
            hinge("start_position_m = 5"),
            "start_position_m",
            "5",
            "this key only with type = \"prismatic\" or \"sliding\"",
        ),
        (slide("polynomial_deg = [1]"), "polynomial_deg", "[1]", "this key only with type = \"revolute\""),
        (
            slide("motor.stiffness_N_m_rad = 5"),
            "motor.stiffness_N_m_rad",
            "5",
            "stiffness_N_m instead: the keys of a prismatic joint are in m and N",
        ),
        (
            hinge("spring.rest_position_m = 5"),
            "spring.rest_position_m",
            "5",
            "rest_angle_deg instead: the keys of a revolute joint are in deg and N·m",
        ),
        (slide("motor.force_limit_N = -1"), "motor.force_limit_N", "-1", "a finite force >= 0 N"),
        (slide("motor.mass_kg = -1"), "motor.mass_kg", "-1", "a finite mass >= 0 kg"),
        (slide("start_position_m = inf"), "start_position_m", "inf", "a finite length in m"),
        (
            slide("latch = { stiffness_ratio = 10 }"),
            "latch.stiffness_ratio",
            "10",
            "a ratio only with a motor or a spring of stiffness > 0; write stiffness_N_m (N/m) instead",
        ),
        (
            slide("release = false\nstart_rate_m_s = 1"),
            "start_rate_m_s",
            "1",
            "a rate of 0 m/s if the joint is locked, prescribed or not released at the start",
        ),
    ] {
        let expected = format!("key 'joint.fold.{key}': {value} is not allowed; allowed: {allowed}");
        assert!(found.ends_with(&expected), "{found}\nexpected {expected}");
    }
}

/// Keys of a revolute joint's motor are invalid on other joints.
#[test]
fn foreign_drive_keys() {
    for key in ["constant_torque_N_m", "torque_limit_N_m", "rate_limit_deg_s", "command_deg"] {
        for (joint, line) in [(format!("{UNIVERSAL}\nbody_axis = [0, 0, 1]"), 35), (BALL.to_owned(), 33)] {
            // a table ends the keys of the joint itself
            let text = with(FOLD, &format!("{joint}\nchild = \"outer\"\n[joint.fold.motor]\n{key} = 1\n"));
            assert_eq!(
                message_of(&text),
                format!(
                    "wing.toml:{line}: key 'joint.fold.motor.{key}': 1 is not allowed; allowed: this key only with type = \
                     \"revolute\""
                )
            );
        }
    }
}

/// The explicit method has no error estimate: it needs a fixed step.
#[test]
fn explicit_method_needs_a_fixed_step() {
    assert_eq!(
        message_of(&with("tolerance = 1e-4", "method = \"rk4\"")),
        "wing.toml:47: key 'solver.fixed_step_s' is missing; allowed: a finite time > 0 s: method = \"rk4\" has no \
         error estimate for choosing steps"
    );
    for method in ["rk4", "esdirk4", "generalized_alpha"] {
        let text = with("tolerance = 1e-4", &format!("method = \"{method}\"\nfixed_step_s = 1e-4"));
        assert_eq!(message_of(&text), "accepted", "{method}");
    }
}

/// Real-time mode: its method, its default step, and its errors.
#[test]
fn real_time_mode() {
    let solver = |keys: &str| message_of(&with("tolerance = 1e-4", keys));
    assert_eq!(
        solver("mode = \"real_time\"\nmethod = \"esdirk4\""),
        "wing.toml:49: key 'solver.method': \"esdirk4\" is not allowed; allowed: \"sdirk2\", or no method, with mode = \
         \"real_time\": with fixed steps the other methods do not damp the vibration of stiff modes after a jump of \
         the accelerations"
    );
    assert_eq!(
        solver("max_iterations = 3"),
        "wing.toml:48: key 'solver.max_iterations': 3 is not allowed; allowed: this key only with mode = \"real_time\""
    );
    assert_eq!(
        solver("mode = \"real_time\"\nmax_iterations = 11"),
        "wing.toml:49: key 'solver.max_iterations': 11 is not allowed; allowed: a whole number from 1 to 10"
    );
    assert_eq!(
        solver("mode = \"real_time\"\nmethod = \"sdirk2\"\nfixed_step_s = 5e-4\nmax_iterations = 6"),
        "accepted"
    );
    let text = with("tolerance = 1e-4", "mode = \"real_time\"");
    let solver = config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}")).solver;
    assert_eq!((solver.method, solver.fixed_step_s, solver.most_iterations), (Method::Sdirk2, Some(1e-3), Some(4)));
}

/// DC motors: the constant in the unit of the joint, a joint that moves freely, and no failure of the current.
#[test]
fn electrical_motors() {
    const LATCH: &str = "[joint.fold.latch]\n";
    const MOTOR: &str = "[joint.fold.dc_motor]\nresistance_ohm = 1\ninductance_H = 1e-3\n";
    assert_eq!(
        message_of(&with(LATCH, &format!("{MOTOR}{LATCH}"))),
        "wing.toml:36: key 'joint.fold.dc_motor.torque_constant_N_m_A' is missing; allowed: a finite torque constant > 0 N·m/A"
    );
    let whole = with(LATCH, &format!("{MOTOR}torque_constant_N_m_A = 0.1\n{LATCH}"));
    assert_eq!(message_of(&whole), "accepted");
    let locked = whole.replacen(&format!("{LATCH}stiffness_ratio = 1e4\n"), "", 1).replacen(
        "start_angle_deg = 170\n",
        "start_angle_deg = 170\nmotion = \"locked\"\n",
        1,
    );
    assert_eq!(
        message_of(&locked),
        "wing.toml:37: key 'joint.fold.dc_motor': a DC motor on a joint that does not move freely is not allowed; \
         allowed: a dc_motor only with motion = \"free\""
    );
    let lost = whole.replacen(
        "[gauge.root]",
        "[failure.lost]\nkind = \"motor_loss\"\njoint = \"fold\"\nat_time_s = 1\n[gauge.root]",
        1,
    );
    assert_eq!(
        message_of(&lost),
        "wing.toml:49: key 'failure.lost.joint': a joint with a DC motor is not allowed; allowed: a joint without dc_motor: \
         its current does not stop by a failure; set its voltage during the run"
    );
}
