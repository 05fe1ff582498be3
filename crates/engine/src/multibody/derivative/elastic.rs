//! Stiffness and stiffness-proportional damping of the strains, eq. (D8): symmetric and constant.

use crate::beam::element::ElementKind;
use crate::math::strain::{Strain, StrainMatrix};
use crate::multibody::Model;
use crate::multibody::dynamics::Damping;
use crate::multibody::model::Element;

/// Adds `K x` to `stiffness` and the damping matrix's product `C x` to `damped`, for the strains.
pub fn elastic_products(model: &Model, damping: &[Damping], x: &[f64], stiffness: &mut [f64], damped: &mut [f64]) {
    for (body, damping) in model.bodies.iter().zip(damping) {
        let elements = &model.elements[body.first_element..body.first_element + body.elements];
        let roots = body.damping_roots.unwrap_or_else(|| Strain::repeat(1.0));
        for (i, element) in elements.iter().enumerate() {
            let (mut force, mut viscous) = (Strain::zeros(), Strain::zeros());
            let mut add = |block: &StrainMatrix, of: &Element| {
                let strain = Strain::from(of.strains(x));
                force += block * strain;
                viscous += block * roots.component_mul(&strain);
            };
            add(&element.stiffness, element);
            if body.kind == ElementKind::Linear {
                add(&element.coupling, &elements[i ^ 1]);
            }
            let viscous = roots.component_mul(&viscous) * damping.stiffness_s;
            for j in element.range() {
                stiffness[j] += force[j - element.coordinate];
                damped[j] += viscous[j - element.coordinate];
            }
        }
    }
}
