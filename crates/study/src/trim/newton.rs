//! The model at equilibrium as a function of the unknowns, and Newton's iteration, NOTATION eq. (Q7).

use crate::trim::attitude::{Attitude, Turn, Turns};
use crate::trim::error::{Cause, Residual, TrimError, UnknownError};
use crate::trim::found::{Balanced, Solved, Trim};
use crate::trim::least_squares::{measure, step_towards};
use crate::trim::unknown::{Balance, Unknown, refuse_repeated};
use crate::values::{Target, no_row};
use crate::warnings::{self, Warning};
use crate::watch::{Progress, Watch, unwatched};
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{Interface, Value, Variable};
use nalgebra::{DMatrix, DVector};

/// Step of the differences, relative to the magnitude of an unknown, or in its SI unit if the magnitude is below 1.
const STEP: f64 = 1e-4;
/// Tolerance of the residuals, relative to their reference sizes.
const TOLERANCE: f64 = 1e-9;
/// Maximum number of Newton steps.
const MAXIMUM_STEPS: usize = 40;
/// Maximum number of halvings of a step that does not reduce the residual.
const MAXIMUM_HALVINGS: usize = 12;

/// Options of [`solve`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Unknowns: real inputs and parameters, or `attitude.roll`, `attitude.pitch`, `attitude.yaw`, which rotate the model relative to
    /// gravity and wind, or `turn.rate` for a steady turn to the right. Names joined by commas share a value; `-name` takes its negative.
    pub solve_for: Vec<String>,
    /// Outputs with their targets, as many as unknowns. Forces and moments on free joints are balanced as well, with up to six more
    /// unknowns for each of these joints.
    pub targets: Vec<Target>,
    /// Start values of the attitude in rad and of the turn in rad/s; for unknowns they are the initial guesses.
    pub turns: Vec<(Turn, f64)>,
}

/// Solves for values of inputs and parameters for which outputs at equilibrium have their targets.
///
/// `plant` has its start values and is not yet initialised; those of the unknowns are the initial guesses. Free hinges take their
/// equilibrium angles.
///
/// # Errors
/// Names that do not belong to a real input, parameter or output, numbers of unknowns and targets that do not match, and an iteration that
/// finds no trim.
pub fn solve(plant: Plant, options: &Options) -> Result<Trim, TrimError> {
    solve_watched(plant, options, &mut unwatched)
}

/// [`solve`] with `watch` called after each equilibrium. The number of equilibria is not known in advance.
///
/// # Errors
/// Those of [`solve`], and [`TrimError::Stopped`].
pub fn solve_watched(plant: Plant, options: &Options, watch: &mut Watch<'_>) -> Result<Trim, TrimError> {
    let interface = Interface::new(plant.machine());
    let mut problem = Problem::new(&interface, plant, options, watch)?;
    let (values, left, steps) = problem.find()?;
    Ok(problem.found(&values, &left, steps))
}

/// The model at equilibrium as a function of the unknowns.
struct Problem<'a> {
    interface: &'a Interface,
    plant: Plant,
    unknowns: Vec<Unknown<'a>>,
    balances: Vec<Balance<'a>>,
    /// Names and units of the loads on free joints, which must vanish.
    loads: Vec<(String, &'static str)>,
    /// Gravity and wind, which depend on the attitude.
    attitude: Attitude,
    /// Given attitude angles and turn rate, or initial guesses.
    turns: Turns,
    /// The model is in a steady turn.
    turning: bool,
    /// Called after every equilibrium.
    watch: &'a mut Watch<'a>,
    /// Number of equilibria.
    equilibria: usize,
    stopped: bool,
}

