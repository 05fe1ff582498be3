//! Checks of gauges, internal-load sections, and loops: their positions, and whether loops are closed at the start.

use crate::beam::law::SectionLaw;
use crate::beam::section::{Outline, Section};
use crate::machine::fault::{Checker, Fault, Range, array_text, is_finite};
use crate::machine::pose::{along, first_frames};
use crate::machine::units::shortest;
use crate::machine::validate::body::section_stands;
use crate::machine::validate::unit_vector;
use crate::machine::{Body, Closure, Gauge, InternalLoad, LoopEnd, Machine, Parent, SectionSide};
use nalgebra::Vector3;

/// Largest initial gap divided by the length of the longer body: angles rounded to 0.01 degrees cause 2e-4. A wider gap is an error in the
/// model and would be closed abruptly by the full force of the penalty.
pub(super) const START_GAP: f64 = 1e-3;

/// The body with an index; an error if it does not exist.
fn body_at<'m>(place: &[&str], index: usize, bodies: &'m [Body], checker: &mut Checker) -> Option<&'m Body> {
    let body = bodies.get(index);
    if body.is_none() {
        let allowed = format!("one of the {} bodies, counted from 0", bodies.len());
        checker.refuse_state(place, format!("body {index}"), allowed);
    }
    body
}

/// Whether half-width and half-height are known along the whole body.
pub(crate) fn has_outline(law: &SectionLaw) -> bool {
    let known = |section: &Section| section.half_width_m > 0.0 && section.half_height_m > 0.0;
    match law {
        SectionLaw::Uniform(section) => known(section),
        SectionLaw::Table(stations) => stations.iter().all(|station| known(&station.section)),
        SectionLaw::Tapered { .. } | SectionLaw::Modal(_) => true,
    }
}

/// Checks a gauge: on its body, on its section, along a fibre whose strain is known.
pub(super) fn gauge(gauge: &Gauge, bodies: &[Body], checker: &mut Checker) {
    let name = gauge.name.as_str();
    let Some(body) = body_at(&["gauge", name, "body"], gauge.body, bodies, checker) else { return };
    if body.is_rigid() && body.length_m == 0.0 {
        let allowed = "a flexible body; this one is rigid";
        checker.refuse(&["gauge", name, "body"], format!("{:?}", body.name), allowed);
        return;
    }
    if body.is_modal() {
        let allowed = "a beam; this body is modal and has no strains of sections";
        checker.refuse(&["gauge", name, "body"], format!("{:?}", body.name), allowed);
        return;
    }
    let law = &body.section;
    checker.on_body(&["gauge", name, "position_m"], gauge.position_m, body.length_m);
    if !section_stands(&body.name, checker) {
        return;
    }
    if !has_outline(law) {
        let allowed = "a body whose section has half_width_m and half_height_m";
        checker.refuse(&["gauge", name, "body"], format!("{:?}", body.name), allowed);
        return;
    }
    point(gauge, law, checker);
    let directed = unit_vector(&["gauge", name, "direction"], &gauge.direction, checker);
    if directed && gauge.row(law).is_none() {
        let allowed = match law.shears() {
            true => "the axis, [1, 0, 0], on a body with shear",
            false => {
                "the axis, [1, 0, 0], on a section that is not a rectangle or an ellipse with shear_modulus_Pa or \
                 poisson_ratio"
            }
        };
        checker.refuse(&["gauge", name, "direction"], array_text(gauge.direction.as_slice()), allowed);
    }
}

/// Checks an internal-load section: it must be on a beam, with a part outboard of it.
pub(super) fn internal_load(internal_load: &InternalLoad, bodies: &[Body], checker: &mut Checker) {
    let name = internal_load.name.as_str();
    let Some(body) = body_at(&["internal_load", name, "body"], internal_load.body, bodies, checker) else { return };
    if body.is_rigid() && body.length_m == 0.0 {
        let allowed =
            "a flexible body; this one is rigid and has no sections: the force and moment of its joint are outputs";
        checker.refuse(&["internal_load", name, "body"], format!("{:?}", body.name), allowed);
        return;
    }
    checker.on_body(&["internal_load", name, "position_m"], internal_load.position_m, body.length_m);
    if internal_load.side == SectionSide::Outboard && internal_load.position_m == body.length_m {
        let allowed = "\"inboard\" at the outer end of the body: there is no part outboard of it";
        checker.refuse(&["internal_load", name, "side"], "\"outboard\"", allowed);
    }
}

/// Reports a point outside the section, except for round-off at its outline.
fn point(gauge: &Gauge, law: &SectionLaw, checker: &mut Checker) {
    let (y_m, z_m) = (gauge.y_m, gauge.z_m);
    let section = law.at(gauge.position_m);
    let outline = law.solid_at(gauge.position_m).map(|solid| solid.outline);
    let (width, height) = (section.half_width_m, section.half_height_m);
    let (y, z) = (y_m.abs() / width, z_m.abs() / height);
    let (reach, allowed) = match outline {
        Some(Outline::Ellipse) => {
            (y.hypot(z), format!("a point on the section: (y/{width})² + (z/{height})² <= 1, in m"))
        }
        _ => (y.max(z), format!("a point on the section: |y| <= {width} m, |z| <= {height} m")),
    };
    if !(reach <= 1.0 + 1e-9 && is_finite(y_m) && is_finite(z_m)) {
        let off_in_z = z_m.abs() > height || y_m == 0.0;
        let (key, value) = if off_in_z { ("z_m", z_m) } else { ("y_m", y_m) };
        checker.refuse(&["gauge", &gauge.name, key], shortest(value), allowed);
    }
}

