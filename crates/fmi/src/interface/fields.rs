//! Reading and writing one field of what the plant takes and gives.

use crate::interface::Value;
use crate::interface::binding::{
    BodyParameter, Counter, Duration, EnergyOutput, JointInput, JointOutput, JointParameter, PointOutput,
    SpatialOutput, SpatialParameter,
};
use foldwing_engine::plant::{
    BodyParameters, EnergyOutputs, JointInputs, JointOutputs, JointParameters, Latency, PointOutputs, SpatialOutputs,
    SpatialParameters, Statistics,
};
use nalgebra::{UnitQuaternion, Vector3};

/// A component of a vector; nalgebra's own index checks more than the bound.
#[inline]
pub(super) fn component(vector: &Vector3<f64>, i: usize) -> f64 {
    vector.as_slice()[i]
}

/// A component of a quaternion in the order w, x, y, z; nalgebra stores x, y, z, w.
#[inline]
fn quaternion_component(rotation: &UnitQuaternion<f64>, i: usize) -> f64 {
    rotation.coords.as_slice()[(i + 3) % 4]
}

impl JointInput {
    #[inline]
    pub(super) fn read(self, joint: &JointInputs) -> Value {
        match self {
            Self::Command => Value::Real(joint.command_rad),
            Self::Torque => Value::Real(joint.torque_n_m),
            Self::Release => Value::Boolean(joint.release),
            Self::LatchEnable => Value::Boolean(joint.latch_enable),
        }
    }
}

impl JointParameter {
    #[inline]
    pub(super) fn read(self, joint: &JointParameters) -> f64 {
        match self {
            Self::StartAngle => joint.start_angle_rad,
            Self::Stiffness => joint.stiffness_n_m_rad,
            Self::Damping => joint.damping_n_m_s_rad,
            Self::ConstantTorque => joint.constant_torque_n_m,
            Self::TorqueLimit => joint.torque_limit_n_m,
            Self::RateLimit => joint.rate_limit_rad_s,
            Self::SpringStiffness => joint.spring_stiffness_n_m_rad,
            Self::SpringDamping => joint.spring_damping_n_m_s_rad,
            Self::RestAngle => joint.rest_angle_rad,
            Self::LatchStiffness => joint.latch_stiffness_n_m_rad,
        }
    }

    pub(super) fn slot(self, joint: &mut JointParameters) -> &mut f64 {
        match self {
            Self::StartAngle => &mut joint.start_angle_rad,
            Self::Stiffness => &mut joint.stiffness_n_m_rad,
            Self::Damping => &mut joint.damping_n_m_s_rad,
            Self::ConstantTorque => &mut joint.constant_torque_n_m,
            Self::TorqueLimit => &mut joint.torque_limit_n_m,
            Self::RateLimit => &mut joint.rate_limit_rad_s,
            Self::SpringStiffness => &mut joint.spring_stiffness_n_m_rad,
            Self::SpringDamping => &mut joint.spring_damping_n_m_s_rad,
            Self::RestAngle => &mut joint.rest_angle_rad,
            Self::LatchStiffness => &mut joint.latch_stiffness_n_m_rad,
        }
    }
}

impl SpatialParameter {
    pub(super) fn read(self, joint: &SpatialParameters) -> f64 {
        match self {
            Self::Stiffness => joint.stiffness_n_m_rad,
            Self::Damping => joint.damping_n_m_s_rad,
        }
    }

    pub(super) fn slot(self, joint: &mut SpatialParameters) -> &mut f64 {
        match self {
            Self::Stiffness => &mut joint.stiffness_n_m_rad,
            Self::Damping => &mut joint.damping_n_m_s_rad,
        }
    }
}

impl BodyParameter {
    pub(super) fn read(self, body: &BodyParameters) -> f64 {
        match self {
            Self::MassFactor => body.mass_factor,
            Self::StiffnessFactor => body.stiffness_factor,
            Self::MassDamping => body.mass_damping_1_s,
            Self::StiffnessDamping => body.stiffness_damping_s,
        }
    }

    pub(super) fn slot(self, body: &mut BodyParameters) -> &mut f64 {
        match self {
            Self::MassFactor => &mut body.mass_factor,
            Self::StiffnessFactor => &mut body.stiffness_factor,
            Self::MassDamping => &mut body.mass_damping_1_s,
            Self::StiffnessDamping => &mut body.stiffness_damping_s,
        }
    }
}

impl JointOutput {
    #[inline]
    pub(super) fn read(self, joint: &JointOutputs) -> Value {
        match self {
            Self::Angle => Value::Real(joint.angle_rad),
            Self::Rate => Value::Real(joint.rate_rad_s),
            Self::TorqueApplied => Value::Real(joint.torque_applied_n_m),
            Self::MotorTorque => Value::Real(joint.motor_torque_n_m),
            Self::SpringTorque => Value::Real(joint.spring_torque_n_m),
            Self::ExternalTorque => Value::Real(joint.external_torque_n_m),
            Self::HoldingTorque => Value::Real(joint.holding_torque_n_m),
            Self::LatchTorque | Self::LatchReaction => Value::Real(joint.latch_torque_n_m),
            Self::Latched => Value::Boolean(joint.latched),
            Self::LatchTime => Value::Real(joint.latch_time_s),
            Self::LatchCount => Value::Integer(joint.latch_count),
            Self::LatchImpulse => Value::Real(joint.latch_impulse_n_m_s),
        }
    }
}

impl SpatialOutput {
    #[inline]
    pub(super) fn read(self, joint: &SpatialOutputs) -> f64 {
        match self {
            Self::Rotation(i) => quaternion_component(&joint.rotation, i),
            Self::AngularVelocity(i) => component(&joint.angular_velocity_rad_s, i),
        }
    }
}

impl PointOutput {
    #[inline]
    pub(super) fn read(self, point: &PointOutputs) -> f64 {
        match self {
            Self::Position(i) => component(&point.position_m, i),
            Self::Velocity(i) => component(&point.velocity_m_s, i),
            Self::AngularVelocity(i) => component(&point.angular_velocity_rad_s, i),
            Self::Acceleration(i) => component(&point.acceleration_m_s2, i),
            Self::AngularAcceleration(i) => component(&point.angular_acceleration_rad_s2, i),
            Self::Rotation(i) => quaternion_component(&point.rotation, i),
        }
    }
}

impl EnergyOutput {
    #[inline]
    pub(super) fn read(self, energy: &EnergyOutputs) -> f64 {
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

impl Duration {
    /// Present value in s.
    pub(super) fn read_s(self, latency: &Latency) -> f64 {
        match self {
            Self::Last => latency.last_s(),
            Self::Median => latency.quantile_s(0.5),
            Self::Slowest => latency.slowest_s(),
        }
    }
}

impl Counter {
    /// Present count; stays at the largest Integer instead of wrapping.
    pub(super) fn read(self, statistics: &Statistics) -> i32 {
        let count = match self {
            Self::Steps => statistics.steps,
            Self::Rejections => statistics.rejections,
            Self::Failures => statistics.failures,
            Self::Iterations => statistics.iterations,
            Self::Factorizations => statistics.factorizations,
            Self::Events => statistics.events,
            Self::Unconverged => statistics.unconverged,
            Self::LargestIterations => statistics.largest_iterations,
        };
        i32::try_from(count).unwrap_or(i32::MAX)
    }
}
