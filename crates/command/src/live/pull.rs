//! Spring between the mouse pointer and a load station.

use foldwing_engine::load::LoadFrame;
use foldwing_engine::plant::{OutputSet, Plant};
use nalgebra::Vector3;
use serde::Serialize;

/// Station that is pulled, and the force of its input without the pull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    /// Index of the station, as in [`foldwing_engine::plant::Inputs::stations`].
    pub station: usize,
    /// Force of the input in N, in the load frame of the body.
    pub base_n: Vector3<f64>,
}

impl Held {
    /// Removes the pull from the inputs of the plant.
    pub fn release(self, plant: &mut Plant) {
        if let Some(load) = plant.inputs_mut().stations_mut().get_mut(self.station) {
            load.force_n = self.base_n;
        }
    }
}

/// Spring between a station and a point fixed in the root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pull {
    /// The station, and its force without the spring.
    pub held: Held,
    /// End of the spring that follows the pointer, in m in the root frame.
    pub target_m: Vector3<f64>,
    /// Stiffness in N/m.
    pub stiffness_n_m: f64,
    /// Force of the spring on the model, in N in the root frame.
    pub force_n: Vector3<f64>,
}

/// Pull as shown in a frame: index of its station, and vectors in the root frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Shown {
    station: usize,
    target: [f64; 3],
    force: [f64; 3],
}

impl Pull {
    /// Attaches a spring to a station; `None` if the model has no such station.
    pub fn new(plant: &Plant, station: usize, target_m: Vector3<f64>, stiffness_n_m: f64) -> Option<Self> {
        let base_n = plant.inputs().stations().get(station)?.force_n;
        let held = Held { station, base_n };
        Some(Self { held, target_m, stiffness_n_m, force_n: Vector3::zeros() })
    }

    /// Sets the force for the next step, of length `step_s`.
    ///
    /// The force is held constant over the step. Computed from the position at the start of the step, it would act like a negative
    /// damping of `−k h/2` and feed energy into oscillations. It is computed from the position extrapolated to the middle of the step by
    /// the velocity: the error is then of second order, and zero in static equilibrium.
    pub fn apply(&mut self, plant: &mut Plant, step_s: f64) {
        plant.provide(OutputSet::STATION_PLACES | OutputSet::STATION_MOTIONS);
        let Some(station) = plant.outputs().stations().get(self.held.station) else { return };
        let middle_m = station.position_m + 0.5 * step_s * station.velocity_m_s;
        self.force_n = self.stiffness_n_m * (self.target_m - middle_m);
        let own_n = match frame_of(plant, self.held.station) {
            LoadFrame::Root => self.force_n,
            LoadFrame::Section => station.rotation.inverse() * self.force_n,
        };
        if let Some(load) = plant.inputs_mut().stations_mut().get_mut(self.held.station) {
            load.force_n = self.held.base_n + own_n;
        }
    }

    /// Data of the pull for a frame.
    pub fn shown(&self) -> Shown {
        Shown { station: self.held.station, target: self.target_m.into(), force: self.force_n.into() }
    }
}

/// Frame of the load on a station.
fn frame_of(plant: &Plant, station: usize) -> LoadFrame {
    let bodies = &plant.machine().bodies;
    let mut frames = bodies.iter().flat_map(|body| body.station_positions_m.iter().map(|_| body.load_frame));
    frames.nth(station).unwrap_or(LoadFrame::Root)
}
