//! What stops a joint at once: stopper, brake, rigid latch. One impulse, one account of the energy, NOTATION eq. (A6).

use crate::plant::equations::Equations;
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Singular};

/// What it takes to stop a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Stop {
    /// Impulse on the outer body about `+θ` in N·m·s.
    pub impulse_n_m_s: f64,
    /// Kinetic energy lost in J.
    pub energy_j: f64,
}

impl Equations {
    /// Stops a revolute joint of the tree at the configuration of the last residual: its rate becomes zero, all other
    /// rates follow through the mass matrix, and the joint is held from then on.
    ///
    /// Joints that are held already stay at rest, so joints stopped one after the other end as if stopped together.
    /// `scratch` has one entry per coordinate. Allocates nothing.
    pub fn stop(&mut self, joint: usize, point: &mut Point, scratch: &mut [f64]) -> Result<Stop, Singular> {
        let (c, body) = (self.joints[joint].coordinate, self.joints[joint].body);
        let rate_rad_s = point.v[c];
        let mut stop = Stop::default();
        if rate_rad_s != 0.0 {
            self.factorize(1.0, 0.0, 0.0)?;
            scratch.fill(0.0);
            scratch[c] = 1.0;
            self.solve(scratch);
            stop.impulse_n_m_s = -rate_rad_s / scratch[c];
            stop.energy_j = -0.5 * stop.impulse_n_m_s * rate_rad_s;
            for (v, per_impulse) in point.v.iter_mut().zip(scratch.iter()) {
                *v += stop.impulse_n_m_s * per_impulse;
            }
            point.v[c] = 0.0;
        }
        self.joints[joint].held = true;
        self.tangents[body].free = false;
        Ok(stop)
    }
}
