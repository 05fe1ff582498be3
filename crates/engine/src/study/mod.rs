//! Analyses of one state of a machine: equilibria and their stability, modes, linear models, derivatives of outputs.

mod aeroelastic;
mod at_rest_in_air;
mod coast;
mod currents;
mod derivatives;
mod differences;
mod flight;
mod lattice_delays;
mod lattice_modes;
mod lattice_space;
mod linear;
mod modes;
mod path_in_air;
mod periodic;
mod pushed_joints;
mod rotor;
mod stability;
mod state_space;
mod statics;
mod steady_turn;
mod supports;
mod whirl;

pub use crate::solve::arc_length::PathPoint;
pub use crate::solve::equilibrium::Effort as StaticEffort;
pub use crate::solve::linearize::{SecondOrder, StateSpace};
pub use crate::solve::multiblade::Whirl;
pub use crate::solve::reduction::{Keep, NoReduction, Reduced, reduce, sampled};
pub use crate::solve::reduction_accuracy::{Accuracy, Dropped};
pub use crate::solve::reduction_band::reduce_in_band;
pub use crate::solve::reduction_sampled::reduce_sampled;
pub use crate::solve::tracking::{Branches, Crossing, Followed, Place, change_of_sign};
pub use flight::FlightLoad;
pub use lattice_space::SampledSpace;
pub use linear::{Argument, Beside, InstantRates};
pub use periodic::{AveragedModes, GroundView};
pub use rotor::Rotor;
pub(crate) use rotor::shaft_of;
pub use stability::{Coarseness, Growth, JUDGED_MODES, Stability};
pub use state_space::InputSlope;
pub use statics::{Branch, Departure, Holding, LoadPath, Rest, Search};

use crate::system::System;
use statics::Quest;
use supports::Supports;

/// Analyses of the current state of a system. Equilibria replace the state; all others restore it.
pub struct Study<'a> {
    system: &'a mut System,
    /// Settings and results of the current search for an equilibrium.
    quest: Quest,
    /// Whether the state is that of an instant, [`Study::at_instant`].
    instant: bool,
    /// Forces of rigid loops by those on the dependent degrees of freedom, while a linear model is computed.
    supports: Option<Supports>,
}

impl<'a> Study<'a> {
    pub(crate) fn new(system: &'a mut System) -> Self {
        Self { system, quest: Quest::default(), instant: false, supports: None }
    }
}
