//! Inputs and parameters as the model states them.

use crate::load::RootMotion;
use crate::machine::Machine;
use crate::plant::face::{BodyParameters, Inputs, JointInputs, JointParameters, Parameters, SpatialParameters};
use crate::plant::{revolutes, spatials};
use nalgebra::Vector3;

impl Inputs {
    /// Start values of a model's inputs.
    pub fn of(machine: &Machine) -> Self {
        Self {
            joints: revolutes(machine)
                .map(|(_, revolute)| JointInputs {
                    command_rad: revolute.drive.command_rad,
                    torque_n_m: 0.0,
                    release: revolute.release,
                    latch_enable: revolute.latch.as_ref().is_some_and(|latch| latch.enable),
                })
                .collect(),
            stations: machine
                .bodies
                .iter()
                .flat_map(|body| {
                    let load = |i: usize| body.station_loads.get(i).copied().unwrap_or_default();
                    (0..body.station_positions_m.len()).map(load)
                })
                .collect(),
            root: RootMotion { gravity_m_s2: machine.gravity_m_s2, ..RootMotion::default() },
            wind_m_s: machine.air.as_ref().map_or(Vector3::zeros(), |air| air.wind_m_s),
        }
    }
}

impl Parameters {
    /// Start values of a model's parameters.
    pub fn of(machine: &Machine) -> Self {
        Self {
            joints: revolutes(machine)
                .map(|(_, revolute)| JointParameters {
                    start_angle_rad: revolute.start_angle_rad,
                    stiffness_n_m_rad: revolute.drive.stiffness_n_m_rad,
                    damping_n_m_s_rad: revolute.drive.damping_n_m_s_rad,
                    constant_torque_n_m: revolute.drive.constant_torque_n_m,
                    torque_limit_n_m: revolute.drive.torque_limit_n_m,
                    rate_limit_rad_s: revolute.drive.rate_limit_rad_s,
                    spring_stiffness_n_m_rad: revolute.spring.map_or(0.0, |spring| spring.stiffness_n_m_rad),
                    spring_damping_n_m_s_rad: revolute.spring.map_or(0.0, |spring| spring.damping_n_m_s_rad),
                    rest_angle_rad: revolute.spring.map_or(0.0, |spring| spring.rest_angle_rad),
                    latch_stiffness_n_m_rad: revolute.latch.as_ref().map_or(0.0, |latch| latch.stiffness_n_m_rad),
                })
                .collect(),
            spatial: spatials(machine)
                .map(|(_, spatial)| SpatialParameters {
                    stiffness_n_m_rad: spatial.stiffness_n_m_rad,
                    damping_n_m_s_rad: spatial.damping_n_m_s_rad,
                })
                .collect(),
            bodies: machine
                .bodies
                .iter()
                .map(|body| BodyParameters {
                    mass_factor: 1.0,
                    stiffness_factor: 1.0,
                    mass_damping_1_s: body.mass_damping_1_s,
                    stiffness_damping_s: body.stiffness_damping_s,
                })
                .collect(),
            air_density_kg_m3: machine.air.as_ref().map_or(0.0, |air| air.density_kg_m3),
            tolerance: machine.solver.tolerance,
            max_step_s: machine.solver.max_step_s,
            min_step_s: machine.solver.min_step_s,
        }
    }
}
