//! Parameters of a model.

use crate::machine::Machine;
use crate::signal::{Segment, are_finite, views};
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Smallest and largest factor on inertia or stiffness, within which the equations remain solvable in double precision.
pub const FACTOR_RANGE: (f64, f64) = (1e-6, 1e6);

/// Parameters of one revolute or prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JointParameters {
    /// Initial fold angle in rad; fixed.
    pub start_angle_rad: f64,
    /// Stiffness `k_m` of the motor in N·m/rad; tunable, like all that follow.
    pub stiffness_n_m_rad: f64,
    /// Damping `c_m` of the motor in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Constant torque `T` of the motor in N·m.
    pub constant_torque_n_m: f64,
    /// Largest magnitude of the motor torque in N·m.
    pub torque_limit_n_m: f64,
    /// Largest rate of the neutral angle in rad/s.
    pub rate_limit_rad_s: f64,
    /// Stiffness of the joint's spring in N·m/rad; 0 without one.
    pub spring_stiffness_n_m_rad: f64,
    /// Damping of the joint's damper in N·m·s/rad.
    pub spring_damping_n_m_s_rad: f64,
    /// Angle at which the joint's spring is unloaded in rad.
    pub rest_angle_rad: f64,
    /// Stiffness of the closed latch in N·m/rad; 0 without a latch.
    pub latch_stiffness_n_m_rad: f64,
}

/// Parameters of one universal, ball or free joint; tunable.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SpatialParameters {
    /// Spring stiffness in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
}

/// Parameters of one body.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BodyParameters {
    /// Factor on the beam's inertia (not on attached masses); fixed.
    pub mass_factor: f64,
    /// Factor on the section stiffness; fixed.
    pub stiffness_factor: f64,
    /// Mass-proportional damping `α` in 1/s; tunable.
    pub mass_damping_1_s: f64,
    /// Stiffness-proportional damping `β` in s; tunable.
    pub stiffness_damping_s: f64,
}

/// Parameters of the time integration; fixed.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SolverParameters {
    /// Error tolerance of the time integration.
    pub tolerance: f64,
    /// Largest internal step in s.
    pub max_step_s: f64,
    /// Smallest internal step in s.
    pub min_step_s: f64,
    /// Frequency in rad/s that no vibration of beams exceeds under an external integrator; 0 without a limit.
    pub frequency_limit_rad_s: f64,
}

/// Layout of [`Parameters::values`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ParameterLayout {
    /// See [`Parameters::joints`].
    pub joints: Segment<JointParameters>,
    /// See [`Parameters::spatial`].
    pub spatial: Segment<SpatialParameters>,
    /// See [`Parameters::bodies`].
    pub bodies: Segment<BodyParameters>,
    /// See [`Parameters::air_density_kg_m3`].
    pub air_density_kg_m3: Segment<f64>,
    /// See [`Parameters::solver`].
    pub solver: Segment<SolverParameters>,
    /// Length of the vector.
    end: usize,
}

impl ParameterLayout {
    /// Layout for a model.
    pub fn new(machine: &Machine) -> Self {
        let mut end = 0;
        Self {
            joints: Segment::append(&mut end, machine.one_freedoms().count()),
            spatial: Segment::append(&mut end, machine.spatials().count()),
            bodies: Segment::append(&mut end, machine.bodies.len()),
            air_density_kg_m3: Segment::append(&mut end, 1),
            solver: Segment::append(&mut end, 1),
            end,
        }
    }
}

/// All parameters. Fixed ones take effect at `Plant::initialize`, tunable ones from the next step.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    layout: ParameterLayout,
    values: Vec<f64>,
}

/// Written by hand, because a derived `clone_from` allocates.
impl Clone for Parameters {
    fn clone(&self) -> Self {
        Self { layout: self.layout, values: self.values.clone() }
    }

    fn clone_from(&mut self, source: &Self) {
        self.layout = source.layout;
        self.values.clone_from(&source.values);
    }
}

