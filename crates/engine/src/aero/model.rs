//! Common interface of the aerodynamic models.

use crate::aero::AirLoads;
use crate::aero::established::Established;
use crate::aero::flap::{Deflection, Flap, HingeMoment};
use crate::aero::flow::{AirPath, Flow};
use crate::aero::lattice::{LatticeOptions, VortexLattice};
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::NoCirculation;
use crate::aero::rotor::bem::{Rotor, RotorOptions, RotorState};
use crate::aero::rotor::loads::RotorLoads;
use crate::aero::slender::{SlenderBody, SlenderBodyOptions, SlenderBodyState};
use crate::aero::strip::{StripOptions, StripState, Strips};
use crate::aero::surface::{Edge, Surface};
use crate::load::SectionMotion;
use serde::{Deserialize, Serialize};

/// Type of the aerodynamic model, with its settings.
#[derive(Debug, Clone, PartialEq)]
pub enum AirOptions {
    /// Unsteady vortex lattice.
    Lattice(LatticeOptions),
    /// Strip theory.
    Strips(StripOptions),
    /// Blade-element momentum theory.
    Rotor(Box<RotorOptions>),
    /// A slender body.
    SlenderBody(Box<SlenderBodyOptions>),
}

impl AirOptions {
    /// Whether linearised models include these aerodynamics with their lags: strips, rotors and slender bodies. The loads of lattices are
    /// held constant.
    pub fn is_linearised(&self) -> bool {
        match self {
            Self::Lattice(_) => false,
            Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_) => true,
        }
    }

    /// Whether loads can be evaluated at an instant for an external integrator, with the lag states that they have: all but lattices.
    pub fn is_continuous(&self) -> bool {
        match self {
            Self::Lattice(_) => false,
            Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_) => true,
        }
    }

    /// The settings of a rotor, if this is one.
    pub fn rotor(&self) -> Option<&RotorOptions> {
        match self {
            Self::Rotor(options) => Some(options),
            Self::Lattice(_) | Self::Strips(_) | Self::SlenderBody(_) => None,
        }
    }

    /// The settings of a slender body, if this is one.
    pub fn slender_body(&self) -> Option<&SlenderBodyOptions> {
        match self {
            Self::SlenderBody(options) => Some(options),
            Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) => None,
        }
    }

    /// Whether this is a rotor.
    pub fn is_rotor(&self) -> bool {
        matches!(self, Self::Rotor(_))
    }
}

/// An aerodynamic model with its scratch.
pub enum AirModel {
    /// Unsteady vortex lattice.
    Lattice(Box<VortexLattice>),
    /// Strip theory.
    Strips(Box<Strips>),
    /// Blade-element momentum theory.
    Rotor(Box<Rotor>),
    /// A slender body.
    SlenderBody(Box<SlenderBody>),
}

/// State of an aerodynamic model from one aerodynamic step to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum AirState {
    /// State of the vortex lattice.
    Lattice(Box<LatticeState>),
    /// State of strip theory.
    Strips(Box<StripState>),
    /// State of a rotor.
    Rotor(Box<RotorState>),
    /// State of a slender body.
    SlenderBody(Box<SlenderBodyState>),
}

impl AirModel {
    /// Makes an aerodynamic model of these surfaces; a slender body has none.
    pub fn new(surfaces: Vec<Surface>, options: &AirOptions) -> Self {
        match options {
            AirOptions::Lattice(options) => Self::Lattice(Box::new(VortexLattice::new(surfaces, options.clone()))),
            AirOptions::Strips(options) => Self::Strips(Box::new(Strips::new(surfaces, *options))),
            AirOptions::Rotor(options) => Self::Rotor(Box::new(Rotor::new(&surfaces, options))),
            AirOptions::SlenderBody(options) => Self::SlenderBody(Box::new(SlenderBody::new(options))),
        }
    }

    /// Joins two surface edges where their bodies are connected (lattice and lifting line).
    pub fn join(&mut self, edges: [Edge; 2]) {
        match self {
            Self::Lattice(lattice) => lattice.join(edges),
            Self::Strips(strips) => strips.join(edges),
            Self::Rotor(_) | Self::SlenderBody(_) => {}
        }
    }

