//! Linear model of the machine about its current state: matrices, modes, derivatives of outputs.
//!
//! The stiffness is the exact tangent if the state is an equilibrium. About a moving state, inertia forces change with the pose: the
//! derivative is then, and with sliding joints, computed by sixth-order differences of the residual without its elastic part, accurate to 1e-11 of its terms. Mass
//! and damping are always exact: the residual is linear in the accelerations and quadratic in the rates. NOTATION eqs. (L10)–(L12).

use crate::force::joint::JointForces;
use crate::load::RootMotion;
use crate::math::strain::SHEARED;
use crate::multibody::dynamics::Environment;
use crate::multibody::kinematics::Motion;
use crate::multibody::tangent::Tangent;
use crate::solve::EquationsOfMotion;
use crate::solve::linearize::SecondOrder;
use crate::solve::point::Point;
use crate::study::Study;
use crate::study::differences::{Bare, add_elastic, direction, displaced, pick, select, sixth_order, stiffness};
use crate::study::supports::Supports;
use crate::system::Outputs;
use crate::system::PlantError;
use crate::system::freedoms::Freedom;
use nalgebra::{DMatrix, DVector, Vector3};

/// Variables with respect to which outputs are differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Argument {
    /// With respect to the coordinates.
    Position,
    /// With respect to their rates.
    Rate,
    /// With respect to their accelerations.
    Acceleration,
}

