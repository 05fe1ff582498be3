//! Checks against overflow: the parameters of a model.

use crate::beam::modal::{ModalElement, ShapesAt};
use crate::multibody::Model;
use crate::multibody::gauge::GaugePoint;
use crate::multibody::model::Elastic;
use crate::multibody::no_slip::Runner;

/// Largest magnitude of a moderate model's numbers, and of the inverse of its smallest stiffness.
const LARGEST_OF_MODEL: f64 = 1e30;

/// Whether the magnitude of a value is at most `limit`; false for NaN.
pub(super) fn within(value: f64, limit: f64) -> bool {
    value.abs() <= limit
}

pub(super) fn all_within(values: &[f64], limit: f64) -> bool {
    values.iter().all(|&value| within(value, limit))
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
        && model.no_slips.iter().all(|no_slip| {
            let described = &no_slip.described;
            let radius_m = match described.runner {
                Runner::Skate { .. } => 0.0,
                Runner::Wheel { radius_m, .. } => radius_m,
            };
            all(described.offset_m.as_slice()) && all(&[described.distance_m, radius_m])
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
