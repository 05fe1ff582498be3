//! A joint with one freedom in the plant: the torques about its hinge, or the forces along its slide, and what they mean
//! for energies and Newton's matrix. Names are those of a hinge; of a slide read m for rad and N for N·m.

use crate::actuation::drive::{Drive, DriveTorque, Piece, Slew};
use crate::actuation::latch::Latch;
use crate::actuation::prescribed::Law;
use crate::actuation::spring::Spring;
use crate::load::Wrench;
use crate::machine::{JointMotion, OneFreedom, UNLIMITED};
use crate::multibody::factor::FreedomTangent;
use crate::multibody::kinematics::Motion;
use crate::multibody::{Model, Workspace};
use crate::plant::state::JointState;
use crate::solve::Powers;
use nalgebra::Vector3;

/// A revolute or prismatic joint as the equations see it.
#[derive(Debug, Clone)]
pub(super) struct JointEquations {
    /// Body that it holds.
    pub body: usize,
    /// Index of its angle in `q`.
    pub coordinate: usize,
    /// The angle does not follow from torques: stopper, rigid latch, lock or prescribed motion.
    pub held: bool,
    /// Motor, spring and damper act: joints that are neither locked nor prescribed.
    pub driven: bool,
    /// Prescribed motion.
    pub law: Option<Law>,
    /// Motor.
    pub drive: Drive,
    /// Its neutral angle.
    pub slew: Slew,
    /// Spring and damper of the joint itself.
    pub spring: Spring,
    /// External torque in N·m.
    pub external_n_m: f64,
    /// Torque at which a limit holds the motor whatever the inputs are, in N·m: only while derivatives by inputs are taken.
    pub pinned_n_m: Option<f64>,
    /// Piece of the motor's limits that residuals stand on, eq. (T12); `None` where they follow from the state.
    pub piece: Option<Piece>,
    /// Latch.
    pub latch: Option<Latch>,
    /// Latch closed.
    pub latched: bool,
    /// Torque of what holds the joint (stopper, rigid latch, lock, prescribed motion), of the last residual, in N·m; 0 where it is free.
    pub holding_n_m: f64,
}

impl JointEquations {
    /// A joint of body `body`, held; what inputs and parameters decide comes later.
    pub fn new(body: usize, coordinate: usize, own: &OneFreedom) -> Self {
        Self {
            body,
            coordinate,
            held: true,
            driven: own.motion == JointMotion::Free,
            law: match &own.motion {
                JointMotion::Prescribed(motion) => Some(Law::new(motion)),
                _ => None,
            },
            drive: Drive::default(),
            slew: Slew::default(),
            spring: Spring::default(),
            external_n_m: 0.0,
            pinned_n_m: None,
            piece: None,
            latch: own.latch.as_ref().map(|latch| Latch {
                kind: latch.kind,
                angle_rad: latch.angle_rad,
                stiffness_n_m_rad: latch.stiffness_n_m_rad,
                capture_rad: latch.capture_rad,
            }),
            latched: false,
            holding_n_m: 0.0,
        }
    }

