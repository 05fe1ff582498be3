//! Derivatives of rows: in time, and with respect to each other.

use crate::interface::access::{Kind, Stage};
use crate::interface::binding::{Binding, Input, Output, Parameter};
use crate::interface::dependencies::Dependence;
use crate::interface::{AccessError, Interface, Scalar, Value, Variable};
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::StartState;
use foldwing_engine::plant::{Inputs, Outputs, Plant, PlantError};

/// Step of differences of initial values, of the known's value, or in its unit where that is smaller (inputs) or zero.
const INITIAL_STEP: f64 = 1e-3;
/// Step in the unit of an input that the initial values are a polynomial of: any is exact, a large one has the least
/// round-off.
const POLYNOMIAL_STEP: f64 = 1.0;
/// Sixth-order central difference: steps and weights, over 60 steps.
const SIXTH_ORDER: [(f64, f64); 6] = [(1.0, 45.0), (-1.0, -45.0), (2.0, -9.0), (-2.0, 9.0), (3.0, 1.0), (-3.0, -1.0)];

/// Why a derivative could not be given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DerivativeError {
    /// A row that has none, or a bad value.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// The plant has no solution beside the present one.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

/// A row that others are differentiated by.
#[derive(Clone, Copy)]
enum Known {
    Input(Input),
    Parameter(Parameter),
}

impl Interface {
    /// Sets the time derivatives of continuous inputs for the next [`Plant::step`]: all of them or, if one is refused,
    /// none. Only order 1 is known. The slices are equally long. Allocates nothing unless it fails.
    pub fn set_input_rates(
        &self,
        plant: &mut Plant,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), AccessError> {
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            self.check_kind(&[reference], Kind::Real)?;
            let refuse = || self.variables()[reference as usize].name.clone();
            if !matches!(self.binding(reference), Some(Binding::Input(_))) {
                return Err(AccessError::NotAnInput { name: refuse() });
            }
            if order != 1 {
                return Err(AccessError::Order { name: refuse(), order });
            }
            if !value.is_finite() {
                return Err(AccessError::NotFinite { name: format!("der({})", refuse()), value });
            }
        }
        for (&reference, &value) in references.iter().zip(values) {
            if let Some(Binding::Input(input)) = self.binding(reference)
                && let Some(slot) = input.real_mut(plant.input_rates_mut())
            {
                *slot = value;
            }
        }
        Ok(())
    }

    /// Time derivatives of Real outputs at the present time ([`Plant::output_rates`]); those of order 2 and higher are
    /// given as zero. The slices are equally long; nothing is written unless all can be read.
    pub fn output_rates(
        &self,
        plant: &mut Plant,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), AccessError> {
        for (&reference, &order) in references.iter().zip(orders) {
            self.output(reference)?;
            if order < 1 {
                return Err(AccessError::Order { name: self.variables()[reference as usize].name.clone(), order });
            }
        }
        if references.is_empty() {
            return Ok(());
        }
        let rates = plant.output_rates();
        for ((&reference, &order), value) in references.iter().zip(orders).zip(values) {
            *value = if order == 1 { real(self.output(reference)?, &rates) } else { 0.0 };
        }
        Ok(())
    }

    /// `Σ ∂unknown/∂known · seed` per unknown, NOTATION eq. (L14): at a communication point ([`Stage::Running`]) by
    /// continuous inputs with the state frozen, in initialisation ([`Stage::Starting`], at `start_s`) by inputs and
    /// parameters. Pairs that the table does not declare as dependent give zero.
    ///
    /// `knowns` and `seeds`, `unknowns` and `values` are equally long; nothing is written unless all can be given. The
    /// plant is as before afterwards.
    pub fn directional_derivative(
        &self,
        plant: &mut Plant,
        (stage, start_s): (Stage, f64),
        (unknowns, values): (&[u32], &mut [f64]),
        (knowns, seeds): (&[u32], &[f64]),
    ) -> Result<(), DerivativeError> {
        let outputs = unknowns.iter().map(|&unknown| self.output(unknown)).collect::<Result<Vec<_>, _>>()?;
        for (&known, &value) in knowns.iter().zip(seeds) {
            self.known(known, stage)?;
            if !value.is_finite() {
                let name = format!("d({})", self.variables()[known as usize].name);
                return Err(AccessError::NotFinite { name, value }.into());
            }
        }
        let concerned = self.concerned(plant.machine(), stage, &outputs, knowns);
        let mut sums = vec![0.0; unknowns.len()];
        for ((&known, &seed), concerned) in knowns.iter().zip(seeds).zip(concerned) {
            if seed == 0.0 || !concerned.contains(&true) {
                continue;
            }
            let add = |sums: &mut [f64], outputs_there: &Outputs, weight: f64| {
                for ((sum, &output), &concerned) in sums.iter_mut().zip(&outputs).zip(&concerned) {
                    if concerned {
                        *sum += weight * real(output, outputs_there);
                    }
                }
            };
            match (stage, self.known(known, stage)?) {
                (Stage::Running, Known::Input(input)) => {
                    let slope = plant.output_response(&|inputs: &mut Inputs, amount| {
                        if let Some(slot) = input.real_mut(inputs) {
                            *slot += amount;
                        }
                    })?;
                    add(&mut sums, &slope, seed);
                }
                (_, known) => {
                    let mut column = vec![0.0; unknowns.len()];
                    let step = initial_differences(plant, start_s, known, &mut |outputs_there, weight| {
                        add(&mut column, outputs_there, weight);
                    })?;
                    sums.iter_mut().zip(column).for_each(|(sum, entry)| *sum += seed * entry / (60.0 * step));
                }
            }
        }
        values.copy_from_slice(&sums);
        Ok(())
    }

    /// Per known, which of the outputs depend on it.
    fn concerned(&self, machine: &Machine, stage: Stage, outputs: &[Output], knowns: &[u32]) -> Vec<Vec<bool>> {
        let dependence = Dependence::new(machine, stage);
        let of = |&known: &u32| {
            let known = self.binding(known);
            outputs.iter().map(|&output| known.is_some_and(|known| dependence.holds(output, known))).collect()
        };
        knowns.iter().map(of).collect()
    }

    /// The Real output of a row.
    fn output(&self, reference: u32) -> Result<Output, AccessError> {
        self.check_kind(&[reference], f64::KIND)?;
        match self.binding(reference) {
            Some(Binding::Output(output)) => Ok(output),
            _ => Err(AccessError::NotAnUnknown { name: self.variables()[reference as usize].name.clone() }),
        }
    }

    /// What a row is differentiated by, if it may be.
    fn known(&self, reference: u32, stage: Stage) -> Result<Known, AccessError> {
        self.check_kind(&[reference], f64::KIND)?;
        match (self.binding(reference), stage) {
            (Some(Binding::Input(input)), _) => Ok(Known::Input(input)),
            (Some(Binding::Parameter(parameter)), Stage::Starting) => Ok(Known::Parameter(parameter)),
            _ => {
                let Variable { name, .. } = &self.variables()[reference as usize];
                Err(AccessError::NotAKnown { name: name.clone() })
            }
        }
    }
}