impl Parameters {
    /// Start values of a model's parameters.
    pub fn of(machine: &Machine) -> Self {
        let layout = ParameterLayout::new(machine);
        let mut parameters = Self { layout, values: vec![0.0; layout.end] };
        for (own, (_, joint)) in parameters.joints_mut().iter_mut().zip(machine.one_freedoms()) {
            *own = JointParameters {
                start_angle_rad: joint.start_angle_rad,
                stiffness_n_m_rad: joint.motor.stiffness_n_m_rad,
                damping_n_m_s_rad: joint.motor.damping_n_m_s_rad,
                constant_torque_n_m: joint.motor.constant_torque_n_m,
                torque_limit_n_m: joint.motor.torque_limit_n_m,
                rate_limit_rad_s: joint.motor.rate_limit_rad_s,
                spring_stiffness_n_m_rad: joint.spring.map_or(0.0, |spring| spring.stiffness_n_m_rad),
                spring_damping_n_m_s_rad: joint.spring.map_or(0.0, |spring| spring.damping_n_m_s_rad),
                rest_angle_rad: joint.spring.map_or(0.0, |spring| spring.rest_angle_rad),
                latch_stiffness_n_m_rad: joint.latch.as_ref().map_or(0.0, |latch| latch.stiffness_n_m_rad),
            };
        }
        for (own, (_, joint)) in parameters.spatial_mut().iter_mut().zip(machine.spatials()) {
            let (stiffness_n_m_rad, damping_n_m_s_rad) = (joint.stiffness_n_m_rad, joint.damping_n_m_s_rad);
            *own = SpatialParameters { stiffness_n_m_rad, damping_n_m_s_rad };
        }
        for (own, body) in parameters.bodies_mut().iter_mut().zip(&machine.bodies) {
            *own = BodyParameters {
                mass_factor: 1.0,
                stiffness_factor: 1.0,
                mass_damping_1_s: body.mass_damping_1_s,
                stiffness_damping_s: body.stiffness_damping_s,
            };
        }
        *parameters.air_density_kg_m3_mut() = machine.air.as_ref().map_or(0.0, |air| air.density_kg_m3);
        let solver = &machine.solver;
        *parameters.solver_mut() = SolverParameters {
            tolerance: solver.tolerance,
            max_step_s: solver.max_step_s,
            min_step_s: solver.min_step_s,
            frequency_limit_rad_s: 0.0,
        };
        parameters
    }

    /// Layout of [`Self::values`].
    pub fn layout(&self) -> &ParameterLayout {
        &self.layout
    }

    /// All values in SI units.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All values, mutable.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    views! { (pub)
        /// Parameters of each revolute or prismatic joint, in the order of `Plant::revolute_joints`.
        joints, joints_mut: [JointParameters];
        /// Parameters of each universal, ball or free joint, in the order of `Plant::spatial_joints`.
        spatial, spatial_mut: [SpatialParameters];
        /// Parameters of each body.
        bodies, bodies_mut: [BodyParameters];
        ;
        /// Parameters of the time integration.
        solver, solver_mut: SolverParameters;
    }

    /// Density of the air in kg/m³; tunable; ignored by models without aerodynamics.
    #[inline]
    pub fn air_density_kg_m3(&self) -> f64 {
        self.layout.air_density_kg_m3.view(&self.values)[0]
    }

    /// [`Self::air_density_kg_m3`], mutable.
    pub fn air_density_kg_m3_mut(&mut self) -> &mut f64 {
        &mut self.layout.air_density_kg_m3.view_mut(&mut self.values)[0]
    }

    /// Whether these parameters have the layout of a model.
    pub(crate) fn fit(&self, layout: &ParameterLayout) -> bool {
        self.layout == *layout && self.values.len() == layout.end
    }

    /// Checks that all values are valid in a run: finite, and such that equations and steps exist.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        let SolverParameters { tolerance, max_step_s, min_step_s, frequency_limit_rad_s } = *self.solver();
        if !(tolerance > 0.0
            && min_step_s > 0.0
            && frequency_limit_rad_s >= 0.0
            && are_finite(&[tolerance, max_step_s, min_step_s, frequency_limit_rad_s]))
        {
            return Err("solver parameters");
        }
        let factor = |value: f64| (FACTOR_RANGE.0..=FACTOR_RANGE.1).contains(&value);
        if !self.bodies().iter().all(|body| factor(body.mass_factor) && factor(body.stiffness_factor)) {
            return Err("factors of a body");
        }
        if are_finite(&self.values) { Ok(()) } else { Err("parameters") }
    }
}
