//! Declared dependencies of outputs.
//!
//! A [`Cause`] represents all rows that act on the output in the same way; [`crate::interface::dependencies`] lists them.

use crate::interface::DependencyKind;
use crate::interface::topology::Topology;

/// One way in which inputs, parameters and time act on an output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cause {
    /// Command of a joint.
    Command(usize),
    /// Commands of all joints.
    AnyCommand,
    /// Connection of a joint's generator.
    Generator(usize),
    /// Voltage of a joint's DC motor.
    Voltage(usize),
    /// External torque of a joint.
    Torque(usize),
    /// Gravity and the root's linear acceleration.
    Weight,
    /// Time, if the motion of a joint is prescribed.
    Prescribed(usize),
    /// Time, if a joint between the root and a body is prescribed.
    Travel(usize),
    /// Time, if any joint is prescribed.
    AnyTravel,
    /// Time, if a joint between the root and either side of a closed loop is prescribed.
    LoopTravel(usize),
    /// Everything that changes accelerations within reach instantaneously.
    Push(Reach),
    /// Aerodynamic loads, which are given functions of time at a communication point.
    Air,
    /// Initial aerodynamic loads.
    AirStart,
    /// Start angle of a joint.
    Start(usize),
    /// Start rate of a joint.
    StartRate(usize),
    /// Initial torque of a motor.
    MotorStart(usize),
    /// Initial torque of a spring and damper of a joint.
    SpringStart(usize),
    /// Initial energy of a spring of a joint.
    SpringStore(usize),
    /// Initial torque of an elastic latch.
    LatchPull(usize),
    /// Initial state of a latch.
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
    /// Initial potential energy of the motors.
    DriveStart,
    /// Angle of a control surface.
    Flap(usize),
    /// Rate of a control surface.
    FlapRate(usize),
    /// Inputs that trigger failures.
    AnyFailure,
}

/// Bodies whose accelerations act on an output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Reach {
    /// All branches attached to the root.
    Root,
    /// The branches joined by closed loops with inertia, by their group: groups are connected only by the root, whose motion is given, and
    /// by springs and dampers, whose forces follow from the state.
    Group(usize),
    /// Inertial motion of a floating group.
    Flight(usize),
}

/// Dependencies of an output.
#[derive(Debug, Clone)]
pub(super) struct Depends {
    /// At a communication point, with the state held constant.
    pub running: Vec<Cause>,
    /// Initially, for a model that starts unstrained.
    pub initial: Vec<Cause>,
    /// If the simulation starts from equilibrium, the initial value is that of the equilibrium.
    pub settles: bool,
    /// Kind of dependence of the initial value on parameters.
    pub factor: DependencyKind,
}

impl Depends {
    /// Dependencies of an output whose initial value is that of an equilibrium.
    pub fn new(running: impl Into<Vec<Cause>>, initial: impl Into<Vec<Cause>>) -> Self {
        Self { running: running.into(), initial: initial.into(), settles: true, factor: DependencyKind::Dependent }
    }

    /// Dependence on all loads within reach.
    pub fn on_push(reach: Reach) -> Self {
        Self::new([Cause::Push(reach), Cause::Air], [Cause::Accelerate(reach), Cause::AirStart])
    }

    /// Dependence on all loads on the group of a body.
    pub fn on_group(topology: &Topology, body: usize) -> Self {
        Self::on_push(Reach::Group(topology.group[body]))
    }

    /// Returns whether aerodynamic loads act on the output.
    pub fn is_in_air(&self) -> bool {
        self.running.iter().any(|cause| matches!(cause, Cause::Air))
    }

    /// Sets whether the initial value is that of an equilibrium.
    pub fn settling(mut self, settles: bool) -> Self {
        self.settles = settles;
        self
    }
}
