//! Latch of a fold joint.

pub use crate::force::memory::LatchState;
use crate::force::memory::{JointMemory, Told};
use crate::force::{Here, Moving, Outcome, Push};

/// Kind of a latch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatchKind {
    /// Acts as a spring about its angle when closed, NOTATION eq. (A3).
    Elastic,
    /// Holds the joint at the angle at which it closed, NOTATION eq. (A7).
    Rigid,
}

/// Parameters of a latch, NOTATION eqs. (A3) and (A7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Latch {
    /// Kind of the latch.
    pub kind: LatchKind,
    /// Angle of the latch, the middle of its capture range, in rad.
    pub angle_rad: f64,
    /// Stiffness when closed in N·m/rad; 0 for a rigid latch, which holds by a constraint torque.
    pub stiffness_n_m_rad: f64,
    /// Half-width of the capture range, rad.
    pub capture_rad: f64,
}

impl Latch {
    /// Whether an angle is in the capture range, where an enabled latch closes.
    pub fn catches(&self, angle_rad: f64) -> bool {
        self.beyond_rad(angle_rad) <= 0.0
    }

    /// Distance of an angle from the capture range in rad; not positive inside.
    pub fn beyond_rad(&self, angle_rad: f64) -> f64 {
        (angle_rad - self.angle_rad).abs() - self.capture_rad
    }

    /// Distance to the capture range in rad for a joint that moves from `from_rad` outside it: falls through zero at the near edge of the
    /// range and continues to decrease beyond.
    pub fn gap_rad(&self, from_rad: f64, angle_rad: f64) -> f64 {
        let side = if from_rad < self.angle_rad { -1.0 } else { 1.0 };
        side * (angle_rad - self.angle_rad) - self.capture_rad
    }

    /// Whether the latch holds the joint rigidly, without a spring.
    pub fn is_rigid(&self) -> bool {
        self.kind == LatchKind::Rigid
    }

    /// Edge of the capture range in rad that a joint reaches from `from_rad` outside it.
    pub fn edge_rad(&self, from_rad: f64) -> f64 {
        self.angle_rad + if from_rad < self.angle_rad { -self.capture_rad } else { self.capture_rad }
    }

    /// Torque of the closed latch's spring on the outer body about `+θ` in N·m.
    pub fn torque_n_m(&self, angle_rad: f64) -> f64 {
        -self.stiffness_n_m_rad * (angle_rad - self.angle_rad)
    }

    /// Energy stored in the closed latch's spring in J.
    pub fn energy_j(&self, angle_rad: f64) -> f64 {
        0.5 * self.stiffness_n_m_rad * (angle_rad - self.angle_rad).powi(2)
    }
}

/// Accuracy to which crossings are located, in s.
pub const CROSSING_S: f64 = 1e-10;

/// A latch with its current state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CatchingLatch {
    /// Parameters of the latch.
    pub latch: Latch,
    /// Whether the latch is closed.
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

    /// Energy stored in the closed latch in J.
    pub fn stored_j(&self, angle_rad: f64) -> f64 {
        if self.closed { self.latch.energy_j(angle_rad) } else { 0.0 }
    }

    /// Whether the latch is closed and holds the joint rigidly.
    pub fn holds(&self, memory: &JointMemory) -> bool {
        memory.latch.closed && self.latch.is_rigid()
    }

    /// Whether the latch is enabled and open and the joint is outside its capture range.
    pub fn is_armed(&self, start: &Moving, memory: &JointMemory) -> bool {
        let state = &memory.latch;
        state.enabled && !state.closed && self.latch.gap_rad(start.angle_rad, start.angle_rad) > 0.0
    }

    /// Closes the latch; the impulse of a rigid one is known only when the joint has been stopped.
    pub fn transition(time_s: f64, memory: &mut JointMemory) -> Outcome {
        let state = &mut memory.latch;
        state.closed = true;
        state.impulse_n_m_s = 0.0;
        state.time_s = time_s;
        state.count += 1;
        Outcome { events: 1, ..Outcome::default() }
    }

    /// Opens the latch and dissipates the energy stored in its spring, or closes it on a joint in the capture range. `crossed`: the current
    /// step ends at the edge of that range.
    pub fn take_inputs(&self, told: &Told, now: &Moving, crossed: bool, memory: &mut JointMemory) -> Outcome {
        let mut outcome = Outcome::default();
        if memory.latch.closed && !told.latch_enable {
            memory.latch.closed = false;
            outcome = Outcome { dissipated_j: self.latch.energy_j(now.angle_rad), events: 1, failed: false };
        } else if !memory.latch.closed && told.latch_enable && {
            // the inputs may change exactly at the crossing
            let arrived = self.latch.beyond_rad(now.angle_rad) <= CROSSING_S * now.rate_rad_s.abs();
            crossed && (told.at_end || arrived) || self.latch.catches(now.angle_rad)
        } {
            outcome = Self::transition(told.time_s, memory);
        }
        memory.latch.enabled = told.latch_enable;
        outcome
    }

    /// Storage of the impulse of a rigid latch that closes at `time_s`.
    pub fn impulse_n_m_s<'a>(&self, time_s: f64, memory: &'a mut JointMemory) -> Option<&'a mut f64> {
        let state = &mut memory.latch;
        (state.closed && state.time_s == time_s && self.latch.is_rigid()).then_some(&mut state.impulse_n_m_s)
    }

    /// Edge of the capture range that a joint reaches from `from_rad` in a direction, 1 or -1, while the latch is enabled and open.
    pub fn ahead_rad(&self, from_rad: f64, direction: f64, memory: &JointMemory) -> Option<f64> {
        let (state, edge_rad) = (&memory.latch, self.latch.edge_rad(from_rad));
        (state.enabled && !state.closed && (edge_rad - from_rad) * direction > 0.0).then_some(edge_rad)
    }

    /// Closes the latch if the static equilibrium would be in its capture range or beyond; a rigid latch holds the joint at the edge.
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
