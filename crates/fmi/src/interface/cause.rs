//! What an output depends on, as its row declares it.
//!
//! A [`Cause`] stands for all rows that reach the output in one way; [`crate::interface::dependencies`] says which those are.

use crate::interface::DependencyKind;
use crate::interface::topology::Topology;

/// One way in which inputs, parameters and time reach an output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cause {
    /// Command of a joint.
    Command(usize),
    /// Commands of all joints.
    AnyCommand,
    /// Whether a joint's generator is connected.
    Generator(usize),
    /// External torque of a joint.
    Torque(usize),
    /// Gravity and the root's linear acceleration.
    Weight,
    /// Time, where the motion of a joint is prescribed.
    Prescribed(usize),
    /// Time, where a prescribed joint lies between the root and a body.
    Travel(usize),
    /// Time, where any joint is prescribed.
    AnyTravel,
    /// Time, where a prescribed joint lies between the root and either side of a closed loop.
    LoopTravel(usize),
    /// Everything that changes accelerations within reach at once.
    Push(Reach),
    /// Loads of the air, which are given functions of time at a communication point.
    Air,
    /// Initial loads of the air.
    AirStart,
    /// Start angle of a joint.
    Start(usize),
    /// Start rate of a joint.
    StartRate(usize),
    /// Initial torque of a motor.
    MotorStart(usize),
    /// Initial torque of a joint's own spring and damper.
    SpringStart(usize),
    /// Initial energy of a joint's own spring.
    SpringStore(usize),
    /// Initial torque of an elastic latch.
    LatchPull(usize),
    /// Whether a latch is closed at the start.
    LatchStart(usize),
    /// Initial accelerations within reach.
    Accelerate(Reach),
    /// Factor on the stiffness of a body.
    Stiffness(usize),
    /// Factors on the inertia of all bodies.
    AnyMassFactor,
    /// Start angles of the joints between the root and a body.
    Folds(usize),
    /// Initial force of a closed loop.
    LoopPull(usize),
    /// Initial moment of a ball joint's damper.
    BallStart(usize),
    /// Initial velocity of a point of a body.
    VelocityStart(usize),
    /// Initial angular velocity of a point of a body.
    AngularVelocityStart(usize),
    /// Initial attitude of a point of a body.
    AttitudeStart(usize),
    /// Initial kinetic energy.
    KineticStart,
    /// Initial potential of the motors.
    DriveStart,
    /// Angle of a flap.
    Flap(usize),
    /// Rate of a flap.
    FlapRate(usize),
    /// Inputs that bring failures about.
    AnyFailure,
}

/// Bodies whose accelerations an output feels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Reach {
    /// All branches that the root holds.
    Root,
    /// The branches that closed loops with inertia join, by their group: groups meet only at the root, whose motion is
    /// given, and in springs and dampers, whose forces follow from the state.
    Group(usize),
    /// Inertial motion of a group that floats.
    Flight(usize),
}

/// What an output depends on.
#[derive(Debug, Clone)]
pub(super) struct Depends {
    /// At a communication point, state frozen.
    pub running: Vec<Cause>,
    /// Initially, of a machine that starts unstrained.
    pub initial: Vec<Cause>,
    /// Where the experiment starts from equilibrium the initial value is that of the equilibrium.
    pub settles: bool,
    /// How the initial value depends on parameters.
    pub factor: DependencyKind,
}

impl Depends {
    /// Of an output whose initial value is that of an equilibrium.
    pub fn new(running: impl Into<Vec<Cause>>, initial: impl Into<Vec<Cause>>) -> Self {
        Self { running: running.into(), initial: initial.into(), settles: true, factor: DependencyKind::Dependent }
    }

    /// On all that pushes within reach.
    pub fn on_push(reach: Reach) -> Self {
        Self::new([Cause::Push(reach), Cause::Air], [Cause::Accelerate(reach), Cause::AirStart])
    }

    /// On what pushes the group of a body.
    pub fn on_group(topology: &Topology, body: usize) -> Self {
        Self::on_push(Reach::Group(topology.group[body]))
    }

    /// Whether an equilibrium decides about the initial value.
    pub fn settling(mut self, settles: bool) -> Self {
        self.settles = settles;
        self
    }
}
