//! Smooth pieces of the functions of the aerodynamic models along a run, NOTATION eq. (X37).

use crate::aero::established::Established;
use crate::aero::pieces::{Holding, PieceList};
use crate::aero::rotor::pieces::RotorPieces;
use crate::aero::{AirLoads, AirModel, AirModels};
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::air::start::flow;
use crate::system::air::{AirCoupling, AirHistory, gaps};
use crate::system::{PlantError, System};

/// Pieces of a model in one evaluation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ModelPieces {
    /// Of models without kinks.
    None,
    /// Per strip.
    Strips(Vec<PieceList>),
    /// Of a rotor.
    Rotor(RotorPieces),
}

/// Pieces of all models in one evaluation.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct AirPieces(pub Vec<ModelPieces>);

impl AirPieces {
    /// Numbers of all pieces, for comparison.
    pub fn choices(&self) -> Vec<usize> {
        let of_model = |pieces: &ModelPieces| match pieces {
            ModelPieces::None => Vec::new(),
            ModelPieces::Strips(strips) => strips.iter().flat_map(|list| list.choices.iter().copied()).collect(),
            ModelPieces::Rotor(rotor) => rotor.choices().collect(),
        };
        self.0.iter().flat_map(of_model).collect()
    }

    /// Has the next evaluation of the models record their pieces.
    pub(super) fn record(models: &mut AirModels) {
        models.each_mut().for_each(|(model, ..)| match model {
            AirModel::Strips(strips) => strips.holding = Holding::Record(strips.no_pieces()),
            AirModel::Rotor(rotor) => rotor.holding = Holding::Record(RotorPieces::default()),
            AirModel::Lattice(_) | AirModel::SlenderBody(_) => {}
        });
    }

    /// Takes the recorded pieces.
    pub(super) fn recorded(models: &mut AirModels) -> Self {
        let of_model = |model: &mut AirModel| match model {
            AirModel::Strips(strips) => ModelPieces::Strips(strips.holding.recorded().unwrap_or_default()),
            AirModel::Rotor(rotor) => ModelPieces::Rotor(rotor.holding.recorded().unwrap_or_default()),
            AirModel::Lattice(_) | AirModel::SlenderBody(_) => ModelPieces::None,
        };
        Self(models.each_mut().map(|(model, ..)| of_model(model)).collect())
    }
}

impl System {
    /// Keeps the pieces of the functions of the aerodynamic models, or lets them go.
    pub(crate) fn hold_air(&mut self, pieces: Option<&AirPieces>) {
        let Some(air) = &mut self.air else { return };
        for (index, (model, ..)) in air.model.each_mut().enumerate() {
            match (model, pieces.and_then(|pieces| pieces.0.get(index))) {
                (AirModel::Strips(strips), Some(ModelPieces::Strips(own))) => {
                    strips.holding = Holding::Keep(own.clone());
                }
                (AirModel::Rotor(rotor), Some(ModelPieces::Rotor(own))) => rotor.holding = Holding::Keep(own.clone()),
                (AirModel::Strips(strips), _) => strips.holding = Holding::Free,
                (AirModel::Rotor(rotor), _) => rotor.holding = Holding::Free,
                (AirModel::Lattice(_) | AirModel::SlenderBody(_), _) => {}
            }
        }
    }

    /// Pieces of the functions of the aerodynamic models at the start of a run with the motion `at`. Lattices are not evaluated.
    pub(crate) fn start_pieces(&mut self, at: &Point) -> AirPieces {
        let Self { equations, scratch, air, state, .. } = self;
        equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut scratch[0]);
        let Some(air) = air.as_mut().filter(|air| air.continuous.is_some()) else { return AirPieces::default() };
        air.observe(equations, at);
        let AirCoupling { model, settings, motions, blank, .. } = &mut **air;
        let flow = flow(settings, state, at.time_s);
        let established = settings.established.then_some(Established { step_s: settings.step_s, turning: false });
        let mut loads = AirLoads::still(motions.len());
        AirPieces::record(model);
        // a flow without a solution is an error of the run
        let _ = model.start(motions, &flow, established, &mut blank.after.clone(), &mut loads);
        AirPieces::recorded(model)
    }

    /// Whether the aerodynamic models are on known pieces at the present.
    pub(crate) fn starts_on(&mut self, known: &AirPieces) -> bool {
        let now = self.state.now.clone();
        self.start_pieces(&now).choices() == known.choices()
    }

    /// Pieces in the aerodynamic step from `before` to the motion `at` its end.
    pub(crate) fn step_pieces(&mut self, before: &AirHistory, at: &Point) -> Result<AirPieces, PlantError> {
        self.meet_end_of_air_step(before, at)?;
        let Self { air: Some(air), state, machine, .. } = self else { return Ok(AirPieces::default()) };
        let AirCoupling { model, settings, motions, .. } = &mut **air;
        let flow = flow(settings, state, before.loads.end_s);
        let mut loads = AirLoads::still(motions.len());
        AirPieces::record(model);
        let solved =
            model.solve(&before.before, motions, &flow, settings.step_s, &mut before.after.clone(), &mut loads);
        let pieces = AirPieces::recorded(model);
        solved.map_err(|error| gaps::failure(machine, settings, before.loads.end_s, error))?;
        Ok(pieces)
    }
}
