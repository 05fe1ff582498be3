//! Solution settings: the tables `[solver]` and `[simulation]` of the model file.

use foldwing_engine::machine::{Experiment, Method, Solver, StartState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Time integration.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct SolverFile {
    /// Integration method.
    pub method: MethodFile,
    /// Tolerance of the error per step: displacement over wing length, rotation in rad.
    #[schemars(range(min = 1e-12, max = 1e-1))]
    pub tolerance: f64,
    /// Maximum internal step.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_step_s: f64,
    /// Minimum internal step; less than `max_step_s`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub min_step_s: f64,
    /// Fixed internal step, default: variable steps; required by `rk4`. It divides the communication step evenly; with
    /// aerodynamics, the aerodynamic step.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fixed_step_s: Option<f64>,
    /// Spectral radius at infinity of the generalised-α method.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub rho_infinity: f64,
    /// `accurate`, or `real_time`: fixed steps, by default of 1 ms, with the method `sdirk2` and bounded work; steps
    /// are never repeated. With aerodynamics only with `coupling = "staggered"`.
    pub mode: ModeFile,
    /// Maximum number of Newton iterations per stage in real-time mode; unconverged results are accepted and counted.
    #[schemars(range(min = 1, max = 10))]
    pub max_iterations: u32,
}

/// Priority of the time integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ModeFile {
    /// Accuracy: steps are repeated until error and convergence tolerances are met.
    Accurate,
    /// Bounded work in every step.
    RealTime,
}

impl Default for SolverFile {
    fn default() -> Self {
        let Solver { tolerance, max_step_s, min_step_s, fixed_step_s, rho_infinity, .. } = Solver::default();
        Self {
            method: MethodFile::Esdirk4,
            tolerance,
            max_step_s,
            min_step_s,
            fixed_step_s,
            rho_infinity,
            mode: ModeFile::Accurate,
            max_iterations: 4,
        }
    }
}

/// Time integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub(super) enum MethodFile {
    /// Generalised-α, second order.
    #[serde(rename = "generalized_alpha")]
    GeneralizedAlpha,
    /// TR-BDF2, second order.
    #[serde(rename = "tr_bdf2")]
    TrBdf2,
    /// Two-stage SDIRK, second order; the method of real-time mode.
    #[serde(rename = "sdirk2")]
    Sdirk2,
    /// ESDIRK, third order.
    #[serde(rename = "esdirk3")]
    Esdirk3,
    /// ESDIRK, fourth order.
    #[serde(rename = "esdirk4")]
    Esdirk4,
    /// Classical explicit Runge–Kutta, fourth order; needs `fixed_step_s`.
    #[serde(rename = "rk4")]
    Rk4,
}

impl From<MethodFile> for Method {
    fn from(method: MethodFile) -> Self {
        match method {
            MethodFile::GeneralizedAlpha => Self::GeneralizedAlpha,
            MethodFile::TrBdf2 => Self::TrBdf2,
            MethodFile::Esdirk3 => Self::Esdirk3,
            MethodFile::Sdirk2 => Self::Sdirk2,
            MethodFile::Esdirk4 => Self::Esdirk4,
            MethodFile::Rk4 => Self::Rk4,
        }
    }
}

/// Default simulation.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct SimulationFile {
    /// Start time.
    pub start_time_s: f64,
    /// Stop time, after the start.
    pub stop_time_s: f64,
    /// Communication step.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step_s: f64,
    /// Initial state: `unstrained`, with gravity and loads applied suddenly; or `equilibrium`, the static equilibrium
    /// under them. The equilibrium has joints locked at their start angles, except joints with a closed latch, and free
    /// joints fixed at their start position; joints with `release = true` are released at the start. In contrast,
    /// `foldwing static`, `modes` and `linearize` compute the equilibrium with the joints free.
    pub start: StartFile,
}

/// Initial state of the simulation.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum StartFile {
    /// Without strains; gravity and loads act from the start on.
    Unstrained,
    /// Static equilibrium under gravity and loads.
    Equilibrium,
}

impl From<StartFile> for StartState {
    fn from(start: StartFile) -> Self {
        match start {
            StartFile::Unstrained => Self::Unstrained,
            StartFile::Equilibrium => Self::Equilibrium,
        }
    }
}

impl Default for SimulationFile {
    fn default() -> Self {
        let Experiment { start_time_s, stop_time_s, step_s, .. } = Experiment::default();
        Self { start_time_s, stop_time_s, step_s, start: StartFile::Unstrained }
    }
}
