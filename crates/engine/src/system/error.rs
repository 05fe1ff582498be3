//! Errors of a model at run time.

/// Error of a plant.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// The time integration failed.
    #[error(
        "no convergence at t = {time_s} s with internal steps down to {step_s:.1e} s, worst at {place}: {cause}; {advice}"
    )]
    NoConvergence {
        /// Last valid time in s.
        time_s: f64,
        /// Internal step in s at which the integrator stopped, below the smallest allowed one.
        step_s: f64,
        /// Element or joint with the largest contribution to the remaining error.
        place: String,
        /// Cause of the failure.
        cause: String,
        /// Suggested remedy.
        advice: &'static str,
    },
    /// Outputs that are not finite.
    #[error("outputs at t = {time_s} s are not finite; {cause}; check the inputs and parameters up to this time")]
    NotFinite {
        /// End of the step in s.
        time_s: f64,
        /// Name of the largest input.
        cause: String,
    },
    /// The maximum computational effort of one communication step was exceeded.
    #[error(
        "reached only t = {time_s} s after {most} iterations, with a last internal step of {step_s:.1e} s; {cause}; use shorter communication steps, or allow a larger solver.tolerance"
    )]
    TooMuchWork {
        /// Last valid time in s.
        time_s: f64,
        /// Maximum number of Newton iterations in one communication step, including trial marches of the aeroelastic coupling.
        most: u64,
        /// Next internal step in s.
        step_s: f64,
        /// Name of the largest input.
        cause: String,
    },
    /// Accelerations that are too large for the aerodynamic step.
    #[error(
        "the accelerations at t = {time_s} s move the wing by {lengths:.1e} times its length within an aerodynamic \
         step of {step_s} s; {cause}; reduce the accelerations, or use a smaller aerodynamics.step_s"
    )]
    Leap {
        /// Time in s.
        time_s: f64,
        /// Displacement within an aerodynamic step divided by the model's length.
        lengths: f64,
        /// Aerodynamic step in s.
        step_s: f64,
        /// Name of the largest input.
        cause: String,
    },
    /// The time is so large that adding a step is lost in round-off.
    #[error("a step of {step_s:.1e} s does not advance the time t = {time_s} s; start nearer to 0 s")]
    Clock {
        /// Last valid time in s.
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
    /// States set by an external integrator that are physically impossible.
    #[error(
        "at t = {time_s} s {place} is compressed to less than zero length: the longitudinal strain is {strain:.3e}, \
         but must be greater than -1"
    )]
    Crushed {
        /// Time in s.
        time_s: f64,
        /// Name of the element.
        place: String,
        /// Longitudinal strain of the element.
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
    /// No aerodynamic loads are consistent with the motion.
    #[error(
        "no aerodynamic loads at t = {time_s} s: {cause}; check wind and density, or try another aerodynamics.step_s"
    )]
    Air {
        /// Time in s.
        time_s: f64,
        /// Cause of the failure.
        cause: String,
    },
    /// The aerodynamic model does not apply to the current state: a control surface beyond its limits, Mach 1, the ground.
    #[error("no aerodynamic loads at t = {time_s} s: {cause}")]
    Surroundings {
        /// Time in s.
        time_s: f64,
        /// Cause and remedy.
        cause: String,
    },
    /// Two lattices coincide.
    #[error(
        "no aerodynamic loads at t = {time_s} s: the lattices of {} and {} are folded onto each other, at most {gap_m:.1e} m or \
         {gap_panels:.2} panels apart; at least {} panels are needed: open their joint further, use more strips, or use strip \
         theory",
        .bodies[0], .bodies[1], crate::aero::near_sheets::CLOSED_PANELS
    )]
    ClosedSheets {
        /// Time in s.
        time_s: f64,
        /// Names of the bodies that carry the lattices.
        bodies: [String; 2],
        /// Largest distance in m.
        gap_m: f64,
        /// Largest distance divided by the panel size.
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
        /// Names of the bodies that carry the lattices.
        bodies: [String; 2],
        /// Penetration depth in m.
        depth_m: f64,
    },
    /// The lattices or lifting lines of two bodies overlap at their joint.
    #[error(
        "no aerodynamic loads at t = {time_s} s: the surfaces of {} and {} overlap by {depth_m:.1e} m where they are joined, \
         because their edges do not coincide (at a hinge: do not lie on its axis): set the incidence of the wing by the \
         attitude of its root instead of incidence_deg, use wider strips, or, at a flared hinge in a vortex lattice, set \
         flare_deg of both surfaces there to the flare of the axis",
        .bodies[0], .bodies[1]
    )]
    OverlappingSheets {
        /// Time in s.
        time_s: f64,
        /// Names of the bodies; the second may be the image of the first.
        bodies: [String; 2],
        /// Depth of the overlap along the span in m.
        depth_m: f64,
    },
    /// No static equilibrium was found.
    #[error(
        "no equilibrium at t = {time_s} s beyond the load factor {reached:.4}, last tried {tried:.4}: {cause}; reduce \
         the load, or start from the unstrained shape"
    )]
    Equilibrium {
        /// Time in s.
        time_s: f64,
        /// Largest load factor with an equilibrium.
        reached: f64,
        /// Load factor at which the search failed.
        tried: f64,
        /// Cause of the failure.
        cause: String,
        /// Wind speed in m/s at which the path of equilibria ends because the stiffness becomes singular, if known.
        diverges_m_s: Option<f64>,
    },
    /// The equilibrium found requires a load on a free joint, so that it is not a steady flight.
    #[error(
        "no steady flight at t = {time_s} s: {force_n:.3e} N and {moment_n_m:.3e} N m remain on the free joint {joint:?}; trim the \
         model and set the values found"
    )]
    Flight {
        /// Time in s.
        time_s: f64,
        /// Name of the joint.
        joint: String,
        /// Magnitude of the force in N that would be needed to hold it.
        force_n: f64,
        /// Magnitude of the moment in N·m about the joint that would be needed to hold it.
        moment_n_m: f64,
    },
    /// A body has left the beam along which it slides.
    #[error(
        "at t = {time_s} s joint {joint} is at {position_m} m, beyond the end of {beam}, which reaches from 0 to {length_m} m: \
         a body cannot leave the beam along which it slides; put end_stops on the joint so far inside the ends that their \
         compression stays on the beam, or stop the run before"
    )]
    OffBeam {
        /// Time in s.
        time_s: f64,
        /// Name of the sliding joint.
        joint: String,
        /// Name of the beam.
        beam: String,
        /// Length of the beam in m.
        length_m: f64,
        /// Position of the joint in m.
        position_m: f64,
    },
    /// An analysis of a machine with sliding joints and too many coordinates.
    #[error(
        "no {analysis} at t = {time_s} s: a model with a sliding joint ({joint}) may have {maximum} coordinates for it, and this one has \
         {coordinates}; use fewer elements, or compute the motion over time"
    )]
    Sliding {
        /// Time in s.
        time_s: f64,
        /// Name of the sliding joint.
        joint: String,
        /// The analysis.
        analysis: &'static str,
        /// Number of coordinates.
        coordinates: usize,
        /// Maximum number of coordinates.
        maximum: usize,
    },
    /// An analysis that models with rigid loops do not support.
    #[error(
        "no {analysis} at t = {time_s} s: the loop {name:?} is rigid, and its constraints are not linearised; compute the motion over \
         time, or give the loop stiffness_N_m in place of rigid = true"
    )]
    RigidLoop {
        /// Time in s.
        time_s: f64,
        /// Name of the loop.
        name: String,
        /// The analysis.
        analysis: &'static str,
    },
    /// An analysis that models with skates or wheels do not support.
    #[error(
        "no {analysis} at t = {time_s} s: the {kind} {name:?} constrains velocities, which no function of the positions represents; \
         compute the motion over time, or omit the table [{kind}.{name}]"
    )]
    NoSlip {
        /// Time in s.
        time_s: f64,
        /// `skate` or `wheel`.
        kind: &'static str,
        /// Name of the skate or wheel.
        name: String,
        /// The analysis.
        analysis: &'static str,
    },
    /// An analysis that models with DC motors do not support.
    #[error(
        "no {analysis} at t = {time_s} s: the current of the dc_motor of joint {joint:?} is a state that this analysis does not include; \
         compute the motion over time, or omit the table [joint.{joint}.dc_motor]"
    )]
    DcMotor {
        /// Time in s.
        time_s: f64,
        /// Name of the joint.
        joint: String,
        /// The analysis.
        analysis: &'static str,
    },
    /// A wheel whose axis, or a skate whose blade, is along the normal of the plane.
    #[error(
        "at t = {time_s} s the {kind} {name:?} {lies}: its {part} is at {angle_deg:.2}° to the normal of the plane, along which it has no \
         heading; hold it off the normal by end_stops or a spring on a joint, or end the run before"
    )]
    NoHeading {
        /// Last valid time in s.
        time_s: f64,
        /// `skate` or `wheel`.
        kind: &'static str,
        /// Name of the skate or wheel.
        name: String,
        /// Position in words.
        lies: &'static str,
        /// `blade` or `axis`.
        part: &'static str,
        /// Angle between the blade or axis and the normal in degrees.
        angle_deg: f64,
    },
    /// The current state has no linear model.
    #[error("no linearisation at t = {time_s} s: {cause}")]
    Linearization {
        /// Time in s.
        time_s: f64,
        /// Cause of the failure.
        cause: String,
    },
    /// No periodic motion of a spinning rotor was found.
    #[error("no periodic motion at t = {time_s} s: {cause}")]
    Periodic {
        /// Time in s.
        time_s: f64,
        /// Cause and remedy.
        cause: String,
    },
    /// The snapshot belongs to another model.
    #[error("the state does not fit this model: {0}; save one with this instance")]
    Snapshot(String),
}

impl PlantError {
    /// Text of an error at states set by the caller: without the advice on inputs and parameters, which are not the cause in this case.
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
            | Self::OverlappingSheets { .. }
            | Self::Equilibrium { .. }
            | Self::Flight { .. }
            | Self::OffBeam { .. }
            | Self::Sliding { .. }
            | Self::RigidLoop { .. }
            | Self::NoSlip { .. }
            | Self::DcMotor { .. }
            | Self::NoHeading { .. }
            | Self::Linearization { .. }
            | Self::Periodic { .. }
            | Self::Snapshot(..) => self.to_string(),
        }
    }
}