/// Checks the penalty of a closed loop, which a rigid loop does not have.
fn penalty(closure: &Closure, checker: &mut Checker) {
    let name = closure.name.as_str();
    let values = [
        ("stiffness_n_m", closure.stiffness_n_m),
        ("damping_n_s_m", closure.damping_n_s_m),
        ("inertia_kg", closure.inertia_kg),
    ];
    if closure.rigid {
        for (key, value) in values.into_iter().filter(|(_, value)| *value != 0.0) {
            let allowed = "no penalty in a loop with rigid = true: its points coincide without one";
            checker.refuse(&["loop", name, key], shortest(value), allowed);
        }
        return;
    }
    if closure.stiffness_n_m == 0.0 {
        let allowed = "a finite stiffness > 0 N/m, or rigid = true in its place";
        checker.refuse(&["loop", name, "stiffness_n_m"], "0", allowed);
    } else {
        checker.number(&["loop", name, "stiffness_n_m"], closure.stiffness_n_m, Range::Above(0.0));
    }
    checker.number(&["loop", name, "damping_n_s_m"], closure.damping_n_s_m, Range::AtLeast(0.0));
    checker.number(&["loop", name, "inertia_kg"], closure.inertia_kg, Range::AtLeast(0.0));
}

/// Checks a closed loop; true if its points exist.
pub(super) fn closure(closure: &Closure, bodies: &[Body], checker: &mut Checker) -> bool {
    let name = closure.name.as_str();
    penalty(closure, checker);
    let offsets: Vec<f64> = closure.offsets_m.iter().flat_map(Vector3::iter).copied().collect();
    let mut holds = checker.array(&["loop", name, "offsets_m"], &offsets);
    if closure.ends == [LoopEnd::Root; 2] {
        let allowed = "one body at least: both points are on the root";
        checker.refuse(&["loop", name, "bodies"], "[\"root\", \"root\"]", allowed);
        return false;
    }
    let positions = || closure.ends.map(|end| end.on_body().map_or(0.0, |(_, position_m)| position_m));
    for (index, position_m) in closure.ends.into_iter().filter_map(LoopEnd::on_body) {
        let Some(body) = body_at(&["loop", name, "bodies"], index, bodies, checker) else { return false };
        if !(0.0..=body.length_m).contains(&position_m) {
            let length = shortest(body.length_m);
            let allowed = format!("positions from 0 to the length of each body; {:?} is {length} m long", body.name);
            checker.refuse(&["loop", name, "positions_m"], array_text(&positions()), allowed);
            holds = false;
        }
    }
    if holds && closure.ends[0] == closure.ends[1] {
        let allowed = "two different points; this one is joined to itself";
        checker.refuse(&["loop", name, "positions_m"], array_text(&positions()), allowed);
        holds = false;
    }
    holds
}

/// Reports loops that are open in the unstrained machine at its initial angles.
pub(super) fn gaps(machine: &Machine, checker: &mut Checker) {
    if machine.closures.is_empty() {
        return;
    }
    let firsts = first_frames(&machine.bodies, |joint| joint.start_angle_rad);
    for closure in &machine.closures {
        let points = [0, 1].map(|side| {
            let Some((body, position_m)) = closure.ends[side].on_body() else { return closure.offsets_m[side] };
            let frame = along(&machine.bodies[body], &firsts[body], position_m);
            frame.position_m + frame.attitude * closure.offsets_m[side]
        });
        let gap = points[1] - points[0];
        let joined = closure.ends.into_iter().filter_map(LoopEnd::on_body);
        // a body that slides along a beam is placed on it to its round-off
        let length_of = |body: usize| match machine.bodies[body].joint.parent {
            Parent::Body { index, .. } if machine.bodies[body].joint.kind.rides() => machine.bodies[index].length_m,
            Parent::Body { .. } | Parent::Root { .. } => machine.bodies[body].length_m,
        };
        let mut length_m = joined.map(|(body, _)| length_of(body)).fold(0.0, f64::max);
        if length_m == 0.0 {
            // rigid bodies extend to their points
            length_m = closure.offsets_m.iter().map(Vector3::norm).fold(0.0, f64::max);
        }
        let limit_m = START_GAP * length_m;
        // a loop with another fault has no points to compare
        let fell = |fault: &Fault| fault.place.0.iter().map(|part| &**part).take(2).eq(["loop", closure.name.as_str()]);
        // a gap of NaN is not closed either
        if (gap.norm() > limit_m || gap.norm().is_nan()) && !checker.faults.iter().any(fell) {
            // without the sign of zeros, also of values that round to zero
            let shown = gap.map(|part_m| (part_m * 1e6).round() * 1e-6 + 0.0);
            checker.refuse_state(
                &["loop", &closure.name],
                format!(
                    "a gap of {:.6} m, from the first point to the second [{:.6}, {:.6}, {:.6}],",
                    gap.norm(),
                    shown.x,
                    shown.y,
                    shown.z
                ),
                format!(
                    "points that coincide in the unstrained model at its start angles within {} m, {START_GAP} of \
                     the length of the longer body",
                    shortest(limit_m)
                ),
            );
        }
    }
}
