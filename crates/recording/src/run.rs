//! A run with the model's start values and constant inputs, recorded step by step as for the viewer page.

use crate::grid::Grid;
use crate::packed::{PackedRun, Packing};
use crate::recording::Recording;
use crate::signals::Signals;
use crate::{columns, number};
use foldwing_engine::plant::{Plant, PlantError};
use foldwing_fmi::interface::{Causality, Interface};

/// A run in progress with all outputs as signals.
pub struct Run {
    plant: Plant,
    interface: Interface,
    /// Value references of the outputs.
    outputs: Vec<u32>,
    grid: Grid,
    signals: Signals,
    recording: Recording,
    /// Communication steps so far.
    point: u64,
}

impl Run {
    /// Initialises the plant at the start of the grid and records its first point; `frames` is the maximum number of frames after the
    /// first.
    ///
    /// # Errors
    /// The plant cannot be initialised.
    pub fn start(mut plant: Plant, interface: Interface, grid: Grid, frames: u64) -> Result<Self, PlantError> {
        plant.initialize(grid.start_s)?;
        let outputs = || interface.variables().iter().filter(|variable| variable.causality == Causality::Output);
        let signals = Signals::new(columns(outputs()), grid.steps);
        let outputs = outputs().map(|variable| variable.value_reference).collect();
        let recording = Recording::new(&plant, grid.steps, frames);
        let mut run = Self { plant, interface, outputs, grid, signals, recording, point: 0 };
        run.include();
        Ok(run)
    }

    /// Takes one communication step and records its end; does nothing at the end of the grid.
    ///
    /// # Errors
    /// The step fails; the last successful time is recorded.
    pub fn advance(&mut self) -> Result<(), PlantError> {
        if self.is_finished() {
            return Ok(());
        }
        let before_s = self.plant.time_s();
        let stepped = self.plant.step(self.grid.time_s(self.point + 1));
        self.point += 1;
        if stepped.is_ok() || self.plant.time_s() > before_s {
            self.include();
        }
        stepped
    }

    /// Returns whether the end of the grid is reached.
    pub fn is_finished(&self) -> bool {
        self.point >= self.grid.steps
    }

    /// Completed fraction of the communication steps, 0 to 1.
    pub fn share(&self) -> f64 {
        self.point as f64 / self.grid.steps as f64
    }

    /// The plant in its current state.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The run so far as text, thinned to the space that one of `runs` runs has in a page.
    pub fn packed(&self, runs: usize) -> PackedRun {
        PackedRun::new(&self.recording, &self.signals, runs)
    }

    /// The run so far as numbers.
    pub fn packing(&self) -> Packing {
        Packing::of_run(&self.recording, &self.signals, 1)
    }

    fn include(&mut self) {
        self.recording.include(&self.plant);
        let (plant, interface) = (&self.plant, &self.interface);
        let value = |reference: &u32| {
            number(&interface.get(plant, plant.outputs(), *reference).expect("rows come from the same table"))
        };
        self.signals.include(plant.time_s(), self.outputs.iter().map(value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::tests::shipped;
    use std::sync::Arc;

    /// A run contains its first and its last point, and no more steps than the grid.
    #[test]
    fn a_run_goes_from_start_to_stop() {
        let machine = shipped("folding_wing");
        let interface = Interface::new(&machine);
        let mut run = Run::start(Plant::new(Arc::new(machine)), interface, Grid::new(0.0, 0.0105, 1e-3), 5).unwrap();
        let mut shares = vec![run.share()];
        while !run.is_finished() {
            run.advance().unwrap();
            shares.push(run.share());
        }
        run.advance().unwrap();
        assert_eq!((shares[0], shares.len(), run.plant().time_s()), (0.0, 12, 0.0105));
        let (frames, signals) = (&run.recording.frames, &run.signals);
        assert_eq!((frames[0].time_s, frames[frames.len() - 1].time_s, frames.len()), (0.0, 0.0105, 5));
        assert_eq!((signals.points, signals.kept(), signals.rows[0]), (12, 12, 0.0));
    }
}
