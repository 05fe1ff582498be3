//! Errors of a machine at run time.

/// Error of a plant.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// The time integration failed.
    #[error(
        "no convergence at t = {time_s} s with internal steps down to {step_s:.1e} s, worst at {place}: {cause}; {advice}"
    )]
    NoConvergence {
        /// Last good time in s.
        time_s: f64,
        /// Internal step at which the integrator stopped, below the smallest allowed, in s.
        step_s: f64,
        /// Element or joint with the largest motion in the remainder.
        place: String,
        /// Cause of the failure.
        cause: String,
        /// Suggested remedy.
        advice: &'static str,
    },
    /// Numbers that grew too large.
    #[error("outputs at t = {time_s} s are not finite; {cause}; check the inputs and parameters up to this time")]
    NotFinite {
        /// End of the step in s.
        time_s: f64,
        /// The largest input.
        cause: String,
    },
    /// More work than one communication step may cost.
    #[error(
        "reached only t = {time_s} s after {most} iterations, with a last internal step of {step_s:.1e} s; {cause}; use shorter communication steps, or allow a larger solver.tolerance"
    )]
    TooMuchWork {
        /// Last good time in s.
        time_s: f64,
        /// Newton iterations of one communication step at most, trial marches with the air included.
        most: u64,
        /// Next internal step in s.
        step_s: f64,
        /// The largest input.
        cause: String,
    },
    /// Accelerations that no aerodynamic step can follow.
    #[error(
        "the accelerations at t = {time_s} s move the wing by {lengths:.1e} times its length within an aerodynamic \
         step of {step_s} s; {cause}; reduce the accelerations, or use a smaller aerodynamics.step_s"
    )]
    Leap {
        /// Time in s.
        time_s: f64,
        /// Displacement in an aerodynamic step over the machine's length.
        lengths: f64,
        /// Aerodynamic step in s.
        step_s: f64,
        /// The largest input.
        cause: String,
    },
    /// The time is so large that a step is lost in its round-off.
    #[error("a step of {step_s:.1e} s does not advance the time t = {time_s} s; start nearer to 0 s")]
    Clock {
        /// Last good time in s.
        time_s: f64,
        /// Internal step in s.
        step_s: f64,
    },
    /// Parameters that contradict each other.
    #[error("solver.min_step, {min_step_s:e} s, is longer than solver.max_step, {max_step_s:e} s; change one of them")]
    Steps {
        /// Smallest internal step in s.
        min_step_s: f64,
        /// Largest internal step in s.
        max_step_s: f64,
    },
    /// States of an external integrator that are impossible for a structure.
    #[error(
        "at t = {time_s} s {place} is compressed to less than zero length: the longitudinal strain is {strain:.3e}, \
         but must be greater than -1"
    )]
    Crushed {
        /// Time in s.
        time_s: f64,
        /// The element.
        place: String,
        /// Its strain.
        strain: f64,
    },
    /// The initial accelerations could not be found.
    #[error("no accelerations at t = {time_s} s: {cause}; check the inputs and parameters from this time on")]
    Initialization {
        /// Start time in s.
        time_s: f64,
        /// Cause of the failure.
        cause: String,
    },
    /// The air has no loads that agree with the motion.
    #[error(
        "no aerodynamic loads at t = {time_s} s: {cause}; check wind and density, or try another aerodynamics.step_s"
    )]
    Air {
        /// Time in s.
        time_s: f64,
        /// Cause of the failure.
        cause: String,
    },
    /// The aerodynamic model does not apply to the present state: a control surface beyond its limits, Mach 1, the ground.
    #[error("no aerodynamic loads at t = {time_s} s: {cause}")]
    Surroundings {
        /// Time in s.
        time_s: f64,
        /// Cause and cure.
        cause: String,
    },
    /// Two lattices coincide.
    #[error(
        "no aerodynamic loads at t = {time_s} s: the lattices of {} and {} lie on each other, {gap_m:.1e} m or {gap_panels:.2} \
         panels apart at the widest place; at least {} panels are needed: open their joint further, use more strips, or strip \
         theory",
        .bodies[0], .bodies[1], crate::aero::near_sheets::CLOSED_PANELS
    )]
    ClosedSheets {
        /// Time in s.
        time_s: f64,
        /// Bodies that carry them.
        bodies: [String; 2],
        /// Distance at the widest place in m.
        gap_m: f64,
        /// The same over the size of a panel.
        gap_panels: f64,
    },
    /// One lattice passes through another.
    #[error(
        "no aerodynamic loads at t = {time_s} s: the lattices of {} and {} pass through each other by {depth_m:.1e} m, \
         as contact is not modelled: use more chord_panels to resolve a narrower gap, or open their joint further",
        .bodies[0], .bodies[1]
    )]
    CrossedSheets {
        /// Time in s.
        time_s: f64,
        /// Bodies that carry them.
        bodies: [String; 2],
        /// Depth in m.
        depth_m: f64,
    },
    /// No state of rest was found.
    #[error(
        "no equilibrium at t = {time_s} s beyond the load factor {reached:.4}, last tried {tried:.4}: {cause}; reduce \
         the load, or start from the unstrained shape"
    )]
    Equilibrium {
        /// Time in s.
        time_s: f64,
        /// Largest load factor with an equilibrium.
        reached: f64,
        /// Load factor that failed.
        tried: f64,
        /// Cause.
        cause: String,
        /// Wind speed in m/s at which the path of equilibria ends for lack of stiffness, if that is known.
        diverges_m_s: Option<f64>,
    },
    /// A free joint without stiffness in the equilibrium found.
    #[error(
        "no steady flight at t = {time_s} s: {force_n:.3e} N and {moment_n_m:.3e} N m remain on the free joint {joint:?}; trim the \
         machine and set the values found"
    )]
    Flight {
        /// Time in s.
        time_s: f64,
        /// Its name.
        joint: String,
        /// Magnitude of the force that would have to hold it in N.
        force_n: f64,
        /// Magnitude of the moment about it that would have to hold it in N·m.
        moment_n_m: f64,
    },
    /// No linear model of the present state.
    #[error("no linearisation at t = {time_s} s: {cause}")]
    Linearization {
        /// Time in s.
        time_s: f64,
        /// Cause.
        cause: String,
    },
    /// No periodic motion of a rotor that turns.
    #[error("no periodic motion at t = {time_s} s: {cause}")]
    Periodic {
        /// Time in s.
        time_s: f64,
        /// Cause and cure.
        cause: String,
    },
    /// A snapshot of another model.
    #[error("the state does not fit this model: {0}; save one with this instance")]
    Snapshot(String),
}

impl PlantError {
    /// The error at states set by the caller: without the advice on inputs and parameters, which are not the cause there.
    pub fn at_set_states(&self) -> String {
        match self {
            Self::NotFinite { time_s, .. } => format!("outputs at t = {time_s} s are not finite"),
            Self::Initialization { time_s, cause } => format!("no accelerations at t = {time_s} s: {cause}"),
            Self::Air { time_s, cause } => format!("no aerodynamic loads at t = {time_s} s: {cause}"),
            Self::NoConvergence { .. }
            | Self::TooMuchWork { .. }
            | Self::Leap { .. }
            | Self::Clock { .. }
            | Self::Steps { .. }
            | Self::Crushed { .. }
            | Self::Surroundings { .. }
            | Self::ClosedSheets { .. }
            | Self::CrossedSheets { .. }
            | Self::Equilibrium { .. }
            | Self::Flight { .. }
            | Self::Linearization { .. }
            | Self::Periodic { .. }
            | Self::Snapshot(..) => self.to_string(),
        }
    }
}
