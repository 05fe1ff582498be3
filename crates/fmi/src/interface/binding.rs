//! What each row of the table is bound to: one exhaustive enum, one `match` per direction.

use crate::interface::Value;
use crate::interface::fields::component;
use foldwing_engine::plant::{Inputs, Latency, OutputSet, Outputs, Parameters, Plant, Statistics};

/// What a row of the table reads and writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Binding {
    /// The independent variable.
    Time,
    /// An input.
    Input(Input),
    /// A parameter.
    Parameter(Parameter),
    /// An output.
    Output(Output),
    /// A counter of the time integration.
    Local(Counter),
    /// A duration of communication steps.
    Duration(Duration),
}

/// An input; indices as in [`Inputs`], components 0, 1, 2 for x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// Of a revolute joint.
    Joint(usize, JointInput),
    /// Force at a station.
    StationForce(usize, usize),
    /// Moment at a station.
    StationMoment(usize, usize),
    /// Gravity.
    Gravity(usize),
    /// Inertial acceleration of the root's origin.
    RootAcceleration(usize),
    /// Angular velocity of the root frame.
    RootAngularVelocity(usize),
    /// Angular acceleration of the root frame.
    RootAngularAcceleration(usize),
    /// Velocity of the air.
    Wind(usize),
}

/// An input of a revolute joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointInput {
    /// Neutral angle.
    Command,
    /// External torque.
    Torque,
    /// Release of the stopper.
    Release,
    /// Latch may close.
    LatchEnable,
}

/// A parameter; indices as in [`Parameters`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// Of a revolute joint.
    Joint(usize, JointParameter),
    /// Of a universal or ball joint.
    Spatial(usize, SpatialParameter),
    /// Of a body.
    Body(usize, BodyParameter),
    /// Density of the air.
    AirDensity,
    /// Of the time integration.
    Solver(SolverParameter),
}

/// A parameter of a revolute joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointParameter {
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
pub enum SpatialParameter {
    /// Spring stiffness.
    Stiffness,
    /// Damping.
    Damping,
}

/// A parameter of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyParameter {
    /// Factor on the beam's inertia.
    MassFactor,
    /// Factor on the section stiffness.
    StiffnessFactor,
    /// Mass-proportional damping.
    MassDamping,
    /// Stiffness-proportional damping.
    StiffnessDamping,
}

/// A parameter of the time integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolverParameter {
    /// Tolerance.
    Tolerance,
    /// Largest internal step.
    MaxStep,
    /// Smallest internal step.
    MinStep,
}

/// An output; indices as in [`Outputs`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// Of a revolute joint.
    Joint(usize, JointOutput),
    /// Of a universal, ball or free joint.
    Spatial(usize, SpatialOutput),
    /// Force of the joint that holds a body, by body.
    JointForce(usize, usize),
    /// Moment of the joint that holds a body, by body.
    JointMoment(usize, usize),
    /// Strain of a gauge.
    Gauge(usize),
    /// Force at a section, by its place in [`foldwing_engine::machine::Machine::section_loads`].
    SectionForce(usize, usize),
    /// Moment at a section.
    SectionMoment(usize, usize),
    /// Gap of a closed loop, by its place in [`foldwing_engine::machine::Machine::closures`].
    LoopGap(usize, usize),
    /// Force of a closed loop on its first body.
    LoopForce(usize, usize),
    /// Force of the wing on the aircraft.
    RootForce(usize),
    /// Moment of the wing on the aircraft.
    RootMoment(usize),
    /// Of a free end.
    Tip(usize, PointOutput),
    /// Of a load station.
    Station(usize, PointOutput),
    /// An energy.
    Energy(EnergyOutput),
    /// Force of the air.
    AirForce(usize),
    /// Moment of the air.
    AirMoment(usize),
    /// Force of the air near a load station.
    AirStationForce(usize, usize),
    /// Moment of the air near a load station.
    AirStationMoment(usize, usize),
    /// Circulation of a strip.
    AirCirculation(usize),
}

