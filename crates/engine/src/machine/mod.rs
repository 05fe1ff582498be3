//! The machine: bodies, joints, loops, gauges, aerodynamics, solver and simulation settings, in SI units and radians.
//!
//! Complete description of the model. A [`Machine`] is built by [`Machine::builder`], in code or from a model file; [`Machine::validate`]
//! reports the errors of a machine whose fields were set directly.

mod air_parts;
mod body_kind;
pub mod builder;
mod closure;
pub(crate) mod edges;
pub mod failure;
pub mod fault;
mod joint_kind;
mod no_slip;
mod one_freedom;
pub mod pose;
pub mod travel;
pub mod units;
pub mod validate;

pub use closure::{Closure, LoopEnd};
pub use failure::{Effect, Failure};
pub use fault::{Fault, Refused};
pub use no_slip::NoSlip;
pub use one_freedom::{OneFreedom, Revolute};

use crate::aero::flap::Flap;
use crate::aero::flow::Gust;
pub use crate::aero::lattice::{LoadRule, WakeModel};
use crate::aero::surface::{ChordLine, Profile};
pub use crate::aero::{AirOptions, AirPart, EndRule, PitchRate};
pub use crate::beam::axis::{Axis, AxisEnds};
pub use crate::beam::element::ElementKind;
pub use crate::beam::law::{NaturalStrain, SectionLaw, SectionStation};
pub use crate::beam::modal::{MAXIMUM_MODES, ModalLaw, Shape};
use crate::beam::recovery::{axial_row, gauge_row};
pub use crate::force::dc_motor::DcMotor;
pub use crate::force::end_stops::EndStops;
pub use crate::force::generator::{Beyond, GeneratorLaw};
pub use crate::force::latch::LatchKind;
pub use crate::force::motor::UNLIMITED;
pub use crate::force::prescribed::Motion;
pub use crate::force::spring::Spring;
use crate::load::{LoadFrame, Wrench};
use crate::math::strain::Strain;
pub use crate::multibody::no_slip::Runner;
use nalgebra::{Matrix3, Vector3};
pub use travel::{LinearMotor, LinearSpring, Travel};

/// A complete machine, validated. Bodies are in topological order: a parent comes before its children.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Model name, an identifier; also the name of the FMU.
    pub name: String,
    /// One-line description.
    pub description: String,
    /// Bodies, each with the joint that attaches it to its parent.
    pub bodies: Vec<Body>,
    /// Joints that close loops, by the penalty method.
    pub closures: Vec<Closure>,
    /// Skates and wheels.
    pub no_slips: Vec<NoSlip>,
    /// Strain gauges.
    pub gauges: Vec<Gauge>,
    /// Sections whose internal loads are outputs.
    pub internal_loads: Vec<InternalLoad>,
    /// Aerodynamics, if it is computed here.
    pub air: Option<Air>,
    /// Possible failures.
    pub failures: Vec<Failure>,
    /// Gravity in the root frame, m/s².
    pub gravity_m_s2: Vector3<f64>,
    /// Time integration.
    pub solver: Solver,
    /// Simulation settings.
    pub experiment: Experiment,
}

/// A beam or a rigid body, and the joint at its inner end.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Identifier.
    pub name: String,
    /// Arc length of the undeformed axis in m; 0 for a rigid body.
    pub length_m: f64,
    /// Cross-section along the body; unused for a rigid body.
    pub section: SectionLaw,
    /// Outline of the aerofoil whose skin is the section, for pictures only, see `BodyBuilder::aerofoil`; empty if there is none.
    pub aerofoil: Vec<[f64; 2]>,
    /// Kind of strain element.
    pub element: ElementKind,
    /// Number of elements along the body (a linear element is one pair of halves); 0 makes the body rigid.
    pub elements: usize,
    /// Natural strains `(εx, κx, κy, κz)` along the body: initial stretch (–), twist and curvatures (1/m).
    pub natural_strain: NaturalStrain,
    /// Ends of an axis given by points, from which the natural strain was derived; the mount includes its attitude at the inner end.
    pub axis: Option<AxisEnds>,
    /// Mass-proportional damping `α` in 1/s.
    pub mass_damping_1_s: f64,
    /// Whether the mass-proportional damping also acts on the attached masses.
    pub damp_attached_masses: bool,
    /// Stiffness-proportional damping `β` in s.
    pub stiffness_damping_s: f64,
    /// Factors of the stiffness-proportional damping in the strains `(εx, κx, κy, κz)`, ≥ 0.
    pub stiffness_damping_factors: Strain,
    /// Factors of the stiffness-proportional damping in both shears of a body with shear.
    pub shear_damping_factors: [f64; 2],
    /// Damping ratios ≥ 0 of the lowest modes of a beam clamped at its inner end with its attached masses; not of further modes.
    pub modal_damping_ratios: Vec<f64>,
    /// Distances of the load stations from the body's inner end in m, ascending.
    pub station_positions_m: Vec<f64>,
    /// Frame of the station loads.
    pub load_frame: LoadFrame,
    /// Start values of the loads, per station, in `load_frame`; stations beyond the list have zero load.
    pub station_loads: Vec<Wrench>,
    /// Point masses and rigid bodies on this body.
    pub masses: Vec<AttachedMass>,
    /// Joint to the parent.
    pub joint: Joint,
}

