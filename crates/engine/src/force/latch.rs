//! Latch of a fold joint.

use crate::force::memory::{JointMemory, Told};
use crate::force::{Here, Moving, Outcome, Push};
use serde::{Deserialize, Serialize};

/// Kind of a closed latch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatchKind {
    /// A spring about its angle, NOTATION eq. (A3).
    Elastic,
    /// Holds the angle at which it has caught the joint, NOTATION eq. (A7).
    Rigid,
}

/// Parameters of a latch, NOTATION eqs. (A3) and (A7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Latch {
    /// Kind of the latch when closed.
    pub kind: LatchKind,
    /// Angle at which it closes in rad.
    pub angle_rad: f64,
    /// Stiffness when closed in N·m/rad; 0 for a rigid one, which holds by its reaction.
    pub stiffness_n_m_rad: f64,
    /// Half-width of the capture range, rad.
    pub capture_rad: f64,
}

impl Latch {
    /// Whether an angle is in the capture range, where an enabled latch is closed.
    pub fn catches(&self, angle_rad: f64) -> bool {
        self.beyond_rad(angle_rad) <= 0.0
    }

    /// Distance of an angle from the capture range in rad; not positive inside.
    pub fn beyond_rad(&self, angle_rad: f64) -> f64 {
        (angle_rad - self.angle_rad).abs() - self.capture_rad
    }

    /// Distance to the capture range in rad for a joint that moves from `from_rad`, outside of it: falls through zero at the edge of the
    /// range, on either side, and continues to fall beyond.
    pub fn gap_rad(&self, from_rad: f64, angle_rad: f64) -> f64 {
        let side = if from_rad < self.angle_rad { -1.0 } else { 1.0 };
        side * (angle_rad - self.angle_rad) - self.capture_rad
    }

    /// Whether it holds the joint without a spring.
    pub fn is_rigid(&self) -> bool {
        self.kind == LatchKind::Rigid
    }

    /// Edge of the capture range in rad that a joint reaches from `from_rad`, outside of it.
    pub fn edge_rad(&self, from_rad: f64) -> f64 {
        self.angle_rad + if from_rad < self.angle_rad { -self.capture_rad } else { self.capture_rad }
    }

    /// Torque of the spring on the outer body about `+θ` in N·m when closed.
    pub fn torque_n_m(&self, angle_rad: f64) -> f64 {
        -self.stiffness_n_m_rad * (angle_rad - self.angle_rad)
    }

    /// Energy that the spring stores when closed in J.
    pub fn energy_j(&self, angle_rad: f64) -> f64 {
        0.5 * self.stiffness_n_m_rad * (angle_rad - self.angle_rad).powi(2)
    }
}

/// Accuracy to which crossings are located, in s.
pub const CROSSING_S: f64 = 1e-10;

/// A latch at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CatchingLatch {
    /// Its parameters.
    pub latch: Latch,
    /// Closed.
    pub closed: bool,
}

impl CatchingLatch {
    /// Adds the torque of a closed latch and its tangent.
    pub fn push(&self, here: &Here, sum: &mut Push) {
        if self.closed {
            sum.torque_n_m += self.latch.torque_n_m(here.angle_rad);
            sum.tangent.stiffness += self.latch.stiffness_n_m_rad;
        }
    }

    /// Energy stored in J.
    pub fn stored_j(&self, angle_rad: f64) -> f64 {
        if self.closed { self.latch.energy_j(angle_rad) } else { 0.0 }
    }

    /// Whether it holds the joint without a spring.
    pub fn holds(&self, memory: &JointMemory) -> bool {
        memory.latch.closed && self.latch.is_rigid()
    }

    /// Whether it is enabled and open and the joint outside its capture range.
    pub fn is_armed(&self, start: &Moving, memory: &JointMemory) -> bool {
        let state = &memory.latch;
        state.enabled && !state.closed && self.latch.gap_rad(start.angle_rad, start.angle_rad) > 0.0
    }

    /// Closes; the impulse of a rigid latch follows when the joint has been stopped.
    pub fn transition(time_s: f64, memory: &mut JointMemory) -> Outcome {
        let state = &mut memory.latch;
        state.closed = true;
        state.impulse_n_m_s = 0.0;
        state.time_s = time_s;
        state.count += 1;
        Outcome { events: 1, ..Outcome::default() }
    }

    /// Opens, and dissipates the stored energy of its spring; or closes on a joint in its capture range. `crossed`: the present step ends
    /// there.
    pub fn take_inputs(&self, told: &Told, now: &Moving, crossed: bool, memory: &mut JointMemory) -> Outcome {
        let mut outcome = Outcome::default();
        if memory.latch.closed && !told.latch_enable {
            memory.latch.closed = false;
            outcome = Outcome { dissipated_j: self.latch.energy_j(now.angle_rad), events: 1, failed: false };
        } else if !memory.latch.closed && told.latch_enable && {
            // the inputs may change at the crossing itself
            let arrived = self.latch.beyond_rad(now.angle_rad) <= CROSSING_S * now.rate_rad_s.abs();
            crossed && (told.at_end || arrived) || self.latch.catches(now.angle_rad)
        } {
            outcome = Self::transition(told.time_s, memory);
        }
        memory.latch.enabled = told.latch_enable;
        outcome
    }

    /// Place of the impulse of a rigid latch that closes at `time_s`.
    pub fn impulse_n_m_s<'a>(&self, time_s: f64, memory: &'a mut JointMemory) -> Option<&'a mut f64> {
        let state = &mut memory.latch;
        (state.closed && state.time_s == time_s && self.latch.is_rigid()).then_some(&mut state.impulse_n_m_s)
    }

    /// Closes on a joint whose static equilibrium would be in its capture range or beyond; a rigid latch holds it at the edge.
    pub fn stops_at_rest(&self, from_rad: &mut f64, to_rad: f64, memory: &mut JointMemory) -> bool {
        let state = &mut memory.latch;
        let caught = state.enabled && !state.closed && self.latch.gap_rad(*from_rad, to_rad) <= 0.0;
        if caught {
            state.closed = true;
            if self.latch.is_rigid() {
                *from_rad = self.latch.edge_rad(*from_rad);
            }
        }
        caught
    }
}

/// State of a latch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LatchState {
    /// Closed.
    pub closed: bool,
    /// May close.
    pub enabled: bool,
    /// Time of the last closing in s; −1 before the first.
    pub time_s: f64,
    /// Number of closings.
    pub count: i32,
    /// Impulse of the last closing on the outer body about `+θ` in N·m·s, of a rigid latch; 0 before the first.
    pub impulse_n_m_s: f64,
}
