//! Joints in code: equivalent of a table `[joint.<name>]` of the model file.

mod attitude;
pub(super) mod carriage;
mod chain;
pub(super) mod freedom;
mod kind;

pub use attitude::Attitude;
pub(super) use kind::Type;

use crate::force::prescribed::Law;
use crate::machine::builder::latch::LatchBuilder;
use crate::machine::fault::{Checker, array_text};
use crate::machine::units::{quoted, shortest};
use crate::machine::validate::joint::{ACROSS, check_motion};
use crate::machine::{
    DcMotor, EndStops, GeneratorLaw, Joint, JointKind, JointMotion, Motion, Motor, OneFreedom, Parent, Spatial,
    SpatialFreedom, Spring, Travel,
};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Parent of a joint, by name.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Holder {
    /// The root frame, at a position in m.
    Root(Vector3<f64>),
    /// A body, at a distance in m from its inner end or at its outer end.
    Body(String, Option<f64>),
}

/// A joint under construction, see [`Joint::clamped`], [`Joint::revolute`], [`Joint::prismatic`], [`Joint::universal`], [`Joint::ball`],
/// [`Joint::free`], [`Joint::cylindrical`]. By default its parent is the root, at its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct JointBuilder {
    pub(super) name: String,
    pub(super) kind: Type,
    pub(super) holder: Holder,
    mount: Matrix3<f64>,
    offset_m: Vector3<f64>,
    axis: Vector3<f64>,
    body_axis: Vector3<f64>,
    attitude: Attitude,
    /// Degrees of freedom of a chain, as joints of one degree of freedom without a name.
    freedoms: Vec<JointBuilder>,
    start_angular_velocity_rad_s: Option<Vector3<f64>>,
    start_velocity_m_s: Option<Vector3<f64>>,
    start_angle_rad: Option<f64>,
    start_rate_rad_s: Option<f64>,
    start_position_m: Option<f64>,
    start_rate_m_s: Option<f64>,
    release: Option<bool>,
    motion: Option<JointMotion>,
    motor: Option<Motor>,
    spring: Option<Spring>,
    generator: Option<GeneratorLaw>,
    dc_motor: Option<DcMotor>,
    latch: Option<LatchBuilder>,
    end_stops: Option<EndStops>,
}

impl Joint {
    fn builder(name: impl Into<String>, kind: Type) -> JointBuilder {
        JointBuilder {
            name: name.into(),
            kind,
            holder: Holder::Root(Vector3::zeros()),
            mount: Matrix3::identity(),
            offset_m: Vector3::zeros(),
            axis: Vector3::zeros(),
            body_axis: Vector3::zeros(),
            attitude: Attitude::Section,
            freedoms: Vec::new(),
            start_angular_velocity_rad_s: None,
            start_velocity_m_s: None,
            start_angle_rad: None,
            start_rate_rad_s: None,
            start_position_m: None,
            start_rate_m_s: None,
            release: None,
            motion: None,
            motor: None,
            spring: None,
            generator: None,
            dc_motor: None,
            latch: None,
            end_stops: None,
        }
    }

    /// A joint without degrees of freedom.
    pub fn clamped(name: impl Into<String>) -> JointBuilder {
        Self::builder(name, Type::Clamped)
    }

    /// A revolute joint about `axis` in the parent's section frame, of any nonzero length; positive angles by the right-hand rule.
    pub fn revolute(name: impl Into<String>, axis: impl Into<Vector3<f64>>) -> JointBuilder {
        JointBuilder { axis: axis.into(), ..Self::builder(name, Type::Revolute) }
    }

    /// A prismatic joint along `axis` in the parent's section frame, of any nonzero length; positive in its direction.
    pub fn prismatic(name: impl Into<String>, axis: impl Into<Vector3<f64>>) -> JointBuilder {
        JointBuilder { axis: axis.into(), ..Self::builder(name, Type::Prismatic) }
    }

    /// A sliding joint along the axis of the beam that is its parent: the body keeps the attitude of the beam's section at the arc length
    /// [`JointBuilder::start_position_m`], and moves along the beam from there. A body that also rotates has another
    /// [`JointBuilder::attitude`].
    pub fn sliding(name: impl Into<String>) -> JointBuilder {
        JointBuilder { axis: Vector3::x(), ..Self::builder(name, Type::Sliding) }
    }

