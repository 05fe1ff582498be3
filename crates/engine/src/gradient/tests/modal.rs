//! Gradients of machines with modal bodies.

use super::folding::{agree, flap, fold, hold, without};
use super::rigid::hardened;
use super::*;
use crate::beam::modal::{ModalLaw, Shape};
use crate::load::LoadFrame;
use crate::machine::builder::JointBuilder;

/// A plate of a width in the first flapwise shapes and an edgewise one of a clamped beam, nearly, with different ratios of damping.
pub(super) fn plate(length_m: f64, [width_m, thickness_m]: [f64; 2], density_kg_m3: f64, damping: f64) -> ModalLaw {
    let young_pa = 3e9;
    let shape = |coefficients: [f64; 3], share: f64| Shape {
        coefficients: coefficients.to_vec(),
        damping_ratio: share * damping,
        start_m: 0.0,
    };
    ModalLaw {
        length_m,
        cells: 8,
        mass_kg_m: Along::constant(density_kg_m3 * width_m * thickness_m),
        flap_stiffness_n_m2: Along::constant(young_pa * width_m * thickness_m.powi(3) / 12.0),
        edge_stiffness_n_m2: Along::constant(young_pa * thickness_m * width_m.powi(3) / 12.0),
        twist_rad: Some(Along::constant(0.2)),
        flap: vec![shape([2.0, -4.0 / 3.0, 1.0 / 3.0], 1.0), shape([-11.0, 18.0, -6.0], 1.7)],
        edge: vec![shape([2.0, -4.0 / 3.0, 1.0 / 3.0], 0.6)],
        axial_shortening: true,
        section_rotation: true,
        rates_of_angles: false,
        mass_factor: 1.0,
        stiffness_factor: 1.0,
    }
}

/// A folding wing of a modal body and a beam, or of two modal bodies, on a root joint.
fn wing(numbers: Numbers, both: bool, root: JointBuilder) -> Result<Machine, String> {
    let wrench = crate::load::Wrench { force_n: [0.0, 0.1, numbers.load].into(), moment_n_m: [0.02, 0.0, 0.01].into() };
    let modal = |name: &str, length_m: f64| {
        let law = plate(length_m, [0.05, numbers.thickness], numbers.density, 20.0 * numbers.beta);
        Body::modal(name, law).load_frame(LoadFrame::Section).load_station_positions_m([0.6 * length_m])
    };
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: numbers.density };
    let beam = Body::beam("outer", 0.3, Solid::rectangle(0.05, numbers.thickness, material)).elements(2);
    let outer = if both { modal("outer", 0.3) } else { beam.stiffness_damping_s(numbers.beta) };
    Machine::builder("Modal")
        .gravity_m_s2([0.0, 0.5, -9.81])
        .body(modal("inner", numbers.length), root)
        .body(outer, fold(numbers, "inner"))
        .mass("outer", AttachedMass::point("tip", 0.3, numbers.mass))
        .load("pull", "inner", 1, wrench)
        .solver(Solver { tolerance: 1e-12, ..solver() })
        .build()
        .map_err(|refused| refused.to_string())
}

fn compare(machine: impl Fn(Numbers) -> Result<Machine, String>, joint: usize, (difference, words): (f64, &str)) {
    let places = without(&["stop", "command"]);
    let compared = compare_over(difference, machine, &InputRows::default(), &places, |plant| {
        let layout = *plant.outputs().layout();
        let indices = [
            layout.tips.place(0, 0) + 2,
            layout.tips.place(0, 0) + 1,
            layout.modal.place(0, 0) + 2,
            layout.energy.place(0, 0),
            layout.root.place(0, 0) + 2,
        ];
        let outputs = (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time }));
        let accounts = layout.accounts().map(|index| RunResult::Output { index, time: 1 });
        outputs.chain(accounts).chain([RunResult::LatchTime { joint }]).collect()
    });
    assert!(compared.events > 0, "{words}: no event");
    agree(&compared, 1e-9, words);
}

/// GR-107: a folding wing of a modal body and a beam, and of two modal bodies, with a load between the ends in the frame of the section,
/// through an elastic latch and through a rigid one; on a ball joint.
#[test]
fn gradients_of_modal_bodies() {
    compare(|numbers| wing(numbers, false, flap()), 1, (DIFFERENCE, "modal and beam"));
    compare(|numbers| wing(numbers, true, flap()).map(hardened), 1, (DIFFERENCE, "two modal bodies"));
    // a start angle of 1.2 rad: over DIFFERENCE the differences are 3.4e-6 off
    compare(|numbers| wing(numbers, true, Joint::ball("hook").motor(hold(numbers))), 0, (1e-4, "on a ball joint"));
}
