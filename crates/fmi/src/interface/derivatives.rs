//! Derivatives of rows: in time, and with respect to each other.

use crate::interface::access::{Kind, Stage};
use crate::interface::dependencies::Dependence;
use crate::interface::known::{Input, Known};
use crate::interface::table::Place;
use crate::interface::{AccessError, Interface, Scalar, Variable};
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::StartState;
use foldwing_engine::plant::{Inputs, Outputs, Plant, PlantError};

/// Step of the differences of initial values, relative to the value of the known; in its unit if the value is zero or, for inputs, smaller
/// than 1.
const INITIAL_STEP: f64 = 1e-3;
/// Step in the unit of an input on which the initial values depend polynomially: any step is exact, a large one has the smallest round-off.
const POLYNOMIAL_STEP: f64 = 1.0;
/// Sixth-order central difference: steps and weights; the sum is divided by 60 steps.
const SIXTH_ORDER: [(f64, f64); 6] = [(1.0, 45.0), (-1.0, -45.0), (2.0, -9.0), (-2.0, 9.0), (3.0, 1.0), (-3.0, -1.0)];

/// Error of a derivative.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DerivativeError {
    /// The row has no derivative, or a value is invalid.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// The plant has no solution next to the current one.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

impl Interface {
    /// Sets the time derivatives of continuous inputs for the next [`Plant::step`]: all of them or, on an error, none. Only order 1 is
    /// supported. The slices are equally long. Allocates nothing unless it fails.
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
            if !matches!(self.known(reference), Some(Known::Input(_))) {
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
            if let Place::Input(place) = self.slots[reference as usize].place {
                plant.input_rates_mut().values_mut()[place] = value;
            }
        }
        Ok(())
    }

    /// Time derivatives of Real outputs at the current time (`Study::output_rates`); those of order 2 and higher are zero. The slices are
    /// equally long; nothing is written unless all can be read.
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
        let rates = plant.study().output_rates();
        for ((&reference, &order), value) in references.iter().zip(orders).zip(values) {
            *value = if order == 1 { rates.values()[self.output(reference)?] } else { 0.0 };
        }
        Ok(())
    }

    /// `Σ ∂unknown/∂known · seed` per unknown, NOTATION eq. (L14): at a communication point ([`Stage::Running`]) with respect to continuous
    /// inputs with the state held constant, in initialisation ([`Stage::Starting`], at `start_s`) with respect to inputs and parameters.
    /// Pairs that the table does not declare as dependent give zero.
    ///
    /// `knowns` and `seeds`, `unknowns` and `values` are equally long; nothing is written unless all can be computed. The plant is
    /// unchanged afterwards.
    pub fn directional_derivative(
        &self,
        plant: &mut Plant,
        (stage, start_s): (Stage, f64),
        (unknowns, values): (&[u32], &mut [f64]),
        (knowns, seeds): (&[u32], &[f64]),
    ) -> Result<(), DerivativeError> {
        let mut sums = vec![0.0; unknowns.len()];
        unknowns.iter().try_for_each(|&unknown| self.output(unknown).map(|_| ()))?;
        for (&known, &seed) in knowns.iter().zip(seeds) {
            self.differentiable(known, stage)?;
            self.finite_seed(known, seed)?;
        }
        let wanted = |known: usize| seeds[known] != 0.0;
        self.columns(plant, (stage, start_s), unknowns, knowns, wanted, |known, column, over| {
            sums.iter_mut().zip(column).for_each(|(sum, entry)| *sum += seeds[known] * entry / over);
        })?;
        values.copy_from_slice(&sums);
        Ok(())
    }

    /// `Σ seed · ∂unknown/∂known` per known: the transpose of [`Interface::directional_derivative`], with the same knowns, unknowns and
    /// errors.
    pub fn adjoint_derivative(
        &self,
        plant: &mut Plant,
        when: (Stage, f64),
        (unknowns, seeds): (&[u32], &[f64]),
        (knowns, values): (&[u32], &mut [f64]),
    ) -> Result<(), DerivativeError> {
        let mut sums = vec![0.0; knowns.len()];
        for (&unknown, &seed) in unknowns.iter().zip(seeds) {
            self.output(unknown)?;
            self.finite_seed(unknown, seed)?;
        }
        self.columns(
            plant,
            when,
            unknowns,
            knowns,
            |_| true,
            |known, column, over| {
                sums[known] = seeds.iter().zip(column).map(|(seed, entry)| seed * entry / over).sum();
            },
        )?;
        values.copy_from_slice(&sums);
        Ok(())
    }

    /// Fails for a seed that is not finite.
    pub(super) fn finite_seed(&self, reference: u32, value: f64) -> Result<(), AccessError> {
        let name = || format!("d({})", self.variables()[reference as usize].name);
        if value.is_finite() { Ok(()) } else { Err(AccessError::NotFinite { name: name(), value }) }
    }

    /// Columns `∂unknowns/∂known`, each times the divisor passed with it; only for knowns that are `wanted` and on which an unknown
    /// depends.
    fn columns(
        &self,
        plant: &mut Plant,
        (stage, start_s): (Stage, f64),
        unknowns: &[u32],
        knowns: &[u32],
        wanted: impl Fn(usize) -> bool,
        mut take: impl FnMut(usize, &[f64], f64),
    ) -> Result<(), DerivativeError> {
        let outputs = unknowns.iter().map(|&unknown| self.output(unknown)).collect::<Result<Vec<_>, _>>()?;
        knowns.iter().try_for_each(|&known| self.differentiable(known, stage))?;
        let concerned = self.concerned(plant.machine(), stage, unknowns, knowns);
        let mut column = vec![0.0; unknowns.len()];
        for (number, (&known, concerned)) in knowns.iter().zip(concerned).enumerate() {
            if !wanted(number) || !concerned.contains(&true) {
                continue;
            }
            column.fill(0.0);
            let add = |column: &mut [f64], outputs_there: &Outputs, weight: f64| {
                for ((entry, &output), &concerned) in column.iter_mut().zip(&outputs).zip(&concerned) {
                    if concerned {
                        *entry += weight * outputs_there.values()[output];
                    }
                }
            };
            let over = match (stage, self.slots[known as usize].place) {
                (Stage::Running, Place::Input(place)) => {
                    let slope = plant
                        .study()
                        .output_response(&|inputs: &mut Inputs, amount| inputs.values_mut()[place] += amount)?;
                    add(&mut column, &slope, 1.0);
                    1.0
                }
                _ => {
                    let step = self.initial_differences(plant, start_s, known, &mut |outputs_there, weight| {
                        add(&mut column, outputs_there, weight);
                    })?;
                    60.0 * step
                }
            };
            take(number, &column, over);
        }
        Ok(())
    }

    /// Per known, the unknowns that depend on it.
    fn concerned(&self, machine: &Machine, stage: Stage, unknowns: &[u32], knowns: &[u32]) -> Vec<Vec<bool>> {
        let dependence = Dependence::new(machine, stage);
        let holds = |unknown: u32, known: u32| {
            let depends = self.bounds[unknown as usize].depends.map(|depends| &self.depends[depends]);
            depends.zip(self.known(known)).is_some_and(|(depends, known)| dependence.holds(depends, known))
        };
        knowns.iter().map(|&known| unknowns.iter().map(|&unknown| holds(unknown, known)).collect()).collect()
    }

    /// Position of the Real output of a row.
    fn output(&self, reference: u32) -> Result<usize, AccessError> {
        self.check_kind(&[reference], f64::KIND)?;
        let name = || self.variables()[reference as usize].name.clone();
        self.slots[reference as usize].place.output().ok_or_else(|| AccessError::NotAnUnknown { name: name() })
    }

    /// Fails for rows that are not knowns.
    fn differentiable(&self, reference: u32, stage: Stage) -> Result<(), AccessError> {
        self.check_kind(&[reference], f64::KIND)?;
        match (self.slots[reference as usize].place, stage) {
            (Place::Input(_), _) | (Place::Parameter(_), Stage::Starting) => Ok(()),
            _ => {
                let Variable { name, .. } = &self.variables()[reference as usize];
                Err(AccessError::NotAKnown { name: name.clone() })
            }
        }
    }

    /// Evaluates the initialisation at values around the current value of a known and passes each result on with its weight; returns the
    /// step. The plant is initialised with the current value afterwards.
    fn initial_differences(
        &self,
        plant: &mut Plant,
        start_s: f64,
        known: u32,
        add: &mut dyn FnMut(&Outputs, f64),
    ) -> Result<f64, PlantError> {
        let place = self.slots[known as usize].place;
        let slot = |plant: &mut Plant, change: &mut dyn FnMut(&mut f64)| match place {
            Place::Input(place) => change(&mut plant.inputs_mut().values_mut()[place]),
            Place::Parameter(place) => change(&mut plant.parameters_mut().values_mut()[place]),
            Place::Time
            | Place::Output(_)
            | Place::Local(_)
            | Place::Duration(_)
            | Place::State(_)
            | Place::Derivative(_)
            | Place::Indicator(_) => {}
        };
        let mut value = 0.0;
        slot(plant, &mut |present| value = *present);
        let floor = if value == 0.0 || matches!(place, Place::Input(_)) { 1.0 } else { 0.0 };
        let step = match self.known(known) {
            Some(known) if is_polynomial(plant.machine(), known) => POLYNOMIAL_STEP,
            _ => INITIAL_STEP * value.abs().max(floor),
        };
        let start_at = |plant: &mut Plant, value: f64| {
            slot(plant, &mut |present| *present = value);
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
}

/// Returns whether the initial values are polynomials of an input: loads and motion of the root on a model whose start coordinates do not
/// depend on them. Motors have limits, and aerodynamic loads are not polynomials of the root's rotation.
fn is_polynomial(machine: &Machine, known: Known) -> bool {
    machine.experiment.start == StartState::Unstrained
        && match known {
            Known::Input(
                Input::Load(_) | Input::Gravity | Input::RootAcceleration | Input::RootAngularAcceleration,
            ) => true,
            Known::Input(Input::RootAngularVelocity) => machine.air.is_none(),
            Known::Input(Input::Joint(..) | Input::Wind | Input::Failure(_) | Input::Flap(_) | Input::FlapRate(_))
            | Known::Parameter(_)
            | Known::Time => false,
        }
}
