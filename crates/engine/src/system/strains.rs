//! Strains of all sections at the current time, for reports; not used in the time step.

use crate::beam::element::ElementKind;
use crate::beam::recovery::maximum_axial_strain;
use crate::math::strain::Strain;
use crate::multibody::gauge::strain_measures;
use crate::multibody::kinematics::Motion;
use crate::system::System;

/// Strain of one section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionStrain {
    /// Index into the model's bodies.
    pub body: usize,
    /// Distance from the body's inner end in m.
    pub position_m: f64,
    /// Strain measures `(γ₁, k₁, k₂, k₃)`: strains minus the natural strains; –, 1/m.
    pub measures: Strain,
    /// Longitudinal strain `E₁₁` of the largest magnitude on the section, NOTATION eq. (R7); on the axis if the section's outline is
    /// unknown.
    pub largest: f64,
    /// Position of the point, `[y, z]` in the section frame, m.
    pub point_m: [f64; 2],
}

impl System {
    /// Strains at both ends of every element or pair, body by body, at the current time.
    pub fn section_strains(&self) -> Vec<SectionStrain> {
        let (model, work, now) = (&self.equations.model, &self.equations.work, &self.state.now);
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        let mut strains = Vec::new();
        for (index, (body, description)) in model.bodies.iter().zip(&self.machine.bodies).enumerate() {
            if body.elements == 0 {
                continue; // rigid bodies have no strain
            }
            let elements = &model.elements[body.first_element..body.first_element + body.elements];
            let stride = if body.kind == ElementKind::Linear { 2 } else { 1 };
            let starts = elements.iter().step_by(stride).map(|element| element.start_m);
            for position_m in starts.chain([description.length_m]) {
                let measures = strain_measures(model, work, motion, &self.equations.damping, index, position_m);
                let outline = description.section.solid_at(position_m).map(|solid| solid.outline);
                let section = description.section.at(position_m);
                let (largest, point_m) = maximum_axial_strain(outline, &section, &measures);
                strains.push(SectionStrain { body: index, position_m, measures, largest, point_m });
            }
        }
        strains
    }
}