/// A state near the current one.
#[derive(Debug, Clone, Copy)]
pub enum Beside<'f> {
    /// The current state itself.
    Nothing,
    /// A degree of freedom changed by an amount, in its unit.
    Position(&'f Freedom, f64),
    /// The rate of a degree of freedom, changed by an amount.
    Rate(&'f Freedom, f64),
    /// The rates of all coordinates, changed by these amounts.
    Rates(&'f [f64]),
    /// An aerodynamic lag state or, after these, a current, by its index in linear models, changed by an amount in its unit.
    Lag(usize, f64),
}

/// Rates of the states at an instant, with the outputs.
#[derive(Debug, Clone)]
pub struct InstantRates {
    /// Rates of all coordinates.
    pub rates: Vec<f64>,
    /// Accelerations of all coordinates.
    pub accelerations: Vec<f64>,
    /// Rates of the aerodynamic lag states and of the currents in their units per s, in the order of linear models.
    pub of_lags: Vec<f64>,
    /// Outputs at the instant.
    pub outputs: Outputs,
}

impl Study<'_> {
    /// Mass, damping and stiffness about the current state with its accelerations, over [`crate::system::System::freedoms`].
    pub fn second_order(&mut self) -> Result<SecondOrder, PlantError> {
        self.system.refuse_no_slip("linear model")?;
        let freedoms = self.system.freedoms();
        let mut unused = vec![0.0; self.system.coordinates()];
        let now = &self.system.state.now;
        self.system.equations.residual(now.time_s, &now.q, &now.v, &now.a, &mut unused);
        let rest = self.system.stands_still();
        if !rest && let Some(cause) = self.system.only_at_rest() {
            return Err(PlantError::Linearization { time_s: now.time_s, cause });
        }
        let stiffness = if rest && self.system.machine.sliding_joint().is_none() {
            let mut tangent = Tangent::new(&self.system.equations.model);
            self.system.equations.linearize_at_rest(&mut tangent, &now.q);
            select(&tangent.dense(&self.system.equations.model), &freedoms)
        } else {
            self.moving_stiffness(&freedoms)
        };
        Ok(SecondOrder { mass: self.mass_matrix(&freedoms), damping: self.damping_matrix(&freedoms), stiffness })
    }

    /// `BᵀMB`: residual due to unit accelerations alone.
    pub(super) fn mass_matrix(&self, freedoms: &[Freedom]) -> DMatrix<f64> {
        let mut bare = Bare::without_stiffness(self.system);
        let columns = freedoms.iter().map(|freedom| {
            let unit = self.direction(freedom);
            pick(&bare.of_accelerations(&self.system.state.now.q, &unit), freedoms)
        });
        let matrix = DMatrix::from_columns(&columns.collect::<Vec<_>>());
        (&matrix + matrix.transpose()) * 0.5
    }

    /// Derivative of the residual with respect to the rates: central differences are exact for quadratic functions.
    fn damping_matrix(&self, freedoms: &[Freedom]) -> DMatrix<f64> {
        let mut bare = Bare::new(self.system);
        let now = &self.system.state.now;
        let zero = vec![0.0; now.q.len()];
        let field = RootMotion {
            gravity_m_s2: Vector3::zeros(),
            acceleration_m_s2: Vector3::zeros(),
            angular_acceleration_rad_s2: Vector3::zeros(),
            ..self.system.equations.root
        };
        let environment = Environment { root: &field, damping: &self.system.equations.damping, stations: &[] };
        let columns = freedoms.iter().map(|freedom| {
            let unit = self.direction(freedom);
            let mut at = |shift: f64| {
                let v: Vec<f64> = now.v.iter().zip(&unit).map(|(v, unit)| v + shift * unit).collect();
                pick(&bare.residual(Motion { q: &now.q, v: &v, a: &zero }, environment), freedoms)
            };
            (at(1.0) - at(-1.0)) * 0.5
        });
        let mut matrix = DMatrix::from_columns(&columns.collect::<Vec<_>>());
        let mut diagonal = DMatrix::zeros(now.q.len(), now.q.len());
        let model = &self.system.equations.model;
        add_elastic(&mut diagonal, model, |body, i, j| {
            let viscous = self.system.equations.damping[body].stiffness_s;
            model.bodies[body].damped_weights::<SHEARED>(0.0, viscous)[(i, j)]
        });
        for joint in self.system.equations.forces.joints().iter().filter(|joint| !joint.held) {
            diagonal[(joint.coordinate, joint.coordinate)] += self.system.equations.tangents[joint.body].damping;
        }
        for joint in self.system.equations.forces.spatial() {
            for c in joint.rows() {
                diagonal[(c, c)] += self.system.equations.tangents[joint.body].damping;
            }
        }
        matrix += select(&diagonal, freedoms);
        matrix
    }

    /// Derivative of the residual with respect to the coordinates about a moving state.
    pub(super) fn moving_stiffness(&self, freedoms: &[Freedom]) -> DMatrix<f64> {
        let (equations, now) = (&self.system.equations, &self.system.state.now);
        stiffness(equations, &mut Bare::new(self.system), Motion { q: &now.q, v: &now.v, a: &now.a }, freedoms)
    }

    /// Change of the coordinates due to a unit of a degree of freedom; also of the rates due to its rate, and of the accelerations due to
    /// its acceleration.
    pub fn direction(&self, freedom: &Freedom) -> Vec<f64> {
        direction(&self.system.equations, freedom)
    }

    /// The coordinates with a degree of freedom changed by `amount`, in its unit.
    pub fn displaced(&self, freedom: &Freedom, amount: f64) -> Vec<f64> {
        displaced(&self.system.equations, &self.system.state.now.q, freedom, amount)
    }

    /// Residual over [`crate::system::System::freedoms`] at the current state with the current inputs. A change of a command moves the motor's neutral
    /// angle immediately: rate limits do not affect infinitesimal changes.
    pub fn residual_of_inputs(&mut self) -> DVector<f64> {
        self.with_present_inputs();
        let mut residual = vec![0.0; self.system.coordinates()];
        let now = &self.system.state.now;
        self.system.equations.residual(now.time_s, &now.q, &now.v, &now.a, &mut residual);
        let freedoms = self.system.freedoms();
        self.system.configure();
        pick(&residual, &freedoms)
    }

    /// Outputs at the current state with one argument changed by `amount` along a degree of freedom, and with the current inputs. The state
    /// of the plant is restored.
    pub fn outputs_beside(&mut self, change: Option<(Argument, &Freedom, f64)>) -> Outputs {
        let mut there = self.system.state.now.clone();
        match change {
            None => {}
            Some((Argument::Position, freedom, amount)) => there.q = self.displaced(freedom, amount),
            Some((argument, freedom, amount)) => {
                let unit = self.direction(freedom);
                let vector = if argument == Argument::Rate { &mut there.v } else { &mut there.a };
                vector.iter_mut().zip(unit).for_each(|(x, unit)| *x += amount * unit);
            }
        }
        self.outputs_at(there)
    }

    /// Outputs at the current state with changed accelerations of all coordinates.
    pub(super) fn outputs_pulled(&mut self, change: &[f64]) -> Outputs {
        let mut there = self.system.state.now.clone();
        there.a.iter_mut().zip(change).for_each(|(a, change)| *a += change);
        self.outputs_at(there)
    }

    fn outputs_at(&mut self, there: Point) -> Outputs {
        let kept = std::mem::replace(&mut self.system.state.now, there);
        self.with_present_inputs();
        if let Some(supports) = &self.supports {
            supports.set(self.system);
        }
        self.system.evaluate();
        let beside = self.system.outputs.clone();
        self.system.state.now = kept;
        self.system.configure();
        self.system.evaluate();
        beside
    }

    /// Calls `take` with the state of an instant: with the set inputs, and with accelerations and aerodynamic loads that are
    /// consistent with coordinates, rates, lag states and inputs, NOTATION eq. (L10), instead of those of the integrator, which are
    /// accurate to its tolerance. An equilibrium remains one, with the residual of the search for it, unless its inputs have changed since.
    ///
    /// # Errors
    /// If the accelerations cannot be computed, and any error of `take`.
    pub(super) fn at_instant<T>(
        &mut self,
        take: impl FnOnce(&mut Self) -> Result<T, PlantError>,
    ) -> Result<T, PlantError> {
        let is_current = self.system.state.inputs == self.system.state.applied_inputs;
        let rests = is_current && self.system.stands_still();
        if self.instant || rests {
            return take(self);
        }
        self.restoring(|study| {
            study.system.settle_present(None)?;
            study.instant = true;
            let taken = take(study);
            study.instant = false;
            taken
        })
    }

    /// Calls `act` with the state and the set inputs, and restores the state afterwards.
    fn restoring<T>(&mut self, act: impl FnOnce(&mut Self) -> Result<T, PlantError>) -> Result<T, PlantError> {
        let (kept, branch_s) = (self.system.state.clone(), self.system.equations.branch_s);
        self.take_inputs();
        self.system.configure();
        let done = act(self);
        self.system.state = kept;
        self.system.equations.branch_s = branch_s;
        self.system.configure();
        self.system.evaluate();
        done
    }

    /// Rates of the states of a linear model, and the outputs, at the current state with the set inputs, or near it: by the nonlinear
    /// equations of the machine, with the loads of strips, rotors and slender bodies at the instant. Loads of lattices are constant. For
    /// comparisons with linear models; with apparent mass the rates must jump with the wind, as in [`Study::state_space`]. The state is
    /// unchanged.
    ///
    /// # Errors
    /// If the accelerations or aerodynamic loads cannot be computed.
    pub fn rates_beside(&mut self, change: Beside) -> Result<InstantRates, PlantError> {
        self.restoring(|study| {
            let mut lags = None;
            match change {
                Beside::Nothing => {}
                Beside::Position(freedom, amount) => study.system.state.now.q = study.displaced(freedom, amount),
                Beside::Rate(freedom, amount) => {
                    let unit = study.direction(freedom);
                    study.system.state.now.v.iter_mut().zip(unit).for_each(|(v, unit)| *v += amount * unit);
                }
                Beside::Rates(change) => {
                    study.system.state.now.v.iter_mut().zip(change).for_each(|(v, change)| *v += change);
                }
                Beside::Lag(lag, amount) => {
                    let mut there = study.system.present_lags(false).unwrap_or_default();
                    match there.get_mut(lag) {
                        Some(value) => *value += amount,
                        None => study.add_to_current(lag - there.len(), amount),
                    }
                    lags = Some(there);
                }
            }
            let mut of_lags = study.system.settle_present(lags.as_deref())?;
            study.system.evaluate();
            let now = &study.system.state.now;
            of_lags.extend(study.system.equations.model.circuits.iter().map(|circuit| now.a[circuit.coordinate]));
            Ok(InstantRates {
                rates: now.v.clone(),
                accelerations: now.a.clone(),
                of_lags,
                outputs: study.system.outputs.clone(),
            })
        })
    }

    /// Calls `take` with linearised forces of joints at the current state, with the current inputs: a motor at its limit stays there, one
    /// exactly at the limit is not limited, a generator at a row of its table continues towards higher speeds, contacts of end stops and
    /// latches are constant, NOTATION eq. (L10). Accelerations are those of the instant.
    pub(super) fn on_tangents<T>(
        &mut self,
        take: impl FnOnce(&mut Self) -> Result<T, PlantError>,
    ) -> Result<T, PlantError> {
        self.at_instant(|study| {
            study.with_present_inputs();
            let now = &study.system.state.now;
            study.system.equations.forces.linearize(now.time_s, &now.q, &now.v);
            study.supports = Supports::of(study.system);
            let taken = take(study);
            study.supports = None;
            study.system.equations.forces.drop_tangents();
            study.system.configure();
            taken
        })
    }

    /// Derivative of a function of the outputs with respect to an argument along a degree of freedom: by sixth-order differences in the
    /// coordinates (error 1e-12 of the outputs' scale), and exactly in rates and accelerations, of which the outputs are polynomials of
    /// second and first degree if forces are linearised (`Study::on_tangents`).
    pub fn output_slope(
        &mut self,
        argument: Argument,
        freedom: &Freedom,
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> DVector<f64> {
        if argument == Argument::Position {
            let mut at = |steps: f64| read(&self.outputs_beside(Some((argument, freedom, steps * freedom.step))));
            return sixth_order(&mut at, freedom.step);
        }
        let mut at = |amount: f64| read(&self.outputs_beside(Some((argument, freedom, amount))));
        (at(1.0) - at(-1.0)) * 0.5
    }

    /// Updates the equations to inputs that have been set since the last step; the state is unchanged.
    fn with_present_inputs(&mut self) {
        let state = &self.system.state;
        let (inputs, from_s) = (state.applied_inputs.clone(), state.applied_from_s);
        let slews: Vec<_> = state.joints.iter().map(|joint| joint.slew).collect();
        self.take_inputs();
        self.system.configure();
        let state = &mut self.system.state;
        (state.applied_inputs, state.applied_from_s) = (inputs, from_s);
        state.joints.iter_mut().zip(slews).for_each(|(joint, slew)| joint.slew = slew);
    }

    /// Applies the set inputs to the state's step. A change of a command moves the motor's neutral angle immediately: rate limits do not
    /// affect infinitesimal changes.
    fn take_inputs(&mut self) {
        let state = &mut self.system.state;
        let now_s = state.now.time_s;
        let mut old = state.applied_inputs.clone();
        old.run_on(&state.applied_rates, now_s - state.applied_from_s);
        state.applied_inputs.clone_from(&state.inputs);
        state.applied_from_s = now_s;
        let forces = self.system.equations.forces.joints();
        // a runaway motor ignores commands
        let follows = |joint: &JointForces| joint.motor().is_some_and(|motor| !motor.deaf);
        let commands = state.inputs.joints().iter().zip(old.joints());
        let joints = state.joints.iter_mut().zip(forces).zip(commands);
        for ((memory, _), (new, old)) in joints.filter(|((_, joint), _)| follows(joint)) {
            let change = new.command_rad - old.command_rad;
            memory.slew.from_rad += change;
            memory.slew.target_rad += change;
        }
    }
}

/// Whether the determinant is positive; `None` if it is round-off.
pub(super) fn determinant_is_positive(matrix: &DMatrix<f64>) -> Option<bool> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].abs().sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] / (scale[i] * scale[j]));
    if !scaled.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let lu = scaled.lu();
    let pivots = lu.u().diagonal();
    let singular = pivots.iter().any(|pivot| pivot.abs() < 1e-13);
    let negative = pivots.iter().filter(|pivot| **pivot < 0.0).count();
    let even = lu.p().determinant::<f64>() > 0.0;
    (!singular).then_some((negative % 2 == 0) == even)
}
