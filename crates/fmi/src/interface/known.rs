//! Knowns in the rules of dependence: time, inputs and parameters.

/// Row on which others may depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Known {
    /// The independent variable.
    Time,
    /// An input.
    Input(Input),
    /// A parameter.
    Parameter(Parameter),
}

/// An input; indices as in [`foldwing_engine::plant::Inputs`]. The components of a vector are one known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Input {
    /// An input of a revolute or prismatic joint.
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
    /// Wind velocity.
    Wind,
    /// Trigger of a failure.
    Failure(usize),
    /// Angle of a control surface.
    Flap(usize),
    /// Rate of a control surface.
    FlapRate(usize),
}

/// An input of a revolute or prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JointInput {
    /// Neutral angle.
    Command,
    /// External torque.
    Torque,
    /// Release of the lock.
    Release,
    /// Enabling of the latch.
    LatchEnable,
    /// Connection of the generator.
    GeneratorOn,
    /// Voltage of the DC motor.
    Voltage,
}

/// A parameter; indices as in [`foldwing_engine::plant::Parameters`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parameter {
    /// A parameter of a revolute or prismatic joint.
    Joint(usize, JointParameter),
    /// A parameter of a universal or ball joint.
    Spatial(usize, SpatialParameter),
    /// A parameter of a body.
    Body(usize, BodyParameter),
    /// Air density.
    AirDensity,
    /// A parameter of the time integration.
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
    /// Maximum motor torque.
    TorqueLimit,
    /// Maximum slew rate of the neutral angle.
    RateLimit,
    /// Stiffness of the joint's spring.
    SpringStiffness,
    /// Damping parallel to this spring.
    SpringDamping,
    /// Angle at which this spring has no torque.
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
