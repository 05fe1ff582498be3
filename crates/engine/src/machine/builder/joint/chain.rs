//! Joints that are chains of joints with one degree of freedom each, with bodies without mass between them, NOTATION eq. (J20).

use super::freedom::{CYLINDRICAL, Freedom};
use super::{JointBuilder, Type};
use crate::machine::fault::Checker;
use crate::machine::{Joint, Travel};

impl JointBuilder {
    /// Start, motion, motor, spring, latch and end stops of the rotation of a cylindrical joint, as of a revolute joint:
    /// `.rotation(|own| own.start_angle_rad(0.1))`. Parent, mount and axis are those of the cylindrical joint.
    pub fn rotation(self, change: impl FnOnce(Self) -> Self) -> Self {
        self.freedom(Travel::Rotation, change)
    }

    /// Start, motion, motor, spring, latch and end stops of the translation of a cylindrical joint, as of a prismatic joint:
    /// `.translation(|own| own.start_position_m(0.1))`. Parent, mount and axis are those of the cylindrical joint.
    pub fn translation(self, change: impl FnOnce(Self) -> Self) -> Self {
        self.freedom(Travel::Translation, change)
    }

    fn freedom(mut self, travel: Travel, change: impl FnOnce(Self) -> Self) -> Self {
        let kind = Type::of_travel(travel);
        let found = self.freedoms.iter().position(|own| own.kind == kind);
        let own = found.map_or_else(|| Joint::builder("", kind), |index| self.freedoms.remove(index));
        self.freedoms.push(change(own));
        self
    }

    /// The joints of a chain, from the parent outward; none of another joint.
    pub(super) fn chain(&self) -> Vec<JointBuilder> {
        let own = |freedom: &Freedom| {
            let kind = Type::of_travel(freedom.travel);
            let stated = self.freedoms.iter().find(|own| own.kind == kind).cloned();
            let own = stated.unwrap_or_else(|| Joint::builder("", kind));
            JointBuilder { name: freedom.joint(&self.name), axis: self.axis, ..own }
        };
        self.kind.freedoms().iter().map(own).collect()
    }

    /// Reports degrees of freedom that this type of joint does not have.
    pub(super) fn refuse_freedoms(&self, checker: &mut Checker) {
        for own in &self.freedoms {
            let known = |freedom: &&Freedom| Type::of_travel(freedom.travel) == own.kind;
            if self.kind.freedoms().iter().any(|freedom| known(&freedom)) {
                continue;
            }
            let name = CYLINDRICAL.iter().find(known).map_or("freedom", |freedom| freedom.name);
            let allowed = format!("this key only with type = {:?}", Type::Cylindrical.name());
            checker.refuse(&["joint", &self.name, name], format!("a {name}"), allowed);
        }
    }
}
