//! Statistics of a run.

use serde::{Deserialize, Serialize};

/// Lock and latch of one revolute joint, which change at events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointStatus {
    /// The lock is released.
    pub released: bool,
    /// Latch closed.
    pub latched: bool,
    /// Time of the last closing in s; −1 before the first.
    pub latch_time_s: f64,
    /// Number of closings.
    pub latch_count: i32,
}

/// Counters of the time integration since initialisation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Steps rejected by the error estimate.
    pub rejections: u64,
    /// Steps that failed in Newton's iteration.
    pub failures: u64,
    /// Newton iterations (residuals with a solve) of the accepted motion.
    pub iterations: u64,
    /// Newton iterations of the trial marches for the coupling of air and structure, which are rolled back.
    pub trial_iterations: u64,
    /// Factorisations.
    pub factorizations: u64,
    /// Events: releases, holds, closings and openings of latches, changes of contact with stops.
    pub events: u64,
    /// Solutions of the air.
    pub air_solutions: u64,
    /// Stages that real-time mode accepted without convergence.
    pub unconverged: u64,
    /// Maximum number of Newton iterations of one stage.
    pub largest_iterations: u64,
    /// Longest wake row shed in an aerodynamic step, in panel chords; 0 without a lattice.
    pub longest_row_panels: f64,
    /// Steps of the air in which strips of a lattice have stalled and follow their polars with a lag, eq. (U32).
    pub stalled_steps: u64,
}