/// A point mass or rigid body fixed to a section.
#[derive(Debug, Clone, PartialEq)]
pub struct AttachedMass {
    /// Identifier.
    pub name: String,
    /// Distance of the section from the body's inner end in m.
    pub position_m: f64,
    /// Mass in kg.
    pub mass_kg: f64,
    /// Position of the centre of gravity relative to the axis, section frame, m.
    pub offset_m: Vector3<f64>,
    /// Inertia about the centre of gravity, section frame, kg·m².
    pub inertia_kg_m2: Matrix3<f64>,
    /// Whether the principal moments need only be positive: an effective inertia that no rigid body could have, e.g. about one axis only.
    pub allow_nonphysical_inertia: bool,
}

/// Joint between a body's inner end and its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Identifier.
    pub name: String,
    /// Parent of the joint.
    pub parent: Parent,
    /// Offset in m from the position on the parent body to the body's first frame, in the parent's section frame there; zero on the root.
    pub offset_m: Vector3<f64>,
    /// Attitude of the body's first frame in the parent's frame, at angle zero of a revolute joint: parent ← body.
    pub mount: Matrix3<f64>,
    /// Type of the joint with its degrees of freedom.
    pub kind: JointKind,
}

/// Parent of a joint.
#[derive(Debug, Clone, PartialEq)]
pub enum Parent {
    /// The root frame, at a position in m.
    Root {
        /// Position of the body's inner end in the root frame, m.
        position_m: Vector3<f64>,
    },
    /// A section of another body.
    Body {
        /// Index into [`Machine::bodies`].
        index: usize,
        /// Distance of the section from that body's inner end in m.
        position_m: f64,
    },
}

/// Type of a joint with its degrees of freedom.
#[derive(Debug, Clone, PartialEq)]
pub enum JointKind {
    /// No degree of freedom.
    Clamped,
    /// Rotation about one axis: `R_body = R_parent · Rot(axis, θ) · mount`.
    Revolute(Box<OneFreedom>),
    /// Translation along one axis: `r_body = r_parent + s · axis`, `R_body = R_parent · mount`.
    Prismatic(Box<OneFreedom>),
    /// Motion along the axis of a beam, to which the section frame at arc length `s` belongs: `r_body = r(s)`, `R_body = R(s) · mount`. The
    /// coordinate is `s`, measured on the unstrained axis from the beam's inner end; the axis is not used.
    Sliding(Box<OneFreedom>),
    /// Several degrees of freedom, described by the paper's redundant parameters; `mount` is the attitude at the start.
    Spatial(Box<Spatial>),
}

/// A universal, ball or free joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Spatial {
    /// Degrees of freedom.
    pub freedom: SpatialFreedom,
    /// Stiffness in N·m/rad of the spring towards the initial attitude: per axis of a universal joint, about the rotation vector of a ball
    /// joint.
    pub stiffness_n_m_rad: f64,
    /// Damping in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Initial angular velocity relative to the parent, parent's frame, rad/s.
    pub start_angular_velocity_rad_s: Vector3<f64>,
    /// Initial velocity of the body's inner end, root frame, m/s; free joints only.
    pub start_velocity_m_s: Vector3<f64>,
}

/// Degrees of freedom of a joint that has several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpatialFreedom {
    /// Rotation about two axes, one fixed to each side.
    Universal {
        /// Unit axis in the parent's section frame.
        parent_axis: Vector3<f64>,
        /// Unit axis in the body's section frame.
        body_axis: Vector3<f64>,
    },
    /// All rotations are free.
    Ball,
    /// All rotations and displacements; only on the root.
    Free,
}

/// Type of motion of a fold angle or a position.
#[derive(Debug, Clone, PartialEq)]
pub enum JointMotion {
    /// Free motion under the joint's torques or forces.
    Free,
    /// Locked at its initial position.
    Locked,
    /// Motion prescribed as a function of absolute time.
    Prescribed(Motion),
}

