//! One text and its run.

use crate::marks::{Mark, marks, warnings};
use foldwing_engine::plant::Plant;
use foldwing_file as config;
use foldwing_fmi::interface::Interface;
use foldwing_recording::packed::Packing;
use foldwing_recording::{Grid, Run};
use serde_json::{Value, json};
use std::sync::Arc;

/// State of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// There are steps left to take.
    Running,
    /// The stop time is reached.
    Finished,
    /// A step failed; the run up to the failure is kept.
    Failed,
}

/// Reason why a text cannot be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// The text is not a model.
    Text(Vec<Mark>),
    /// The model cannot start.
    Start(String),
}

impl Refusal {
    /// The reason as JSON for the page: marks, or a message for the model as a whole.
    pub fn json(&self) -> Value {
        match self {
            Self::Text(marks) => json!({ "marks": marks.iter().map(Mark::json).collect::<Vec<_>>() }),
            Self::Start(message) => json!({ "marks": [], "message": message }),
        }
    }
}

/// The run of a model with the settings of its `[simulation]`, as `foldwing simulate --view` records it.
pub struct Session {
    run: Run,
    warnings: Vec<Mark>,
    failure: Option<String>,
}

impl Session {
    /// Reads a model and starts its run, which is recorded in at most `frames` frames after the first.
    ///
    /// # Errors
    /// The text is rejected, or the machine cannot start.
    pub fn begin(text: &str, frames: u64) -> Result<Self, Refusal> {
        let machine = config::parse(text, "model").map_err(|error| Refusal::Text(marks(text, &error)))?;
        let interface = Interface::new(&machine);
        let experiment = &machine.experiment;
        let grid = Grid::new(experiment.start_time_s, experiment.stop_time_s, experiment.step_s);
        let plant = Plant::new(Arc::new(machine));
        let run = Run::start(plant, interface, grid, frames).map_err(|error| Refusal::Start(error.to_string()))?;
        Ok(Self { run, warnings: warnings(text), failure: None })
    }

    /// Takes at most `steps` communication steps.
    pub fn advance(&mut self, steps: u32) -> State {
        for _ in 0..steps {
            if self.state() != State::Running {
                break;
            }
            self.failure = self.run.advance().err().map(|error| error.to_string());
        }
        self.state()
    }

    /// State of the run.
    pub fn state(&self) -> State {
        match self.failure {
            Some(_) => State::Failed,
            None if self.run.is_finished() => State::Finished,
            None => State::Running,
        }
    }

    /// The run so far for the page.
    pub fn packing(&self) -> Packing {
        self.run.packing()
    }

    /// Report of the run so far, as JSON for the page and programs: time in s, completed fraction of the steps, warnings, failure,
    /// latch times in s (`null` before the first closing), counters of the solver.
    pub fn summary(&self) -> Value {
        let plant = self.run.plant();
        let latches = plant.outputs().latches().iter().zip(plant.revolute_joints()).map(|(latch, body)| {
            let time_s = (latch.count.get() > 0).then_some(latch.time_s);
            json!({ "joint": plant.machine().bodies[*body].joint.name, "time_s": time_s })
        });
        let statistics = plant.statistics();
        json!({
            "name": plant.machine().name,
            "time_s": plant.time_s(),
            "share": self.run.share(),
            "marks": self.warnings.iter().map(Mark::json).collect::<Vec<_>>(),
            "failure": self.failure,
            "latches": latches.collect::<Vec<_>>(),
            "lattice": plant.lattice().is_some(),
            "steps": statistics.steps,
            "iterations": statistics.iterations,
        })
    }
}
