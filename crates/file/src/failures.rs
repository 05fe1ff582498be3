//! Failures of the file told to a [`MachineBuilder`].

use crate::failure_file::{FailureFile, FailureKind, WhenFile};
use crate::file::ModelFile;
use crate::joint_file::JointType;
use crate::validate::Checker;
use foldwing_engine::machine::builder::{FailureBuilder, MachineBuilder};
use foldwing_engine::machine::failure::{BoundSide, FrictionBrake, Quantity};
use foldwing_engine::machine::units::quoted;
use foldwing_engine::machine::{Failure, Travel};

/// Keys of a bound: what it bounds, on which side, of which joints.
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

/// Rate in rad/s and m/s beyond which a brake slips that says nothing of it.
const SLIP: [f64; 2] = [0.5 * std::f64::consts::PI / 180.0, 1e-3];

/// Adds them to a machine; what is refused is left out.
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

/// How a joint of the file moves; by turns where there is none of that name.
fn travel(file: &ModelFile, joint: &str) -> Travel {
    file.joint.get(joint).map_or(JointType::Revolute, |joint| joint.kind).travel().unwrap_or(Travel::Rotation)
}

fn build(name: &str, failure: &FailureFile, file: &ModelFile, checker: &mut Checker) -> Option<FailureBuilder> {
    use FailureKind as Kind;
    let place = |key| ["failure", name, key];
    refuse_strangers(name, failure, checker);
    let (target, key) = match failure.kind {
        Kind::LoopOpens => (&failure.closure, "loop"),
        Kind::BodyWeakens => (&failure.body, "body"),
        Kind::DriveDies
        | Kind::DriveJams
        | Kind::DriveRunsAway
        | Kind::LatchBreaks
        | Kind::LatchDoesNotCatch
        | Kind::StopperOpens
        | Kind::SpringBreaks
        | Kind::BrakeComesOn => (&failure.joint, "joint"),
    };
    let Some(target) = target else {
        checker.refuse(&place(key), format!("the name of a {key}"));
        return None;
    };
    let travel = travel(file, target);
    // keys of a joint that turns and of one that slides, and what their values are in SI
    let mut of_travel = |keys: [&'static str; 2], values: [Option<f64>; 2], or: Option<[f64; 2]>| {
        let (own, other) = if travel == Travel::Rotation { (0, 1) } else { (1, 0) };
        if values[other].is_some() {
            checker
                .refuse(&place(keys[other]), format!("this key only on the other kind of joint; write {}", keys[own]));
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
        Kind::DriveDies => Failure::drive_dies(name, target),
        Kind::DriveJams => Failure::drive_jams(name, target),
        Kind::DriveRunsAway => {
            let to_rad = of_travel(["to_deg", "to_m"], [turned(failure.to_deg), failure.to_m], None);
            let rates = [turned(failure.rate_deg_s), failure.rate_m_s];
            let rate_rad_s = of_travel(["rate_deg_s", "rate_m_s"], rates, None);
            Failure::drive_runs_away(name, target, to_rad?, rate_rad_s?)
        }
        Kind::LatchBreaks => Failure::latch_breaks(name, target),
        Kind::LatchDoesNotCatch => Failure::latch_does_not_catch(name, target),
        Kind::StopperOpens => Failure::stopper_opens(name, target),
        Kind::SpringBreaks => Failure::spring_weakens(name, target, failure.remaining.unwrap_or(0.0)),
        Kind::LoopOpens => Failure::loop_weakens(name, target, failure.remaining.unwrap_or(0.0)),
        Kind::BodyWeakens => {
            let Some(remaining) = failure.remaining else {
                checker.refuse(&place("remaining"), "a share from 1e-6 to 1");
                return None;
            };
            Failure::body_weakens(name, target, remaining)
        }
        Kind::BrakeComesOn => {
            let torque_n_m = of_travel(["torque_N_m", "force_N"], [failure.torque_n_m, failure.force_n], None);
            let slips = [turned(failure.slip_deg_s), failure.slip_m_s];
            let slip_rad_s = of_travel(["slip_deg_s", "slip_m_s"], slips, Some(SLIP));
            let brake = FrictionBrake {
                torque_n_m: torque_n_m?,
                ramp_s: failure.ramp_s.unwrap_or(0.0),
                slip_rad_s: slip_rad_s?,
            };
            Failure::brake_comes_on(name, target, brake)
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

/// Refuses keys that the kind does not have.
fn refuse_strangers(name: &str, failure: &FailureFile, checker: &mut Checker) {
    use FailureKind as Kind;
    let on_joint = !matches!(failure.kind, Kind::LoopOpens | Kind::BodyWeakens);
    let runs = failure.kind == Kind::DriveRunsAway;
    let brakes = failure.kind == Kind::BrakeComesOn;
    let weakens = matches!(failure.kind, Kind::SpringBreaks | Kind::LoopOpens | Kind::BodyWeakens);
    let stated = [
        ("joint", failure.joint.is_some(), on_joint, "of failures on joints"),
        ("loop", failure.closure.is_some(), failure.kind == Kind::LoopOpens, "with kind = \"loop_opens\""),
        ("body", failure.body.is_some(), failure.kind == Kind::BodyWeakens, "with kind = \"body_weakens\""),
        ("to_deg", failure.to_deg.is_some(), runs, "with kind = \"drive_runs_away\""),
        ("to_m", failure.to_m.is_some(), runs, "with kind = \"drive_runs_away\""),
        ("rate_deg_s", failure.rate_deg_s.is_some(), runs, "with kind = \"drive_runs_away\""),
        ("rate_m_s", failure.rate_m_s.is_some(), runs, "with kind = \"drive_runs_away\""),
        (
            "remaining",
            failure.remaining.is_some(),
            weakens,
            "with kind = \"spring_breaks\", \"loop_opens\" or \"body_weakens\"",
        ),
        ("torque_N_m", failure.torque_n_m.is_some(), brakes, "with kind = \"brake_comes_on\""),
        ("force_N", failure.force_n.is_some(), brakes, "with kind = \"brake_comes_on\""),
        ("ramp_s", failure.ramp_s.is_some(), brakes, "with kind = \"brake_comes_on\""),
        ("slip_deg_s", failure.slip_deg_s.is_some(), brakes, "with kind = \"brake_comes_on\""),
        ("slip_m_s", failure.slip_m_s.is_some(), brakes, "with kind = \"brake_comes_on\""),
    ];
    for (key, _, _, allowed) in stated.into_iter().filter(|(_, stated, fits, _)| *stated && !fits) {
        checker.refuse(&["failure", name, key], format!("this key only {allowed}"));
    }
}

/// What a bound bounds, on which side, and where it lies in SI.
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