/// Motor torque on the outer body about `+θ`: `−(k_m (θ − θ_cmd) + c_m θ̇ + T)`, limited, NOTATION eq. (A1).
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    /// Spring stiffness `k` in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping `c` in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Constant torque `T` in N·m, in the direction of −θ.
    pub constant_torque_n_m: f64,
    /// Largest magnitude of the motor's torque in N·m; [`UNLIMITED`] without a limit.
    pub torque_limit_n_m: f64,
    /// Largest slew rate of the neutral angle in rad/s; [`UNLIMITED`] without a limit.
    pub rate_limit_rad_s: f64,
    /// Moment of inertia that rotates with the joint angle only, in kg·m².
    pub inertia_kg_m2: f64,
    /// Gear ratio: rotation of the motor's rotor divided by that of the joint, negative for opposite directions; the rotor then also
    /// rotates with the body that carries the joint about its axis. `None` neglects this, which is accurate for a large ratio. For revolute
    /// joints only.
    pub gear_ratio: Option<f64>,
    /// Start value of the command input in rad.
    pub command_rad: f64,
}

impl Default for Motor {
    /// No motor: no torque, no limits, no inertia.
    fn default() -> Self {
        Self {
            stiffness_n_m_rad: 0.0,
            damping_n_m_s_rad: 0.0,
            constant_torque_n_m: 0.0,
            torque_limit_n_m: UNLIMITED,
            rate_limit_rad_s: UNLIMITED,
            inertia_kg_m2: 0.0,
            gear_ratio: None,
            command_rad: 0.0,
        }
    }
}

/// Default half-width of a latch's capture range, rad: it captures a joint at rest or in slow motion at the latch angle; a passing joint is
/// captured too early only by the time in which it moves through this small angle.
pub const DEFAULT_CAPTURE_RAD: f64 = 1e-6;

/// Latch of a fold joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Latch {
    /// Effect when closed.
    pub kind: LatchKind,
    /// Angle in rad at which it closes.
    pub angle_rad: f64,
    /// Stiffness in N·m/rad added when closed; 0 for a rigid latch.
    pub stiffness_n_m_rad: f64,
    /// Half-width of the capture range: an enabled latch closes as soon as the angle is within it, rad.
    pub capture_rad: f64,
    /// Whether the latch is closed at the start, for any position of the joint; elastic latches only.
    pub initially_closed: bool,
    /// Start value of the enable input.
    pub enable: bool,
}

/// A strain gauge: strain of a fibre at a point of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct Gauge {
    /// Identifier.
    pub name: String,
    /// Index into [`Machine::bodies`].
    pub body: usize,
    /// Distance from the body's inner end in m.
    pub position_m: f64,
    /// Chordwise coordinate of the point in m.
    pub y_m: f64,
    /// Thickness coordinate of the point in m.
    pub z_m: f64,
    /// Unit vector along the fibre, section frame.
    pub direction: Vector3<f64>,
}

impl Gauge {
    /// A gauge along the beam axis at the point `(y_m, z_m)` of a section.
    pub fn axial(name: impl Into<String>, body: usize, position_m: f64, [y_m, z_m]: [f64; 2]) -> Self {
        Self { name: name.into(), body, position_m, y_m, z_m, direction: Vector3::x() }
    }

    /// Weights of the strain measures `(γ₁, k₁, k₂, k₃)` of its section, NOTATION eqs. (R1), (R6). `None` for a fibre that is not along the
    /// axis if the section is not solid with a known Poisson's ratio, or deforms in shear.
    pub fn row(&self, section: &SectionLaw) -> Option<Strain> {
        if self.direction.y == 0.0 && self.direction.z == 0.0 {
            return Some(axial_row(self.y_m, self.z_m));
        }
        let solid = section.solid_at(self.position_m).filter(|solid| solid.material.poisson_ratio().is_some())?;
        if solid.shear_factor.is_some() {
            return None; // shear strain due to transverse forces is not recovered
        }
        Some(gauge_row(&solid, self.y_m, self.z_m, &self.direction))
    }
}

/// A section of a beam whose internal loads are outputs: force and moment of the part outboard of it on the part inboard of it, in the
/// section frame.
#[derive(Debug, Clone, PartialEq)]
pub struct InternalLoad {
    /// Identifier.
    pub name: String,
    /// Index into [`Machine::bodies`].
    pub body: usize,
    /// Distance from the body's inner end in m.
    pub position_m: f64,
    /// Side of the section.
    pub side: SectionSide,
}

/// Side of an internal-load section: parts at the same position (loads of a station, masses, children, loops) are on the other side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SectionSide {
    /// Towards the body's inner end: the load includes parts attached there.
    #[default]
    Inboard,
    /// Towards the body's outer end: the load excludes parts attached there.
    Outboard,
}