/// Evaluates the initialisation beside the present value of a known and hands every result on with its weight; returns
/// the step. The plant is initialised with the present value afterwards.
fn initial_differences(
    plant: &mut Plant,
    start_s: f64,
    known: Known,
    add: &mut dyn FnMut(&Outputs, f64),
) -> Result<f64, PlantError> {
    let value = match known {
        Known::Input(input) => *input.real_mut(plant.inputs_mut()).expect("a Real input"),
        Known::Parameter(parameter) => *parameter.slot(plant.parameters_mut()),
    };
    let floor = if value == 0.0 || matches!(known, Known::Input(_)) { 1.0 } else { 0.0 };
    let step =
        if is_polynomial(plant.machine(), known) { POLYNOMIAL_STEP } else { INITIAL_STEP * value.abs().max(floor) };
    let start_at = |plant: &mut Plant, value: f64| {
        match known {
            Known::Input(input) => *input.real_mut(plant.inputs_mut()).expect("a Real input") = value,
            Known::Parameter(parameter) => *parameter.slot(plant.parameters_mut()) = value,
        }
        plant.initialize(start_s)
    };
    let mut outcome = Ok(step);
    for (steps, weight) in SIXTH_ORDER {
        match start_at(plant, value + steps * step) {
            Ok(()) => add(plant.outputs(), weight),
            Err(error) => {
                outcome = Err(error);
                break;
            }
        }
    }
    start_at(plant, value)?;
    outcome
}

/// Whether the initial values are polynomials of an input: loads and motion of the root on a machine whose coordinates at
/// the start do not follow from them. Drives have limits, the air is no polynomial of the turning of the root.
fn is_polynomial(machine: &Machine, known: Known) -> bool {
    machine.experiment.start == StartState::Unstrained
        && match known {
            Known::Input(
                Input::StationForce(..)
                | Input::StationMoment(..)
                | Input::Gravity(_)
                | Input::RootAcceleration(_)
                | Input::RootAngularAcceleration(_),
            ) => true,
            Known::Input(Input::RootAngularVelocity(_)) => machine.air.is_none(),
            Known::Input(Input::Joint(..) | Input::Wind(_)) | Known::Parameter(_) => false,
        }
}

/// A Real output's value.
fn real(output: Output, outputs: &Outputs) -> f64 {
    match output.read(outputs) {
        Value::Real(value) => value,
        Value::Integer(_) | Value::Boolean(_) => 0.0,
    }
}
