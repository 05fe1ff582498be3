//! The variable table: name, causality, unit, start value and meaning of every variable, bound to the plant.
//!
//! It is the single source for the model description, the FMI calls, `foldwing check`, CSV columns and the documentation page.

mod access;
mod air;
mod arrays;
mod cause;
mod checks;
mod counter;
mod counters;
mod dependencies;
mod derivatives;
mod guid;
mod hinge_dependencies;
mod joints;
mod known;
mod linear;
mod no_slips;
mod operating_point;
mod point_dependencies;
mod rows;
mod slopes;
mod state_dependencies;
mod states;
mod table;
mod topology;
mod units;
mod variable;

pub use access::{AccessError, Kind, Scalar, Stage};
pub use arrays::{Array, Selection, Whole};
pub use derivatives::DerivativeError;
pub use guid::guid;
pub use linear::{GUSTS, LinearModel, LinearSignal, Reduction, reduce_any};
pub use operating_point::{Acting, JointPoint, OperatingPoint};
pub use table::{Shape, Signal};
pub use units::{BASES, RealType, TYPES, UNITS, Unit};
pub use variable::{Causality, Dependencies, DependencyKind, Initial, MAXIMUM_LISTED, Value, Variability, Variable};

use access::Slot;
use cause::Depends;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{OutputSet, Outputs, Plant};
use known::Known;
use rows::Integrator;
use std::collections::HashMap;
use table::{Bound, Place};

/// The table of one model.
pub struct Interface {
    variables: Vec<Variable>,
    slots: Vec<Slot>,
    bounds: Vec<Bound>,
    depends: Vec<Depends>,
    signals: Vec<Signal>,
    references: HashMap<String, u32>,
    nominals: Vec<f64>,
    /// Body of each coordinate among the continuous states; the coordinates precede their rates.
    coordinates: Vec<usize>,
    arrays: arrays::Arrays,
    /// Whether the aerodynamic model of the machine, if any, can be linearised.
    linear_air: bool,
}

impl Interface {
    /// The table of a model. Row 0 is `time`.
    pub fn new(machine: &Machine) -> Self {
        Self::of(rows::build(machine, Integrator::Own), machine, Vec::new())
    }

    /// The table with the continuous states and their derivatives at its end, for Model Exchange. `plant` is a plant of the machine; the
    /// energy accounts are in the table if they are states of it
    /// ([`keep_exchange_accounts`](foldwing_engine::plant::System::keep_exchange_accounts)).
    pub fn with_states(machine: &Machine, plant: &Plant) -> Self {
        let mut table = rows::build(machine, Integrator::Importer { accounts: plant.keeps_exchange_accounts() });
        let coordinates = states::add(&mut table, plant);
        Self::of(table, machine, coordinates)
    }

    /// The table of [`Self::with_states`] with the event indicators after the states, for Model Exchange of FMI 3.0.
    pub fn with_states_and_indicators(machine: &Machine, plant: &Plant) -> Self {
        let mut table = rows::build(machine, Integrator::Importer { accounts: plant.keeps_exchange_accounts() });
        let coordinates = states::add(&mut table, plant);
        states::add_indicators(&mut table, plant);
        Self::of(table, machine, coordinates)
    }

    /// The same table without arrays: in FMI 3.0 each row is then a separate variable, with its name and value reference in FMI 2.0.
    pub fn in_scalars(mut self) -> Self {
        self.arrays = arrays::Arrays::scalars(&self.variables);
        self
    }

    /// The same table for a description whose outputs are all Real: outputs of other types are local variables. An instance has the table with
    /// all outputs, and the same values under the same references.
    pub fn with_real_outputs_only(mut self) -> Self {
        for row in &mut self.variables {
            if row.causality == Causality::Output && row.value.kind() != Kind::Real {
                row.causality = Causality::Local;
            }
        }
        self
    }

    fn of(table: table::Table, machine: &Machine, coordinates: Vec<usize>) -> Self {
        let table::Table { variables, bounds, signals, depends, .. } = table;
        let nominals = variables.iter().filter_map(|row| row.nominal).collect();
        let slots = variables.iter().zip(&bounds).map(|(variable, bound)| Slot::new(variable, bound)).collect();
        let references = variables.iter().map(|row| (row.name.clone(), row.value_reference)).collect();
        let linear_air = machine.air.as_ref().is_some_and(|air| air.is_linearised());
        let arrays = arrays::Arrays::new(&signals);
        Self { variables, slots, bounds, depends, signals, references, nominals, coordinates, arrays, linear_air }
    }

    /// Sets the start values of the continuous states: those of `plant`, initialised with the default start values. They are for the model
    /// description; initial values of an instance do not depend on them.
    pub fn give_start_states(&mut self, plant: &Plant) {
        for (row, bound) in self.variables.iter_mut().zip(&self.bounds) {
            if let Place::State(state) = bound.place {
                row.initial = Some(Initial::Approximate);
                row.value = Value::Real(plant.exchange_state(state));
            }
        }
    }

