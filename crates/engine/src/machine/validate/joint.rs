//! Checks of joints: names, attitudes, axes, motions, motors, springs, latches, start rates.

use crate::machine::fault::{Checker, Range, array_text, is_finite};
use crate::machine::units::shortest;
use crate::machine::validate::{dc_motor, unit_vector};
use crate::machine::{
    Beyond, EndStops, GeneratorLaw, Joint, JointKind, JointMotion, Latch, LatchKind, Motion, Motor, OneFreedom, Parent,
    Spatial, SpatialFreedom, Spring, Travel, UNLIMITED,
};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Groups of the FMU's variables, which must not be names of joints.
pub const RESERVED: &[&str] = &[
    "load",
    "gravity",
    "root",
    "wind",
    "gauge",
    "internal_load",
    "loop",
    "tip",
    "station",
    "aero",
    "energy",
    "failure",
    "solver",
    "body",
    "time",
    "der",
];

/// Cosine of the angle between a universal joint's axes above which they count as parallel.
const PARALLEL: f64 = 0.999;

/// Fraction of an initial angular velocity normal to both axes of a universal joint that counts as round-off.
pub(crate) const ACROSS: f64 = 1e-4;

/// Checks a joint, except for its parent.
pub(super) fn check(joint: &Joint, checker: &mut Checker) {
    let name = joint.name.as_str();
    if RESERVED.contains(&name) {
        let allowed = format!("a name that is not one of {}", RESERVED.join(", "));
        checker.refuse_state(&["joint", name], format!("the name {name:?}"), allowed);
    }
    let turned = joint.mount.transpose() * joint.mount - Matrix3::identity();
    let proper = turned.amax() <= 1e-9 && joint.mount.determinant() > 0.0;
    if !(proper && joint.mount.iter().copied().all(is_finite)) {
        checker.refuse_state(&["joint", name, "mount"], "a matrix that is not a rotation", "a rotation matrix");
        return;
    }
    if let Some((travel, own)) = joint.kind.one_freedom() {
        check_one_freedom(name, travel, own, checker);
    }
    if let JointKind::Spatial(spatial) = &joint.kind {
        check_spatial(name, joint, spatial, checker);
    }
}

/// Range of the position of a joint: within one revolution in either direction, or unlimited.
fn stand(travel: Travel) -> Range {
    match travel {
        Travel::Rotation => Range::Within(-TAU, TAU),
        Travel::Translation => Range::Finite,
    }
}

fn check_one_freedom(name: &str, travel: Travel, joint: &OneFreedom, checker: &mut Checker) {
    unit_vector(&["joint", name, "axis"], &joint.axis, checker);
    let start = match joint.motion {
        JointMotion::Prescribed(_) => Range::Finite, // at the start of the prescribed motion
        JointMotion::Free | JointMotion::Locked => stand(travel),
    };
    checker.number(&["joint", name, &travel.words("start_angle_rad")], joint.start_angle_rad, start);
    let rate_key = travel.words("start_rate_rad_s");
    let rate = checker.number(&["joint", name, &rate_key], joint.start_rate_rad_s, Range::Finite);
    if rate && joint.start_rate_rad_s != 0.0 && (joint.motion != JointMotion::Free || !joint.release) {
        let allowed = "a rate of 0 rad/s if the joint is locked, prescribed or not released at the start";
        checker.refuse(&["joint", name, &rate_key], shortest(joint.start_rate_rad_s), travel.words(allowed));
    }
    if let JointMotion::Prescribed(motion) = &joint.motion {
        check_motion(&["joint", name, "motion"], travel, motion, checker);
    }
    check_motor(name, travel, &joint.motor, checker);
    if let Some(Spring { stiffness_n_m_rad, damping_n_m_s_rad, rest_angle_rad }) = joint.spring {
        for (key, value, range) in [
            ("stiffness_n_m_rad", stiffness_n_m_rad, Range::AtLeast(0.0)),
            ("damping_n_m_s_rad", damping_n_m_s_rad, Range::AtLeast(0.0)),
            ("rest_angle_rad", rest_angle_rad, stand(travel)),
        ] {
            checker.number(&["joint", name, "spring", &travel.words(key)], value, range);
        }
    }
    if let Some(generator) = &joint.generator {
        check_generator(name, joint, generator, checker);
    }
    if let Some(dc_motor) = &joint.dc_motor {
        dc_motor::check(name, travel, joint, dc_motor, checker);
    }
    if let Some(latch) = &joint.latch {
        check_latch(name, travel, joint, latch, checker);
    }
    if let Some(end_stops) = &joint.end_stops {
        check_stops(name, travel, joint, end_stops, checker);
    }
}

