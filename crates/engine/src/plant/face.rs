//! What goes in and what comes out: plain data without behaviour.

use crate::load::{RootMotion, Wrench};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Inputs of one revolute joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointInputs {
    /// Neutral angle `θ_cmd` in rad.
    pub command_rad: f64,
    /// External torque `τ_ext` on the outer body about `+θ` in N·m.
    pub torque_n_m: f64,
    /// Release of the stopper; false holds the joint where it is.
    pub release: bool,
    /// Latch may close; ignored by joints without a latch.
    pub latch_enable: bool,
}

/// All inputs, held during a step.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Per revolute joint, in the order of [`crate::plant::Plant::revolute_joints`].
    pub joints: Vec<JointInputs>,
    /// Total force and moment per station, bodies in model order, stations from the inner end outward,
    /// each in its body's `load_frame`.
    pub stations: Vec<Wrench>,
    /// Gravity and motion of the root.
    pub root: RootMotion,
    /// Velocity of the air relative to the root's origin, root frame, m/s; ignored by machines without air.
    pub wind_m_s: Vector3<f64>,
}

/// By hand, because a derived `clone_from` allocates and inputs are copied whenever they change.
impl Clone for Inputs {
    fn clone(&self) -> Self {
        Self { joints: self.joints.clone(), stations: self.stations.clone(), root: self.root, wind_m_s: self.wind_m_s }
    }

    fn clone_from(&mut self, source: &Self) {
        self.joints.clone_from(&source.joints);
        self.stations.clone_from(&source.stations);
        self.root = source.root;
        self.wind_m_s = source.wind_m_s;
    }
}

/// Parameters of one revolute joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointParameters {
    /// Fold angle at the start in rad; fixed.
    pub start_angle_rad: f64,
    /// Motor's stiffness `k_m` in N·m/rad; tunable, as all that follow.
    pub stiffness_n_m_rad: f64,
    /// Motor's damping `c_m` in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Motor's constant torque `T` in N·m.
    pub constant_torque_n_m: f64,
    /// Largest magnitude of the motor's torque in N·m.
    pub torque_limit_n_m: f64,
    /// Largest slew of the neutral angle in rad/s.
    pub rate_limit_rad_s: f64,
    /// Stiffness of the joint's own spring in N·m/rad; 0 without one.
    pub spring_stiffness_n_m_rad: f64,
    /// Damping beside the joint's own spring in N·m·s/rad.
    pub spring_damping_n_m_s_rad: f64,
    /// Angle at which the joint's own spring is slack in rad.
    pub rest_angle_rad: f64,
    /// Stiffness of the closed latch in N·m/rad; 0 without a latch.
    pub latch_stiffness_n_m_rad: f64,
}

/// Parameters of one universal, ball or free joint; tunable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpatialParameters {
    /// Spring stiffness in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
}

/// Parameters of one body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyParameters {
    /// Multiplies the beam's inertia (not attached masses); fixed.
    pub mass_factor: f64,
    /// Multiplies the section stiffness; fixed.
    pub stiffness_factor: f64,
    /// Mass-proportional damping `α` in 1/s; tunable.
    pub mass_damping_1_s: f64,
    /// Stiffness-proportional damping `β` in s; tunable.
    pub stiffness_damping_s: f64,
}

/// Smallest and largest factor on inertia or stiffness: the equations must stay solvable in double precision.
pub const FACTOR_RANGE: (f64, f64) = (1e-6, 1e6);

/// All parameters. Fixed ones act at [`crate::plant::Plant::initialize`], tunable ones from the next step on.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Per revolute joint.
    pub joints: Vec<JointParameters>,
    /// Per universal, ball or free joint.
    pub spatial: Vec<SpatialParameters>,
    /// Per body.
    pub bodies: Vec<BodyParameters>,
    /// Density of the air in kg/m³; tunable; ignored by machines without air.
    pub air_density_kg_m3: f64,
    /// Solver tolerance; fixed.
    pub tolerance: f64,
    /// Largest internal step in s; fixed.
    pub max_step_s: f64,
    /// Smallest internal step in s; fixed.
    pub min_step_s: f64,
}