    /// Torque of the motor at a state; nothing where none acts.
    pub fn motor_torque(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> DriveTorque {
        if !self.driven {
            return DriveTorque::default();
        }
        if let Some(applied_n_m) = self.pinned_n_m {
            return DriveTorque { applied_n_m, saturated: true };
        }
        self.drive.torque(angle_rad, rate_rad_s, self.slew.at(time_s).0)
    }

    /// Torque of the motor in N·m if it had no limit.
    fn wanted_n_m(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> f64 {
        self.drive.wanted_n_m(angle_rad, rate_rad_s, self.slew.at(time_s).0)
    }

    /// Whether a limit may act on the motor.
    fn is_limited(&self) -> bool {
        !self.held && self.driven && self.pinned_n_m.is_none() && self.drive.torque_limit_n_m < UNLIMITED
    }

    /// Moves a motor with a limit to the piece on which a state lies; says whether that is another one.
    pub fn move_piece(&mut self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> bool {
        if !self.is_limited() {
            return false;
        }
        let piece = self.drive.piece(self.wanted_n_m(time_s, angle_rad, rate_rad_s), self.piece);
        self.piece.replace(piece) != Some(piece)
    }

    /// Torque of the joint's own spring and damper at a state in N·m.
    pub fn spring_torque_n_m(&self, angle_rad: f64, rate_rad_s: f64) -> f64 {
        if self.driven { self.spring.torque_n_m(angle_rad, rate_rad_s) } else { 0.0 }
    }

    /// External torque in N·m, of joints that take one.
    pub fn external_torque_n_m(&self) -> f64 {
        if self.driven { self.external_n_m } else { 0.0 }
    }

    /// Torque of the closed elastic latch in N·m.
    pub fn latch_torque_n_m(&self, angle_rad: f64) -> f64 {
        self.closed_latch().map_or(0.0, |latch| latch.torque_n_m(angle_rad))
    }

    /// Sum of all torques on the outer body about `+θ` in N·m, NOTATION eqs. (A1) and (A3), with its tangent.
    pub fn torque(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> (f64, FreedomTangent) {
        let motor = match self.piece {
            Some(piece) => self.drive.torque_on(piece, self.wanted_n_m(time_s, angle_rad, rate_rad_s)),
            None => self.motor_torque(time_s, angle_rad, rate_rad_s),
        };
        let sum_n_m = motor.applied_n_m
            + self.spring_torque_n_m(angle_rad, rate_rad_s)
            + self.external_torque_n_m()
            + self.latch_torque_n_m(angle_rad);
        let active = if motor.saturated { 0.0 } else { 1.0 };
        let tangent = FreedomTangent {
            free: true,
            stiffness: active * self.drive.stiffness_n_m_rad
                + self.spring.stiffness_n_m_rad
                + self.closed_latch().map_or(0.0, |latch| latch.stiffness_n_m_rad),
            damping: active * self.drive.damping_n_m_s_rad + self.spring.damping_n_m_s_rad,
        };
        (sum_n_m, tangent)
    }

    /// Completes the joint's wrench on its body, root frame, along its freedom: a joint that moves freely passes on its
    /// torques or forces, less what its drive's inertia takes, whatever the last residual left there. A joint that is held
    /// keeps its wrench.
    pub fn complete_reaction(&self, model: &Model, work: &Workspace, motion: Motion, time_s: f64, on: &mut Wrench) {
        if self.held {
            return;
        }
        let (c, joint) = (self.coordinate, &model.bodies[self.body].joint);
        let twists = joint.freedom_twists(&work.joints[self.body]);
        let axis = |row: usize| -> Vector3<f64> { twists.fixed_view::<3, 1>(row, 0).into_owned() };
        // unit axes of a slide and of a hinge; the other one is zero
        let (slide, hinge) = (axis(0), axis(3));
        let along = self.torque(time_s, motion.q[c], motion.v[c]).0 - joint.drive_inertia * motion.a[c];
        on.force_n += slide * (along * slide.norm_squared() - slide.dot(&on.force_n));
        on.moment_n_m += hinge * (along * hinge.norm_squared() - hinge.dot(&on.moment_n_m));
    }

    /// Energy that spring and closed latch store in J.
    pub fn stored_j(&self, angle_rad: f64) -> f64 {
        let spring_j = if self.driven { self.spring.energy_j(angle_rad) } else { 0.0 };
        spring_j + self.closed_latch().map_or(0.0, |latch| latch.energy_j(angle_rad))
    }

    /// Adds what motor, damper and external torque do, NOTATION eq. (A5).
    pub fn add_powers(&self, time_s: f64, branch_s: f64, angle_rad: f64, rate_rad_s: f64, powers: &mut Powers) {
        let (neutral_rad, slew_rate_rad_s) = self.slew.at_on(time_s, branch_s);
        let motor = self.motor_torque(time_s, angle_rad, rate_rad_s);
        powers.work +=
            self.external_n_m * rate_rad_s + self.drive.slew_power_w(angle_rad, neutral_rad, slew_rate_rad_s);
        powers.dissipated += self.drive.dissipation_w(motor, angle_rad, rate_rad_s, neutral_rad)
            + self.spring.damping_n_m_s_rad * rate_rad_s * rate_rad_s;
    }

    /// Whether stopper, rigid latch, lock or prescribed motion hold the joint in a state of it.
    pub fn is_held_in(&self, state: &JointState) -> bool {
        !self.driven || !state.released || state.latch.closed && self.has_rigid_latch()
    }

    /// Whether its latch is a rigid one.
    pub fn has_rigid_latch(&self) -> bool {
        self.latch.as_ref().is_some_and(Latch::is_rigid)
    }

    /// The latch, if it is closed.
    pub fn closed_latch(&self) -> Option<&Latch> {
        self.latch.as_ref().filter(|_| self.latched)
    }
}
