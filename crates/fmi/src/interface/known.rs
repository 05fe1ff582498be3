//! What values follow from: time, inputs and parameters, as the rules of dependence tell them apart.

/// A row that others may depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Known {
    /// The independent variable.
    Time,
    /// An input.
    Input(Input),
    /// A parameter.
    Parameter(Parameter),
}

/// An input; indices as in [`foldwing_engine::plant::Inputs`]. Components of a vector are not told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Input {
    /// Of a revolute or prismatic joint.
    Joint(usize, JointInput),
    /// Force or moment at a station.
    Load(usize),
    /// Gravity.
    Gravity,
    /// Inertial acceleration of the root's origin.
    RootAcceleration,
    /// Angular velocity of the root frame.
    RootAngularVelocity,
    /// Angular acceleration of the root frame.
    RootAngularAcceleration,
    /// Velocity of the air.
    Wind,
    /// Brings a failure about.
    Failure(usize),
    /// Angle of a flap.
    Flap(usize),
    /// Rate of a flap.
    FlapRate(usize),
}

/// An input of a revolute or prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JointInput {
    /// Neutral angle.
    Command,
    /// External torque.
    Torque,
    /// Release of the stopper.
    Release,
    /// Latch may close.
    LatchEnable,
    /// Generator is connected.
    GeneratorOn,
}

/// A parameter; indices as in [`foldwing_engine::plant::Parameters`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parameter {
    /// Of a revolute or prismatic joint.
    Joint(usize, JointParameter),
    /// Of a universal or ball joint.
    Spatial(usize, SpatialParameter),
    /// Of a body.
    Body(usize, BodyParameter),
    /// Density of the air.
    AirDensity,
    /// Of the time integration.
    Solver,
}

/// A parameter of a revolute or prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JointParameter {
    /// Fold angle at the start.
    StartAngle,
    /// Spring stiffness.
    Stiffness,
    /// Damping.
    Damping,
    /// Constant torque.
    ConstantTorque,
    /// Largest motor torque.
    TorqueLimit,
    /// Largest slew of the neutral angle.
    RateLimit,
    /// Stiffness of the joint's own spring.
    SpringStiffness,
    /// Damping beside it.
    SpringDamping,
    /// Angle at which it is slack.
    RestAngle,
    /// Stiffness of the closed latch.
    LatchStiffness,
}

/// A parameter of a universal or ball joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SpatialParameter {
    /// Spring stiffness.
    Stiffness,
    /// Damping.
    Damping,
}

/// A parameter of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BodyParameter {
    /// Factor on the beam's inertia.
    MassFactor,
    /// Factor on the section stiffness.
    StiffnessFactor,
    /// Mass-proportional damping.
    MassDamping,
    /// Stiffness-proportional damping.
    StiffnessDamping,
}
