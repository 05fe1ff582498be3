//! Instance of a foreign FMU of either version, from set-up to termination.

use crate::description::{Datum, Variable};
use crate::error::CallError;
use crate::slave2::{Readout2, Slave2};
use crate::slave3::{Readout3, Slave3};
use crate::step::Step;

/// An instance. It is terminated and freed when dropped, if its last status allows this.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "a run has one, and nothing copies it")]
pub enum Slave {
    /// FMI 2.0.
    Fmi2(Slave2),
    /// FMI 3.0.
    Fmi3(Slave3),
}

/// Variables that are read together, and their last values.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "a run has a few, and nothing copies it")]
pub enum Readout {
    /// FMI 2.0.
    Fmi2(Readout2),
    /// FMI 3.0.
    Fmi3(Readout3),
}

impl Readout {
    /// Creates the readout of variables of one FMU, in the given order.
    pub fn new<'a>(variables: impl IntoIterator<Item = &'a Variable> + Clone) -> Self {
        let third = variables.clone().into_iter().any(|variable| variable.element.is_some());
        if third { Self::Fmi3(Readout3::new(variables)) } else { Self::Fmi2(Readout2::new(variables)) }
    }

    /// Last values, in the order of the variables.
    pub fn values(&self) -> Box<dyn Iterator<Item = Datum> + '_> {
        match self {
            Self::Fmi2(readout) => Box::new(readout.values()),
            Self::Fmi3(readout) => Box::new(readout.values()),
        }
    }
}

impl Slave {
    /// Number of calls with `fmi2Warning` or `fmi3Warning` so far.
    pub fn warnings(&self) -> u64 {
        match self {
            Self::Fmi2(slave) => slave.warnings(),
            Self::Fmi3(slave) => slave.warnings(),
        }
    }

    /// Sets the times and, if given, the tolerance of the experiment.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn set_up(&mut self, tolerance: Option<f64>, start_s: f64, stop_s: f64) -> Result<(), CallError> {
        match self {
            Self::Fmi2(slave) => slave.set_up(tolerance, start_s, stop_s),
            Self::Fmi3(slave) => {
                slave.set_up(tolerance, start_s, stop_s);
                Ok(())
            }
        }
    }

    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn enter_initialization(&mut self) -> Result<(), CallError> {
        match self {
            Self::Fmi2(slave) => slave.enter_initialization(),
            Self::Fmi3(slave) => slave.enter_initialization(),
        }
    }

    /// Leaves Initialization Mode; steps may follow.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        match self {
            Self::Fmi2(slave) => slave.exit_initialization(),
            Self::Fmi3(slave) => slave.exit_initialization(),
        }
    }

    /// Sets variables. Elements of one array of FMI 3.0 are set together; the other elements keep the values set last.
    ///
    /// # Errors
    /// The status of the FMU, with the variable's name and value.
    pub fn set<'a>(&mut self, values: impl IntoIterator<Item = (&'a Variable, Datum)>) -> Result<(), CallError> {
        match self {
            Self::Fmi2(slave) => values.into_iter().try_for_each(|(variable, value)| slave.set(variable, &value)),
            Self::Fmi3(slave) => slave.set(values),
        }
    }

    /// Reads variables.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn read(&mut self, readout: &mut Readout) -> Result<(), CallError> {
        match (self, readout) {
            (Self::Fmi2(slave), Readout::Fmi2(readout)) => slave.read(readout),
            (Self::Fmi3(slave), Readout::Fmi3(readout)) => slave.read(readout),
            // there is nothing to read
            _ => Ok(()),
        }
    }

    /// Performs a step from a communication point.
    ///
    /// # Errors
    /// The status of the FMU. In FMI 2.0, `fmi2Discard` is an error unless the FMU requests the end of the simulation.
    pub fn step(&mut self, time_s: f64, step_s: f64) -> Result<Step, CallError> {
        match self {
            Self::Fmi2(slave) => slave.step(time_s, step_s),
            Self::Fmi3(slave) => slave.step(time_s, step_s),
        }
    }
}
