//! Joints that consist of several, with carriages, bodies without mass, between them: a hinge or a ball joint on a sliding joint, NOTATION
//! eq. (J16), and chains of joints with one degree of freedom, eq. (J20).

use super::freedom::carriage;
use super::{Attitude, Holder, JointBuilder, Type};
use crate::machine::builder::body::BodyBuilder;
use crate::machine::fault::Checker;
use crate::machine::{Body, Joint};
use nalgebra::{Matrix3, Vector3};
use std::borrow::Cow;

impl JointBuilder {
    /// Attitude of the body of a sliding joint. Default [`Attitude::Section`].
    ///
    /// With the other attitudes the machine has two parts more: the body `<joint>_carriage` without mass, which this joint moves along the
    /// beam, and the joint `<joint>_hinge` or `<joint>_ball` of the body on it. [`JointBuilder::offset_m`] is the position of the hinge or
    /// ball in the frame of the section; the mount and the start values of a revolute or ball joint apply to the body on the carriage, and
    /// all forces, latches, end stops and motions to the position along the beam.
    pub fn attitude(self, attitude: Attitude) -> Self {
        Self { attitude, ..self }
    }

    /// Reports an attitude of a joint that does not slide along a beam.
    pub(super) fn refuse_attitude(&self, checker: &mut Checker) {
        if self.attitude != Attitude::Section && self.kind != Type::Sliding {
            let allowed = "this key only with type = \"sliding\"";
            checker.refuse(&["joint", &self.name, "attitude"], format!("{:?}", self.attitude), allowed);
        }
    }

    /// The joints of which this one consists, from the parent outward; none if it is a single joint.
    fn links(&self) -> Vec<JointBuilder> {
        let Some([_, joint]) = self.attitude.parts(&self.name).filter(|_| self.kind == Type::Sliding) else {
            return self.chain();
        };
        let mut slide = JointBuilder { attitude: Attitude::Section, ..self.clone() };
        let turning = match self.attitude {
            Attitude::Hinge(axis) => JointBuilder {
                start_angle_rad: slide.start_angle_rad.take(),
                start_rate_rad_s: slide.start_rate_rad_s.take(),
                ..Joint::revolute(joint, axis)
            },
            Attitude::Section | Attitude::Ball => JointBuilder {
                start_angular_velocity_rad_s: slide.start_angular_velocity_rad_s.take(),
                ..Joint::ball(joint)
            },
        };
        vec![slide, turning]
    }

    /// The body on the last of these joints, and a carriage on each of the others.
    fn parts(&self, body: &BodyBuilder) -> Option<Vec<(BodyBuilder, JointBuilder)>> {
        let links = self.links();
        let last = links.len().checked_sub(1)?;
        let placed = links.into_iter().enumerate().map(|(index, link)| {
            let carried = if index == last {
                (body.clone(), self.mount)
            } else {
                (Body::rigid(carriage(&self.name, index)).load_stations(0), Matrix3::identity())
            };
            let (holder, offset_m) = match index.checked_sub(1) {
                Some(inner) => (Holder::Body(carriage(&self.name, inner), None), Vector3::zeros()),
                None => (self.holder.clone(), self.offset_m),
            };
            (carried.0, JointBuilder { holder, offset_m, mount: carried.1, ..link })
        });
        Some(placed.collect())
    }
}

/// Bodies with their joints, with a carriage before every body that rotates on a sliding joint or is held by a chain of joints.
pub(in crate::machine::builder) fn with_carriages<'b>(
    bodies: &'b [(BodyBuilder, JointBuilder)],
    checker: &mut Checker,
) -> Cow<'b, [(BodyBuilder, JointBuilder)]> {
    bodies.iter().for_each(|(_, joint)| joint.refuse_freedoms(checker));
    let is_single = |joint: &JointBuilder| joint.attitude == Attitude::Section && joint.kind.freedoms().is_empty();
    if bodies.iter().all(|(_, joint)| is_single(joint)) {
        return Cow::Borrowed(bodies);
    }
    for (_, joint) in bodies.iter().filter(|(_, joint)| !joint.kind.freedoms().is_empty()) {
        joint.refuse_strangers(checker);
        joint.refuse_attitude(checker);
    }
    let parted = bodies.iter().flat_map(|(body, joint)| match joint.parts(body) {
        Some(parts) => parts,
        None => vec![(body.clone(), joint.clone())],
    });
    Cow::Owned(parted.collect())
}
