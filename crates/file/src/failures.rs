//! Builds the failures of the model file with a [`MachineBuilder`].

use crate::checker::Checker;
use crate::failure_file::{FailureFile, FailureKind, WhenFile};
use crate::file::ModelFile;
use foldwing_engine::machine::builder::{FailureBuilder, MachineBuilder};
use foldwing_engine::machine::failure::{BoundSide, FrictionBrake, Quantity};
use foldwing_engine::machine::units::quoted;
use foldwing_engine::machine::{Failure, Travel};

/// Keys of a limit, for each quantity, side and type of joint.
pub(super) const BOUNDS: [&str; 8] = [
    "angle_above_deg",
    "angle_below_deg",
    "rate_above_deg_s",
    "rate_below_deg_s",
    "position_above_m",
    "position_below_m",
    "rate_above_m_s",
    "rate_below_m_s",
];

/// Default slip rate of a brake in rad/s and m/s.
const SLIP: [f64; 2] = [0.5 * std::f64::consts::PI / 180.0, 1e-3];

/// Adds the failures to a machine; invalid ones are omitted.
pub(super) fn add(file: &ModelFile, mut machine: MachineBuilder, checker: &mut Checker) -> MachineBuilder {
    for (name, failure) in &file.failure {
        if let Some(built) = build(name, failure, file, checker) {
            machine = machine.failure(built);
        } else {
            checker.stands_in(&["failure"]);
        }
    }
    machine
}

/// Type of motion of a joint of the model; rotation if there is no joint with this name.
fn travel(file: &ModelFile, joint: &str) -> Travel {
    let single = file.joint.get(joint).and_then(|joint| joint.kind.travel());
    let chains = file.joint.iter().flat_map(|(name, chain)| chain.kind.freedoms().iter().map(move |own| (name, own)));
    let of_chain = || chains.into_iter().find(|(name, own)| own.joint(name) == joint).map(|(_, own)| own.travel);
    single.or_else(of_chain).unwrap_or(Travel::Rotation)
}

fn build(name: &str, failure: &FailureFile, file: &ModelFile, checker: &mut Checker) -> Option<FailureBuilder> {
    use FailureKind as Kind;
    let place = |key| ["failure", name, key];
    refuse_strangers(name, failure, checker);
    let (target, key) = match failure.kind {
        Kind::LoopBreak => (&failure.closure, "loop"),
        Kind::StiffnessLoss => (&failure.body, "body"),
        Kind::MotorLoss
        | Kind::MotorJam
        | Kind::MotorRunaway
        | Kind::LatchBreak
        | Kind::LatchNoCapture
        | Kind::LockRelease
        | Kind::SpringBreak
        | Kind::BrakeApplied => (&failure.joint, "joint"),
    };
    let Some(target) = target else {
        checker.refuse(&place(key), format!("the name of a {key}"));
        return None;
    };
    let travel = travel(file, target);
    // keys for a revolute and a prismatic joint, and their values in SI units
    let mut of_travel = |keys: [&'static str; 2], values: [Option<f64>; 2], or: Option<[f64; 2]>| {
        let (own, other) = if travel == Travel::Rotation { (0, 1) } else { (1, 0) };
        if values[other].is_some() {
            checker
                .refuse(&place(keys[other]), format!("this key only for the other type of joint; write {}", keys[own]));
            return None;
        }
        let found = values[own].or(or.map(|or| or[own]));
        if found.is_none() {
            checker.refuse(&place(keys[own]), "a number");
        }
        found
    };
    let turned = |degrees: Option<f64>| degrees.map(f64::to_radians);
    let mut built = match failure.kind {
        Kind::MotorLoss => Failure::motor_loss(name, target),
        Kind::MotorJam => Failure::motor_jam(name, target),
        Kind::MotorRunaway => {
            let to_rad = of_travel(["to_deg", "to_m"], [turned(failure.to_deg), failure.to_m], None);
            let rates = [turned(failure.rate_deg_s), failure.rate_m_s];
            let rate_rad_s = of_travel(["rate_deg_s", "rate_m_s"], rates, None);
            Failure::motor_runaway(name, target, to_rad?, rate_rad_s?)
        }
        Kind::LatchBreak => Failure::latch_break(name, target),
        Kind::LatchNoCapture => Failure::latch_no_capture(name, target),
        Kind::LockRelease => Failure::lock_release(name, target),
        Kind::SpringBreak => Failure::spring_break(name, target, failure.remaining_fraction.unwrap_or(0.0)),
        Kind::LoopBreak => Failure::loop_break(name, target, failure.remaining_fraction.unwrap_or(0.0)),
        Kind::StiffnessLoss => {
            let Some(remaining) = failure.remaining_fraction else {
                checker.refuse(&place("remaining_fraction"), "a fraction from 1e-6 to 1");
                return None;
            };
            Failure::stiffness_loss(name, target, remaining)
        }
        Kind::BrakeApplied => {
            let torque_n_m = of_travel(["torque_N_m", "force_N"], [failure.torque_n_m, failure.force_n], None);
            let slips = [turned(failure.slip_deg_s), failure.slip_m_s];
            let slip_rad_s = of_travel(["slip_deg_s", "slip_m_s"], slips, Some(SLIP));
            let brake = FrictionBrake {
                torque_n_m: torque_n_m?,
                ramp_s: failure.ramp_s.unwrap_or(0.0),
                slip_rad_s: slip_rad_s?,
            };
            Failure::brake_applied(name, target, brake)
        }
    };
    if let Some(time_s) = failure.at_time_s {
        built = built.at_time_s(time_s);
    }
    if let Some(other) = &failure.after {
        built = built.after(other);
    }
    if let Some(when) = &failure.when {
        let (quantity, side, value) = bound(name, when, file, checker)?;
        built = built.when(&when.joint, quantity, side, value);
    }
    Some(built.delay_s(failure.delay_s))
}