/// Aerodynamics of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Air {
    /// Aerodynamic models, each of some of the surfaces; the rest of the settings is common to all.
    pub parts: Vec<AirPart>,
    /// Air density in kg/m³.
    pub density_kg_m3: f64,
    /// Wind velocity relative to the root's origin, root frame, m/s: start value of the input.
    pub wind_m_s: Vector3<f64>,
    /// Aerodynamic step in s.
    pub step_s: f64,
    /// Coupling of aerodynamics and structure.
    pub coupling: Coupling,
    /// Whether the run starts with an established flow.
    pub established: bool,
    /// Whether the circulation of every strip is an output.
    pub reports_circulation: bool,
    /// Lifting surfaces, in the order of their bodies.
    pub surfaces: Vec<LiftingSurface>,
    /// Gusts.
    pub gusts: Vec<Gust>,
    /// Control surfaces, in the order in which they were added.
    pub flaps: Vec<Flap>,
}

impl Air {
    /// Whether loads depend on polars, which are linear between their rows.
    pub fn has_polars(&self) -> bool {
        let of_part = |part: &AirPart| match part.options {
            AirOptions::Rotor(_) => true,
            AirOptions::Strips(_) | AirOptions::Lattice(_) | AirOptions::SlenderBody(_) => false,
        };
        self.parts.iter().any(of_part) || self.surfaces.iter().any(|surface| surface.profile.polar.is_some())
    }
}

/// Coupling of aerodynamics and structure at the end of an aerodynamic step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coupling {
    /// A prediction and one correction.
    Staggered,
    /// Iteration until convergence.
    Iterated {
        /// Change of the loads, relative to the largest so far, at which the iteration ends.
        tolerance: f64,
        /// Maximum number of iterations per aerodynamic step.
        most_iterations: usize,
    },
}

/// Lifting surface of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct LiftingSurface {
    /// Index into [`Machine::bodies`].
    pub body: usize,
    /// Body whose surface adjoins this one's inner edge: the other half of a wing.
    pub other_half: Option<usize>,
    /// Body whose inner edge is attached to the same point, if it is not joined, and their distance in chords, up to a half.
    pub slit: Option<(usize, f64)>,
    /// Whether its inner edge lies at the mirror plane and adjoins that of its image.
    pub at_mirror: bool,
    /// Edges of its strips: distances from the body's inner end in m, ascending.
    pub positions_m: Vec<f64>,
    /// Chord at each edge.
    pub chords: Vec<ChordLine>,
    /// Number of panels along the chord.
    pub chord_panels: usize,
    /// Profile, for strip theory.
    pub profile: Profile,
}

/// Time integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Generalised-α, second order.
    GeneralizedAlpha,
    /// TR-BDF2, second order.
    TrBdf2,
    /// Two-stage SDIRK, second order.
    Sdirk2,
    /// `ESDIRK3(2)4L[2]SA`, third order.
    Esdirk3,
    /// `ESDIRK4(3)6L[2]SA`, fourth order.
    Esdirk4,
    /// Classical explicit Runge–Kutta, fourth order; with fixed steps only.
    Rk4,
}

/// Settings of the time integration.
#[derive(Debug, Clone, PartialEq)]
pub struct Solver {
    /// Method.
    pub method: Method,
    /// Tolerance of the kinematic error norm per step (displacement divided by wing length, rotation in rad).
    pub tolerance: f64,
    /// Largest internal step in s.
    pub max_step_s: f64,
    /// Smallest internal step in s, below which non-convergence is an error.
    pub min_step_s: f64,
    /// Fixed internal step in s; `None` for variable steps.
    pub fixed_step_s: Option<f64>,
    /// Spectral radius at infinity of generalised-α.
    pub rho_infinity: f64,
    /// Maximum number of Newton iterations of a stage in real-time mode, in which no step is repeated; `None` otherwise.
    pub most_iterations: Option<usize>,
}

impl Default for Solver {
    /// Defaults of a model file without a table `[solver]`: ESDIRK4 at 1e-4 with steps of up to 5 ms.
    fn default() -> Self {
        Self {
            method: Method::Esdirk4,
            tolerance: 1e-4,
            max_step_s: 5e-3,
            min_step_s: 1e-9,
            fixed_step_s: None,
            rho_infinity: 0.8,
            most_iterations: None,
        }
    }
}

/// Simulation settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Start time in s.
    pub start_time_s: f64,
    /// Stop time in s.
    pub stop_time_s: f64,
    /// Communication step in s.
    pub step_s: f64,
    /// State at the start.
    pub start: StartState,
}

impl Default for Experiment {
    /// Defaults of a model file without a table `[simulation]`: from 0 to 0.4 s in steps of 0.5 ms, from the unstrained state.
    fn default() -> Self {
        Self { start_time_s: 0.0, stop_time_s: 0.4, step_s: 5e-4, start: StartState::Unstrained }
    }
}

/// State of the machine at the start of the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartState {
    /// Without strains, so that loads are applied suddenly at the start.
    Unstrained,
    /// Static equilibrium under the loads at the start, with locks on the joints that are not latched.
    Equilibrium,
}
