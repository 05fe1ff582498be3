//! Degrees of freedom at the current state.

use crate::machine::Travel;
use crate::math::strain::{CURVATURES, NAMES};
use crate::system::System;

/// Step of the finite difference for a link or joint in rad.
const STEP_RAD: f64 = 2e-3;
/// Step of the finite difference for the amplitude of a mode of a modal body, relative to the body's length: high modes rotate the end by
/// tens of times as much.
const MODAL_STEP: f64 = 1e-4;

const AXES: [&str; 3] = ["x", "y", "z"];

/// A degree of freedom, with its name and units.
#[derive(Debug, Clone, PartialEq)]
pub struct Freedom {
    /// Index in the vectors of the equations.
    pub(crate) index: usize,
    /// Name, e.g. `fold.angle` or `inner.element[2].kappa_y`.
    pub name: String,
    /// Unit of the coordinate, as the variable table writes units.
    pub unit: &'static str,
    /// Unit of its rate.
    pub rate_unit: &'static str,
    /// Step of the finite difference.
    pub(crate) step: f64,
    /// Degrees of freedom that rigid loops move with it: indices in the vectors of the equations, with their change per unit, eq. (L49).
    pub(crate) follow: Vec<(usize, f64)>,
}

impl Freedom {
    /// Adds a change of this degree of freedom, with those of the dependent ones, to a vector of the equations.
    pub(crate) fn spread(&self, amount: f64, vector: &mut [f64]) {
        vector[self.index] += amount;
        for (index, share) in &self.follow {
            vector[*index] += share * amount;
        }
    }

    /// Force on it, of the forces on all coordinates.
    pub(crate) fn gather(&self, vector: &[f64]) -> f64 {
        self.follow.iter().fold(vector[self.index], |sum, (index, share)| sum + share * vector[*index])
    }
}

impl System {
    /// Degrees of freedom at the current state: angles of joints that are not held, rotations and displacements of universal, ball and free
    /// joints, strains; body by body. With rigid loops only the independent ones, eq. (L49): as far as possible those of the last joints
    /// depend on the others.
    pub fn freedoms(&self) -> Vec<Freedom> {
        self.independent(self.freedoms_of_tree())
    }

    /// Degrees of freedom without the constraints of rigid loops.
    pub(super) fn freedoms_of_tree(&self) -> Vec<Freedom> {
        let mut list = Vec::new();
        let equations = &self.equations;
        for (index, (body, described)) in equations.model.bodies.iter().zip(&self.machine.bodies).enumerate() {
            let joint = &described.joint.name;
            let mut add = |index: usize, name: String, [unit, rate_unit]: [&'static str; 2], step: f64| {
                list.push(Freedom { index, name, unit, rate_unit, step, follow: Vec::new() });
            };
            let held = equations.forces.joints().iter().any(|joint| joint.body == index && joint.held);
            let (kind, first) = (body.joint.kind, body.joint.coordinate);
            if kind.is_redundant() {
                let shifts = kind.translations();
                for (k, axis) in AXES.iter().enumerate().take(shifts) {
                    add(first + k, format!("{joint}.position.{axis}"), ["m", "m/s"], STEP_RAD);
                }
                for k in shifts..kind.freedoms() {
                    add(first + k, format!("{joint}.turn[{}]", k - shifts + 1), ["rad", "rad/s"], STEP_RAD);
                }
            } else if kind.freedoms() == 1 && !held {
                let travel = described.joint.kind.one_freedom().map_or(Travel::Rotation, |(travel, _)| travel);
                add(first, format!("{joint}.{}", travel.coordinate()), travel.units(), STEP_RAD);
            }
            if let Some(modal) = &body.modal {
                for (k, index) in modal.range().enumerate() {
                    let step = MODAL_STEP * modal.element.length_m;
                    add(index, format!("{}.mode[{}]", described.name, k + 1), ["m", "m/s"], step);
                }
            }
            for i in 0..body.elements {
                let element = &equations.model.elements[body.first_element + i];
                for ((k, strain), index) in NAMES.iter().enumerate().zip(element.range()) {
                    let step = if CURVATURES.contains(&k) { STEP_RAD / element.length_m } else { STEP_RAD };
                    let name = format!("{}.element[{}].{}", described.name, i + 1, strain.name);
                    add(index, name, strain.units, step);
                }
            }
        }
        list
    }

    /// Current values of [`System::freedoms`] and of their rates. Degrees of freedom of universal, ball and free joints have no coordinate:
    /// they are measured from the current attitude, and are zero at the state of linearisation.
    pub fn free_state(&self) -> (Vec<f64>, Vec<f64>) {
        let spatial = |index: usize| {
            let mut joints = self.equations.model.bodies.iter().map(|body| body.joint);
            joints.any(|joint| joint.kind.is_redundant() && joint.range().contains(&index))
        };
        let read = |vector: &[f64]| {
            let value = |freedom: &Freedom| if spatial(freedom.index) { 0.0 } else { vector[freedom.index] };
            self.freedoms().iter().map(value).collect()
        };
        (read(&self.state.now.q), read(&self.state.now.v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::section::{Material, Solid};
    use crate::machine::{Body, Joint, Machine};
    use crate::math::strain::STRAINS;
    use crate::run::Plant;
    use std::sync::Arc;

    /// Every degree of freedom has the unit of its quantity, and its rate has that unit per second: joints of all kinds, strains and
    /// curvatures.
    #[test]
    fn freedoms_have_the_units_of_their_quantities() {
        let plate = Solid::rectangle(0.1, 0.01, Material::isotropic(7e10, 0.3, 2700.0));
        let body = |name: &str| Body::beam(name, 1.0, plate).elements(2);
        let machine = Machine::builder("All")
            .body(body("a"), Joint::free("fly"))
            .body(body("b"), Joint::revolute("fold", [0.0, 1.0, 0.0]).on("a"))
            .body(body("c"), Joint::prismatic("slide", [1.0, 0.0, 0.0]).on("b"))
            .body(body("d"), Joint::universal("cross", [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).on("c"))
            .body(body("e"), Joint::ball("ball").on("d"))
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let freedoms = plant.freedoms();
        // joints in their order; strains of the two halves of two elements of each body
        assert_eq!(freedoms.len(), 6 + 1 + 1 + 2 + 3 + 5 * 2 * 2 * STRAINS);
        for Freedom { name, unit, rate_unit, .. } in freedoms {
            let quantity = name.rsplit('.').find(|part| part.len() > 1).expect("a quantity");
            let due = match quantity.trim_end_matches(|c: char| c.is_ascii_digit() || "[]".contains(c)) {
                "position" => ["m", "m/s"],
                "angle" | "turn" => ["rad", "rad/s"],
                "epsilon_x" => ["1", "1/s"],
                "kappa_x" | "kappa_y" | "kappa_z" => ["1/m", "1/(m.s)"],
                other => panic!("{name}: {other}"),
            };
            assert_eq!([unit, rate_unit], due, "{name}");
        }
    }
}