    /// Joins an edge that lies at the mirror plane with its image (lattice and lifting line).
    pub fn join_image(&mut self, edge: Edge) {
        match self {
            Self::Lattice(lattice) => lattice.join_image(edge),
            Self::Strips(strips) => strips.join_image(edge),
            Self::Rotor(_) | Self::SlenderBody(_) => {}
        }
    }

    /// Adds control surfaces to the surfaces, with zero deflection and rate; to be called before any state is made. Not for rotor blades.
    pub fn add_flaps(&mut self, flaps: &[Flap]) {
        match self {
            Self::Lattice(lattice) => lattice.add_flaps(flaps),
            Self::Strips(strips) => strips.add_flaps(flaps),
            Self::Rotor(_) | Self::SlenderBody(_) => {}
        }
    }

    /// Sets the deflections of the control surfaces for the instant of the next [`AirModel::start`] or [`AirModel::solve`].
    pub fn deflect(&mut self, deflections: &[Deflection]) {
        match self {
            Self::Lattice(lattice) => lattice.deflect(deflections),
            Self::Strips(strips) => strips.deflect(deflections),
            Self::Rotor(_) | Self::SlenderBody(_) => {}
        }
    }

    /// Returns an empty state of the right size.
    pub fn blank_state(&self) -> AirState {
        match self {
            Self::Lattice(lattice) => AirState::Lattice(Box::new(lattice.blank_state())),
            Self::Strips(strips) => AirState::Strips(Box::new(strips.blank_state())),
            Self::Rotor(rotor) => AirState::Rotor(Box::new(rotor.blank_state())),
            Self::SlenderBody(body) => AirState::SlenderBody(Box::new(body.blank_state())),
        }
    }

    /// Computes the initial state and loads: of an established flow (`steady_initial_flow`), or of an impulsively started one.
    ///
    /// # Errors
    /// If panels of the lattice coincide, two sheets are closed or overlap, a surface is below the ground, or a model with a speed of sound
    /// reaches Mach 1.
    pub fn start(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        established: Option<Established>,
        state: &mut AirState,
        loads: &mut AirLoads,
    ) -> Result<(), NoCirculation> {
        match (self, state) {
            (Self::Lattice(lattice), AirState::Lattice(state)) => {
                lattice.start(motions, flow, established, state, loads)
            }
            (Self::Strips(strips), AirState::Strips(state)) => {
                strips.start(motions, flow, established.is_some(), state, loads);
                strips.validity()
            }
            (Self::Rotor(rotor), AirState::Rotor(state)) => {
                rotor.start(motions, flow, established.is_some(), state, loads);
                Ok(())
            }
            (Self::SlenderBody(body), AirState::SlenderBody(state)) => {
                body.start(motions, flow, state, loads);
                Ok(())
            }
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), ..) => {
                unreachable!("a state belongs to its model")
            }
        }
    }

    /// Convects the flow to the end of a step; called once per step, before [`AirModel::solve`].
    pub fn convect(&mut self, from: &AirState, flow: &Flow, step_s: f64, to: &mut AirState) {
        match (self, from, to) {
            (Self::Lattice(lattice), AirState::Lattice(from), AirState::Lattice(to)) => {
                lattice.convect(from, flow, step_s, to);
            }
            (Self::Strips(strips), AirState::Strips(from), AirState::Strips(to)) => {
                strips.convect(from, flow, step_s, to);
            }
            (Self::Rotor(_), AirState::Rotor(from), AirState::Rotor(to)) => to.copy_from(from),
            (Self::SlenderBody(_), AirState::SlenderBody(from), AirState::SlenderBody(to)) => to.copy_from(from),
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), ..) => {
                unreachable!("a state belongs to its model")
            }
        }
    }

    /// Computes state and loads at the end of a step, for the section motions `motions` at that instant. May be repeated with other
    /// motions.
    ///
    /// # Errors
    /// If panels of the lattice coincide, two sheets are closed or overlap, a surface is below the ground, or a model with a speed of sound
    /// reaches Mach 1.
    pub fn solve(
        &mut self,
        from: &AirState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        to: &mut AirState,
        loads: &mut AirLoads,
    ) -> Result<(), NoCirculation> {
        match (self, from, to) {
            (Self::Lattice(lattice), AirState::Lattice(from), AirState::Lattice(to)) => {
                lattice.solve(from, motions, flow, step_s, to, loads)
            }
            (Self::Strips(strips), AirState::Strips(from), AirState::Strips(to)) => {
                strips.solve(from, motions, flow, step_s, to, loads);
                strips.validity()
            }
            (Self::Rotor(rotor), AirState::Rotor(from), AirState::Rotor(to)) => {
                rotor.solve(from, motions, flow, step_s, to, loads);
                Ok(())
            }
            (Self::SlenderBody(body), AirState::SlenderBody(from), AirState::SlenderBody(to)) => {
                body.solve(from, motions, flow, step_s, to, loads);
                Ok(())
            }
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), ..) => {
                unreachable!("a state belongs to its model")
            }
        }
    }

    /// Length of the longest wake row of a step in panel chords, [`VortexLattice::row_panels`]; strips have none.
    pub fn row_panels(&self, from: &AirState, to: &AirState, path: &AirPath) -> f64 {
        match (self, from, to) {
            (Self::Lattice(lattice), AirState::Lattice(from), AirState::Lattice(to)) => {
                lattice.row_panels(from, to, path)
            }
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), ..) => 0.0,
        }
    }

    /// Whether strips of the lattice have stalled and follow their polars with a lag, eq. (U32).
    pub fn lags_beyond_stall(&self, state: &AirState) -> bool {
        matches!(state, AirState::Lattice(state) if state.lags)
    }

    /// Whether the model uses instantaneous velocities; otherwise it uses mean velocities over a step, from displacements, eq. (Q4). A
    /// rotor has no apparent mass, and rotates through a large angle within a step.
    pub fn sees_instants(&self) -> bool {
        matches!(self, Self::Rotor(_))
    }

    /// Circulation of a strip in m²/s, positive along the span from the inner to the outer end; 0 for rotor blades, which are modelled by
    /// annuli, and slender bodies.
    pub fn strip_circulation_m2_s(&self, state: &AirState, surface: usize, strip: usize) -> f64 {
        match (self, state) {
            (Self::Lattice(lattice), AirState::Lattice(state)) => lattice.strip_circulation(state, surface, strip),
            (Self::Strips(strips), AirState::Strips(state)) => strips.strip_circulation_m2_s(state, surface, strip),
            (Self::Rotor(_), AirState::Rotor(_)) | (Self::SlenderBody(_), AirState::SlenderBody(_)) => 0.0,
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), ..) => {
                unreachable!("a state belongs to its model")
            }
        }
    }
}

