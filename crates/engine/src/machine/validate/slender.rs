//! Checks of slender bodies.

use crate::aero::slender::SlenderBodyOptions;
use crate::machine::builder::place::air_place;
use crate::machine::fault::{Checker, Range, array_text, is_finite};
use crate::machine::{Air, Body};

/// Maximum number of parts along a slender body.
pub(crate) const MAXIMUM_SEGMENTS: usize = 1_000;

/// Checks the slender bodies of the machine.
pub(super) fn check(air: &Air, bodies: &[Body], checker: &mut Checker) {
    let mut earlier: Vec<(usize, &str)> = Vec::new();
    for (part, options) in air.slender_bodies() {
        let Some(body) = bodies.get(options.body) else {
            let allowed = format!("one of the {} bodies, counted from 0", bodies.len());
            checker.refuse_state(&air_place(&part.name, "body"), format!("body {}", options.body), allowed);
            continue;
        };
        if air.surfaces.iter().any(|surface| surface.body == options.body) {
            let allowed = "a body without a lifting surface: its loads would be counted twice";
            checker.refuse_state(
                &air_place(&part.name, "body"),
                format!("{}, which has a surface", body.name),
                allowed,
            );
        }
        if let Some((_, other)) = earlier.iter().find(|(body, _)| *body == options.body) {
            let allowed = "one slender body per body";
            checker.refuse_state(
                &air_place(&part.name, "body"),
                format!("{}, the body of {other}", body.name),
                allowed,
            );
        }
        earlier.push((options.body, &part.name));
        check_shape(options, body, &part.name, checker);
    }
}

fn check_shape(options: &SlenderBodyOptions, body: &Body, part: &str, checker: &mut Checker) {
    let place = |key| air_place(part, key);
    let positions_m = &options.positions_m;
    checker.count(&place("segments"), positions_m.len().saturating_sub(1), 1, MAXIMUM_SEGMENTS);
    let length_m = body.length_m * (1.0 + 1e-12);
    let on_body = options.rigid || positions_m.iter().all(|s| (0.0..=length_m).contains(s));
    let finite = positions_m.iter().copied().all(is_finite);
    if !(finite && on_body && positions_m.windows(2).all(|pair| pair[0] < pair[1])) {
        checker.refuse(&place("radius_m"), array_text(positions_m), "ascending lengths in m on the body");
    }
    let radii_m = &options.radii_m;
    let sound = radii_m.iter().all(|radius_m| *radius_m >= 0.0 && is_finite(*radius_m));
    if !(sound && radii_m.len() == positions_m.len() && radii_m.iter().any(|radius_m| *radius_m > 0.0)) {
        let allowed = "a finite radius >= 0 m at every position, not all 0";
        checker.refuse(&place("radius_m"), array_text(radii_m), allowed);
    }
    if options.rigid != body.is_rigid() {
        let allowed = "sections fixed to one frame on a rigid body, and only there";
        checker.refuse_state(&place("rigid"), options.rigid.to_string(), allowed);
    }
    let drags = [
        ("cross_flow_drag_coefficient", options.cross_flow_drag_coefficient),
        ("axial_drag_coefficient", options.axial_drag_coefficient),
    ];
    for (key, coefficient) in drags {
        checker.number(&place(key), coefficient, Range::AtLeast(0.0));
    }
}