/// By hand, because a derived `clone_from` allocates.
impl Clone for Parameters {
    fn clone(&self) -> Self {
        Self {
            joints: self.joints.clone(),
            spatial: self.spatial.clone(),
            bodies: self.bodies.clone(),
            air_density_kg_m3: self.air_density_kg_m3,
            tolerance: self.tolerance,
            max_step_s: self.max_step_s,
            min_step_s: self.min_step_s,
        }
    }

    fn clone_from(&mut self, source: &Self) {
        self.joints.clone_from(&source.joints);
        self.spatial.clone_from(&source.spatial);
        self.bodies.clone_from(&source.bodies);
        self.air_density_kg_m3 = source.air_density_kg_m3;
        self.tolerance = source.tolerance;
        self.max_step_s = source.max_step_s;
        self.min_step_s = source.min_step_s;
    }
}

/// Outputs of one revolute joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointOutputs {
    /// Fold angle in rad.
    pub angle_rad: f64,
    /// Fold rate in rad/s.
    pub rate_rad_s: f64,
    /// Torque of motor, spring and external torque together on the outer body about `+θ`, in N·m.
    pub torque_applied_n_m: f64,
    /// Torque of the motor, limited, in N·m.
    pub motor_torque_n_m: f64,
    /// Torque of the joint's own spring and damper in N·m.
    pub spring_torque_n_m: f64,
    /// External torque `τ_ext` that acts, in N·m.
    pub external_torque_n_m: f64,
    /// Torque of what holds the joint (stopper, lock, prescribed motion) in N·m; 0 where it turns freely, and where a
    /// closed rigid latch bears it all.
    pub holding_torque_n_m: f64,
    /// Latch torque on the outer body in N·m: of the spring, or the reaction of a rigid latch.
    pub latch_torque_n_m: f64,
    /// Impulse of a rigid latch's last closing on the outer body in N·m·s; 0 before the first.
    pub latch_impulse_n_m_s: f64,
    /// Latch closed.
    pub latched: bool,
    /// Time of the last closing in s; −1 before the first.
    pub latch_time_s: f64,
    /// Number of closings.
    pub latch_count: i32,
}

/// Outputs of one universal, ball or free joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpatialOutputs {
    /// Attitude, parent ← body; sign continuous in time.
    pub rotation: UnitQuaternion<f64>,
    /// Angular velocity relative to the parent, parent's frame, rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
}

/// Outputs of one closed loop, root frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoopOutputs {
    /// Second point less first point in m, eq. (C1).
    pub gap_m: Vector3<f64>,
    /// Force on the first point in N, eq. (C2); its opposite acts on the second.
    pub force_n: Vector3<f64>,
}

/// Position, velocities and attitude of a point of the wing, root frame, relative to the root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointOutputs {
    /// Position in m.
    pub position_m: Vector3<f64>,
    /// Velocity in m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity in rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
    /// Inertial acceleration (without gravity) in m/s².
    pub acceleration_m_s2: Vector3<f64>,
    /// Inertial angular acceleration in rad/s².
    pub angular_acceleration_rad_s2: Vector3<f64>,
    /// Attitude, root ← section; sign continuous in time.
    pub rotation: UnitQuaternion<f64>,
}

/// Stopper and latch of one revolute joint: what its events change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointStatus {
    /// The stopper has let go.
    pub released: bool,
    /// Latch closed.
    pub latched: bool,
    /// Time of the last closing in s; −1 before the first.
    pub latch_time_s: f64,
    /// Number of closings.
    pub latch_count: i32,
}

/// Energies in J. `total − work + dissipated` is constant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyOutputs {
    /// Kinetic energy relative to the root frame.
    pub kinetic: f64,
    /// Strain energy of beams, springs of fold joints, closed latches and closed loops.
    pub elastic: f64,
    /// Potential of `gravity − root acceleration`, zero at the root's origin.
    pub gravity: f64,
    /// Potential of the motors' stiffness and constant torques within their limits, and of springs of universal and ball joints.
    pub drive: f64,
    /// Work of inputs: loads, torques, commands, root motion, changed parameters.
    pub work: f64,
    /// Energy dissipated by damping, opening latches and stopping joints.
    pub dissipated: f64,
    /// `kinetic + elastic + gravity + drive`.
    pub total: f64,
}

