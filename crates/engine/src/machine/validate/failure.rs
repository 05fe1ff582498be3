//! Checks of failures: the parts on which they act, triggers and numbers.

use crate::machine::failure::{Bound, Effect, Failure};
use crate::machine::fault::{Checker, Range};
use crate::machine::units::shortest;
use crate::machine::{Body, JointKind, JointMotion, Machine, Method, OneFreedom, Travel};

/// Maximum number of failures of a machine, and of bounds on the motion of one joint.
const MAXIMUM_FAILURES: usize = 100;
const MAXIMUM_BOUNDS: usize = 16;
/// Maximum rate of a runaway in rad/s or m/s.
const FASTEST: f64 = 1e6;
/// Minimum remaining fraction of the stiffness of a body, below which the equations cannot be solved in double precision.
const MINIMUM_SHARE: f64 = 1e-6;

/// Checks all failures.
pub(super) fn check(machine: &Machine, checker: &mut Checker) {
    super::names("failure", machine.failures.iter().map(|failure| failure.name.as_str()), checker);
    if machine.failures.len() > MAXIMUM_FAILURES {
        let state = format!("{} failures", machine.failures.len());
        checker.refuse_state(&["failure"], state, format!("at most {MAXIMUM_FAILURES}"));
    }
    for (index, failure) in machine.failures.iter().enumerate() {
        check_one(machine, index, failure, checker);
    }
    for body in 0..machine.bodies.len() {
        let mut bounds = machine.failures.iter().filter(|failure| failure.when.is_some_and(|bound| bound.body == body));
        if let Some(failure) = bounds.nth(MAXIMUM_BOUNDS) {
            let allowed = format!("at most {MAXIMUM_BOUNDS} failures that wait for the motion of one joint");
            checker.refuse_state(&["failure", &failure.name, "when"], "one bound too many on its joint", allowed);
        }
    }
}

fn check_one(machine: &Machine, index: usize, failure: &Failure, checker: &mut Checker) {
    let name = failure.name.as_str();
    let place = |key| ["failure", name, key];
    if let Some(at_s) = failure.at_time_s {
        checker.number(&place("at_time_s"), at_s, Range::Finite);
    }
    checker.number(&place("delay_s"), failure.delay_s, Range::AtLeast(0.0));
    if let Some(after) = failure.after
        && (after == index || after >= machine.failures.len())
    {
        let found = machine.failures.get(after).map_or(format!("failure {after}"), |other| format!("{:?}", other.name));
        checker.refuse(&place("after"), found, "the name of another failure");
    }
    effect(machine, name, &failure.effect, checker);
    if let Some(bound) = &failure.when {
        check_bound(machine, name, bound, checker);
    }
}

/// A joint with one degree of freedom and free motion; otherwise an error.
fn free_joint<'m>(
    machine: &'m Machine,
    place: &[&str],
    body: usize,
    checker: &mut Checker,
) -> Option<(Travel, &'m OneFreedom)> {
    let Some(Body { joint, .. }) = machine.bodies.get(body) else {
        checker.refuse_state(place, format!("body {body}"), format!("one of the {} bodies", machine.bodies.len()));
        return None;
    };
    let found = joint.kind.one_freedom().filter(|(_, own)| own.motion == JointMotion::Free);
    if found.is_none() {
        let allowed = "a revolute or prismatic joint with motion = \"free\"";
        checker.refuse(place, format!("{:?}", joint.name), allowed);
    }
    found
}