impl<'a> Problem<'a> {
    fn new(
        interface: &'a Interface,
        plant: Plant,
        options: &Options,
        watch: &'a mut Watch<'a>,
    ) -> Result<Self, TrimError> {
        let unknowns =
            options.solve_for.iter().map(|name| Unknown::of(name, interface)).collect::<Result<Vec<_>, _>>()?;
        let balance = |target: &Target| Balance::of(&target.output, target.value, interface);
        let balances = options.targets.iter().map(balance).collect::<Result<Vec<_>, _>>()?;
        let loads: Vec<_> = plant.flying_joints().iter().flat_map(|joint| loads_on(joint)).collect();
        if unknowns.len() < balances.len() || unknowns.len() > balances.len() + loads.len() {
            let (unknowns, targets) = (unknowns.len(), balances.len());
            return Err(TrimError::Count { unknowns, targets, joint_loads: loads.len() });
        }
        refuse_repeated(&unknowns, &balances)?;
        if unknowns.is_empty() {
            return Err(TrimError::NothingFree);
        }
        let attitude = Attitude::of(&plant);
        let mut turns: Turns = [0.0; 4];
        let mut turning = false;
        for &(turn, value) in &options.turns {
            if !value.is_finite() {
                return Err(TrimError::NotFinite { turn, value });
            }
            attitude.check(turn).map_err(|error| TrimError::Turn { turn, error })?;
            turns[turn as usize] = value;
            turning |= turn == Turn::Rate;
        }
        for unknown in &unknowns {
            if let Unknown::Turn(turn) = unknown {
                let refused =
                    |error| TrimError::SolveFor { unknown: turn.name().to_owned(), error: UnknownError::Turn(error) };
                attitude.check(*turn).map_err(refused)?;
                turning |= *turn == Turn::Rate;
            }
        }
        let (equilibria, stopped) = (0, false);
        Ok(Self { interface, plant, unknowns, balances, loads, attitude, turns, turning, watch, equilibria, stopped })
    }

    /// The result for these values of the unknowns.
    fn found(&self, values: &DVector<f64>, left: &DVector<f64>, steps: usize) -> Trim {
        let solved = self.unknowns.iter().zip(values.iter()).map(|(unknown, value)| Solved {
            name: unknown.name().to_owned(),
            unit: unknown.unit(),
            value: *value,
        });
        let outputs = self.outputs();
        let balanced = self.balances.iter().zip(outputs).zip(left.iter()).map(|((own, value), left)| Balanced {
            output: own.row.name.clone(),
            unit: own.row.unit(),
            value,
            residual: *left,
        });
        Trim {
            machine: self.plant.machine().name.clone(),
            solved: solved.collect(),
            balanced: balanced.collect(),
            joint_loads: self.residuals(left).split_off(self.balances.len()),
            settings: self.settings(values),
            steps,
            warnings: warnings::balance_at(&self.plant).into_iter().chain(warnings::joints_at(&self.plant)).collect(),
        }
    }

    /// Start values of inputs and parameters that put the model into the state of the unknowns.
    fn settings(&self, values: &DVector<f64>) -> Vec<(String, f64)> {
        let mut list = Vec::new();
        let mut attitude = self.attitude.clone();
        let (mut turns, mut sought) = (self.turns, Vec::new());
        for (unknown, &value) in self.unknowns.iter().zip(values.iter()) {
            match unknown {
                Unknown::Value { rows, .. } => {
                    for (sign, row) in rows {
                        if attitude.take(&row.name, sign * value) {
                            sought.push(row.name.as_str());
                        } else {
                            list.push((row.name.clone(), sign * value));
                        }
                    }
                }
                Unknown::Turn(turn) => turns[*turn as usize] = value,
            }
        }
        let turned = turns != [0.0; 4] || self.unknowns.iter().any(|unknown| matches!(unknown, Unknown::Turn(_)));
        let all = attitude.turned(turns, self.turning);
        list.extend(all.into_iter().filter(|(name, _)| turned || sought.contains(&name.as_str())));
        list
    }

