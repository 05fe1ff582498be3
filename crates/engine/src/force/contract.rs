//! Arguments and results that all forces on joints have in common.

use crate::multibody::Workspace;
use crate::multibody::elimination::FreedomTangent;

/// Arguments of a force: the state of a joint at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Here<'a> {
    /// Time in s.
    pub time_s: f64,
    /// Time in s that selects the branch of slews and prescribed motions.
    pub branch_s: f64,
    /// First coordinate of the joint: the angle in rad if it has one degree of freedom.
    pub angle_rad: f64,
    /// Rate of that coordinate in rad/s.
    pub rate_rad_s: f64,
    /// Rates of all coordinates.
    pub v: &'a [f64],
    /// Results of the last sweep.
    pub work: &'a Workspace,
}

/// Sum of the forces on a joint, with their tangent.
#[derive(Debug)]
pub struct Push<'a> {
    /// Torque on the outer body about `+θ` in N·m, for a joint with one degree of freedom.
    pub torque_n_m: f64,
    /// Stiffness `−∂τ/∂θ` and damping `−∂τ/∂θ̇`.
    pub tangent: FreedomTangent,
    /// Rows of the joint's degrees of freedom in the residual, for forces on joints with several.
    pub rows: &'a mut [f64],
}

/// Energy stored in forces, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stored {
    /// Energy in motors, and in springs of universal and ball joints.
    pub drive: f64,
    /// Energy in springs of joints with one degree of freedom, and in closed latches.
    pub elastic: f64,
}

/// Motion of a joint with one degree of freedom, for indicators.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving {
    /// Angle in rad.
    pub angle_rad: f64,
    /// Rate in rad/s.
    pub rate_rad_s: f64,
    /// Acceleration in rad/s².
    pub acceleration_rad_s2: f64,
}

/// Result of a change by inputs or a crossing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outcome {
    /// Dissipated energy in J; the rest of the jump in potential energy is work of the inputs.
    pub dissipated_j: f64,
    /// Number of events.
    pub events: u64,
    /// Whether a failure has occurred: the loss of potential energy is then dissipated as well.
    pub failed: bool,
}

impl Outcome {
    /// Adds another outcome.
    pub fn add(&mut self, other: Self) {
        self.dissipated_j += other.dissipated_j;
        self.events += other.events;
        self.failed |= other.failed;
    }
}

/// Point at which an indicator is evaluated: an end of a step, or a point within it, where each value must be interpolated from the stages.
pub trait Place {
    /// Angle in rad.
    fn angle_rad(&self) -> f64;
    /// Rate in rad/s.
    fn rate_rad_s(&self) -> f64;
}

impl Place for Moving {
    fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    fn rate_rad_s(&self) -> f64 {
        self.rate_rad_s
    }
}