    /// A revolute joint with all fields set.
    pub fn hinge(name: impl Into<String>, hinge: OneFreedom) -> JointBuilder {
        let (start, rate, builder) = Self::one_freedom(name, Type::Revolute, hinge);
        JointBuilder { start_angle_rad: start, start_rate_rad_s: rate, ..builder }
    }

    /// A prismatic joint with all fields set.
    pub fn slide(name: impl Into<String>, slide: OneFreedom) -> JointBuilder {
        let (start, rate, builder) = Self::one_freedom(name, Type::Prismatic, slide);
        JointBuilder { start_position_m: start, start_rate_m_s: rate, ..builder }
    }

    /// Returns the start, the start rate and a builder with all other fields.
    fn one_freedom(name: impl Into<String>, kind: Type, joint: OneFreedom) -> (Option<f64>, Option<f64>, JointBuilder) {
        let OneFreedom {
            axis,
            start_angle_rad,
            start_rate_rad_s,
            motion,
            release,
            motor,
            spring,
            generator,
            dc_motor,
            latch,
            end_stops,
        } = joint;
        let prescribed = matches!(motion, JointMotion::Prescribed(_)); // prescribed: the motion determines the start
        let builder = JointBuilder {
            axis,
            motion: Some(motion),
            release: Some(release),
            motor: Some(motor),
            spring,
            generator,
            dc_motor,
            latch: latch.map(LatchBuilder::from),
            end_stops,
            ..Self::builder(name, kind)
        };
        (Some(start_angle_rad).filter(|_| !prescribed), Some(start_rate_rad_s), builder)
    }

    /// A universal joint: rotation about `axis`, in the parent's section frame, and `body_axis`, in the body's section frame.
    pub fn universal(
        name: impl Into<String>,
        axis: impl Into<Vector3<f64>>,
        body_axis: impl Into<Vector3<f64>>,
    ) -> JointBuilder {
        JointBuilder { axis: axis.into(), body_axis: body_axis.into(), ..Self::builder(name, Type::Universal) }
    }

    /// A ball joint, which allows all rotations.
    pub fn ball(name: impl Into<String>) -> JointBuilder {
        Self::builder(name, Type::Ball)
    }

    /// A cylindrical joint: a translation along `axis` and a rotation about it, in the parent's section frame, of any nonzero length.
    /// [`JointBuilder::translation`] and [`JointBuilder::rotation`] set start, motion and forces of each.
    ///
    /// The machine then has two joints, `<joint>_translation` and `<joint>_rotation`, with all that prismatic and revolute joints have, and
    /// between them the body `<joint>_carriage` without mass.
    pub fn cylindrical(name: impl Into<String>, axis: impl Into<Vector3<f64>>) -> JointBuilder {
        JointBuilder { axis: axis.into(), ..Self::builder(name, Type::Cylindrical) }
    }

    /// A free joint, for a free-flying body. Its parent must be the root.
    pub fn free(name: impl Into<String>) -> JointBuilder {
        Self::builder(name, Type::Free)
    }
}

impl JointBuilder {
    /// Attaches the joint to the outer end of the body `parent`; `"root"` is the root frame's origin.
    pub fn on(self, parent: impl Into<String>) -> Self {
        let parent = parent.into();
        let holder = if parent == "root" { Holder::Root(Vector3::zeros()) } else { Holder::Body(parent, None) };
        Self { holder, ..self }
    }

    /// Attaches the joint to the body `parent` at a distance in m from its inner end.
    pub fn on_at(self, parent: impl Into<String>, position_m: f64) -> Self {
        Self { holder: Holder::Body(parent.into(), Some(position_m)), ..self }
    }

    /// Attaches the joint to the root frame at a position in m.
    pub fn at_root(self, position_m: impl Into<Vector3<f64>>) -> Self {
        Self { holder: Holder::Root(position_m.into()), ..self }
    }

    /// Offset in m from the position on the parent body to the body's first frame, in the frame of the parent's section there. Default 0;
    /// on the root use [`Self::at_root`].
    pub fn offset_m(self, offset_m: impl Into<Vector3<f64>>) -> Self {
        Self { offset_m: offset_m.into(), ..self }
    }

    /// Rotation vector in rad of the body's first frame in the parent's frame: at angle zero for revolute joints, at the start for
    /// universal, ball and free joints. Default none.
    pub fn mount_rotation_rad(self, rotation_rad: impl Into<Vector3<f64>>) -> Self {
        self.mount(Rotation3::new(rotation_rad.into()).into_inner())
    }