    /// Values of the unknowns, residuals of the balances, and number of steps: Newton's iteration, with shorter steps if a full one does
    /// not reduce the residuals, NOTATION eq. (Q7); by least squares with more balances than unknowns, as for the loads of a symmetric
    /// flight.
    fn find(&mut self) -> Result<(DVector<f64>, DVector<f64>, usize), TrimError> {
        let count = self.unknowns.len();
        let mut values = DVector::from_iterator(count, self.unknowns.iter().map(|unknown| self.value_of(unknown)));
        let mut left = self.left(&values)?;
        let rows = left.len();
        let mut sizes = self.sizes(&left);
        let mut warnings = warnings::joints_at(&self.plant);
        for steps in 0..MAXIMUM_STEPS {
            if measure(&left, &sizes) <= TOLERANCE {
                // leave the model at these values
                self.left(&values)?;
                return Ok((values, left, steps));
            }
            let mut slopes = DMatrix::zeros(rows, count);
            for i in 0..count {
                let step = STEP * values[i].abs().max(1.0);
                let [above, below] = [1.0, -1.0].map(|sign| {
                    let mut beside = values.clone();
                    beside[i] += sign * step;
                    self.left(&beside)
                });
                slopes.set_column(i, &((above? - below?) / (2.0 * step)));
            }
            // size of a balance that is zero at first: its change with the unknowns
            for (i, size) in sizes.iter_mut().enumerate().take(self.balances.len()) {
                let moved = (0..count).map(|j| slopes[(i, j)].abs() * values[j].abs().max(1.0)).fold(0.0, f64::max);
                *size = size.max(1e-3 * moved);
            }
            let Some(change) = step_towards(&slopes, &left, &sizes) else {
                return Err(self.failed(Cause::Dependent, &left, warnings));
            };
            let (before, mut share) = (measure(&left, &sizes), 1.0);
            let nearer = (0..=MAXIMUM_HALVINGS).find_map(|_| {
                let beside = &values - &change * share;
                share *= 0.5;
                let found = self.left(&beside).ok()?;
                (measure(&found, &sizes) < before).then_some((beside, found))
            });
            let Some(found) = nearer else {
                if self.stopped {
                    return Err(TrimError::Stopped);
                }
                return Err(self.failed(Cause::NoDescent, &left, warnings));
            };
            (values, left) = found;
            warnings = warnings::joints_at(&self.plant);
        }
        Err(self.failed(Cause::Steps, &left, warnings))
    }

    /// Reference size of each residual: its target or its initial value; for loads on free joints the weight or the largest load.
    fn sizes(&mut self, left: &DVector<f64>) -> DVector<f64> {
        let study = self.plant.study();
        let (size_n, length_m) = (study.flight_scale_n(), study.flight_length_m());
        let balances = self.balances.iter().zip(left.iter()).map(|(own, left)| own.target.abs().max(left.abs()));
        let loads = (0..self.loads.len()).map(|i| if i % 6 < 3 { size_n } else { size_n * length_m });
        DVector::from_iterator(left.len(), balances.chain(loads))
    }

    fn failed(&self, cause: Cause, left: &DVector<f64>, warnings: Vec<Warning>) -> TrimError {
        TrimError::NotConverged { cause, residuals: self.residuals(left), warnings }
    }

    /// Residuals with names and units: outputs, then loads on free joints.
    fn residuals(&self, left: &DVector<f64>) -> Vec<Residual> {
        let outputs = self.balances.iter().map(|own| (own.row.name.clone(), own.row.unit()));
        let all = outputs.chain(self.loads.iter().cloned());
        all.zip(left.iter()).map(|((name, unit), value)| Residual { name, unit, value: *value }).collect()
    }