/// An output of a revolute joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointOutput {
    /// Fold angle.
    Angle,
    /// Fold rate.
    Rate,
    /// Torque of motor, spring and external torque together.
    TorqueApplied,
    /// Torque of the motor.
    MotorTorque,
    /// Torque of the joint's own spring and damper.
    SpringTorque,
    /// External torque.
    ExternalTorque,
    /// Torque of what holds the joint.
    HoldingTorque,
    /// Torque of an elastic latch, which follows from the angle.
    LatchTorque,
    /// Torque of a rigid latch, a reaction.
    LatchReaction,
    /// Latch closed.
    Latched,
    /// Time of the last closing.
    LatchTime,
    /// Number of closings.
    LatchCount,
    /// Impulse of a rigid latch's last closing.
    LatchImpulse,
}

/// An output of a universal, ball or free joint, with its component; rotations run over w, x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpatialOutput {
    /// Attitude.
    Rotation(usize),
    /// Angular velocity.
    AngularVelocity(usize),
}

/// An output of a point, with its component; rotations run over w, x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointOutput {
    /// Position.
    Position(usize),
    /// Velocity.
    Velocity(usize),
    /// Angular velocity.
    AngularVelocity(usize),
    /// Acceleration.
    Acceleration(usize),
    /// Angular acceleration.
    AngularAcceleration(usize),
    /// Attitude.
    Rotation(usize),
}

/// An energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnergyOutput {
    /// Kinetic.
    Kinetic,
    /// Elastic.
    Elastic,
    /// Gravity.
    Gravity,
    /// Drives.
    Drive,
    /// Work of inputs.
    Work,
    /// Dissipated.
    Dissipated,
    /// Total.
    Total,
}

/// A counter of the time integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counter {
    /// Accepted steps.
    Steps,
    /// Rejected steps.
    Rejections,
    /// Steps given up by Newton.
    Failures,
    /// Newton iterations.
    Iterations,
    /// Factorisations.
    Factorizations,
    /// Events.
    Events,
    /// Stages accepted without convergence.
    Unconverged,
    /// Most iterations of one stage.
    LargestIterations,
}

/// A duration of communication steps in real-time mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Duration {
    /// Of the last one.
    Last,
    /// That half of them do not exceed.
    Median,
    /// Of the slowest.
    Slowest,
}

/// Where values are read from.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    /// Inputs.
    pub inputs: &'a Inputs,
    /// Parameters.
    pub parameters: &'a Parameters,
    /// Outputs.
    pub outputs: &'a Outputs,
    /// Counters.
    pub statistics: Statistics,
    /// Durations of steps.
    pub latency: &'a Latency,
}

impl<'a> Source<'a> {
    /// Inputs and parameters of a plant, with outputs of the caller's choice.
    pub fn new(plant: &'a Plant, outputs: &'a Outputs) -> Self {
        Self {
            inputs: plant.inputs(),
            parameters: plant.parameters(),
            outputs,
            statistics: plant.statistics(),
            latency: plant.latency(),
        }
    }
}

impl Binding {
    /// Present value.
    #[inline]
    pub(super) fn read(self, source: &Source) -> Value {
        match self {
            Self::Time => Value::Real(source.outputs.time_s),
            Self::Input(input) => input.read(source.inputs),
            Self::Parameter(parameter) => Value::Real(parameter.read(source.parameters)),
            Self::Output(output) => output.read(source.outputs),
            Self::Local(counter) => Value::Integer(counter.read(&source.statistics)),
            Self::Duration(duration) => Value::Real(duration.read_s(source.latency)),
        }
    }

    /// Sets an input or parameter; the caller has checked that the row is one and that the types agree.
    #[inline]
    pub(super) fn write(self, plant: &mut Plant, value: Value) {
        match (self, value) {
            (Self::Input(input), Value::Real(value)) => {
                if let Some(slot) = input.real_mut(plant.inputs_mut()) {
                    *slot = value;
                }
            }
            (Self::Input(input), Value::Boolean(value)) => {
                if let Some(slot) = input.boolean_mut(plant.inputs_mut()) {
                    *slot = value;
                }
            }
            (Self::Parameter(parameter), Value::Real(value)) => *parameter.slot(plant.parameters_mut()) = value,
            _ => debug_assert!(false, "{self:?} cannot be set to {value:?}"),
        }
    }

    /// Outputs that the plant must have found before it is read.
    pub(super) fn needs(self) -> OutputSet {
        match self {
            Self::Output(output) => output.group(),
            Self::Time | Self::Input(_) | Self::Parameter(_) | Self::Local(_) | Self::Duration(_) => OutputSet::NONE,
        }
    }

