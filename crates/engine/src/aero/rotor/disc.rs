//! Inflow of a section of a rotor and the state of its disc at one instant, before induction.

use crate::aero::rotor::loads::RotorLoads;
use crate::aero::rotor::skew::Skew;
use nalgebra::Vector3;

/// Geometry and inflow of a section at one instant, before induction, with its line loads.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    pub(super) arm_m: Vector3<f64>,
    pub(super) relative_m_s: Vector3<f64>,
    /// Wind along the shaft relative to the hub, without the influence of the tower, in m/s.
    pub(super) wind_m_s: f64,
    pub(super) radial_m: Vector3<f64>,
    pub(super) from_apex_m: Vector3<f64>,
    pub(super) line_n_m: Vector3<f64>,
    pub(super) moment_n: Vector3<f64>,
}

pub(super) const NO_CUT: Cut = Cut {
    arm_m: Vector3::new(0.0, 0.0, 0.0),
    relative_m_s: Vector3::new(0.0, 0.0, 0.0),
    wind_m_s: 0.0,
    radial_m: Vector3::new(0.0, 0.0, 0.0),
    from_apex_m: Vector3::new(0.0, 0.0, 0.0),
    line_n_m: Vector3::new(0.0, 0.0, 0.0),
    moment_n: Vector3::new(0.0, 0.0, 0.0),
};

/// Rotor disc at one instant.
pub(super) struct Disc {
    pub(super) normal: Vector3<f64>,
    pub(super) turn: f64,
    pub(super) share: f64,
    pub(super) radius_m: f64,
    /// Angular velocity of the hub, root frame, rad/s.
    pub(super) hub_rad_s: Vector3<f64>,
    /// Component of the rotation about the shaft that is excluded from the pitch rates of dynamic stall, in rad/s: all of it, because a
    /// coned blade keeps its angle of attack as the rotor turns; none for compatibility with AeroDyn.
    pub(super) shaft_spin_rad_s: Vector3<f64>,
    pub(super) skew: Option<Skew>,
    /// Whether the wind along the shaft is sufficient to define the coefficients.
    pub(super) has_wind: bool,
    pub(super) loads: RotorLoads,
}

/// Flips a vector normal to the disc, if necessary, to point downwind along the disc's `normal`.
pub(super) fn downwind(across: Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
    if across.dot(normal) < 0.0 { -across } else { across }
}
