//! Smooth pieces of the functions of an aerodynamic model along a run, NOTATION eq. (X37).

use crate::aero::pieces::{Holding, PieceList};
use crate::aero::rotor::pieces::RotorPieces;
use crate::aero::{AirLoads, AirModel, AirState};
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::air::AirHistory;
use crate::system::air::start::flow;
use crate::system::{PlantError, System};

/// Pieces of a model in one evaluation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum AirPieces {
    /// Per strip.
    Strips(Vec<PieceList>),
    /// Of a rotor.
    Rotor(RotorPieces),
}

impl AirPieces {
    /// Numbers of all pieces, for comparison.
    pub fn choices(&self) -> Vec<usize> {
        match self {
            Self::Strips(strips) => strips.iter().flat_map(|list| list.choices.iter().copied()).collect(),
            Self::Rotor(rotor) => rotor.choices().collect(),
        }
    }
}

/// Has the next evaluation of a model record its pieces.
pub(super) fn record(model: &mut AirModel) {
    match model {
        AirModel::Strips(strips) => strips.holding = Holding::Record(strips.no_pieces()),
        AirModel::Rotor(rotor) => rotor.holding = Holding::Record(RotorPieces::default()),
        AirModel::Lattice(_) | AirModel::SlenderBody(_) => {}
    }
}

/// Takes the recorded pieces; `None` of models without kinks.
pub(super) fn recorded(model: &mut AirModel) -> Option<AirPieces> {
    match model {
        AirModel::Strips(strips) => strips.holding.recorded().map(AirPieces::Strips),
        AirModel::Rotor(rotor) => rotor.holding.recorded().map(AirPieces::Rotor),
        AirModel::Lattice(_) | AirModel::SlenderBody(_) => None,
    }
}

impl System {
    /// Keeps the pieces of the functions of the aerodynamic model, or lets them go.
    pub(crate) fn hold_air(&mut self, pieces: Option<&AirPieces>) {
        let Some(model) = self.air.as_mut().and_then(|air| air.model.only_mut()) else { return };
        match (model, pieces) {
            (AirModel::Strips(strips), Some(AirPieces::Strips(pieces))) => {
                strips.holding = Holding::Keep(pieces.clone());
            }
            (AirModel::Rotor(rotor), Some(AirPieces::Rotor(pieces))) => rotor.holding = Holding::Keep(pieces.clone()),
            (AirModel::Strips(strips), Some(AirPieces::Rotor(_)) | None) => strips.holding = Holding::Free,
            (AirModel::Rotor(rotor), Some(AirPieces::Strips(_)) | None) => rotor.holding = Holding::Free,
            (AirModel::Lattice(_) | AirModel::SlenderBody(_), _) => {}
        }
    }

    /// Pieces of the functions of the aerodynamic model at the start of a run with the motion `at`; `None` without one that has kinks.
    pub(crate) fn start_pieces(&mut self, at: &Point) -> Option<AirPieces> {
        let Self { equations, scratch, air, state, .. } = self;
        equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut scratch[0]);
        let Some(air) = air else { return None };
        air.observe(equations, at);
        let flow = flow(&air.settings, state, at.time_s);
        let (motions, established) = (&air.motions, air.settings.established);
        let mut loads = AirLoads::still(motions.len());
        let model = air.model.only_mut()?;
        record(model);
        match model {
            AirModel::Strips(strips) => {
                let mut begun = strips.blank_state();
                strips.start(motions, &flow, established, &mut begun, &mut loads);
            }
            AirModel::Rotor(rotor) => {
                let mut begun = rotor.blank_state();
                rotor.start(motions, &flow, established, &mut begun, &mut loads);
            }
            AirModel::Lattice(_) | AirModel::SlenderBody(_) => {}
        }
        recorded(model)
    }

    /// Whether the aerodynamic model is on known pieces at the present.
    pub(crate) fn starts_on(&mut self, known: Option<&AirPieces>) -> bool {
        let now = self.state.now.clone();
        let own = self.start_pieces(&now);
        own.as_ref().map(AirPieces::choices) == known.map(AirPieces::choices)
    }

    /// Pieces in the aerodynamic step from `before` to the motion `at` its end; `None` without a model that has kinks.
    pub(crate) fn step_pieces(&mut self, before: &AirHistory, at: &Point) -> Result<Option<AirPieces>, PlantError> {
        self.meet_end_of_air_step(before, at)?;
        let Self { air: Some(air), state, .. } = self else { return Ok(None) };
        let flow = flow(&air.settings, state, before.loads.end_s);
        let (motions, step_s) = (&air.motions, air.settings.step_s);
        let (Some(model), Some(from)) = (air.model.only_mut(), before.before.only()) else { return Ok(None) };
        record(model);
        let mut loads = AirLoads::still(motions.len());
        match (&mut *model, from) {
            (AirModel::Strips(strips), AirState::Strips(from)) => {
                let mut to = strips.blank_state();
                strips.solve(from, motions, &flow, step_s, &mut to, &mut loads);
            }
            (AirModel::Rotor(rotor), AirState::Rotor(from)) => {
                let mut to = rotor.blank_state();
                rotor.solve(from, motions, &flow, step_s, &mut to, &mut loads);
            }
            (AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::Lattice(_) | AirModel::SlenderBody(_), _) => {}
        }
        Ok(recorded(model))
    }
}