impl AirState {
    /// Copies another state of the same model without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        match (self, other) {
            (Self::Lattice(own), Self::Lattice(other)) => own.copy_from(other),
            (Self::Strips(own), Self::Strips(other)) => own.copy_from(other),
            (Self::Rotor(own), Self::Rotor(other)) => own.copy_from(other),
            (Self::SlenderBody(own), Self::SlenderBody(other)) => own.copy_from(other),
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), ..) => {
                unreachable!("a state belongs to its model")
            }
        }
    }

    /// Copies the initial values for the search of a steady flow, see [`VortexLattice::start`]; no effect if it is unique.
    pub fn go_on_from(&mut self, earlier: &Self) {
        match (self, earlier) {
            (Self::Lattice(own), Self::Lattice(earlier)) => own.profile_m_s.copy_from_slice(&earlier.profile_m_s),
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), _) => {}
        }
    }

    /// Hinge moments of the control surfaces.
    pub fn hinge_moments(&self) -> &[HingeMoment] {
        match self {
            Self::Lattice(state) => &state.hinges,
            Self::Strips(state) => &state.hinges,
            Self::Rotor(_) | Self::SlenderBody(_) => &[],
        }
    }

    /// Loads of a rotor; `None` for other models.
    pub fn rotor_loads(&self) -> Option<&RotorLoads> {
        match self {
            Self::Rotor(state) => Some(&state.loads),
            Self::Lattice(_) | Self::Strips(_) | Self::SlenderBody(_) => None,
        }
    }

    /// Whether another state has the same sizes.
    pub fn fits(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Lattice(own), Self::Lattice(other)) => own.fits(other),
            (Self::Strips(own), Self::Strips(other)) => own.fits(other),
            (Self::Rotor(own), Self::Rotor(other)) => own.fits(other),
            (Self::SlenderBody(own), Self::SlenderBody(other)) => own.fits(other),
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), _) => false,
        }
    }
}
