//! The classical Runge–Kutta method of fourth order with a fixed step, as an implementation of the trait of fmi-rs, whose only
//! integrator without downloads is Euler's. An event is located by bisection of the step that crosses it.

use fmi_rs::sim::SimulationError;
use fmi_rs::sim::solver::{Dae, Ode, Solver, SolverFactory};

/// Bisections of a step: an event is located within the step divided by 2⁴⁴.
const BISECTIONS: usize = 44;

/// Makes integrators of a given step.
pub struct RungeKuttaFactory {
    /// Longest step in s.
    pub step_s: f64,
}

struct RungeKutta<O> {
    step_s: f64,
    time_s: f64,
    states: Vec<f64>,
    /// Indicators at `time_s`.
    indicators: Vec<f64>,
    ode: O,
}

impl SolverFactory for RungeKuttaFactory {
    fn create<'a, O: Ode + 'a, D: Dae + 'a>(
        &self,
        start_time: f64,
        _relative_tolerance: f64,
        ode: O,
        _dae: Option<D>,
    ) -> Result<Box<dyn Solver + 'a>, SimulationError> {
        let (states, indicators) = (vec![0.0; ode.nx()], vec![0.0; ode.nz()]);
        let mut solver = RungeKutta { step_s: self.step_s, time_s: start_time, states, indicators, ode };
        solver.reset(start_time)?;
        Ok(Box::new(solver))
    }
}

impl<O: Ode> RungeKutta<O> {
    /// States after a step from the current ones.
    fn taken(&self, step_s: f64) -> Result<Vec<f64>, SimulationError> {
        let slope = |time_s: f64, states: &[f64]| {
            let mut slope = vec![0.0; states.len()];
            self.ode.f(time_s, states, &mut slope).map(|()| slope)
        };
        let ahead = |slope: &[f64], share: f64| -> Vec<f64> {
            self.states.iter().zip(slope).map(|(state, slope)| state + share * step_s * slope).collect()
        };
        let (half_s, end_s) = (self.time_s + 0.5 * step_s, self.time_s + step_s);
        let first = slope(self.time_s, &self.states)?;
        let second = slope(half_s, &ahead(&first, 0.5))?;
        let third = slope(half_s, &ahead(&second, 0.5))?;
        let fourth = slope(end_s, &ahead(&third, 1.0))?;
        let mean = (0..self.states.len()).map(|i| (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]) / 6.0);
        Ok(ahead(&mean.collect::<Vec<f64>>(), 1.0))
    }

    fn indicators_at(&self, time_s: f64, states: &[f64]) -> Result<Vec<f64>, SimulationError> {
        let mut indicators = vec![0.0; self.indicators.len()];
        self.ode.g(time_s, states, &mut indicators)?;
        Ok(indicators)
    }

    /// Whether an indicator has changed sign since the current state.
    fn crosses(&self, indicators: &[f64]) -> bool {
        self.indicators.iter().zip(indicators).any(|(was, is)| (*was > 0.0) != (*is > 0.0))
    }
}

impl<O: Ode> Solver for RungeKutta<O> {
    fn reset(&mut self, time: f64) -> Result<(), SimulationError> {
        self.time_s = time;
        let mut nominals = vec![0.0; self.states.len()];
        self.ode.init(&mut self.states, &mut nominals)?;
        self.indicators = self.indicators_at(time, &self.states)?;
        Ok(())
    }

    fn step(&mut self, next_time: f64) -> Result<(f64, &[f64], bool), SimulationError> {
        let (begin_s, span_s) = (self.time_s, next_time - self.time_s);
        let steps = (span_s / self.step_s * (1.0 - 1e-9)).ceil().max(1.0) as usize;
        for step in 1..=steps {
            let end_s = if step == steps { next_time } else { begin_s + span_s * step as f64 / steps as f64 };
            let mut step_s = end_s - self.time_s;
            let mut states = self.taken(step_s)?;
            let mut indicators = self.indicators_at(end_s, &states)?;
            let event = self.crosses(&indicators);
            if event {
                let mut before_s = 0.0;
                for _ in 0..BISECTIONS {
                    let middle_s = 0.5 * (before_s + step_s);
                    let there = self.taken(middle_s)?;
                    let found = self.indicators_at(self.time_s + middle_s, &there)?;
                    if self.crosses(&found) {
                        (step_s, states, indicators) = (middle_s, there, found);
                    } else {
                        before_s = middle_s;
                    }
                }
            }
            self.time_s = if event { self.time_s + step_s } else { end_s };
            (self.states, self.indicators) = (states, indicators);
            if event {
                return Ok((self.time_s, &self.states, true));
            }
        }
        Ok((self.time_s, &self.states, false))
    }
}