    /// Whether the value comes from the last evaluation rather than from the importer.
    pub(super) fn is_computed(self) -> bool {
        matches!(self, Self::Output(_) | Self::Local(_) | Self::Duration(_))
    }
}

impl Input {
    /// Present value.
    #[inline]
    pub(super) fn read(self, inputs: &Inputs) -> Value {
        match self {
            Self::Joint(joint, field) => field.read(&inputs.joints[joint]),
            Self::StationForce(station, i) => Value::Real(component(&inputs.stations[station].force_n, i)),
            Self::StationMoment(station, i) => Value::Real(component(&inputs.stations[station].moment_n_m, i)),
            Self::Gravity(i) => Value::Real(component(&inputs.root.gravity_m_s2, i)),
            Self::RootAcceleration(i) => Value::Real(component(&inputs.root.acceleration_m_s2, i)),
            Self::RootAngularVelocity(i) => Value::Real(component(&inputs.root.angular_velocity_rad_s, i)),
            Self::RootAngularAcceleration(i) => Value::Real(component(&inputs.root.angular_acceleration_rad_s2, i)),
            Self::Wind(i) => Value::Real(component(&inputs.wind_m_s, i)),
        }
    }

    #[inline]
    pub(super) fn real_mut(self, inputs: &mut Inputs) -> Option<&mut f64> {
        Some(match self {
            Self::Joint(joint, JointInput::Command) => &mut inputs.joints[joint].command_rad,
            Self::Joint(joint, JointInput::Torque) => &mut inputs.joints[joint].torque_n_m,
            Self::Joint(_, JointInput::Release | JointInput::LatchEnable) => return None,
            Self::StationForce(station, i) => &mut inputs.stations[station].force_n.as_mut_slice()[i],
            Self::StationMoment(station, i) => &mut inputs.stations[station].moment_n_m.as_mut_slice()[i],
            Self::Gravity(i) => &mut inputs.root.gravity_m_s2.as_mut_slice()[i],
            Self::RootAcceleration(i) => &mut inputs.root.acceleration_m_s2.as_mut_slice()[i],
            Self::RootAngularVelocity(i) => &mut inputs.root.angular_velocity_rad_s.as_mut_slice()[i],
            Self::RootAngularAcceleration(i) => &mut inputs.root.angular_acceleration_rad_s2.as_mut_slice()[i],
            Self::Wind(i) => &mut inputs.wind_m_s.as_mut_slice()[i],
        })
    }

    fn boolean_mut(self, inputs: &mut Inputs) -> Option<&mut bool> {
        match self {
            Self::Joint(joint, JointInput::Release) => Some(&mut inputs.joints[joint].release),
            Self::Joint(joint, JointInput::LatchEnable) => Some(&mut inputs.joints[joint].latch_enable),
            _ => None,
        }
    }
}

impl Parameter {
    /// Present value.
    pub(super) fn read(self, parameters: &Parameters) -> f64 {
        match self {
            Self::Joint(joint, field) => field.read(&parameters.joints[joint]),
            Self::Spatial(joint, field) => field.read(&parameters.spatial[joint]),
            Self::Body(body, field) => field.read(&parameters.bodies[body]),
            Self::AirDensity => parameters.air_density_kg_m3,
            Self::Solver(SolverParameter::Tolerance) => parameters.tolerance,
            Self::Solver(SolverParameter::MaxStep) => parameters.max_step_s,
            Self::Solver(SolverParameter::MinStep) => parameters.min_step_s,
        }
    }

    pub(super) fn slot(self, parameters: &mut Parameters) -> &mut f64 {
        match self {
            Self::Joint(joint, field) => field.slot(&mut parameters.joints[joint]),
            Self::Spatial(joint, field) => field.slot(&mut parameters.spatial[joint]),
            Self::Body(body, field) => field.slot(&mut parameters.bodies[body]),
            Self::AirDensity => &mut parameters.air_density_kg_m3,
            Self::Solver(SolverParameter::Tolerance) => &mut parameters.tolerance,
            Self::Solver(SolverParameter::MaxStep) => &mut parameters.max_step_s,
            Self::Solver(SolverParameter::MinStep) => &mut parameters.min_step_s,
        }
    }
}

