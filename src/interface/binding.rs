//! What each row of the table is bound to: one exhaustive enum, one `match` per direction.

use crate::interface::Value;
use crate::plant::{
    BodyParameters, EnergyOutputs, Inputs, JointInputs, JointOutputs, JointParameters, Outputs, Parameters, Plant,
    PointOutputs, Statistics,
};
use nalgebra::Vector3;

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
    /// Of a body.
    Body(usize, BodyParameter),
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
    /// Largest drive torque.
    TorqueLimit,
    /// Largest slew of the neutral angle.
    RateLimit,
    /// Stiffness of the closed latch.
    LatchStiffness,
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
    /// Strain of a gauge.
    Gauge(usize),
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
}

/// An output of a revolute joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointOutput {
    /// Fold angle.
    Angle,
    /// Fold rate.
    Rate,
    /// Drive torque.
    TorqueApplied,
    /// Latch torque.
    LatchTorque,
    /// Latch closed.
    Latched,
    /// Time of the last closing.
    LatchTime,
    /// Number of closings.
    LatchCount,
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
}

/// A component of a vector; nalgebra's own index checks more than the bound.
#[inline]
fn component(vector: &Vector3<f64>, i: usize) -> f64 {
    vector.as_slice()[i]
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
}

impl<'a> Source<'a> {
    /// Inputs and parameters of a plant, with outputs of the caller's choice.
    pub fn new(plant: &'a Plant, outputs: &'a Outputs) -> Self {
        Self { inputs: plant.inputs(), parameters: plant.parameters(), outputs, statistics: plant.statistics() }
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

    /// Whether the value comes from the last evaluation rather than from the importer.
    pub(super) fn is_computed(self) -> bool {
        matches!(self, Self::Output(_) | Self::Local(_))
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

impl JointInput {
    #[inline]
    fn read(self, joint: &JointInputs) -> Value {
        match self {
            Self::Command => Value::Real(joint.command_rad),
            Self::Torque => Value::Real(joint.torque_n_m),
            Self::Release => Value::Boolean(joint.release),
            Self::LatchEnable => Value::Boolean(joint.latch_enable),
        }
    }
}

impl Parameter {
    /// Present value.
    pub(super) fn read(self, parameters: &Parameters) -> f64 {
        match self {
            Self::Joint(joint, field) => field.read(&parameters.joints[joint]),
            Self::Body(body, field) => field.read(&parameters.bodies[body]),
            Self::Solver(SolverParameter::Tolerance) => parameters.tolerance,
            Self::Solver(SolverParameter::MaxStep) => parameters.max_step_s,
            Self::Solver(SolverParameter::MinStep) => parameters.min_step_s,
        }
    }

    fn slot(self, parameters: &mut Parameters) -> &mut f64 {
        match self {
            Self::Joint(joint, field) => field.slot(&mut parameters.joints[joint]),
            Self::Body(body, field) => field.slot(&mut parameters.bodies[body]),
            Self::Solver(SolverParameter::Tolerance) => &mut parameters.tolerance,
            Self::Solver(SolverParameter::MaxStep) => &mut parameters.max_step_s,
            Self::Solver(SolverParameter::MinStep) => &mut parameters.min_step_s,
        }
    }
}

impl JointParameter {
    #[inline]
    fn read(self, joint: &JointParameters) -> f64 {
        match self {
            Self::StartAngle => joint.start_angle_rad,
            Self::Stiffness => joint.stiffness_n_m_rad,
            Self::Damping => joint.damping_n_m_s_rad,
            Self::ConstantTorque => joint.constant_torque_n_m,
            Self::TorqueLimit => joint.torque_limit_n_m,
            Self::RateLimit => joint.rate_limit_rad_s,
            Self::LatchStiffness => joint.latch_stiffness_n_m_rad,
        }
    }

    fn slot(self, joint: &mut JointParameters) -> &mut f64 {
        match self {
            Self::StartAngle => &mut joint.start_angle_rad,
            Self::Stiffness => &mut joint.stiffness_n_m_rad,
            Self::Damping => &mut joint.damping_n_m_s_rad,
            Self::ConstantTorque => &mut joint.constant_torque_n_m,
            Self::TorqueLimit => &mut joint.torque_limit_n_m,
            Self::RateLimit => &mut joint.rate_limit_rad_s,
            Self::LatchStiffness => &mut joint.latch_stiffness_n_m_rad,
        }
    }
}

impl BodyParameter {
    fn read(self, body: &BodyParameters) -> f64 {
        match self {
            Self::MassFactor => body.mass_factor,
            Self::StiffnessFactor => body.stiffness_factor,
            Self::MassDamping => body.mass_damping_1_s,
            Self::StiffnessDamping => body.stiffness_damping_s,
        }
    }

    fn slot(self, body: &mut BodyParameters) -> &mut f64 {
        match self {
            Self::MassFactor => &mut body.mass_factor,
            Self::StiffnessFactor => &mut body.stiffness_factor,
            Self::MassDamping => &mut body.mass_damping_1_s,
            Self::StiffnessDamping => &mut body.stiffness_damping_s,
        }
    }
}

impl Output {
    /// Present value.
    #[inline]
    pub(super) fn read(self, outputs: &Outputs) -> Value {
        match self {
            Self::Joint(joint, field) => field.read(&outputs.joints[joint]),
            Self::Gauge(gauge) => Value::Real(outputs.gauges[gauge]),
            Self::RootForce(i) => Value::Real(component(&outputs.root.force_n, i)),
            Self::RootMoment(i) => Value::Real(component(&outputs.root.moment_n_m, i)),
            Self::Tip(tip, field) => Value::Real(field.read(&outputs.tips[tip])),
            Self::Station(station, field) => Value::Real(field.read(&outputs.stations[station])),
            Self::Energy(field) => Value::Real(field.read(&outputs.energy)),
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

impl JointOutput {
    #[inline]
    fn read(self, joint: &JointOutputs) -> Value {
        match self {
            Self::Angle => Value::Real(joint.angle_rad),
            Self::Rate => Value::Real(joint.rate_rad_s),
            Self::TorqueApplied => Value::Real(joint.torque_applied_n_m),
            Self::LatchTorque => Value::Real(joint.latch_torque_n_m),
            Self::Latched => Value::Boolean(joint.latched),
            Self::LatchTime => Value::Real(joint.latch_time_s),
            Self::LatchCount => Value::Integer(joint.latch_count),
        }
    }
}

impl PointOutput {
    #[inline]
    fn read(self, point: &PointOutputs) -> f64 {
        match self {
            Self::Position(i) => component(&point.position_m, i),
            Self::Velocity(i) => component(&point.velocity_m_s, i),
            Self::AngularVelocity(i) => component(&point.angular_velocity_rad_s, i),
            Self::Acceleration(i) => component(&point.acceleration_m_s2, i),
            // nalgebra stores x, y, z, w.
            Self::Rotation(i) => point.rotation.coords.as_slice()[(i + 3) % 4],
        }
    }
}

impl EnergyOutput {
    #[inline]
    fn read(self, energy: &EnergyOutputs) -> f64 {
        match self {
            Self::Kinetic => energy.kinetic,
            Self::Elastic => energy.elastic,
            Self::Gravity => energy.gravity,
            Self::Drive => energy.drive,
            Self::Work => energy.work,
            Self::Dissipated => energy.dissipated,
            Self::Total => energy.total,
        }
    }
}

impl Counter {
    /// Present count; stays at the largest Integer instead of wrapping.
    fn read(self, statistics: &Statistics) -> i32 {
        let count = match self {
            Self::Steps => statistics.steps,
            Self::Rejections => statistics.rejections,
            Self::Failures => statistics.failures,
            Self::Iterations => statistics.iterations,
            Self::Factorizations => statistics.factorizations,
            Self::Events => statistics.events,
        };
        i32::try_from(count).unwrap_or(i32::MAX)
    }
}
