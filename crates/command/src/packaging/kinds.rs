//! Kinds of FMU: who integrates.

use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{NotHybrid, Plant};
use foldwing_fmi::interface::Interface;
use std::fmt;
use std::sync::Arc;

/// What an importer may instantiate an FMU as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kinds {
    /// Co-simulation: the FMU integrates.
    pub co_simulation: bool,
    /// Model Exchange: the importer integrates.
    pub model_exchange: bool,
}

impl Default for Kinds {
    fn default() -> Self {
        Self { co_simulation: true, model_exchange: false }
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
    /// Refuses Model Exchange of machines whose states an importer cannot integrate.
    pub fn check(self, machine: &Machine) -> Result<(), NotHybrid> {
        if self.model_exchange && machine.air.is_some() { Err(NotHybrid::Air) } else { Ok(()) }
    }

    /// The table of variables: with the continuous states for Model Exchange.
    pub fn interface(self, machine: &Machine) -> Interface {
        match self.model_exchange {
            false => Interface::new(machine),
            true => Interface::with_states(machine, &Plant::new(Arc::new(machine.clone()))),
        }
    }
}
