//! Checks of electrical DC motors.

use crate::machine::fault::{Checker, Range};
use crate::machine::units::shortest;
use crate::machine::{DcMotor, JointMotion, OneFreedom, Travel};

/// Checks the DC motor of a joint.
pub(super) fn check(name: &str, travel: Travel, joint: &OneFreedom, own: &DcMotor, checker: &mut Checker) {
    let place = |key| ["joint", name, "dc_motor", key];
    if joint.motion != JointMotion::Free {
        let found = "a DC motor on a joint that does not move freely";
        checker.refuse_state(&["joint", name, "dc_motor"], found, "a dc_motor only with motion = \"free\"");
    }
    let constant = travel.words("torque_constant_n_m_a");
    for (key, value, range) in [
        ("resistance_ohm", own.resistance_ohm, Range::Above(0.0)),
        (&*constant, own.torque_constant_n_m_a, Range::Above(0.0)),
        ("voltage_v", own.voltage_v, Range::Finite),
        ("start_current_a", own.start_current_a, Range::Finite),
    ] {
        checker.number(&place(key), value, range);
    }
    if own.inductance_h == 0.0 {
        // the current would follow from the rate without a state
        let allowed = travel.words(
            "an inductance > 0; without inductance the motor is a damper: omit dc_motor, give the joint a spring with the damping \
             (K N)²/R, and set its external torque to K N/R times the voltage",
        );
        checker.refuse(&place("inductance_h"), "0", allowed);
    } else {
        checker.number(&place("inductance_h"), own.inductance_h, Range::Above(0.0));
    }
    match travel {
        Travel::Translation if own.gear_ratio != 1.0 => {
            let allowed = "1 on a prismatic or sliding joint: its force constant refers to the joint";
            checker.refuse(&place("gear_ratio"), shortest(own.gear_ratio), allowed);
        }
        Travel::Rotation if !(1e-6..=1e6).contains(&own.gear_ratio.abs()) => {
            checker.refuse(&place("gear_ratio"), shortest(own.gear_ratio), "a ratio of a magnitude from 1e-6 to 1e6");
        }
        Travel::Translation | Travel::Rotation => {}
    }
}
