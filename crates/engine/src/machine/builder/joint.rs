//! Joints in code: equivalent of a table `[joint.<name>]` of the model file.

mod attitude;
mod build;
pub(super) mod carriage;
mod chain;
pub(super) mod freedom;
mod kind;

pub use attitude::Attitude;
pub(super) use kind::Type;

use crate::machine::builder::latch::LatchBuilder;
use crate::machine::{DcMotor, EndStops, GeneratorLaw, Joint, JointMotion, Motion, Motor, OneFreedom, Spring};
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
}
