//! FMI version and interface types of an FMU.

use crate::packaging::{description, description3};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{NotHybrid, Plant};
use foldwing_fmi::instance::Version;
use foldwing_fmi::interface::{Array, Interface, Variable, guid};
use std::fmt;
use std::sync::Arc;

/// Interface types of an FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kinds {
    /// Version of the standard.
    pub version: Version,
    /// Co-simulation: the FMU integrates the equations.
    pub co_simulation: bool,
    /// Model Exchange: the importer integrates the equations.
    pub model_exchange: bool,
    /// Whether an FMI 3.0 FMU has scalars instead of arrays.
    pub scalars: bool,
    /// In Model Exchange alone, the energy accounts as continuous states; with co-simulation they always are.
    pub accounts: bool,
    /// Whether outputs that are not Real are local variables of the description. Values, references and tokens are those of the same FMU
    /// with all outputs.
    pub real_outputs_only: bool,
}

impl Default for Kinds {
    fn default() -> Self {
        Self {
            version: Version::Fmi2,
            co_simulation: true,
            model_exchange: false,
            scalars: false,
            accounts: false,
            real_outputs_only: false,
        }
    }
}

impl fmt::Display for Kinds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match (self.co_simulation, self.model_exchange) {
            (_, false) => "co-simulation",
            (false, true) => "Model Exchange",
            (true, true) => "co-simulation and Model Exchange",
        })
    }
}

impl Kinds {
    /// Returns an error for Model Exchange if an importer cannot integrate all states of the machine.
    pub fn check(self, machine: &Machine) -> Result<(), NotHybrid> {
        let sampled = machine.air.as_ref().is_some_and(|air| !air.is_continuous());
        match self.model_exchange {
            true if sampled => Err(NotHybrid::Air),
            true if machine.sliding_joint().is_some() => Err(NotHybrid::Sliding),
            true if machine.closures.iter().any(|closure| closure.rigid) => Err(NotHybrid::RigidLoop),
            true if !machine.no_slips.is_empty() => Err(NotHybrid::NoSlip),
            true | false => Ok(()),
        }
    }

    /// Returns the variable table, for Model Exchange with the continuous states and their start values.
    pub fn interface(self, machine: &Machine) -> Interface {
        let all = self.with_all_outputs(machine);
        if self.real_outputs_only { all.with_real_outputs_only() } else { all }
    }

    /// The table of the library, which is independent of the choice of outputs.
    fn with_all_outputs(self, machine: &Machine) -> Interface {
        let arrays = if self.model_exchange { self.with_states(machine) } else { Interface::new(machine) };
        if self.scalars { arrays.in_scalars() } else { arrays }
    }

    /// Whether the table has the energy accounts: always with co-simulation, because one table serves both interface types.
    pub fn keeps_accounts(self) -> bool {
        self.co_simulation || self.accounts
    }

    fn with_states(self, machine: &Machine) -> Interface {
        let mut plant = Plant::new(Arc::new(machine.clone()));
        plant.system_mut().keep_exchange_accounts(self.keeps_accounts());
        let mut interface = match self.version {
            Version::Fmi2 => Interface::with_states(machine, &plant),
            Version::Fmi3 => Interface::with_states_and_indicators(machine, &plant),
        };
        // the start values are a valid state for importers that start from the description; a model without an
        // initial state has none
        let started = plant.initialize(machine.experiment.start_time_s).is_ok();
        if started && plant.system_mut().begin_exchange().is_ok() {
            interface.give_start_states(&plant);
        }
        interface
    }

    /// Returns the GUID of FMI 2.0 or the instantiation token of FMI 3.0 for the table of [`Kinds::interface`] with all outputs.
    pub fn token(self, interface: &Interface, model_text: &str) -> String {
        match self.version {
            Version::Fmi2 => guid(model_text, interface.variables()),
            Version::Fmi3 => interface.instantiation_token(model_text),
        }
    }

    /// Returns the `modelDescription.xml` of a machine with the model file `model_text`.
    pub fn model_description(self, machine: &Machine, interface: &Interface, model_text: &str) -> String {
        let dependencies = interface.dependencies(machine);
        let token = match self.real_outputs_only {
            true => self.token(&self.with_all_outputs(machine), model_text),
            false => self.token(interface, model_text),
        };
        match self.version {
            Version::Fmi2 => {
                description::model_description(machine, interface.variables(), &dependencies, &token, self)
            }
            Version::Fmi3 => description3::model_description(machine, interface, &dependencies, &token, self),
        }
    }

    /// Variables of the FMU; for FMI 3.0 one row per array, with its dimensions in its name.
    pub fn variables(self, interface: &Interface) -> Vec<Variable> {
        match self.version {
            Version::Fmi2 => interface.variables().to_vec(),
            Version::Fmi3 => interface.arrays().iter().map(|array| shown(interface, array)).collect(),
        }
    }

    /// Returns the version number of the standard.
    pub fn standard(self) -> &'static str {
        match self.version {
            Version::Fmi2 => "2.0",
            Version::Fmi3 => "3.0",
        }
    }
}

/// An array as a row of a list.
fn shown(interface: &Interface, array: &Array) -> Variable {
    let lengths: Vec<String> = array.dimensions.iter().map(usize::to_string).collect();
    let name = match lengths.as_slice() {
        [] => array.name.clone(),
        lengths => format!("{}[{}]", array.name, lengths.join(", ")),
    };
    Variable { name, description: array.description.clone(), ..interface.head(array).clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldwing_fmi::interface::{Causality, Kind};

    const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/models/folding_wing.toml");

    /// In both versions, for both interface types: outputs of other types than Real are local, everything else is the same row, and the
    /// description has the token of the FMU with all outputs, which the library has.
    #[test]
    fn real_outputs_only_leaves_the_rest_local() {
        let text = std::fs::read_to_string(MODEL).unwrap();
        let machine = foldwing_file::parse(&text, MODEL).unwrap();
        for version in [Version::Fmi2, Version::Fmi3] {
            for (co_simulation, model_exchange) in [(true, false), (false, true), (true, true)] {
                let all = Kinds { version, co_simulation, model_exchange, ..Kinds::default() };
                let only = Kinds { real_outputs_only: true, ..all };
                let (before, after) = (all.interface(&machine), only.interface(&machine));
                let mut hidden = 0;
                assert_eq!(before.variables().len(), after.variables().len());
                for (was, is) in before.variables().iter().zip(after.variables()) {
                    let other = was.causality == Causality::Output && was.value.kind() != Kind::Real;
                    hidden += usize::from(other);
                    let expected = if other { Causality::Local } else { was.causality };
                    assert_eq!(is.causality, expected, "{}", was.name);
                    assert_eq!((&is.name, is.value_reference), (&was.name, was.value_reference));
                }
                assert!(hidden > 0, "the latch is a Boolean output");
                let token = all.token(&before, &text);
                let [plain, real] = [(all, before), (only, after)]
                    .map(|(kinds, interface)| kinds.model_description(&machine, &interface, &text));
                assert!(plain.contains(&token) && real.contains(&token), "{only:?}");
                let causality = |text: &str| {
                    let place = text.find("name=\"fold.latched\"").unwrap();
                    text[place..].split("causality=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()
                };
                assert_eq!((causality(&plain).as_str(), causality(&real).as_str()), ("output", "local"));
            }
        }
    }
}