impl Output {
    /// Present value.
    #[inline]
    pub(super) fn read(self, outputs: &Outputs) -> Value {
        match self {
            Self::Joint(joint, field) => field.read(&outputs.joints[joint]),
            Self::Spatial(joint, field) => Value::Real(field.read(&outputs.spatial[joint])),
            Self::JointForce(body, i) => Value::Real(component(&outputs.joint_reactions[body].force_n, i)),
            Self::JointMoment(body, i) => Value::Real(component(&outputs.joint_reactions[body].moment_n_m, i)),
            Self::Gauge(gauge) => Value::Real(outputs.gauges[gauge]),
            Self::SectionForce(place, i) => Value::Real(component(&outputs.section_loads[place].force_n, i)),
            Self::SectionMoment(place, i) => Value::Real(component(&outputs.section_loads[place].moment_n_m, i)),
            Self::LoopGap(closure, i) => Value::Real(component(&outputs.loops[closure].gap_m, i)),
            Self::LoopForce(closure, i) => Value::Real(component(&outputs.loops[closure].force_n, i)),
            Self::RootForce(i) => Value::Real(component(&outputs.root.force_n, i)),
            Self::RootMoment(i) => Value::Real(component(&outputs.root.moment_n_m, i)),
            Self::Tip(tip, field) => Value::Real(field.read(&outputs.tips[tip])),
            Self::Station(station, field) => Value::Real(field.read(&outputs.stations[station])),
            Self::Energy(field) => Value::Real(field.read(&outputs.energy)),
            Self::AirForce(i) => Value::Real(component(&outputs.air.total.force_n, i)),
            Self::AirMoment(i) => Value::Real(component(&outputs.air.total.moment_n_m, i)),
            Self::AirStationForce(station, i) => Value::Real(component(&outputs.air.stations[station].force_n, i)),
            Self::AirStationMoment(station, i) => Value::Real(component(&outputs.air.stations[station].moment_n_m, i)),
            Self::AirCirculation(strip) => Value::Real(outputs.air.circulation_m2_s[strip]),
        }
    }

    /// The group that it is found with.
    fn group(self) -> OutputSet {
        match self {
            Self::Joint(_, JointOutput::HoldingTorque | JointOutput::LatchReaction) => OutputSet::HOLDING,
            Self::Joint(..) => OutputSet::JOINTS,
            Self::Spatial(..) => OutputSet::SPATIAL,
            Self::JointForce(..) | Self::JointMoment(..) => OutputSet::REACTIONS,
            Self::Gauge(_) => OutputSet::GAUGES,
            Self::SectionForce(..) | Self::SectionMoment(..) => OutputSet::SECTION_LOADS,
            Self::LoopGap(..) | Self::LoopForce(..) => OutputSet::LOOPS,
            Self::RootForce(_) | Self::RootMoment(_) => OutputSet::ROOT,
            Self::Tip(_, PointOutput::Position(_) | PointOutput::Rotation(_)) => OutputSet::TIP_PLACES,
            Self::Tip(..) => OutputSet::TIP_MOTIONS,
            Self::Station(_, PointOutput::Position(_) | PointOutput::Rotation(_)) => OutputSet::STATION_PLACES,
            Self::Station(_, PointOutput::Acceleration(_) | PointOutput::AngularAcceleration(_)) => {
                OutputSet::STATION_ACCELERATIONS
            }
            Self::Station(..) => OutputSet::STATION_MOTIONS,
            Self::Energy(EnergyOutput::Work | EnergyOutput::Dissipated) => OutputSet::ACCOUNTS,
            Self::Energy(_) => OutputSet::ENERGIES,
            Self::AirForce(_)
            | Self::AirMoment(_)
            | Self::AirStationForce(..)
            | Self::AirStationMoment(..)
            | Self::AirCirculation(_) => OutputSet::AIR,
        }
    }

    /// Zero of the row's type: outputs have no start value.
    pub(super) fn zero(self) -> Value {
        match self {
            Self::Joint(_, JointOutput::Latched) => Value::Boolean(false),
            Self::Joint(_, JointOutput::LatchCount) => Value::Integer(0),
            _ => Value::Real(0.0),
        }
    }
}
