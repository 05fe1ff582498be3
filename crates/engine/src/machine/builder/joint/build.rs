//! Builds a joint from its description in code, with checks.

use super::{JointBuilder, Type, attitude};
use crate::force::prescribed::Law;
use crate::machine::fault::{Checker, array_text};
use crate::machine::units::{quoted, shortest};
use crate::machine::validate::joint::{ACROSS, check_motion};
use crate::machine::{
    Joint, JointKind, JointMotion, Motion, Motor, OneFreedom, Parent, Spatial, SpatialFreedom, Travel,
};
use nalgebra::Vector3;

impl JointBuilder {
    /// Builds the joint on a known parent; invalid values are replaced after an error.
    pub(in crate::machine::builder) fn build(&self, parent: Parent, start_time_s: f64, checker: &mut Checker) -> Joint {
        self.refuse_strangers(checker);
        self.refuse_attitude(checker);
        let kind = match self.kind {
            Type::Clamped => JointKind::Clamped,
            Type::Revolute => {
                let start = (self.start_angle_rad, self.start_rate_rad_s);
                JointKind::Revolute(Box::new(self.build_one_freedom(Travel::Rotation, start, start_time_s, checker)))
            }
            Type::Prismatic => {
                let start = (self.start_position_m, self.start_rate_m_s);
                JointKind::Prismatic(Box::new(self.build_one_freedom(
                    Travel::Translation,
                    start,
                    start_time_s,
                    checker,
                )))
            }
            Type::Sliding => {
                let start = (self.start_position_m, self.start_rate_m_s);
                JointKind::Sliding(Box::new(self.build_one_freedom(Travel::Translation, start, start_time_s, checker)))
            }
            Type::Universal | Type::Ball | Type::Free => JointKind::Spatial(Box::new(self.build_spatial(checker))),
            Type::Cylindrical => unreachable!("a chain is divided into its joints"),
        };
        Joint { name: self.name.clone(), parent, offset_m: self.offset_m, mount: self.mount, kind }
    }

    /// Reports values that do not apply to this type of joint.
    pub(super) fn refuse_strangers(&self, checker: &mut Checker) {
        use Type::{Ball, Free, Prismatic, Revolute, Sliding, Universal};
        let stated: [(&str, &[Type], Option<String>); 10] = [
            (
                "start_angular_velocity_rad_s",
                &[Universal, Ball, Free],
                self.start_angular_velocity_rad_s.map(|v| array_text(v.as_slice())),
            ),
            ("start_velocity_m_s", &[Free], self.start_velocity_m_s.map(|v| array_text(v.as_slice()))),
            ("start_angle_rad", &[Revolute], self.start_angle_rad.map(shortest)),
            ("start_rate_rad_s", &[Revolute], self.start_rate_rad_s.map(shortest)),
            ("start_position_m", &[Prismatic, Sliding], self.start_position_m.map(shortest)),
            ("start_rate_m_s", &[Prismatic, Sliding], self.start_rate_m_s.map(shortest)),
            ("release", &[Revolute, Prismatic, Sliding], self.release.map(|release| release.to_string())),
            ("motion", &[Revolute, Prismatic, Sliding], self.motion.as_ref().map(|motion| format!("{motion:?}"))),
            (
                "motor",
                &[Revolute, Prismatic, Sliding, Universal, Ball],
                self.motor.as_ref().map(|_| "a motor".to_owned()),
            ),
            ("spring", &[Revolute, Prismatic, Sliding], self.spring.map(|_| "a spring".to_owned())),
        ];
        let latch = self.latch.as_ref().map(|_| "a latch".to_owned());
        let end_stops = self.end_stops.map(|_| "end_stops".to_owned());
        let generator = self.generator.as_ref().map(|_| "a generator".to_owned());
        let dc_motor = self.dc_motor.map(|_| "a DC motor".to_owned());
        let machinery: [(&str, &[Type], Option<String>); 4] = [
            ("latch", &[Revolute, Prismatic, Sliding], latch),
            ("end_stops", &[Revolute, Prismatic, Sliding], end_stops),
            ("generator", &[Revolute], generator),
            ("dc_motor", &[Revolute, Prismatic, Sliding], dc_motor),
        ];
        for (key, types, found) in stated.into_iter().chain(machinery) {
            if let (Some(found), false) = (found, types.contains(&self.kind)) {
                let names: Vec<&str> = types.iter().copied().map(Type::name).collect();
                let freedoms = self.kind.freedoms().iter().filter(|own| types.contains(&Type::of_travel(own.travel)));
                let freedoms: Vec<&str> = freedoms.map(|own| own.name).collect();
                let allowed = match attitude::of_start(key).filter(|_| self.kind == Sliding) {
                    Some(attitude) => format!("this key of a sliding joint only with attitude = {attitude:?}"),
                    None if !freedoms.is_empty() => {
                        format!("this key of a {} joint only in its {}", self.kind.name(), quoted(&freedoms))
                    }
                    None => format!("this key only with type = {}", quoted(&names)),
                };
                checker.refuse(&["joint", &self.name, key], found, allowed);
            }
        }
    }