    /// All signals in the order of their rows, which FMI 2.0 flattens into [`Self::variables`].
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// All rows; a row's position is its value reference.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Dependencies of each row, in the order of the rows. `machine` is that of the table.
    ///
    /// Every output is compared with every input and parameter, which takes longer than the rest of an instantiation without aerodynamics.
    /// The model description needs the result, an instance does not.
    pub fn dependencies(&self, machine: &Machine) -> Vec<Dependencies> {
        let knowns = (0..).zip(&self.bounds).filter_map(|(reference, bound)| Some((reference, bound.known?)));
        let rows = self.bounds.iter().map(|bound| bound.depends.map(|depends| &self.depends[depends]));
        let mut found = dependencies::find(machine, &knowns.collect::<Vec<_>>(), rows);
        self.add_states_to(&mut found, machine);
        found
    }

    /// Returns the row of a name.
    pub fn find(&self, name: &str) -> Option<&Variable> {
        self.references.get(name).map(|&reference| &self.variables[reference as usize])
    }

    /// Index of an output's value in [`Outputs::values`]; `None` for rows that are not outputs of the model.
    pub fn output_index(&self, value_reference: u32) -> Option<usize> {
        self.bounds.get(value_reference as usize)?.place.output()
    }

    /// Index of an input's value in [`Inputs::values`](foldwing_engine::plant::Inputs::values); `None` for rows that are not inputs.
    pub fn input_index(&self, value_reference: u32) -> Option<usize> {
        self.bounds.get(value_reference as usize)?.place.input()
    }

    /// Current value: of inputs and parameters from the plant, of outputs from `outputs`.
    pub fn get(&self, plant: &Plant, outputs: &Outputs, value_reference: u32) -> Option<Value> {
        self.slots.get(value_reference as usize).map(|slot| slot.read(plant, outputs))
    }

    /// Sets an input or parameter, including fixed ones (they act at the next [`Plant::initialize`]); the type must be that of the row and
    /// the value within its range.
    pub fn set(&self, plant: &mut Plant, value_reference: u32, value: Value) -> Result<(), AccessError> {
        let slot = self.check(value_reference, value, Stage::Starting)?;
        slot.write(plant, value, Stage::Starting);
        Ok(())
    }

    /// Outputs that a plant must have computed before these rows are read; rows that do not exist need none.
    pub fn needs(&self, selection: impl Selection) -> OutputSet {
        let slots = selection.heads(self).filter_map(|reference| self.slots.get(reference as usize));
        slots.fold(OutputSet::NONE, |needs, slot| needs | slot.needs)
    }

    /// Reads many rows of one type; nothing is written to `values` unless all can be read.
    ///
    /// There is a value for each row. The plant must have computed the outputs given by [`Interface::needs`]. Allocates nothing.
    pub fn get_all<T: Scalar>(
        &self,
        plant: &Plant,
        selection: impl Selection,
        values: &mut [T],
    ) -> Result<(), AccessError> {
        selection.check(self, T::KIND, values.len())?;
        debug_assert!(plant.provides(self.needs(selection)), "outputs of an earlier time");
        let outputs = plant.outputs();
        let mut values = values.iter_mut();
        for block in selection.blocks(self) {
            for (&reference, value) in block.iter().zip(&mut values) {
                if let Some(read) = T::from_value(self.slots[reference as usize].read(plant, outputs)) {
                    *value = read;
                }
            }
        }
        Ok(())
    }

    /// Sets many inputs and parameters of one type; on an error, none is set.
    ///
    /// There is a value for each row. Allocates nothing unless it fails.
    pub fn set_all<T: Scalar, S: Selection>(
        &self,
        plant: &mut Plant,
        selection: S,
        values: &[T],
        stage: Stage,
    ) -> Result<(), AccessError> {
        if S::ALIKE {
            selection.check(self, T::KIND, values.len())?;
        }
        let mut left = values;
        for block in selection.blocks(self) {
            let (these, others) = left.split_at(block.len().min(left.len()));
            left = others;
            let mut pairs = block.iter().zip(these).map(|(&reference, &value)| (reference, value.into_value()));
            if S::ALIKE
                && let Some((reference, value)) = pairs.next()
            {
                let head = self.check(reference, value, stage)?;
                pairs.try_for_each(|(reference, value)| self.check_beside(head, reference, value))?;
            } else {
                pairs.try_for_each(|(reference, value)| self.check(reference, value, stage).map(|_| ()))?;
            }
        }
        let mut values = values.iter();
        for block in selection.blocks(self) {
            for (&reference, &value) in block.iter().zip(&mut values) {
                self.slots[reference as usize].write(plant, value.into_value(), stage);
            }
        }
        Ok(())
    }

    /// The known that a row represents, if others may depend on it.
    fn known(&self, value_reference: u32) -> Option<Known> {
        self.bounds.get(value_reference as usize).and_then(|bound| bound.known)
    }

    /// Returns whether a row is neither an input nor a parameter set by the importer.
    pub fn moves(&self, value_reference: u32) -> bool {
        self.variables
            .get(value_reference as usize)
            .is_some_and(|row| !matches!(row.causality, Causality::Input | Causality::Parameter))
    }

    /// Returns whether the value of a row comes from the last evaluation (outputs and locals).
    pub fn is_computed(&self, value_reference: u32) -> bool {
        self.slots.get(value_reference as usize).is_some_and(|slot| slot.is_computed())
    }
}

#[cfg(test)]
mod tests;
