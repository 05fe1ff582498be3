//! State of the aerodynamics over an aerodynamic step, as part of the model's state.

use crate::aero::{AirState, AirStates};
use crate::load::Wrench;
use crate::system::air::{Gain, Sample, StepLoads};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Aerodynamic part of the plant's state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct AirHistory {
    /// Start time of the aerodynamic steps in s.
    pub start_s: f64,
    /// Number of aerodynamic steps since `start_s`.
    pub steps: u64,
    /// Aerodynamic states at the start of the current step.
    pub before: AirStates,
    /// Aerodynamic states at the end of the current step.
    pub after: AirStates,
    /// Motion of the sections at the start of the current step, with the averaged velocities of eq. (Q4).
    pub begin: Vec<Sample>,
    /// Motion of the sections at the end of the current step.
    pub end: Vec<Sample>,
    /// Loads of the current step.
    pub loads: StepLoads,
    /// Circulatory loads at the start of the current step; `loads` may start later.
    pub at_begin: Vec<Wrench>,
    /// Displacement of the wind from the start of the step to that of `loads`, in m.
    pub carried_m: Vector3<f64>,
    /// Change of the wind in that time.
    pub gain: Gain,
    /// Largest force so far, in N.
    pub scale_n: f64,
    /// Allowed displacement error of Newton's iteration in the current aerodynamic step, in the kinematic norm, so small that it has a
    /// negligible effect on the loads; eq. (Q2).
    pub motion_tolerance: f64,
    /// Structural step within the current aerodynamic step in s: the smallest step that the error estimate required in the first trial
    /// march, apart from steps bounded by `after_jump_s`. If the step changed between trials, the loads at the end would jump by the
    /// integration error within the tolerance, and the iteration would not converge.
    pub structure_step_s: f64,
    /// Bound in s on the structural steps after the last jump of the accelerations; it grows with the time since the jump, and is 0 if
    /// there is no bound. It makes the steps of all marches through an impact equally short.
    pub after_jump_s: f64,
    /// Number of consecutive aerodynamic steps in which the load prediction of the staggered coupling was off by more than `scale_n`.
    pub strayed: u32,
}

impl AirHistory {
    /// Shifts all times, to correct the round-off of the caller's clock.
    pub fn shift(&mut self, shift_s: f64) {
        self.start_s += shift_s;
        self.loads.begin_s += shift_s;
        self.loads.end_s += shift_s;
    }

    /// Copies a history of the same sizes without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        (self.start_s, self.steps) = (other.start_s, other.steps);
        self.before.copy_from(&other.before);
        self.after.copy_from(&other.after);
        self.begin.copy_from_slice(&other.begin);
        self.end.copy_from_slice(&other.end);
        self.loads.copy_from(&other.loads);
        self.at_begin.copy_from_slice(&other.at_begin);
        (self.carried_m, self.gain, self.scale_n) = (other.carried_m, other.gain, other.scale_n);
        (self.structure_step_s, self.strayed) = (other.structure_step_s, other.strayed);
        (self.motion_tolerance, self.after_jump_s) = (other.motion_tolerance, other.after_jump_s);
    }

    /// Size of the stored numbers in bytes.
    pub fn bytes(&self) -> usize {
        let states = self.before.0.iter().chain(&self.after.0).map(|state| match state {
            AirState::Strips(state) => size_of_val(&state.strips[..]),
            AirState::SlenderBody(state) => size_of_val(&state.momenta_m4_s[..]),
            AirState::Lattice(_) | AirState::Rotor(_) => 0,
        });
        let samples = size_of_val(&self.begin[..]) + size_of_val(&self.end[..]);
        states.sum::<usize>() + samples + 4 * size_of_val(&self.at_begin[..])
    }

    /// Whether another history has the same sizes.
    pub fn fits(&self, other: &Self) -> bool {
        let sections = self.at_begin.len();
        self.before.fits(&other.before)
            && self.before.fits(&other.after)
            && [other.begin.len(), other.end.len()] == [sections; 2]
            && [&other.at_begin, &other.loads.from, &other.loads.to, &other.loads.impulsive]
                .iter()
                .all(|loads| loads.len() == sections)
    }
}
