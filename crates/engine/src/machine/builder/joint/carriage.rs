//! Bodies that rotate on sliding joints: a hinge or a ball joint holds them on a carriage without mass, NOTATION eq. (J16).

use super::{Attitude, Holder, JointBuilder, Type};
use crate::machine::builder::body::BodyBuilder;
use crate::machine::fault::Checker;
use crate::machine::{Body, Joint};
use nalgebra::Matrix3;
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

    /// The carriage and the body, each with its joint, if the body rotates on a sliding joint.
    fn parts(&self, body: &BodyBuilder) -> Option<[(BodyBuilder, JointBuilder); 2]> {
        let [carriage, joint] = self.attitude.parts(&self.name).filter(|_| self.kind == Type::Sliding)?;
        let mut slide = JointBuilder { attitude: Attitude::Section, mount: Matrix3::identity(), ..self.clone() };
        let mut turning = match self.attitude {
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
        (turning.holder, turning.mount) = (Holder::Body(carriage.clone(), None), self.mount);
        Some([(Body::rigid(carriage).load_stations(0), slide), (body.clone(), turning)])
    }
}

/// Bodies with their joints, with a carriage before every body that rotates on a sliding joint.
pub(in crate::machine::builder) fn with_carriages(
    bodies: &[(BodyBuilder, JointBuilder)],
) -> Cow<'_, [(BodyBuilder, JointBuilder)]> {
    if bodies.iter().all(|(_, joint)| joint.attitude == Attitude::Section) {
        return Cow::Borrowed(bodies);
    }
    let parted = bodies.iter().flat_map(|(body, joint)| match joint.parts(body) {
        Some(parts) => parts.to_vec(),
        None => vec![(body.clone(), joint.clone())],
    });
    Cow::Owned(parted.collect())
}