    /// Attitude of the body's first frame in the parent's frame as a rotation matrix, parent ← body; see [`Self::mount_rotation_rad`].
    pub fn mount(self, mount: Matrix3<f64>) -> Self {
        Self { mount, ..self }
    }

    /// Initial angular velocity in rad/s of a universal, ball or free joint's body, relative to the parent and resolved in the parent's
    /// section frame. Default 0.
    pub fn start_angular_velocity_rad_s(self, velocity_rad_s: impl Into<Vector3<f64>>) -> Self {
        Self { start_angular_velocity_rad_s: Some(velocity_rad_s.into()), ..self }
    }

    /// Initial velocity in m/s of a free body's inner end, root frame. Default 0.
    pub fn start_velocity_m_s(self, velocity_m_s: impl Into<Vector3<f64>>) -> Self {
        Self { start_velocity_m_s: Some(velocity_m_s.into()), ..self }
    }

    /// Initial fold angle of a revolute joint in rad. Default 0.
    pub fn start_angle_rad(self, angle_rad: f64) -> Self {
        Self { start_angle_rad: Some(angle_rad), ..self }
    }

    /// Initial fold rate of a revolute joint in rad/s. Default 0.
    pub fn start_rate_rad_s(self, rate_rad_s: f64) -> Self {
        Self { start_rate_rad_s: Some(rate_rad_s), ..self }
    }

    /// Initial position of a prismatic joint in m. Default 0.
    pub fn start_position_m(self, position_m: f64) -> Self {
        Self { start_position_m: Some(position_m), ..self }
    }

    /// Initial velocity of a prismatic joint in m/s. Default 0.
    pub fn start_rate_m_s(self, rate_m_s: f64) -> Self {
        Self { start_rate_m_s: Some(rate_m_s), ..self }
    }

    /// Start value of the release input of a revolute or prismatic joint; false holds it at its initial position. Default true.
    pub fn release(self, release: bool) -> Self {
        Self { release: Some(release), ..self }
    }

    /// Type of motion of a revolute or prismatic joint. Default [`JointMotion::Free`].
    pub fn motion(self, motion: JointMotion) -> Self {
        Self { motion: Some(motion), ..self }
    }

    /// Locks a revolute or prismatic joint at its initial position.
    pub fn locked(self) -> Self {
        self.motion(JointMotion::Locked)
    }

    /// Prescribes the angle of a revolute joint, or the position of a prismatic one, as a function of absolute time, which also determines
    /// the initial state.
    pub fn prescribed(self, motion: Motion) -> Self {
        self.motion(JointMotion::Prescribed(motion))
    }

    /// Motor of a revolute ([`Motor`]) or prismatic joint ([`LinearMotor`](crate::machine::LinearMotor)); spring towards the initial
    /// attitude and damper of a universal or ball joint.
    pub fn motor(self, motor: impl Into<Motor>) -> Self {
        Self { motor: Some(motor.into()), ..self }
    }

    /// Spring and damper of a revolute ([`Spring`]) or prismatic joint ([`LinearSpring`](crate::machine::LinearSpring)), in addition to its
    /// motor.
    pub fn spring(self, spring: impl Into<Spring>) -> Self {
        Self { spring: Some(spring.into()), ..self }
    }

    /// Latch of a revolute or prismatic joint, from a constructor of [`Latch`](crate::machine::Latch).
    pub fn latch(self, latch: impl Into<LatchBuilder>) -> Self {
        Self { latch: Some(latch.into()), ..self }
    }

    /// End stops of a revolute or prismatic joint: a spring and a damper beyond either end of its travel.
    pub fn end_stops(self, end_stops: EndStops) -> Self {
        Self { end_stops: Some(end_stops), ..self }
    }

    /// Generator on the high-speed shaft of a revolute joint.
    pub fn generator(self, generator: GeneratorLaw) -> Self {
        Self { generator: Some(generator), ..self }
    }

    /// Electrical DC motor of a revolute, prismatic or sliding joint, in addition to its motor.
    pub fn dc_motor(self, dc_motor: DcMotor) -> Self {
        Self { dc_motor: Some(dc_motor), ..self }
    }

    /// Builds the joint on a known parent; invalid values are replaced after an error.
    pub(super) fn build(&self, parent: Parent, start_time_s: f64, checker: &mut Checker) -> Joint {
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
    fn refuse_strangers(&self, checker: &mut Checker) {
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