/// Checks that a prescribed motion can be evaluated.
pub(crate) fn check_motion(place: &[&str], travel: Travel, motion: &Motion, checker: &mut Checker) -> bool {
    let (fits, allowed) = match motion {
        Motion::Polynomial(coefficients) => {
            let fits = (1..=100).contains(&coefficients.len()) && coefficients.iter().copied().all(is_finite);
            (fits, "an array of 1 to 100 finite coefficients in rad and s")
        }
        Motion::Table(points) | Motion::Onward(points) | Motion::QuasiStatic(points) => {
            let finite = points.len() >= 2 && points.iter().all(|(t, angle)| is_finite(*t) && is_finite(*angle));
            let ascending = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
            (finite && ascending, "at least 2 pairs [time in s, angle in rad] of finite numbers with ascending times")
        }
    };
    if !fits {
        checker.refuse(place, format!("{motion:?}"), travel.words(allowed));
    }
    fits
}

fn check_motor(name: &str, travel: Travel, motor: &Motor, checker: &mut Checker) {
    for (key, value, range) in [
        ("stiffness_n_m_rad", motor.stiffness_n_m_rad, Range::AtLeast(0.0)),
        ("damping_n_m_s_rad", motor.damping_n_m_s_rad, Range::AtLeast(0.0)),
        ("torque_limit_n_m", motor.torque_limit_n_m, Range::AtLeast(0.0)),
        ("rate_limit_rad_s", motor.rate_limit_rad_s, Range::AtLeast(0.0)),
        ("inertia_kg_m2", motor.inertia_kg_m2, Range::AtLeast(0.0)),
        ("constant_torque_n_m", motor.constant_torque_n_m, Range::Finite),
        ("command_rad", motor.command_rad, stand(travel)),
    ] {
        checker.number(&["joint", name, "motor", &travel.words(key)], value, range);
    }
    let place = ["joint", name, "motor", "gear_ratio"];
    match motor.gear_ratio {
        Some(ratio) if travel == Travel::Translation => {
            checker.refuse(&place, shortest(ratio), "no gear_ratio on a prismatic joint");
        }
        Some(ratio) if !(1e-6..=1e6).contains(&ratio.abs()) => {
            checker.refuse(
                &place,
                shortest(ratio),
                "a ratio of a magnitude from 1e-6 to 1e6, negative if the motor turns in the opposite direction",
            );
        }
        _ => {}
    }
}

fn check_generator(name: &str, joint: &OneFreedom, law: &GeneratorLaw, checker: &mut Checker) {
    let place = |key| ["joint", name, "generator", key];
    if joint.motion != JointMotion::Free {
        let allowed = "a generator only with motion = \"free\"";
        checker.refuse_state(
            &["joint", name, "generator"],
            "a generator on a joint that does not turn freely",
            allowed,
        );
    }
    let rows = &law.rows;
    let finite = rows.iter().flatten().copied().all(is_finite);
    if !(finite && (1..=1000).contains(&rows.len()) && rows.windows(2).all(|pair| pair[0][0] < pair[1][0])) {
        let allowed = "1 to 1000 rows [speed in rad/s, torque in N·m] of finite numbers with ascending speeds";
        checker.refuse(&place("rows"), format!("{rows:?}"), allowed);
    } else if law.beyond == Beyond::Power && rows[rows.len() - 1][0] <= 0.0 {
        let allowed = "a last row at a speed > 0, above which its power is held constant";
        checker.refuse(&place("rows"), format!("{rows:?}"), allowed);
    }
    if let Some(gain) = law.square_gain_n_m_s2 {
        checker.number(&place("square_gain_n_m_s2"), gain, Range::AtLeast(0.0));
    }
    checker.number(&place("efficiency"), law.efficiency, Range::Within(0.0, 1.0));
    if !(1e-6..=1e6).contains(&law.gear_ratio.abs()) {
        let allowed = "a ratio of a magnitude from 1e-6 to 1e6";
        checker.refuse(&place("gear_ratio"), shortest(law.gear_ratio), allowed);
    }
}

