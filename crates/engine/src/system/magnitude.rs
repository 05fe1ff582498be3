//! Checks against overflow: a check of the inputs replaces a check of all outputs.

use crate::beam::modal::{ModalElement, ShapesAt};
use crate::multibody::Model;
use crate::multibody::gauge::GaugePoint;
use crate::multibody::model::Elastic;
use crate::signal::{Inputs, JointParameters, Parameters};
use crate::solve::point::Point;
use crate::system::System;
use crate::system::state::State;

/// Largest magnitude in SI units of coordinates, their derivatives, inputs and parameters for which no output overflows, in a model with
/// moderate parameters: outputs are products of at most ten of them.
const LARGEST: f64 = 1e20;
/// Largest magnitude of a moderate model's numbers, and of the inverse of its smallest stiffness.
const LARGEST_OF_MODEL: f64 = 1e30;
/// Largest magnitude of the energy accounts.
const LARGEST_ACCOUNT: f64 = 1e200;

/// Whether the magnitude of a value is at most `limit`; false for NaN.
fn within(value: f64, limit: f64) -> bool {
    value.abs() <= limit
}

fn all_within(values: &[f64], limit: f64) -> bool {
    values.iter().all(|&value| within(value, limit))
}

impl System {
    /// Whether all outputs at the current time are certain to be finite, by the magnitudes of the quantities that they depend on; always
    /// false for models with aerodynamics.
    pub(crate) fn is_moderate(&self) -> bool {
        self.air.is_none() && self.rest_is_moderate() && coordinates_are_moderate(&self.state.now)
    }

    /// Like [`Self::is_moderate`], for the current time and all times until the end of the integrator's step, without the aerodynamic
    /// loads, which are checked in the step.
    pub(crate) fn stays_moderate(&self) -> bool {
        let State { now, ahead, .. } = &self.state;
        self.rest_is_moderate() && [now, ahead].into_iter().all(coordinates_are_moderate)
    }

    /// Whether all quantities except the coordinates are moderate.
    fn rest_is_moderate(&self) -> bool {
        let state = &self.state;
        self.model_is_moderate
            && state.joints.iter().all(|joint| {
                let slew = &joint.slew;
                [slew.from_rad, slew.target_rad, slew.target_rate_rad_s, slew.start_s]
                    .into_iter()
                    .all(|value| within(value, LARGEST))
            })
            && [&state.applied_inputs, &state.applied_rates].into_iter().all(inputs_are_moderate)
            && parameters_are_moderate(&state.applied_parameters)
    }
}

fn coordinates_are_moderate(at: &Point) -> bool {
    at.q.iter().chain(&at.v).chain(&at.a).all(|&value| within(value, LARGEST))
        && [at.work, at.dissipated].into_iter().all(|account| within(account, LARGEST_ACCOUNT))
}

/// Whether the inputs are too small to make an output overflow.
pub(crate) fn inputs_are_moderate(inputs: &Inputs) -> bool {
    all_within(inputs.values(), LARGEST)
}

fn parameters_are_moderate(parameters: &Parameters) -> bool {
    // limits may be infinite: they can only reduce the torque
    let joint = |joint: &JointParameters| {
        let others = [JointParameters { torque_limit_n_m: 0.0, rate_limit_rad_s: 0.0, ..*joint }];
        all_within(bytemuck::cast_slice(&others), LARGEST)
    };
    parameters.joints().iter().all(joint)
        && all_within(bytemuck::cast_slice(parameters.spatial()), LARGEST)
        && all_within(bytemuck::cast_slice(parameters.bodies()), LARGEST)
}

/// Whether the parameters of a model are moderate.
pub(crate) fn model_is_moderate(model: &Model, gauges: &[GaugePoint]) -> bool {
    let all = |values: &[f64]| all_within(values, LARGEST_OF_MODEL);
    let element = |element: &crate::multibody::model::Element| {
        let elastic = element.sheared.as_ref().map_or_else(|| is_moderate(&element.elastic), |own| is_moderate(own));
        elastic
            && all(&[element.length_m, element.start_m])
            && all(element.cross_mass.as_slice())
            && element.inner_mass.as_ref().is_none_or(|inner| all(inner.as_slice()))
            && all(element.outer_mass.as_slice())
    };
    model.elements.iter().all(element)
        && model.nodes.iter().all(|node| {
            all(node.beam.as_slice()) && node.attached.as_ref().is_none_or(|attached| all(attached.as_slice()))
        })
        && model.closures.iter().all(|closure| {
            let penalty = &closure.penalty;
            all(&[penalty.inertia_kg, penalty.damping_n_s_m, penalty.stiffness_n_m])
                && closure.offsets_m.iter().all(|offset| all(offset.as_slice()))
        })
        && gauges.iter().all(|gauge| all(gauge.row.as_slice()) && all(&[gauge.position_m]))
        && model.bodies.iter().filter_map(|body| body.modal.as_ref()).all(|modal| modal_is_moderate(&modal.element))
        && within(model.reference_length_m, LARGEST_OF_MODEL)
}

/// Whether the parameters of an element's elasticity are moderate.
fn is_moderate<const N: usize>(elastic: &Elastic<N>) -> bool {
    let all = |values: &[f64]| all_within(values, LARGEST_OF_MODEL);
    let flexibility = elastic.section_stiffness[0].diagonal().map(|stiffness| 1.0 / stiffness);
    all(flexibility.as_slice())
        && elastic.section_stiffness.iter().all(|stiffness| all(stiffness.as_slice()))
        && all(elastic.natural_strain.as_slice())
        && all(elastic.stiffness.as_slice())
        && all(elastic.coupling.as_slice())
}

/// Whether the parameters of a modal body are moderate.
fn modal_is_moderate(element: &ModalElement) -> bool {
    let all = |values: &[f64]| all_within(values, LARGEST_OF_MODEL);
    let shapes = |at: &ShapesAt| {
        all(at.bend.as_flattened()) && all(at.slope_1_m.as_flattened()) && all(at.shortening_1_m.as_flattened())
    };
    all(element.stiffness.as_slice())
        && all(element.damping.as_slice())
        && all(&[element.length_m])
        && shapes(&element.tip)
        && element.masses.iter().all(|point| all(&[point.mass_kg]) && shapes(&point.shapes))
}
