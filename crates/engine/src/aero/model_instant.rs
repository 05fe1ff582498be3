//! Common interface of the aerodynamic models at one instant, in continuous time.

use crate::aero::rotor::loads::RotorLoads;
use crate::aero::strip::continuous::{Answer, LOAD_ROWS, Variable};
use crate::aero::strip::instant::Instant;
use crate::aero::{AirModel, AirState};

impl AirModel {
    /// Numbers of lag states and of rows of a response behind loads and rates of the lag states; `None` for a lattice, which has no response
    /// at an instant.
    pub(super) fn instant_rows(&self, gusts: bool) -> Option<[usize; 2]> {
        let lags = match self {
            Self::Lattice(_) => return None,
            Self::Strips(strips) => strips.lag_count(gusts),
            Self::Rotor(rotor) => rotor.lags().len(),
            Self::SlenderBody(_) => 0,
        };
        Some([lags, self.rest_rows()])
    }

    /// Number of rows of a response behind loads and rates of the lag states.
    pub(super) fn rest_rows(&self) -> usize {
        match self {
            Self::Lattice(lattice) => lattice.strip_count() + lattice.hinge_count(),
            Self::Strips(strips) => strips.count() + strips.flap_count(),
            Self::Rotor(_) => size_of::<RotorLoads>() / size_of::<f64>(),
            Self::SlenderBody(_) => 0,
        }
    }

    /// Response at an instant: loads of the sections in their frames, rates of the lag states, other rows.
    pub(super) fn respond(&mut self, at: &Instant, gusts: bool, answer: &mut [f64]) {
        match self {
            Self::Lattice(_) => answer.fill(0.0),
            Self::Strips(strips) => strips.respond(at, gusts, answer),
            Self::Rotor(rotor) => rotor.respond(at, answer),
            Self::SlenderBody(body) => body.respond(at, answer),
        }
    }

    /// Derivative of the response.
    pub(super) fn slope(&mut self, at: &Instant, gusts: bool, variable: Variable) -> Answer {
        match self {
            Self::Lattice(_) => vec![0.0; LOAD_ROWS * at.motions.len()],
            Self::Strips(strips) => strips.slope(at, gusts, variable),
            Self::Rotor(rotor) => rotor.slope(at, variable),
            Self::SlenderBody(body) => body.slope(at, variable),
        }
    }

    /// Adds a multiple of the other rows of a response to a state: circulations and hinge moments, or loads and coefficients of a rotor.
    pub(super) fn add_rest(&self, rest: &[f64], amount: f64, state: &mut AirState) {
        match (self, state) {
            (Self::Lattice(lattice), AirState::Lattice(state)) => {
                let (circulations, hinges) = rest.split_at(lattice.strip_count());
                for (moment, hinge) in state.hinges.iter_mut().zip(hinges) {
                    moment.circulatory_n_m += hinge * amount;
                }
                lattice.add_strip_circulations(state, circulations, amount);
            }
            (Self::Strips(strips), AirState::Strips(state)) => {
                let (circulations, hinges) = rest.split_at(strips.count());
                for (moment, hinge) in state.hinges.iter_mut().zip(hinges) {
                    moment.circulatory_n_m += hinge * amount;
                }
                for (strip, circulation) in state.strips.iter_mut().zip(circulations) {
                    strip.circulation_m2_s += circulation * amount;
                }
            }
            (Self::Rotor(_), AirState::Rotor(state)) => {
                let numbers: &mut [f64] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut state.loads));
                numbers.iter_mut().zip(rest).for_each(|(number, entry)| *number += entry * amount);
            }
            (Self::Lattice(_) | Self::Strips(_) | Self::Rotor(_) | Self::SlenderBody(_), _) => {}
        }
    }
}