/// Reports keys that do not apply to the kind of failure.
fn refuse_strangers(name: &str, failure: &FailureFile, checker: &mut Checker) {
    use FailureKind as Kind;
    let on_joint = !matches!(failure.kind, Kind::LoopBreak | Kind::StiffnessLoss);
    let runs = failure.kind == Kind::MotorRunaway;
    let brakes = failure.kind == Kind::BrakeApplied;
    let weakens = matches!(failure.kind, Kind::SpringBreak | Kind::LoopBreak | Kind::StiffnessLoss);
    let stated = [
        ("joint", failure.joint.is_some(), on_joint, "for failures of joints"),
        ("loop", failure.closure.is_some(), failure.kind == Kind::LoopBreak, "with kind = \"loop_break\""),
        ("body", failure.body.is_some(), failure.kind == Kind::StiffnessLoss, "with kind = \"stiffness_loss\""),
        ("to_deg", failure.to_deg.is_some(), runs, "with kind = \"motor_runaway\""),
        ("to_m", failure.to_m.is_some(), runs, "with kind = \"motor_runaway\""),
        ("rate_deg_s", failure.rate_deg_s.is_some(), runs, "with kind = \"motor_runaway\""),
        ("rate_m_s", failure.rate_m_s.is_some(), runs, "with kind = \"motor_runaway\""),
        (
            "remaining_fraction",
            failure.remaining_fraction.is_some(),
            weakens,
            "with kind = \"spring_break\", \"loop_break\" or \"stiffness_loss\"",
        ),
        ("torque_N_m", failure.torque_n_m.is_some(), brakes, "with kind = \"brake_applied\""),
        ("force_N", failure.force_n.is_some(), brakes, "with kind = \"brake_applied\""),
        ("ramp_s", failure.ramp_s.is_some(), brakes, "with kind = \"brake_applied\""),
        ("slip_deg_s", failure.slip_deg_s.is_some(), brakes, "with kind = \"brake_applied\""),
        ("slip_m_s", failure.slip_m_s.is_some(), brakes, "with kind = \"brake_applied\""),
    ];
    for (key, _, _, allowed) in stated.into_iter().filter(|(_, stated, fits, _)| *stated && !fits) {
        checker.refuse(&["failure", name, key], format!("this key only {allowed}"));
    }
}

/// Quantity, side and value in SI units of a limit.
fn bound(name: &str, when: &WhenFile, file: &ModelFile, checker: &mut Checker) -> Option<(Quantity, BoundSide, f64)> {
    let values = [
        when.angle_above_deg,
        when.angle_below_deg,
        when.rate_above_deg_s,
        when.rate_below_deg_s,
        when.position_above_m,
        when.position_below_m,
        when.rate_above_m_s,
        when.rate_below_m_s,
    ];
    let turns = travel(file, &when.joint) == Travel::Rotation;
    let own = if turns { &BOUNDS[..4] } else { &BOUNDS[4..] };
    let stated: Vec<(usize, f64)> = values.iter().enumerate().filter_map(|(i, value)| Some((i, (*value)?))).collect();
    let &[(index, value)] = stated.as_slice() else {
        let found = if stated.is_empty() { "no bound" } else { "several bounds" };
        checker.refuse_as(&["failure", name, "when"], found, format!("one of the keys {}", quoted(own)));
        return None;
    };
    if !own.contains(&BOUNDS[index]) {
        let allowed = format!("one of the keys {} on this joint", quoted(own));
        checker.refuse(&["failure", name, "when", BOUNDS[index]], allowed);
        return None;
    }
    let quantity = if index % 4 < 2 { Quantity::Angle } else { Quantity::Rate };
    let side = if index % 2 == 0 { BoundSide::Above } else { BoundSide::Below };
    Some((quantity, side, if turns { value.to_radians() } else { value }))
}
