//! Check of damping by modes: the order of modes with equal frequencies is arbitrary, so that their ratios must be equal.

use crate::beam::element::rigid_body_mass;
use crate::machine::Machine;
use crate::machine::fault::{Checker, array_text};
use crate::machine::units::shortest;
use crate::multibody::joint::JointKind;
use crate::multibody::mode_damping::ClampedModes;
use crate::multibody::model::{Attachment, BodyDescription, Model};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Relative distance of two frequencies below which their modes count as one: the shapes are determined to round-off over this distance.
const CLOSE: f64 = 1e-6;

/// Reports different ratios for modes with equal frequencies. The bodies must have no faults.
pub(super) fn check(machine: &Machine, checker: &mut Checker) {
    for body in machine.bodies.iter().filter(|body| body.modal_damping_ratios.iter().any(|ratio| *ratio > 0.0)) {
        let alone = BodyDescription {
            length_m: body.length_m,
            section: body.section.clone(),
            kind: body.element,
            elements: body.elements,
            natural_strain: body.natural_strain.clone(),
            parent: Attachment::Root(Vector3::zeros()),
            offset_m: Vector3::zeros(),
            mount: Matrix3::identity(),
            joint: JointKind::Clamped,
            masses: body
                .masses
                .iter()
                .map(|mass| (mass.position_m, rigid_body_mass(mass.mass_kg, &mass.offset_m, &mass.inertia_kg_m2)))
                .collect(),
            stations_m: Vec::new(),
            load_frame: body.load_frame,
        };
        let Some(modes) = ClampedModes::of(&Model::new(&[alone]), 0) else { continue };
        let ratios = &body.modal_damping_ratios;
        // the first mode beyond the list has no ratio
        let ratio = |i: usize| ratios.get(i).copied().unwrap_or(0.0);
        let pair = modes
            .frequencies_rad_s
            .windows(2)
            .take(ratios.len())
            .enumerate()
            .find(|(i, pair)| ratio(*i) != ratio(*i + 1) && pair[1] - pair[0] < CLOSE * pair[1]);
        if let Some((i, pair)) = pair {
            let allowed = format!(
                "equal ratios for modes {} and {}, whose frequencies are equal ({} Hz), so that their order is arbitrary",
                i + 1,
                i + 2,
                shortest(pair[0] / TAU)
            );
            checker.refuse(&["body", &body.name, "modal_damping_ratios"], array_text(ratios), allowed);
        }
    }
}
