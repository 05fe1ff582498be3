//! Loads of a rotor on its shaft, and its coefficients.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Loads and coefficients of the rotor.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct RotorLoads {
    /// Aerodynamic force along the shaft, downwind positive, in N.
    pub thrust_n: f64,
    /// Aerodynamic torque about the shaft, positive if it drives the rotor, in N·m.
    pub torque_n_m: f64,
    /// Aerodynamic power in W: torque times speed of the hub.
    pub power_w: f64,
    /// Speed of the hub about its shaft in rad/s, positive in the rotor's direction of rotation.
    pub speed_rad_s: f64,
    /// Mean wind along the shaft over the sections of all blades, relative to them, in m/s.
    pub wind_m_s: f64,
    /// Power divided by `½ρπR²U³`, with the mean current radius of the blades' outermost sections and the wind `U` along the shaft. This
    /// and the following coefficients are 0 if that wind is below a hundredth of the relative speed of the tips: in still air, or with the
    /// wind normal to the shaft.
    pub power_coefficient: f64,
    /// Thrust divided by `½ρπR²U²`.
    pub thrust_coefficient: f64,
    /// Speed of the outermost sections divided by the wind along the shaft.
    pub tip_speed_ratio: f64,
    /// Mean axial induced velocity of the annuli divided by their mean wind.
    pub induction: f64,
}

impl RotorLoads {
    /// Interpolates linearly: these loads at a `share` of 0, the `other` ones at 1.
    pub fn between(&self, other: &Self, share: f64) -> Self {
        let mut mixed = *self;
        let (numbers, ends): (&mut [f64], &[f64]) = (
            bytemuck::cast_slice_mut(std::slice::from_mut(&mut mixed)),
            bytemuck::cast_slice(std::slice::from_ref(other)),
        );
        numbers.iter_mut().zip(ends).for_each(|(number, end)| *number += (end - *number) * share);
        mixed
    }
}
