//! Smooth pieces of the functions of a rotor along a run, NOTATION eq. (X37).

use crate::aero::rotor::pieces::{Holding, RotorPieces};
use crate::aero::{AirLoads, AirModel, AirState};
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::air::AirHistory;
use crate::system::air::start::flow;
use crate::system::{PlantError, System};

impl System {
    /// Keeps the pieces of the functions of a rotor, or lets them go.
    pub(crate) fn hold_rotor(&mut self, pieces: Option<&RotorPieces>) {
        if let Some(AirModel::Rotor(rotor)) = self.air.as_mut().and_then(|air| air.model.only_mut()) {
            rotor.holding = pieces.map_or(Holding::Free, |pieces| Holding::Keep(pieces.clone()));
        }
    }

    /// Pieces of the functions of a rotor at the start of a run with the motion `at`; `None` without a rotor.
    pub(crate) fn start_pieces(&mut self, at: &Point) -> Option<RotorPieces> {
        let Self { equations, scratch, air, state, .. } = self;
        equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut scratch[0]);
        let Some(air) = air else { return None };
        air.observe(equations, at);
        let flow = flow(&air.settings, state, at.time_s);
        let (motions, established) = (&air.motions, air.settings.established);
        let mut loads = AirLoads::still(motions.len());
        let Some(AirModel::Rotor(rotor)) = air.model.only_mut() else { return None };
        rotor.holding = Holding::Record(RotorPieces::default());
        let mut begun = rotor.blank_state();
        rotor.start(motions, &flow, established, &mut begun, &mut loads);
        rotor.holding.recorded()
    }

    /// Whether a rotor is on known pieces at the present.
    pub(crate) fn starts_on(&mut self, known: Option<&RotorPieces>) -> bool {
        let now = self.state.now.clone();
        let own = self.start_pieces(&now);
        own.iter().flat_map(RotorPieces::choices).eq(known.into_iter().flat_map(RotorPieces::choices))
    }

    /// Pieces in the aerodynamic step from `before` to the motion `at` its end; `None` without a rotor.
    pub(crate) fn step_pieces(&mut self, before: &AirHistory, at: &Point) -> Result<Option<RotorPieces>, PlantError> {
        self.meet_end_of_air_step(before, at)?;
        let Self { air: Some(air), state, .. } = self else { return Ok(None) };
        let flow = flow(&air.settings, state, before.loads.end_s);
        let (motions, step_s) = (&air.motions, air.settings.step_s);
        let (Some(AirModel::Rotor(rotor)), Some(AirState::Rotor(from))) = (air.model.only_mut(), before.before.only())
        else {
            return Ok(None);
        };
        rotor.holding = Holding::Record(RotorPieces::default());
        let (mut to, mut loads) = (rotor.blank_state(), AirLoads::still(motions.len()));
        rotor.solve(from, motions, &flow, step_s, &mut to, &mut loads);
        Ok(rotor.holding.recorded())
    }
}
