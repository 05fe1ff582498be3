//! Checks of modal bodies, and of parts attached to them.

use crate::beam::modal::{MAXIMUM_MODES, ModalLaw, Shape};
use crate::machine::fault::{Checker, Range, array_text, is_finite};
use crate::machine::units::shortest;
use crate::machine::validate::profile::{least_of, profile};
use crate::machine::{Body, LoopEnd, Machine, Parent};

/// Largest deviation from 1 of the sum of a shape's coefficients: published tables deviate by 1e-3 (the second shape of the NREL 5 MW
/// tower).
const SUM_TOLERANCE: f64 = 2e-3;
/// Maximum number of coefficients of a shape.
const MAXIMUM_COEFFICIENTS: usize = 20;

/// Checks the shapes and properties of a modal body whose length is valid.
pub(super) fn check(body: &Body, law: &ModalLaw, checker: &mut Checker) {
    let name = body.name.as_str();
    if law.length_m != body.length_m || law.cells != body.elements {
        let allowed = "the length and the number of cells of its law";
        checker.refuse_state(&["body", name, "length_m"], "another length or number of cells", allowed);
        return;
    }
    let modes = law.modes();
    if modes == 0 || modes > MAXIMUM_MODES {
        let allowed = format!("1 to {MAXIMUM_MODES} shapes, those in flap and in edge together");
        checker.refuse_state(&["body", name, "flap"], format!("{modes} shapes"), allowed);
    }
    for (key, along, least) in [
        ("mass_kg_m", &law.mass_kg_m, 0.0),
        ("flap_stiffness_n_m2", &law.flap_stiffness_n_m2, 0.0),
        ("edge_stiffness_n_m2", &law.edge_stiffness_n_m2, 0.0),
    ] {
        let place = ["body", name, key];
        if profile(&place, along, law.length_m, checker) {
            let found = least_of(along, law.length_m);
            if found.is_nan() || found <= least {
                let allowed = "values > 0 all along the body";
                checker.refuse_state(&place, format!("a value of {}", shortest(found)), allowed);
            }
        }
    }
    if let Some(twist) = &law.twist_rad {
        profile(&["body", name, "twist_rad"], twist, law.length_m, checker);
    }
    for (key, shapes) in [("flap", &law.flap), ("edge", &law.edge)] {
        for shape in shapes {
            one(&["body", name, key], shape, checker);
        }
    }
    for (key, value) in [("mass_damping_1_s", body.mass_damping_1_s), ("stiffness_damping_s", body.stiffness_damping_s)]
    {
        if value != 0.0 {
            let allowed = "0 on a modal body: its shapes have damping ratios";
            checker.refuse(&["body", name, key], shortest(value), allowed);
        }
    }
    for mass in &body.masses {
        at_an_end(&["mass", &mass.name, "position_m"], mass.position_m, body, checker);
    }
}

fn one(place: &[&str], shape: &Shape, checker: &mut Checker) {
    let coefficients = &shape.coefficients;
    let sum: f64 = coefficients.iter().sum();
    let finite = !coefficients.is_empty()
        && coefficients.len() <= MAXIMUM_COEFFICIENTS
        && coefficients.iter().copied().all(is_finite);
    if !finite || (sum - 1.0).abs() > SUM_TOLERANCE {
        let allowed = format!(
            "1 to {MAXIMUM_COEFFICIENTS} coefficients of x², x³, … that add up to 1, so that the shape is 1 at the outer end"
        );
        checker.refuse(&[place, &["coefficients"]].concat(), array_text(coefficients), allowed);
    }
    checker.number(&[place, &["damping_ratio"]].concat(), shape.damping_ratio, Range::AtLeast(0.0));
    checker.number(&[place, &["start_m"]].concat(), shape.start_m, Range::Finite);
}

/// Checks that a part is at an end of a modal body, where its nodes are: joints, masses and loops are attached there.
fn at_an_end(place: &[&str], position_m: f64, body: &Body, checker: &mut Checker) {
    let near = 1e-9 * body.length_m;
    if position_m > near && position_m < body.length_m - near {
        let length = shortest(body.length_m);
        let allowed = format!("0 or {length} m: {:?} is a modal body and carries others at its ends only", body.name);
        checker.refuse(place, shortest(position_m), allowed);
    }
}

/// Checks the parts attached to modal bodies.
pub(super) fn placed(machine: &Machine, checker: &mut Checker) {
    let modal = |index: usize| machine.bodies.get(index).filter(|body| body.is_modal());
    for body in &machine.bodies {
        if let Parent::Body { index, position_m } = body.joint.parent
            && let Some(parent) = modal(index)
        {
            at_an_end(&["joint", &body.joint.name, "parent_position_m"], position_m, parent, checker);
        }
    }
    for closure in &machine.closures {
        for (index, position_m) in closure.ends.into_iter().filter_map(LoopEnd::on_body) {
            if let Some(body) = modal(index) {
                at_an_end(&["loop", &closure.name, "positions_m"], position_m, body, checker);
            }
        }
    }
    for no_slip in &machine.no_slips {
        if let Some(body) = modal(no_slip.body) {
            at_an_end(&[no_slip.table(), &no_slip.name, "position_m"], no_slip.position_m, body, checker);
        }
    }
    for place in &machine.internal_loads {
        if let Some(body) = modal(place.body) {
            at_an_end(&["internal_load", &place.name, "position_m"], place.position_m, body, checker);
        }
    }
}
