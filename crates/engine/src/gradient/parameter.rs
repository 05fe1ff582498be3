//! Parameters of a run: any number of a machine, by machines beside the present one, eq. (X9).

use crate::gradient::GradientError;
use crate::gradient::tape::{Step, Tape};
use crate::machine::Machine;
use crate::run::Plant;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::System;
use std::sync::Arc;

/// Weights of the machines at −2, −1, 1, 2 steps, over the step: fourth order.
pub(super) const WEIGHTS: [f64; 4] = [1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0];

/// A number of a machine.
///
/// Residual, start state and outputs are differenced along the tape, not the run: at a step of a thousandth of the number, or of its usual
/// size, fourth-order differences of these smooth functions have 1e-12 of truncation and of round-off.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Name, for messages.
    pub name: String,
    /// Step between the machines, in the parameter's unit.
    pub step: f64,
    /// The machine with the parameter changed by −2, −1, 1 and 2 steps.
    pub machines: [Arc<Machine>; 4],
}

impl Parameter {
    /// A parameter from a function that gives the machine for a value of it.
    pub fn new<E>(
        name: impl Into<String>,
        value: f64,
        step: f64,
        machine: impl Fn(f64) -> Result<Machine, E>,
    ) -> Result<Self, E> {
        let beside = |steps: f64| machine(value + steps * step).map(Arc::new);
        Ok(Self { name: name.into(), step, machines: [beside(-2.0)?, beside(-1.0)?, beside(1.0)?, beside(2.0)?] })
    }
}

/// The machines beside the present one, at work.
pub(super) struct Neighbours {
    plants: [Plant; 4],
    step: f64,
    /// Slopes of the start's coordinates and rates.
    pub start: [Vec<f64>; 2],
    scratch: Vec<f64>,
}

impl Neighbours {
    pub fn new(parameter: &Parameter, own: &System, tape: &Tape) -> Result<Self, GradientError> {
        let time_s = tape.steps.first().map_or(0.0, |step| step.start.time_s);
        let refuse = |what| GradientError::Structure { parameter: parameter.name.clone(), what };
        let coordinates = own.coordinates();
        let mut start = [vec![0.0; coordinates], vec![0.0; coordinates]];
        let mut plants = Vec::new();
        for (machine, weight) in parameter.machines.iter().zip(WEIGHTS) {
            let mut plant = Plant::new(Arc::clone(machine));
            plant.initialize(time_s)?;
            let system = plant.system_mut();
            if system.coordinates() != coordinates || system.outputs.values().len() != own.outputs.values().len() {
                return Err(refuse("the number of coordinates or outputs"));
            }
            system.refuse_gradient()?;
            if let Some(first) = tape.steps.first() {
                let held = system.state.joints.iter().zip(&first.joints);
                if held.clone().count() != first.joints.len()
                    || held.clone().any(|(a, b)| {
                        (a.released, a.latch.closed, a.latch.enabled, a.contact)
                            != (b.released, b.latch.closed, b.latch.enabled, b.contact)
                    })
                {
                    return Err(refuse("the state of a joint at the start (lock, latch or stop)"));
                }
            }
            super::add(&mut start[0], weight / parameter.step, &system.state.now.q);
            super::add(&mut start[1], weight / parameter.step, &system.state.now.v);
            plants.push(plant);
        }
        let plants = plants.try_into().map_err(|_| refuse("the machine"))?;
        Ok(Self { plants, step: parameter.step, start, scratch: vec![0.0; coordinates] })
    }

    /// Adopts the states of the joints in a step.
    pub fn adopt(&mut self, step: &Step) {
        for plant in &mut self.plants {
            adopt(plant.system_mut(), step);
        }
    }

    /// The machines.
    pub fn systems(&mut self) -> impl Iterator<Item = &mut System> {
        self.plants.iter_mut().map(Plant::system_mut)
    }

    /// Slope of the residual at a point into `slope`.
    pub fn residual_slope(&mut self, at: &Point, slope: &mut [f64]) {
        slope.fill(0.0);
        for (plant, weight) in self.plants.iter_mut().zip(WEIGHTS) {
            let equations = &mut plant.system_mut().equations;
            equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut self.scratch);
            super::add(slope, weight / self.step, &self.scratch);
        }
    }

    /// Slope of a number that each machine gives.
    pub fn slope(&mut self, mut of: impl FnMut(&mut System) -> f64) -> f64 {
        let each = self.plants.iter_mut().zip(WEIGHTS);
        each.map(|(plant, weight)| weight / self.step * of(plant.system_mut())).sum()
    }
}

/// Puts a system's joints into their states in a step. Neutral angles of motors stay the system's own.
pub(super) fn adopt(system: &mut System, step: &Step) {
    for (own, taped) in system.state.joints.iter_mut().zip(&step.joints) {
        let slew = own.slew;
        *own = *taped;
        own.slew = slew;
    }
    system.configure();
}