    fn build_one_freedom(
        &self,
        travel: Travel,
        (start, rate): (Option<f64>, Option<f64>),
        start_time_s: f64,
        checker: &mut Checker,
    ) -> OneFreedom {
        let name = self.name.as_str();
        let motion = self.motion.clone().unwrap_or(JointMotion::Free);
        let motor = self.motor.clone().unwrap_or_default();
        let spring = self.spring;
        let own_n_m_rad = motor.stiffness_n_m_rad + spring.map_or(0.0, |spring| spring.stiffness_n_m_rad);
        let start_angle_rad = match &motion {
            JointMotion::Prescribed(law) => {
                if let Some(start) = start {
                    let allowed = travel.words("no start angle with motion = \"prescribed\", which determines it");
                    checker.refuse(&["joint", name, &travel.words("start_angle_rad")], shortest(start), allowed);
                }
                // an invalid prescribed motion is reported with the machine
                let sound = check_motion(&["joint", name, "motion"], travel, law, &mut Checker::default());
                if sound { law_start_rad(law, start_time_s) } else { 0.0 }
            }
            JointMotion::Free | JointMotion::Locked => start.unwrap_or(0.0),
        };
        OneFreedom {
            axis: self.unit_axis("axis", &self.axis, checker).unwrap_or(Vector3::x()),
            start_angle_rad,
            start_rate_rad_s: rate.unwrap_or(0.0),
            motion,
            release: self.release.unwrap_or(true),
            motor,
            spring,
            generator: self.generator.clone(),
            dc_motor: self.dc_motor,
            latch: self.latch.as_ref().map(|latch| latch.build(name, travel, own_n_m_rad, checker)),
            end_stops: self.end_stops,
        }
    }

    /// The direction as a unit vector; `None` if its length is zero, which is an error.
    fn unit_axis(&self, key: &str, direction: &Vector3<f64>, checker: &mut Checker) -> Option<Vector3<f64>> {
        let largest = direction.amax();
        if largest > 0.0 && largest < f64::INFINITY {
            return Some((direction / largest).normalize());
        }
        let found = array_text(direction.as_slice());
        checker.refuse(&["joint", &self.name, key], found, "an array of 3 finite numbers, not all 0");
        None
    }

    /// Axes of a universal joint and its initial angular velocity without the round-off component normal to both axes. If an axis is
    /// invalid, a ball joint replaces the joint.
    fn universal(&self, mut spin: Vector3<f64>, checker: &mut Checker) -> (SpatialFreedom, Vector3<f64>) {
        let axes = [("axis", &self.axis), ("body_axis", &self.body_axis)];
        let [Some(parent_axis), Some(body_axis)] = axes.map(|(key, axis)| self.unit_axis(key, axis, checker)) else {
            return (SpatialFreedom::Ball, spin);
        };
        let normal = parent_axis.cross(&(self.mount * body_axis)).normalize();
        let part = normal * normal.dot(&spin);
        // a larger component is reported with the machine
        if spin.amax() > 0.0 && part.norm() <= ACROSS * spin.norm() {
            spin -= part;
        }
        (SpatialFreedom::Universal { parent_axis, body_axis }, spin)
    }

    fn build_spatial(&self, checker: &mut Checker) -> Spatial {
        let spin = self.start_angular_velocity_rad_s.unwrap_or_default();
        let (freedom, spin) = match self.kind {
            Type::Universal => self.universal(spin, checker),
            Type::Free => (SpatialFreedom::Free, spin),
            Type::Ball | Type::Clamped | Type::Revolute | Type::Prismatic | Type::Sliding | Type::Cylindrical => {
                (SpatialFreedom::Ball, spin)
            }
        };
        let free = self.kind == Type::Free;
        let motor = self.motor.clone().filter(|_| !free).unwrap_or_default(); // a motor on a free joint is an error
        self.refuse_motor(&motor, checker);
        Spatial {
            freedom,
            stiffness_n_m_rad: motor.stiffness_n_m_rad,
            damping_n_m_s_rad: motor.damping_n_m_s_rad,
            start_angular_velocity_rad_s: spin,
            start_velocity_m_s: self.start_velocity_m_s.filter(|_| free).unwrap_or_default(),
        }
    }

    /// Reports values that apply to the motor of a revolute joint only.
    fn refuse_motor(&self, motor: &Motor, checker: &mut Checker) {
        let none = Motor::default();
        for (key, value, default) in [
            ("constant_torque_n_m", motor.constant_torque_n_m, none.constant_torque_n_m),
            ("torque_limit_n_m", motor.torque_limit_n_m, none.torque_limit_n_m),
            ("rate_limit_rad_s", motor.rate_limit_rad_s, none.rate_limit_rad_s),
            ("inertia_kg_m2", motor.inertia_kg_m2, none.inertia_kg_m2),
            ("command_rad", motor.command_rad, none.command_rad),
        ] {
            if value != default {
                let allowed = "this key only with type = \"revolute\"";
                checker.refuse(&["joint", &self.name, "motor", key], shortest(value), allowed);
            }
        }
    }
}

/// Angle (rad) or position (m) of a prescribed motion at a time; between the points of a table only approximate (linear).
fn law_start_rad(law: &Motion, time_s: f64) -> f64 {
    match law {
        Motion::Polynomial(coefficients) => coefficients.iter().rev().fold(0.0, |sum, c| sum * time_s + c),
        Motion::Onward(_) => Law::new(law).at(time_s)[0],
        Motion::Table(points) | Motion::QuasiStatic(points) => {
            let after = points.partition_point(|(time, _)| *time <= time_s);
            match (points.get(after.wrapping_sub(1)), points.get(after)) {
                (Some((t0, a0)), Some((t1, a1))) => a0 + (a1 - a0) * (time_s - t0) / (t1 - t0),
                (Some((_, angle)), None) | (None, Some((_, angle))) => *angle,
                (None, None) => 0.0,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_of_a_law() {
        let table = Motion::Table(vec![(1.0, 0.0), (3.0, 1.0)]);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(|t| law_start_rad(&table, t)), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(law_start_rad(&Motion::Polynomial(vec![1.0, 2.0, 3.0]), 2.0), 17.0);
    }
}
