//! Values and derivatives of variables.

use crate::instance::error::CallError;
use crate::instance::log::LogCategory;
use crate::instance::status::Status;
use crate::instance::{Instance, InterfaceKind, Phase};
use crate::interface::{AccessError, DerivativeError, Interface, Kind, Scalar, Selection, Stage, Whole};
use foldwing_engine::plant::Plant;

/// Rows and their seeds.
type Seeds<'a> = (&'a [u32], &'a [f64]);

impl Instance {
    /// Reads variables of one type; in Initialization Mode computed values are evaluated first.
    pub fn get<T: Scalar>(&mut self, selection: impl Selection, values: &mut [T]) -> Result<(), CallError> {
        if self.stale && selection.heads(&self.interface).any(|reference| self.interface.is_computed(reference)) {
            // an invalid call changes nothing
            selection.check(&self.interface, T::KIND, values.len())?;
            self.evaluate()?;
        }
        self.update(selection, T::KIND, values.len())?;
        let needs = self.interface.needs(selection);
        self.read = self.read | needs;
        // importers read the same variables after every step: one evaluation serves all their calls
        if !self.plant.provides(needs) {
            self.plant.provide(self.read | self.read_before);
        }
        Ok(self.interface.get_all(&self.plant, selection, values)?)
    }

    /// Sets inputs and parameters of one type: all of them or, on an error, none.
    pub fn set<T: Scalar, S: Selection>(&mut self, selection: S, values: &[T]) -> Result<(), CallError> {
        let stage = self.stage();
        self.refuse_discrete(selection)?;
        self.interface.set_all(&mut self.plant, selection, values, stage)?;
        if stage == Stage::Starting
            && self.log.wants(LogCategory::Warning)
            && let Some(state) = selection.heads(&self.interface).find(|&reference| self.interface.is_state(reference))
        {
            let name = &self.interface.variables()[state as usize].name;
            let text = format!(
                "the start value of continuous state {name} is not used: initial states follow from inputs and parameters; set those"
            );
            self.log.write(Status::Warning, LogCategory::Warning, &text);
        }
        self.plant.system_mut().exchange_inputs_set();
        self.stale |= stage == Stage::Starting && selection.heads(&self.interface).next().is_some();
        Ok(())
    }

    /// Fails for variables that may not change during the integration: switches in Continuous-Time Mode, and within steps of an importer
    /// that uses Event Mode tunable parameters too.
    fn refuse_discrete(&self, selection: impl Selection) -> Result<(), CallError> {
        let passing = match self.phase {
            // tunable parameters act like continuous inputs: optimisers set them at any time
            Phase::ContinuousTime => return self.refuse(selection, |reference| self.interface.is_switch(reference)),
            Phase::StepComplete => self.manner.event_mode,
            Phase::Instantiated
            | Phase::Initialization
            | Phase::StepFailed
            | Phase::Terminated
            | Phase::Fatal
            | Phase::Event
            | Phase::IntermediateUpdate => false,
        };
        if !passing {
            return Ok(());
        }
        self.refuse(selection, |reference| self.interface.is_set_at_events(reference))
    }

    /// Fails for variables that can be set at events only.
    fn refuse(&self, selection: impl Selection, at_events: impl Fn(u32) -> bool) -> Result<(), CallError> {
        match selection.heads(&self.interface).find(|&reference| at_events(reference)) {
            None => Ok(()),
            Some(reference) => {
                let row = self.interface.variables().get(reference as usize);
                let name = row.map_or_else(|| format!("of value reference {reference}"), |row| row.name.clone());
                Err(CallError::OnlyContinuousInputs { version: self.version, phase: self.phase, name })
            }
        }
    }

    /// Stage for setting and differentiating.
    fn stage(&self) -> Stage {
        match self.phase {
            Phase::Instantiated | Phase::Initialization => Stage::Starting,
            Phase::Event | Phase::ContinuousTime | Phase::Terminated if self.kind == InterfaceKind::ModelExchange => {
                Stage::Exchanging
            }
            Phase::StepComplete
            | Phase::StepFailed
            | Phase::Terminated
            | Phase::Fatal
            | Phase::Event
            | Phase::ContinuousTime
            | Phase::IntermediateUpdate => Stage::Running,
        }
    }