fn check_latch(name: &str, travel: Travel, joint: &OneFreedom, latch: &Latch, checker: &mut Checker) {
    let keys = ["angle_rad", "capture_rad", "stiffness_n_m_rad"].map(|key| travel.words(key));
    let place = |key| ["joint", name, "latch", key];
    if joint.motion != JointMotion::Free {
        let allowed = "a latch only with motion = \"free\"";
        checker.refuse_state(&["joint", name, "latch"], "a latch on a joint that does not move freely", allowed);
    }
    if latch.kind == LatchKind::Rigid && latch.initially_closed {
        let allowed = "true only with kind = \"elastic\": a rigid latch is closed at the start if it is enabled and \
             start_angle lies within capture of angle";
        checker.refuse(&place("initially_closed"), "true", travel.words(allowed));
    } else if latch.initially_closed && !latch.enable {
        let allowed = "true only with enable = true: a latch that is not enabled is open";
        checker.refuse(&place("initially_closed"), "true", allowed);
    }
    let caught = latch.enable && (joint.start_angle_rad - latch.angle_rad).abs() <= latch.capture_rad;
    if latch.kind == LatchKind::Rigid && caught && joint.start_rate_rad_s != 0.0 {
        let allowed = "a rate of 0 rad/s if a rigid latch is closed at the start; start outside its capture range, or write \
             enable = false";
        let rate_key = travel.words("start_rate_rad_s");
        checker.refuse(&["joint", name, &rate_key], shortest(joint.start_rate_rad_s), travel.words(allowed));
    }
    let window = match travel {
        Travel::Rotation => Range::Within(0.0, TAU),
        Travel::Translation => Range::AtLeast(0.0),
    };
    checker.number(&place(&keys[0]), latch.angle_rad, stand(travel));
    checker.number(&place(&keys[1]), latch.capture_rad, window);
    if latch.kind == LatchKind::Elastic {
        checker.number(&place(&keys[2]), latch.stiffness_n_m_rad, Range::Above(0.0));
    } else if latch.stiffness_n_m_rad != 0.0 {
        let found = shortest(latch.stiffness_n_m_rad);
        checker.refuse(&place(&keys[2]), found, "0: a rigid latch has no spring");
    }
}

fn check_stops(name: &str, travel: Travel, joint: &OneFreedom, end_stops: &EndStops, checker: &mut Checker) {
    let keys = ["lower_rad", "upper_rad", "stiffness_n_m_rad", "damping_n_m_s_rad"].map(|key| travel.words(key));
    let place = |key| ["joint", name, "end_stops", key];
    if joint.motion != JointMotion::Free {
        let allowed = "end stops only with motion = \"free\"";
        checker.refuse_state(&["joint", name, "end_stops"], "end stops of a joint that does not move freely", allowed);
    }
    let ends = [end_stops.lower_rad, end_stops.upper_rad];
    let mut sound = true;
    for (key, end) in keys.iter().zip(ends) {
        sound &= end.is_none_or(|end| checker.number(&place(key), end, stand(travel)));
    }
    match ends {
        [None, None] => {
            let allowed = travel.words("lower_rad or upper_rad, or both");
            checker.refuse_state(&["joint", name, "end_stops"], "end stops without an end", allowed);
        }
        [Some(lower), Some(upper)] if sound && lower >= upper => {
            let allowed = travel.words("an angle above lower_rad");
            checker.refuse(&place(&keys[1]), shortest(upper), allowed);
        }
        _ => {}
    }
    checker.number(&place(&keys[2]), end_stops.stiffness_n_m_rad, Range::Above(0.0));
    checker.number(&place(&keys[3]), end_stops.damping_n_m_s_rad, Range::AtLeast(0.0));
}