/// Everything the interface reports, at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Time in s.
    pub time_s: f64,
    /// Per revolute joint.
    pub joints: Vec<JointOutputs>,
    /// Per universal, ball or free joint, in the order of [`crate::plant::Plant::spatial_joints`].
    pub spatial: Vec<SpatialOutputs>,
    /// Per body: force and moment of the joint on the body's inner end, root frame, at that end.
    pub joint_reactions: Vec<Wrench>,
    /// Axial strain per gauge.
    pub gauges: Vec<f64>,
    /// Per place of [`crate::machine::Machine::section_loads`]: force and moment of the part outboard of the section on the
    /// part inboard of it, section frame.
    pub section_loads: Vec<Wrench>,
    /// Per closed loop, in the order of [`crate::machine::Machine::closures`].
    pub loops: Vec<LoopOutputs>,
    /// Force and moment of the wing on the aircraft at the origin, root frame.
    pub root: Wrench,
    /// Per free end, in the order of [`crate::plant::Plant::tip_bodies`].
    pub tips: Vec<PointOutputs>,
    /// Per station, in the order of [`Inputs::stations`].
    pub stations: Vec<PointOutputs>,
    /// Energies.
    pub energy: EnergyOutputs,
    /// Loads of the air; zero and empty for machines without air.
    pub air: AirOutputs,
}

impl Outputs {
    /// Whether all of them are finite; what follows from others by a rotation is taken with those.
    pub(super) fn are_finite(&self) -> bool {
        let wrench = |wrench: &Wrench| wrench.force_n.sum() + wrench.moment_n_m.sum();
        let EnergyOutputs { total, work, dissipated, .. } = self.energy;
        let joint = |joint: &JointOutputs| {
            joint.rate_rad_s + joint.torque_applied_n_m + joint.latch_torque_n_m + joint.holding_torque_n_m
        };
        let point = |point: &PointOutputs| {
            point.position_m.sum()
                + point.velocity_m_s.sum()
                + point.angular_velocity_rad_s.sum()
                + point.acceleration_m_s2.sum()
                + point.angular_acceleration_rad_s2.sum()
                + point.rotation.coords.sum()
        };
        let sum = total
            + work
            + dissipated
            + wrench(&self.root)
            + wrench(&self.air.total)
            + self.joints.iter().map(joint).sum::<f64>()
            + self
                .spatial
                .iter()
                .map(|joint| joint.angular_velocity_rad_s.sum() + joint.rotation.coords.sum())
                .sum::<f64>()
            + self.joint_reactions.iter().map(wrench).sum::<f64>()
            + self.gauges.iter().sum::<f64>()
            + self.section_loads.iter().map(wrench).sum::<f64>()
            + self.loops.iter().map(|closed| closed.force_n.sum()).sum::<f64>()
            + self.tips.iter().chain(&self.stations).map(point).sum::<f64>()
            + self.air.stations.iter().map(wrench).sum::<f64>()
            + self.air.circulation_m2_s.iter().sum::<f64>();
        sum.is_finite()
    }
}

/// Loads of the air on the wing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AirOutputs {
    /// Force and moment at the origin, root frame.
    pub total: Wrench,
    /// Per load station: force and moment of the air on the part of the body that is nearest to it, at the station,
    /// root frame.
    pub stations: Vec<Wrench>,
    /// Per strip, surfaces in the order of their bodies: circulation in m²/s.
    pub circulation_m2_s: Vec<f64>,
}

/// Counters of the time integration since initialisation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Steps rejected by the error estimate.
    pub rejections: u64,
    /// Steps given up by the Newton iteration.
    pub failures: u64,
    /// Newton iterations (residuals with a solve) of the motion that was taken.
    pub iterations: u64,
    /// Newton iterations of the trial marches in which air and structure agree, and which are taken back.
    pub trial_iterations: u64,
    /// Factorisations.
    pub factorizations: u64,
    /// Events: releases, holds, closings, openings.
    pub events: u64,
    /// Solutions of the air.
    pub air_solutions: u64,
    /// Stages that real-time mode accepted without convergence.
    pub unconverged: u64,
    /// Most Newton iterations of one stage.
    pub largest_iterations: u64,
    /// Longest row that a step of the air has given the wake, in panel chords; 0 without a lattice.
    pub longest_row_panels: f64,
}

