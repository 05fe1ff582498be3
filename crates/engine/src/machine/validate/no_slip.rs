//! Checks of skates and wheels, and of the parts of a machine that exclude them.

use crate::machine::fault::{Checker, Fault, Range};
use crate::machine::pose::{along, first_frames};
use crate::machine::validate::attached::START_GAP;
use crate::machine::validate::basics::{names, unit_vector};
use crate::machine::{Machine, NoSlip, Runner, StartState};
use crate::multibody::no_slip::LEAST_SINE;
use nalgebra::Vector3;

/// Checks all skates and wheels; true if their places exist.
pub(super) fn check(machine: &Machine, checker: &mut Checker) -> bool {
    for table in ["skate", "wheel"] {
        let own = machine.no_slips.iter().filter(|no_slip| no_slip.table() == table);
        names(table, own.map(|no_slip| no_slip.name.as_str()), checker);
    }
    let mut holds = true;
    for no_slip in &machine.no_slips {
        holds &= numbers(no_slip, machine, checker);
    }
    if let (Some(no_slip), StartState::Equilibrium) = (machine.no_slips.first(), machine.experiment.start) {
        let allowed = format!(
            "\"unstrained\": there is no static equilibrium with the {} {:?}, whose forces depend on the motion",
            no_slip.table(),
            no_slip.name
        );
        checker.refuse(&["simulation", "start"], "\"equilibrium\"", allowed);
    }
    holds
}

/// Checks the numbers of a skate or a wheel; true if its place exists.
fn numbers(no_slip: &NoSlip, machine: &Machine, checker: &mut Checker) -> bool {
    let place = |key: &'static str| [no_slip.table(), no_slip.name.as_str(), key];
    let Some(body) = machine.bodies.get(no_slip.body) else {
        let found = format!("body {} of {}", no_slip.body, machine.bodies.len());
        checker.refuse_state(&place("body"), found, "a body of the model");
        return false;
    };
    checker.on_body(&place("position_m"), no_slip.position_m, body.length_m);
    let on_body = (0.0..=body.length_m).contains(&no_slip.position_m);
    let mut holds = on_body
        & checker.array(&place("offset_m"), no_slip.offset_m.as_slice())
        & checker.array(&place("plane_point_m"), no_slip.plane_point_m.as_slice())
        & unit_vector(&place("plane_normal"), &no_slip.plane_normal, checker);
    match &no_slip.runner {
        Runner::Skate { direction } => holds &= unit_vector(&place("direction"), direction, checker),
        Runner::Wheel { axis, radius_m, .. } => {
            holds &= unit_vector(&place("axis"), axis, checker)
                & checker.number(&place("radius_m"), *radius_m, Range::Above(0.0));
        }
    }
    holds
}

/// Reports blades and axes without a heading, and points of contact off their planes, in the unstrained machine at its start angles.
pub(super) fn starts(machine: &Machine, checker: &mut Checker) {
    let firsts = first_frames(&machine.bodies, |joint| joint.start_angle_rad);
    for no_slip in &machine.no_slips {
        let (table, name) = (no_slip.table(), no_slip.name.as_str());
        let fell = |fault: &Fault| fault.place.0.iter().map(|part| &**part).take(2).eq([table, name]);
        if checker.faults.iter().any(fell) {
            continue;
        }
        let body = &machine.bodies[no_slip.body];
        let frame = along(body, &firsts[no_slip.body], no_slip.position_m);
        let (key, direction) = match &no_slip.runner {
            Runner::Skate { direction } => ("direction", direction),
            Runner::Wheel { axis, .. } => ("axis", axis),
        };
        let direction = frame.attitude * direction;
        let sine = direction.cross(&no_slip.plane_normal).norm();
        if sine < LEAST_SINE {
            let allowed = format!(
                "a direction that is inclined by at least {:.1}° to the normal of the plane in the unstrained model at its start \
                 angles: the heading is its part in the plane",
                LEAST_SINE.asin().to_degrees()
            );
            checker.refuse_state(
                &[table, name, key],
                format!("a direction at {:.1}° to the normal", sine.asin().to_degrees()),
                allowed,
            );
            continue;
        }
        let centre_m = frame.position_m + frame.attitude * no_slip.offset_m;
        let reach_m = match &no_slip.runner {
            Runner::Skate { .. } => 0.0,
            // the sine is that of the axis: the wheel is upright at 1
            Runner::Wheel { radius_m, .. } => radius_m * sine,
        };
        let height_m = (centre_m - no_slip.plane_point_m).dot(&no_slip.plane_normal) - reach_m;
        let lengths =
            [body.length_m, no_slip.offset_m.norm(), reach_m, (frame.position_m - no_slip.plane_point_m).norm()];
        let limit_m = START_GAP * lengths.into_iter().fold(0.0, f64::max);
        // a height of NaN is off the plane too
        if no_slip.hold_normal && (height_m.abs() > limit_m || height_m.is_nan()) {
            let point_m: Vector3<f64> = centre_m - no_slip.plane_normal * reach_m;
            let allowed = format!(
                "a point of contact in the plane in the unstrained model at its start angles, within {limit_m:.0e} m; a plane_point_m such as \
                 [{:.6}, {:.6}, {:.6}], or hold_normal = false",
                point_m.x, point_m.y, point_m.z
            );
            let found = format!("a point of contact {height_m:.6} m from the plane along its normal,");
            checker.refuse_state(&[table, name, "plane_point_m"], found, allowed);
        }
    }
}