fn effect(machine: &Machine, name: &str, effect: &Effect, checker: &mut Checker) {
    let joint = ["failure", name, "joint"];
    let share = |key: &str, value: f64, least: f64, checker: &mut Checker| {
        checker.number(&["failure", name, key], value, Range::Within(least, 1.0));
    };
    match *effect {
        Effect::MotorLoss { body } => {
            let own = free_joint(machine, &joint, body, checker);
            if own.is_some_and(|(_, own)| own.dc_motor.is_some()) {
                let allowed =
                    "a joint without dc_motor: its current does not stop by a failure; set its voltage during the run";
                checker.refuse_state(&joint, "a joint with a DC motor", allowed);
            }
        }
        Effect::MotorJam { body } | Effect::LockRelease { body } => {
            free_joint(machine, &joint, body, checker);
        }
        Effect::MotorRunaway { body, to_rad, rate_rad_s } => {
            let Some((travel, own)) = free_joint(machine, &joint, body, checker) else { return };
            checker.number(&["failure", name, &travel.words("to_rad")], to_rad, Range::Finite);
            let key = travel.words("rate_rad_s");
            if checker.number(&["failure", name, &key], rate_rad_s, Range::Above(0.0)) && rate_rad_s > FASTEST {
                let allowed = travel.words(&format!("a rate up to {} rad/s", shortest(FASTEST)));
                checker.refuse(&["failure", name, &key], shortest(rate_rad_s), allowed);
            }
            if own.motor.stiffness_n_m_rad == 0.0 {
                let allowed = "a joint whose motor has a stiffness: without one the neutral angle has no effect";
                checker.refuse_state(&joint, "a motor without stiffness", travel.words(allowed));
            }
        }
        Effect::LatchBreak { body } | Effect::LatchNoCapture { body } => {
            let own = free_joint(machine, &joint, body, checker);
            if own.is_some_and(|(_, own)| own.latch.is_none()) {
                checker.refuse_state(&joint, "a joint without a latch", "a joint with a latch");
            }
        }
        Effect::SpringBreak { body, remaining } => {
            share("remaining_fraction", remaining, 0.0, checker);
            let spatial = machine.bodies.get(body).map(|body| &body.joint.kind);
            if let Some(JointKind::Spatial(own)) = spatial {
                if own.stiffness_n_m_rad == 0.0 && own.damping_n_m_s_rad == 0.0 {
                    checker.refuse_state(&joint, "a joint without a spring", "a joint with a spring or a damper");
                }
                return;
            }
            let own = free_joint(machine, &joint, body, checker);
            if own.is_some_and(|(_, own)| own.spring.is_none()) {
                let allowed = "a joint with a spring, [joint.<name>.spring]";
                checker.refuse_state(&joint, "a joint without a spring", allowed);
            }
        }
        Effect::LoopBreak { closure, remaining } => {
            share("remaining_fraction", remaining, 0.0, checker);
            if closure >= machine.closures.len() {
                let allowed = format!("one of the {} loops", machine.closures.len());
                checker.refuse_state(&["failure", name, "loop"], format!("loop {closure}"), allowed);
            } else if machine.closures[closure].rigid {
                let allowed = "a loop with a penalty, stiffness_N_m: constraint forces have none to weaken";
                checker.refuse(&["failure", name, "loop"], format!("{:?}", machine.closures[closure].name), allowed);
            }
        }
        Effect::StiffnessLoss { body, remaining } => {
            share("remaining_fraction", remaining, MINIMUM_SHARE, checker);
            let place = ["failure", name, "body"];
            match machine.bodies.get(body) {
                Some(body) if body.is_rigid() || body.is_modal() => {
                    checker.refuse(&place, format!("{:?}", body.name), "a beam, a table [body.<name>]");
                }
                None => {
                    let allowed = format!("one of the {} bodies", machine.bodies.len());
                    checker.refuse_state(&place, format!("body {body}"), allowed);
                }
                Some(_) => {}
            }
        }
        Effect::BrakeApplied { body, brake } => {
            let Some((travel, _)) = free_joint(machine, &joint, body, checker) else { return };
            // the brake torque would alternate between both signs at full magnitude, and the rate would not decay
            if machine.solver.method == Method::Rk4 {
                let allowed =
                    "an implicit method, e.g. solver.method = \"esdirk4\": below its slip rate a brake is stiff";
                checker.refuse_state(&["failure", name, "kind"], "a brake with solver.method = \"rk4\"", allowed);
            }
            for (key, value, range) in [
                ("torque_n_m", brake.torque_n_m, Range::Above(0.0)),
                ("ramp_s", brake.ramp_s, Range::AtLeast(0.0)),
                ("slip_rad_s", brake.slip_rad_s, Range::Above(0.0)),
            ] {
                checker.number(&["failure", name, &travel.words(key)], value, range);
            }
        }
    }
}

fn check_bound(machine: &Machine, name: &str, bound: &Bound, checker: &mut Checker) {
    if free_joint(machine, &["failure", name, "when", "joint"], bound.body, checker).is_some() {
        checker.number(&["failure", name, "when", "value"], bound.value, Range::Finite);
    }
}