/// Why a plant cannot go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// The time integration gave up.
    #[error(
        "no convergence at t = {time_s} s with internal steps down to {step_s:.1e} s, worst at {place}: {cause}; {advice}"
    )]
    NoConvergence {
        /// Last good time in s.
        time_s: f64,
        /// Internal step given up, below the smallest allowed, in s.
        step_s: f64,
        /// Element or joint that moves most in what is left.
        place: String,
        /// What failed.
        cause: String,
        /// What to try.
        advice: &'static str,
    },
    /// Numbers that grew too large.
    #[error("outputs at t = {time_s} s are not finite; {cause}; look at the inputs and parameters that act until then")]
    NotFinite {
        /// End of the step in s.
        time_s: f64,
        /// The largest input.
        cause: String,
    },
    /// More work than one communication step may cost.
    #[error(
        "reached only t = {time_s} s after {most} iterations, with a last internal step of {step_s:.1e} s; {cause}; take shorter communication steps, or allow a larger solver.tolerance"
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
        "the accelerations at t = {time_s} s carry the wing by {lengths:.1e} times its length within an aerodynamic step of {step_s} s; {cause}; reduce it, or take a smaller aerodynamics.step_s"
    )]
    Leap {
        /// Time in s.
        time_s: f64,
        /// Way in an aerodynamic step over the machine's length.
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
    #[error("solver.min_step, {min_step_s:e} s, is longer than solver.max_step, {max_step_s:e} s; set one of them")]
    Steps {
        /// Smallest internal step in s.
        min_step_s: f64,
        /// Largest internal step in s.
        max_step_s: f64,
    },
    /// The initial accelerations could not be found.
    #[error("no accelerations at t = {time_s} s: {cause}; look at the inputs and parameters that act from then on")]
    Initialization {
        /// Start time in s.
        time_s: f64,
        /// What failed.
        cause: String,
    },
    /// The air has no loads that agree with the motion.
    #[error(
        "no loads of the air at t = {time_s} s: {cause}; look at wind and density, or try another aerodynamics.step_s"
    )]
    Air {
        /// Time in s.
        time_s: f64,
        /// What failed.
        cause: String,
    },
    /// Two lattices lie on each other.
    #[error(
        "no loads of the air at t = {time_s} s: the lattices of {} and {} lie on each other, {gap_m:.1e} m or {gap_panels:.2} \
         panels apart at the widest place; at least {} panels are needed: open their joint farther, use more strips, or strip \
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
        "no loads of the air at t = {time_s} s: the lattices of {} and {} pass through each other by {depth_m:.1e} m, and nothing \
         holds them apart: more chord_panels resolve a narrower gap; else open their joint farther",
        .bodies[0], .bodies[1]
    )]
    CrossedSheets {
        /// Time in s.
        time_s: f64,
        /// Bodies that carry them.
        bodies: [String; 2],
        /// How far in m.
        depth_m: f64,
    },
    /// No state of rest was found.
    #[error(
        "no equilibrium at t = {time_s} s beyond {reached:.4} of the load, last tried {tried:.4}: {cause}; reduce the load, or let the experiment start unstrained"
    )]
    Equilibrium {
        /// Time in s.
        time_s: f64,
        /// Largest load factor with an equilibrium.
        reached: f64,
        /// Load factor that failed.
        tried: f64,
        /// Why.
        cause: String,
    },
    /// No linear model of the present state.
    #[error("no linearisation at t = {time_s} s: {cause}")]
    Linearization {
        /// Time in s.
        time_s: f64,
        /// Why.
        cause: String,
    },
    /// A snapshot of another model.
    #[error("the state does not fit this model: {0}; save one with this instance")]
    Snapshot(String),
}
