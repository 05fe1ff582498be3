//! Aerodynamics: loads on the sections of lifting bodies that move through a flow.
//!
//! An aerodynamic model is a function of motion and history: from its [state](AirState) at the start of an aerodynamic step and the motion
//! of every section at its end, it computes the state at the end and the loads. This module is independent of beams and integrators; the
//! plant controls when a step is accepted.

pub mod biot_savart;
pub mod continuous_turbulence;
pub mod established;
pub mod flap;
pub mod flow;
pub mod fourier;
mod hinged_panels;
pub mod images;
pub mod joined_edges;
pub mod lattice;
mod lattice_far;
mod lattice_flaps;
mod lattice_influence;
pub mod lattice_linear;
mod lattice_loads;
mod lattice_near;
mod lattice_profiles;
mod lattice_solve;
pub mod lattice_state;
mod lattice_wake_slopes;
pub mod linear_system;
pub(crate) mod memory;
mod model;
mod model_instant;
pub mod near_sheets;
mod panel_forces;
pub(crate) mod parts;
mod parts_instant;
pub mod pieces;
pub mod polar;
mod profile_circulation;
pub mod random;
pub mod rear;
pub mod rotor;
mod sheet;
pub mod slender;
mod slender_instant;
pub mod slender_slopes;
pub mod strip;
pub mod surface;
mod vortex_segments;
mod wake;

pub use model::{AirModel, AirOptions, AirState};
pub use parts::{AirModels, AirPart, AirStates};
pub use parts_instant::Stack;
pub use rotor::induction::EndRule;
pub use rotor::loads::RotorLoads;
pub use rotor::options::PitchRate;

use crate::load::{SectionMotion, Wrench};
use nalgebra::Vector3;

/// Aerodynamic loads on every section, about the sections' reference points, resolved in the root frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AirLoads {
    /// Loads due to circulation and velocity at the end of the step.
    pub circulatory: Vec<Wrench>,
    /// Loads due to apparent mass: mean rate of the fluid's impulse over the step. Their time integral over the step is exact, which keeps
    /// light wings stable.
    pub impulsive: Vec<Wrench>,
}

impl AirLoads {
    /// Zero loads on `sections` sections.
    pub fn still(sections: usize) -> Self {
        let none = vec![Wrench::default(); sections];
        Self { circulatory: none.clone(), impulsive: none }
    }

    /// Sets all loads to zero.
    pub fn clear(&mut self) {
        self.circulatory.fill(Wrench::default());
        self.impulsive.fill(Wrench::default());
    }
}

/// Splits a force in N that acts at the mean of two points, one fixed to each of two sections, into halves at these points: the power of
/// the sections' wrenches then equals that of the force to round-off.
pub fn split_between(
    loads: &mut [Wrench],
    motions: &[SectionMotion],
    sections: [usize; 2],
    points_m: [&Vector3<f64>; 2],
    force_n: &Vector3<f64>,
) {
    let half_n = 0.5 * force_n;
    for (section, point_m) in sections.into_iter().zip(points_m) {
        let arm_m = motions[section].rotation * point_m;
        loads[section].add_force_at(&arm_m, &half_n);
    }
}

#[cfg(test)]
mod test_lattices;
