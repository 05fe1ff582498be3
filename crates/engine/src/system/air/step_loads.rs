//! Loads of the sections over an aerodynamic step, and the motion of a section as input of the aerodynamic model.

use crate::load::{SectionMotion, Wrench};
use crate::math::so3::rotation_vector;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Weights of eq. (Q4): of the mean velocity over the step, of the mean velocity over the previous step, and of the averaged velocity at
/// the start of the step. Second order; each step halves the response to a jump.
pub(crate) const VELOCITY_WEIGHTS: [f64; 3] = [1.75, -0.25, -0.5];

/// Aerodynamic loads in an aerodynamic step, per section and in the section frame.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct StepLoads {
    /// Time of `from` in s.
    pub begin_s: f64,
    /// Time of `to` in s.
    pub end_s: f64,
    /// Circulatory loads at the start.
    pub from: Vec<Wrench>,
    /// Circulatory loads at the end.
    pub to: Vec<Wrench>,
    /// Impulsive loads, mean over the step.
    pub impulsive: Vec<Wrench>,
}

impl StepLoads {
    /// Zero loads on `sections` sections.
    pub fn none(sections: usize) -> Self {
        let none = vec![Wrench::default(); sections];
        Self { begin_s: 0.0, end_s: 0.0, from: none.clone(), to: none.clone(), impulsive: none }
    }

    /// Copies without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        (self.begin_s, self.end_s) = (other.begin_s, other.end_s);
        self.from.copy_from_slice(&other.from);
        self.to.copy_from_slice(&other.to);
        self.impulsive.copy_from_slice(&other.impulsive);
    }

    /// Sets all loads to zero.
    pub fn clear(&mut self) {
        self.scale(&[], 0.0);
    }

    /// Sets constant loads: the circulatory loads at the end of `target`, multiplied by `factor`.
    pub fn scale(&mut self, target: &[Wrench], factor: f64) {
        (self.begin_s, self.end_s) = (0.0, 0.0);
        self.impulsive.fill(Wrench::default());
        for (i, load) in self.from.iter_mut().enumerate() {
            let target = target.get(i).copied().unwrap_or_default();
            *load = Wrench { force_n: target.force_n * factor, moment_n_m: target.moment_n_m * factor };
        }
        self.to.copy_from_slice(&self.from);
    }

    /// Writes the effective loads, NOTATION eq. (Q1).
    pub fn write(&self, loads: &mut [Wrench]) {
        let ends = self.from.iter().zip(&self.to);
        for ((load, (from, to)), impulsive) in loads.iter_mut().zip(ends).zip(&self.impulsive) {
            load.force_n = (from.force_n + to.force_n) * 0.5 + impulsive.force_n;
            load.moment_n_m = (from.moment_n_m + to.moment_n_m) * 0.5 + impulsive.moment_n_m;
        }
    }
}

/// Motion of a section at the end of an aerodynamic step, as input of the aerodynamic model: actual position and attitude, velocities by
/// eq. (Q4).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sample {
    /// Position, attitude and velocities.
    pub motion: SectionMotion,
    /// Mean velocity over the step in m/s.
    pub mean_m_s: Vector3<f64>,
    /// Mean angular velocity over the step in rad/s.
    pub mean_rad_s: Vector3<f64>,
}

impl Sample {
    /// Sample of a steady motion.
    pub fn steady(motion: &SectionMotion) -> Self {
        Self { motion: *motion, mean_m_s: motion.velocity_m_s, mean_rad_s: motion.spin_rad_s }
    }

    /// Returns the sample one step later, for the section motion `motion` and the wind change `gain`; NOTATION eq. (Q4).
    pub fn next(&self, motion: &SectionMotion, step_s: f64, gain: &Gain) -> Self {
        let mean_m_s = (motion.position_m - self.motion.position_m - gain.displacement_m) / step_s;
        let mean_rad_s = rotation_vector(&(motion.rotation * self.motion.rotation.transpose())) / step_s;
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        Self {
            motion: SectionMotion {
                velocity_m_s: mean_m_s * own
                    + self.mean_m_s * earlier
                    + self.motion.velocity_m_s * last
                    + gain.velocity_m_s,
                spin_rad_s: mean_rad_s * own + self.mean_rad_s * earlier + self.motion.spin_rad_s * last,
                ..*motion
            },
            mean_m_s: mean_m_s + gain.velocity_m_s,
            mean_rad_s,
        }
    }
}

/// Change of the wind since the start of an aerodynamic step due to the rates of the inputs, without jumps. Velocities are averaged
/// relative to air with the same change, so that an accelerated root in still air and a wing in accelerated air have the same flow.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Gain {
    /// Velocity in m/s.
    velocity_m_s: Vector3<f64>,
    /// Displacement in m by that velocity.
    displacement_m: Vector3<f64>,
}

impl Gain {
    /// Gain a time `time_s` later, with a constant rate of the wind.
    pub fn after(&self, time_s: f64, rate_m_s2: &Vector3<f64>) -> Self {
        Self {
            velocity_m_s: self.velocity_m_s + rate_m_s2 * time_s,
            displacement_m: self.displacement_m + (self.velocity_m_s + rate_m_s2 * (0.5 * time_s)) * time_s,
        }
    }
}