    /// The model at equilibrium for values of the unknowns; residuals of the balances, and the loads on free joints.
    fn left(&mut self, values: &DVector<f64>) -> Result<DVector<f64>, TrimError> {
        self.report()?;
        for (name, value) in self.settings(values) {
            let row = self.interface.find(&name).ok_or_else(|| no_row(&name, "input or parameter", self.interface))?;
            let set = self.interface.set(&mut self.plant, row.value_reference, Value::Real(value));
            set.map_err(|error| TrimError::Refused { name, value, error })?;
        }
        let time_s = self.plant.machine().experiment.start_time_s;
        let loads = self.plant.study().rest_held_in_flight(time_s)?;
        let outputs = self.outputs();
        let balances = self.balances.iter().zip(outputs.iter()).map(|(own, value)| value - own.target);
        let loads = loads
            .iter()
            .flat_map(|load| load.force_n.iter().chain(load.moment_n_m.iter()).copied().collect::<Vec<_>>());
        Ok(DVector::from_vec(balances.chain(loads).collect()))
    }

    /// Reports the equilibria so far.
    fn report(&mut self) -> Result<(), TrimError> {
        let progress = Progress { part: "equilibria", done: self.equilibria, total: None };
        self.equilibria += 1;
        self.stopped = self.stopped || (self.watch)(progress).is_break();
        if self.stopped { Err(TrimError::Stopped) } else { Ok(()) }
    }

    /// Values of the outputs with targets.
    fn outputs(&self) -> Vec<f64> {
        self.balances.iter().map(|own| self.value(own.row)).collect()
    }

    /// Initial guess of an unknown.
    fn value_of(&self, unknown: &Unknown) -> f64 {
        match unknown {
            Unknown::Value { rows, .. } => rows[0].0 * self.value(rows[0].1),
            Unknown::Turn(turn) => self.turns[*turn as usize],
        }
    }

    fn value(&self, row: &Variable) -> f64 {
        match self.interface.get(&self.plant, self.plant.outputs(), row.value_reference) {
            Some(Value::Real(value)) => value,
            _ => 0.0,
        }
    }
}

/// Names of the loads on a free joint, with their units.
fn loads_on(joint: &str) -> impl Iterator<Item = (String, &'static str)> {
    let named =
        |part: &'static str, unit: &'static str| ["x", "y", "z"].map(|axis| (format!("{joint}: {part} {axis}"), unit));
    named("force", "N").into_iter().chain(named("moment", "N.m"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldwing_engine::machine::{Body, Joint, Machine, Spring};
    use std::sync::Arc;

    /// A pendulum of 1 kg at 1 m turns by `arctan` of the ratio of two components of gravity, which flattens: from three times the other
    /// one, Newton's full step towards a small angle leads to the other side and farther away. With halved steps the iteration converges,
    /// to `g_z = −g_x tan θ − kθ/(m l cos θ)`.
    #[test]
    fn steps_that_lead_away_are_halved() {
        const ANGLE_RAD: f64 = 0.2;
        let spring = Spring { stiffness_n_m_rad: 0.1, damping_n_m_s_rad: 0.0, rest_angle_rad: 0.0 };
        let machine = Machine::builder("Pendulum")
            .gravity_m_s2([10.0, 0.0, 30.0])
            .body(
                Body::rigid("arm").inertia(1.0, [1.0, 0.0, 0.0], nalgebra::Matrix3::identity()),
                Joint::revolute("hinge", [0.0, 1.0, 0.0]).spring(spring),
            )
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let options = Options {
            solve_for: vec!["gravity.z".to_owned()],
            targets: vec![Target { output: "hinge.angle".to_owned(), value: ANGLE_RAD }],
            ..Options::default()
        };
        let found = solve(Plant::new(Arc::new(machine)), &options).unwrap_or_else(|error| panic!("{error}"));
        let expected_m_s2 = -10.0 * ANGLE_RAD.tan() - 0.1 * ANGLE_RAD / ANGLE_RAD.cos();
        // the tolerance of balances, 1e-9, divided by the derivative of the angle
        assert!((found.solved[0].value - expected_m_s2).abs() < 1e-7, "{found:?} for {expected_m_s2}");
    }
}
