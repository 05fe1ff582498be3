//! Statistics of a run.

use serde::{Deserialize, Serialize};

/// Status of the lock and latch of one revolute or prismatic joint, which changes at events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointStatus {
    /// Whether the lock is released.
    pub released: bool,
    /// Whether the latch is closed.
    pub latched: bool,
    /// Time of the last closing in s; −1 before the first.
    pub latch_time_s: f64,
    /// Number of closings.
    pub latch_count: i32,
}

/// Counters of the time integration since initialisation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Number of accepted steps.
    pub steps: u64,
    /// Number of steps rejected by the error estimate.
    pub rejections: u64,
    /// Number of steps in which Newton's method failed.
    pub failures: u64,
    /// Number of Newton iterations (residuals with a solve) in the accepted motion.
    pub iterations: u64,
    /// Number of Newton iterations in the trial marches of the aeroelastic coupling, which are rolled back.
    pub trial_iterations: u64,
    /// Number of factorisations.
    pub factorizations: u64,
    /// Number of events: releases, holds, closings and openings of latches, changes of contact with stops.
    pub events: u64,
    /// Number of solutions of the aerodynamic model.
    pub air_solutions: u64,
    /// Number of stages that real-time mode accepted without convergence.
    pub unconverged: u64,
    /// Maximum number of Newton iterations of one stage.
    pub largest_iterations: u64,
    /// Longest wake row shed in an aerodynamic step, in panel chords; 0 without a lattice.
    pub longest_row_panels: f64,
    /// Number of aerodynamic steps in which strips of a lattice have stalled and follow their polars with a lag, eq. (U32).
    pub stalled_steps: u64,
}