    /// Sets time derivatives of inputs, for the next step only.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), CallError> {
        Ok(self.interface.set_input_rates(&mut self.plant, references, orders, values)?)
    }

    /// Time derivatives of outputs.
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), CallError> {
        Ok(self.interface.output_rates(&mut self.plant, references, orders, values)?)
    }

    /// Time derivatives of array outputs, with one order of differentiation for each array.
    pub fn array_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), CallError> {
        let rows = self.rows_of(references, values.len())?;
        let lengths = Whole(references).blocks(&self.interface).map(<[u32]>::len);
        let orders: Vec<i32> =
            orders.iter().zip(lengths).flat_map(|(&order, length)| std::iter::repeat_n(order, length)).collect();
        self.output_derivatives(&rows, &orders, values)
    }

    /// Directional derivative of rows with respect to rows.
    pub fn directional_derivative(
        &mut self,
        unknowns: (&[u32], &mut [f64]),
        knowns: Seeds<'_>,
    ) -> Result<(), CallError> {
        if self.stage() == Stage::Exchanging {
            return self.differentiate_exchange(|interface, plant| {
                interface.exchange_directional_derivative(plant, unknowns, knowns)
            });
        }
        let when = (self.stage(), self.experiment.start_s);
        self.differentiate(|interface, plant| interface.directional_derivative(plant, when, unknowns, knowns))
    }

    /// Directional derivative of arrays with respect to arrays.
    pub fn array_directional_derivative(
        &mut self,
        unknowns: (&[u32], &mut [f64]),
        knowns: Seeds<'_>,
    ) -> Result<(), CallError> {
        let (of, by) = (self.rows_of(unknowns.0, unknowns.1.len())?, self.rows_of(knowns.0, knowns.1.len())?);
        self.directional_derivative((&of, unknowns.1), (&by, knowns.1))
    }

    /// Adjoint derivative of arrays with respect to arrays: `Σ seed · ∂unknown/∂known` per known.
    pub fn array_adjoint_derivative(
        &mut self,
        unknowns: Seeds<'_>,
        knowns: (&[u32], &mut [f64]),
    ) -> Result<(), CallError> {
        let (of, by) = (self.rows_of(unknowns.0, unknowns.1.len())?, self.rows_of(knowns.0, knowns.1.len())?);
        if self.stage() == Stage::Exchanging {
            return self.differentiate_exchange(|interface, plant| {
                interface.exchange_adjoint_derivative(plant, (&of, unknowns.1), (&by, knowns.1))
            });
        }
        let when = (self.stage(), self.experiment.start_s);
        self.differentiate(|interface, plant| {
            interface.adjoint_derivative(plant, when, (&of, unknowns.1), (&by, knowns.1))
        })
    }

    /// Computes derivatives for the integrator of an importer. In Event Mode, inputs already act as they will after the event, which is
    /// executed later.
    fn differentiate_exchange(
        &mut self,
        find: impl FnOnce(&Interface, &mut Plant) -> Result<(), DerivativeError>,
    ) -> Result<(), CallError> {
        self.evaluate()?;
        let before = self.plant.snapshot();
        self.plant.system_mut().leave_exchange_event();
        let outcome = match find(&self.interface, &mut self.plant) {
            Ok(()) => Ok(()),
            Err(DerivativeError::Access(error)) => Err(error.into()),
            Err(DerivativeError::Plant(error)) => self.found(|_| Err(error)),
        };
        self.plant.restore(&before)?;
        outcome
    }

    /// Evaluates the start values if necessary, and computes derivatives.
    fn differentiate(
        &mut self,
        find: impl FnOnce(&Interface, &mut Plant) -> Result<(), DerivativeError>,
    ) -> Result<(), CallError> {
        if self.machine.air.is_some() {
            return Err(CallError::DerivativesInAir);
        }
        // an invalid call changes nothing: the evaluation is rolled back with it
        let before = self.stale.then(|| self.plant.snapshot());
        let outcome = self.evaluate().and_then(|()| {
            find(&self.interface, &mut self.plant).map_err(|error| match error {
                DerivativeError::Access(error) => error.into(),
                DerivativeError::Plant(error) => error.into(),
            })
        });
        if let (Err(_), Some(before)) = (&outcome, before) {
            self.plant.restore(&before)?;
            self.stale = true;
        }
        outcome
    }

    /// Rows of arrays of real numbers with `count` values in total.
    fn rows_of(&self, references: &[u32], count: usize) -> Result<Vec<u32>, CallError> {
        Whole(references).check(&self.interface, Kind::Real, count)?;
        Ok(Whole(references).blocks(&self.interface).flatten().copied().collect())
    }

    /// Fails for every reference: there are no strings.
    pub fn no_strings(&self, references: &[u32]) -> Result<(), CallError> {
        Ok(self.interface.check_kind(references, Kind::String)?)
    }

    /// Fails for every reference of a type of FMI 3.0 without variables.
    pub fn none_of_type(&self, references: &[u32], of: &'static str) -> Result<(), CallError> {
        let found: Result<(), AccessError> =
            references.iter().try_for_each(|&reference| self.interface.check_array_type(reference, of));
        Ok(found?)
    }
}