/// Checks universal, ball and free joints.
fn check_spatial(name: &str, joint: &Joint, spatial: &Spatial, checker: &mut Checker) {
    let place = |key| ["joint", name, key];
    let within = [place("stiffness_n_m_rad"), place("damping_n_m_s_rad")];
    checker.number(&within[0], spatial.stiffness_n_m_rad, Range::AtLeast(0.0));
    checker.number(&within[1], spatial.damping_n_m_s_rad, Range::AtLeast(0.0));
    let spin = &spatial.start_angular_velocity_rad_s;
    let turns = checker.array(&place("start_angular_velocity_rad_s"), spin.as_slice());
    checker.array(&place("start_velocity_m_s"), spatial.start_velocity_m_s.as_slice());
    let free = spatial.freedom == SpatialFreedom::Free;
    if free && !matches!(joint.parent, Parent::Root { .. }) {
        let allowed = "\"root\" (a free joint cannot have a body as its parent; use another joint type to attach one \
                       body to another)";
        checker.refuse(&place("parent"), "a body", allowed);
    }
    if free && (spatial.stiffness_n_m_rad != 0.0 || spatial.damping_n_m_s_rad != 0.0) {
        let allowed = "0 on a free joint, which has no spring or damper";
        checker.refuse(&within[0], shortest(spatial.stiffness_n_m_rad.max(spatial.damping_n_m_s_rad)), allowed);
    }
    if !free && spatial.start_velocity_m_s != Vector3::zeros() {
        let found = array_text(spatial.start_velocity_m_s.as_slice());
        checker.refuse(&place("start_velocity_m_s"), found, "0 on joints that are not free");
    }
    let SpatialFreedom::Universal { parent_axis, body_axis } = &spatial.freedom else { return };
    if !(unit_vector(&place("axis"), parent_axis, checker) & unit_vector(&place("body_axis"), body_axis, checker)) {
        return;
    }
    let second = joint.mount * body_axis;
    if parent_axis.dot(&second).abs() > PARALLEL {
        let allowed = "an array of 3 finite numbers that after mount_rotation is not parallel to axis";
        checker.refuse(&place("body_axis"), array_text(body_axis.as_slice()), allowed);
        return;
    }
    let normal = parent_axis.cross(&second).normalize();
    // scaled, so that squares do not overflow
    let scale = spin.amax();
    if turns && scale > 0.0 && normal.dot(&(spin / scale).normalize()).abs() > ACROSS {
        let [x, y, z] = normal.map(|part| (part * 1e4).round() / 1e4 + 0.0).into();
        let allowed =
            format!("rates in rad/s about axis and body_axis only: the component must be zero along [{x}, {y}, {z}]");
        checker.refuse(&place("start_angular_velocity_rad_s"), array_text(spin.as_slice()), allowed);
    }
}

/// Stiffness in N·m/rad of a latch that makes its joint `ratio` times as stiff when closed; `None` after an error.
pub(crate) fn latch_stiffness_n_m_rad(
    name: &str,
    travel: Travel,
    ratio: f64,
    own_n_m_rad: f64,
    checker: &mut Checker,
) -> Option<f64> {
    let place = ["joint", name, "latch", "stiffness_ratio"];
    if !checker.number(&place, ratio, Range::Above(1.0)) {
        return None;
    }
    let stiffness = (ratio - 1.0) * own_n_m_rad;
    if own_n_m_rad == 0.0 {
        let allowed =
            "a ratio only with a motor or a spring of stiffness > 0; write stiffness_n_m_rad (N·m/rad) instead";
        checker.refuse(&place, shortest(ratio), travel.words(allowed));
        return None;
    }
    if !(stiffness > 0.0 && stiffness <= UNLIMITED) {
        checker.refuse(&place, shortest(ratio), travel.words("a ratio that gives a finite stiffness > 0 N·m/rad"));
        return None;
    }
    Some(stiffness)
}
