//! Failures in the model file: errors, and the meaning of an accepted file.

use crate::model_file::{MODEL, message_of};
use foldwing::config;
use foldwing::machine::failure::{Bound, BoundSide, Quantity};
use foldwing::machine::{Effect, Failure};

/// A failure appended to the small model, whose fold joint holds its second body.
fn model(lines: &str) -> String {
    format!("{MODEL}[failure.motor]\n{lines}\n")
}

#[test]
fn accepted_failures_mean_what_they_say() {
    let text = model(
        "kind = \"motor_runaway\"\njoint = \"fold\"\nto_deg = 180\nrate_deg_s = 90\nat_time_s = 0.1\ndelay_s = 0.02\nwhen = { joint = \
         \"fold\", rate_below_deg_s = -360 }",
    ) + "[failure.latch]\nkind = \"latch_break\"\njoint = \"fold\"\nafter = \"motor\"\n";
    let machine = config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    let pi = std::f64::consts::PI;
    let bound = Bound { body: 1, quantity: Quantity::Rate, value: -2.0 * pi, side: BoundSide::Below };
    assert_eq!(
        machine.failures,
        [
            Failure {
                name: "motor".into(),
                effect: Effect::MotorRunaway { body: 1, to_rad: pi, rate_rad_s: 0.5 * pi },
                at_time_s: Some(0.1),
                after: None,
                when: Some(bound),
                delay_s: 0.02,
            },
            Failure {
                name: "latch".into(),
                effect: Effect::LatchBreak { body: 1 },
                at_time_s: None,
                after: Some(0),
                when: None,
                delay_s: 0.0,
            },
        ]
    );
}

/// Messages for lines of a failure, with their locations.
#[test]
fn refusals_name_place_and_cure() {
    for (lines, key, part) in [
        ("kind = \"motor_loss\"", "failure.motor.joint", "the name of a joint"),
        ("kind = \"motor_loss\"\njoint = \"fald\"", "failure.motor.joint", "did you mean \"fold\"?"),
        ("kind = \"motor_loss\"\njoint = \"mount\"", "failure.motor.joint", "motion = \"free\""),
        ("kind = \"motor_los\"\njoint = \"fold\"", "failure.motor.kind", "motor_loss"),
        ("kind = \"motor_loss\"\njoint = \"fold\"\ndelay_s = -1", "failure.motor.delay_s", ">= 0"),
        ("kind = \"motor_loss\"\njoint = \"fold\"\nafter = \"motor\"", "failure.motor.after", "another failure"),
        (
            "kind = \"motor_loss\"\njoint = \"fold\"\nremaining_fraction = 0.5",
            "failure.motor.remaining_fraction",
            "this key only with",
        ),
        ("kind = \"motor_runaway\"\njoint = \"fold\"\nrate_deg_s = 1", "failure.motor.to_deg", "a number"),
        ("kind = \"motor_runaway\"\njoint = \"fold\"\nto_m = 1\nrate_deg_s = 1", "failure.motor.to_m", "write to_deg"),
        (
            "kind = \"motor_runaway\"\njoint = \"fold\"\nto_deg = 1\nrate_deg_s = 1e9",
            "failure.motor.rate_deg_s",
            "a rate up to",
        ),
        ("kind = \"spring_break\"\njoint = \"fold\"", "failure.motor.joint", "[joint.<name>.spring]"),
        ("kind = \"loop_break\"\nloop = \"pin\"", "failure.motor.loop", "a loop"),
        ("kind = \"stiffness_loss\"\nbody = \"outer\"", "failure.motor.remaining_fraction", "a fraction"),
        (
            "kind = \"stiffness_loss\"\nbody = \"outer\"\nremaining_fraction = 0",
            "failure.motor.remaining_fraction",
            "from 1e-6 to 1",
        ),
        ("kind = \"brake_applied\"\njoint = \"fold\"", "failure.motor.torque_N_m", "a number"),
        (
            "kind = \"motor_jam\"\njoint = \"fold\"\nwhen = { joint = \"fold\" }",
            "failure.motor.when",
            "angle_above_deg",
        ),
        (
            "kind = \"motor_jam\"\njoint = \"fold\"\nwhen = { joint = \"fold\", position_above_m = 1 }",
            "failure.motor.when.position_above_m",
            "angle_above_deg",
        ),
        (
            "kind = \"motor_jam\"\njoint = \"fold\"\nwhen = { joint = \"mount\", angle_above_deg = 1 }",
            "failure.motor.when.joint",
            "motion = \"free\"",
        ),
    ] {
        let message = message_of(&model(lines));
        assert!(message.contains(&format!("key '{key}'")) && message.contains(part), "{lines}\n{message}");
        assert_eq!(message.lines().count(), 1, "one fault: {message}");
    }
}

/// A failure after an invalid one: only the invalid one is reported.
#[test]
fn failures_after_an_invalid_one_are_not_reported() {
    let text = format!(
        "{}\n[failure.second]\nkind = \"motor_loss\"\njoint = \"fold\"\nafter = \"motor\"\n",
        model("kind = \"brake_applied\"\njoint = \"fold\"")
    );
    let message = message_of(&text);
    assert!(message.contains("key 'failure.motor.torque_N_m'"), "{message}");
    assert_eq!(message.lines().count(), 1, "one fault: {message}");
    let valid = text.replacen("brake_applied", "motor_jam", 1);
    config::parse(&valid, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
}

/// The slip of a brake is stiff: an explicit method would alternate between full torques in both directions.
#[test]
fn a_brake_with_an_explicit_method_is_refused() {
    let brake = model("kind = \"brake_applied\"\njoint = \"fold\"\ntorque_N_m = 1");
    config::parse(&brake, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    let message = message_of(&brake.replacen("[solver]", "[solver]\nmethod = \"rk4\"\nfixed_step_s = 1e-4", 1));
    assert!(message.contains("key 'failure.motor.kind'") && message.contains("an implicit method"), "{message}");
    assert_eq!(message.lines().count(), 1, "one fault: {message}");
}

/// One bound more than a joint's motion may trigger failures at is rejected.
#[test]
fn too_many_bounds_on_one_joint_are_refused() {
    let one = |i: usize| {
        let when = "when = { joint = \"fold\", angle_above_deg = 1 }";
        format!("[failure.f{i}]\nkind = \"motor_loss\"\njoint = \"fold\"\n{when}\n")
    };
    let text = |count: usize| format!("{MODEL}{}", (0..count).map(one).collect::<String>());
    let accepted = config::parse(&text(16), "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(accepted.failures.len(), 16);
    let message = message_of(&text(17));
    assert!(message.contains("key 'failure.f16.when'") && message.contains("at most 16 failures"), "{message}");
}
