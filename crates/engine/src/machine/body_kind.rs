//! Types of bodies: rigid bodies, modal bodies and beams; selections of bodies by their joints and children.

use crate::beam::element::ElementKind;
use crate::machine::{Body, DcMotor, GeneratorLaw, JointMotion, Machine, OneFreedom, Parent, Spatial};
use crate::math::strain::{SHEARED, STRAINS};

impl Machine {
    /// Bodies with a revolute or prismatic joint, and that joint.
    pub fn one_freedoms(&self) -> impl Iterator<Item = (usize, &OneFreedom)> {
        let bodies = self.bodies.iter().enumerate();
        bodies.filter_map(|(index, body)| body.joint.kind.one_freedom().map(|(_, joint)| (index, joint)))
    }

    /// Bodies with a universal, ball or free joint, and that joint.
    pub fn spatials(&self) -> impl Iterator<Item = (usize, &Spatial)> {
        let bodies = self.bodies.iter().enumerate();
        bodies.filter_map(|(index, body)| body.joint.kind.spatial().map(|joint| (index, joint)))
    }

    /// Generators on joints with free motion: indices into [`Machine::one_freedoms`], with their torque laws.
    pub fn generators(&self) -> impl Iterator<Item = (usize, &GeneratorLaw)> {
        let joints = self.one_freedoms().enumerate().filter(|(_, (_, joint))| joint.motion == JointMotion::Free);
        joints.filter_map(|(index, (_, joint))| Some((index, joint.generator.as_ref()?)))
    }

    /// Electrical DC motors on joints with free motion: indices into [`Machine::one_freedoms`], with their data.
    pub fn dc_motors(&self) -> impl Iterator<Item = (usize, &DcMotor)> {
        let joints = self.one_freedoms().enumerate().filter(|(_, (_, joint))| joint.motion == JointMotion::Free);
        joints.filter_map(|(index, (_, joint))| Some((index, joint.dc_motor.as_ref()?)))
    }

    /// Bodies with a reference frame for the deflection of their outer end: modal bodies, and beams with an axis given by points.
    pub fn framed_bodies(&self) -> impl Iterator<Item = usize> {
        let framed = |body: &Body| body.is_modal() || body.axis.is_some();
        (0..self.bodies.len()).filter(move |&body| framed(&self.bodies[body]))
    }

    /// Name of the first sliding joint, if there is one.
    pub fn sliding_joint(&self) -> Option<&str> {
        self.bodies.iter().find(|body| body.joint.kind.rides()).map(|body| body.joint.name.as_str())
    }

    /// Bodies with a free outer end: no body is attached to it.
    pub fn tip_bodies(&self) -> impl Iterator<Item = usize> {
        let carries = |body: usize| {
            self.bodies.iter().any(|child| match child.joint.parent {
                Parent::Body { index, position_m } => {
                    index == body && position_m >= self.bodies[body].length_m * (1.0 - 1e-9)
                }
                Parent::Root { .. } => false,
            })
        };
        (0..self.bodies.len()).filter(move |&body| !carries(body))
    }
}

impl Body {
    /// Whether the body has no elements: a single frame that carries masses, joints and loads.
    pub fn is_rigid(&self) -> bool {
        self.elements == 0
    }

    /// Whether it is a modal body; its elements are then the intervals over which its shapes are integrated.
    pub fn is_modal(&self) -> bool {
        self.section.modal().is_some()
    }

    /// Whether its sections rotate when it bends: always, except for a modal body without this option.
    pub fn sections_turn(&self) -> bool {
        self.section.modal().is_none_or(|law| law.section_rotation)
    }

    /// Whether the body is made of strain elements.
    pub fn is_beam(&self) -> bool {
        !self.is_rigid() && !self.is_modal()
    }

    /// Whether its elements deform in shear and have six strains.
    pub fn has_shear(&self) -> bool {
        self.is_beam() && self.section.shears()
    }

    /// Number of its elastic coordinates: the strains of each constant-strain element and of both halves of each linear one; one per shape
    /// of a modal body; none for a rigid body.
    pub fn elastic_freedoms(&self) -> usize {
        let strains = if self.has_shear() { SHEARED } else { STRAINS };
        match (self.section.modal(), self.element) {
            (Some(law), _) => law.modes(),
            (None, ElementKind::Constant) => strains * self.elements,
            (None, ElementKind::Linear) => 2 * strains * self.elements,
        }
    }
}
