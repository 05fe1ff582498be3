//! Instance of a foreign FMU of FMI 2.0, from set-up to termination.

use crate::description::{Datum, Kind, Variable};
use crate::error::{CallError, Fault};
use crate::step::Step;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::{Fmi2Error, Fmi2Res};
use foldwing_fmi::interface::Value;
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// An instance. It is terminated and freed when dropped, if its last status allows this.
#[derive(Debug)]
pub struct Slave2 {
    /// `None` only while the instance is dropped.
    instance: Option<InstanceCS>,
    stepping: bool,
    failed: Option<Fault>,
    warnings: u64,
}

/// Variables that are read together, and their last values.
#[derive(Debug, Default)]
pub struct Readout2 {
    /// Type and index in the list of that type, in the order of the variables.
    places: Vec<(Type, usize)>,
    reals: List<f64>,
    integers: List<i32>,
    booleans: List<i32>,
    strings: List<CString>,
}

#[derive(Debug, Clone, Copy)]
enum Type {
    Real,
    Integer,
    Boolean,
    String,
}

#[derive(Debug, Default)]
struct List<T> {
    references: Vec<u32>,
    values: Vec<T>,
}

impl<T: Default> List<T> {
    fn push(&mut self, reference: u32) -> usize {
        self.references.push(reference);
        self.values.push(T::default());
        self.values.len() - 1
    }
}

impl Readout2 {
    /// Creates the readout of variables, in the given order.
    pub fn new<'a>(variables: impl IntoIterator<Item = &'a Variable>) -> Self {
        let mut readout = Self::default();
        for variable in variables {
            let reference = variable.value_reference;
            let place = match variable.kind {
                Kind::Real => (Type::Real, readout.reals.push(reference)),
                Kind::Integer | Kind::Enumeration(_) => (Type::Integer, readout.integers.push(reference)),
                Kind::Boolean => (Type::Boolean, readout.booleans.push(reference)),
                // FMI 2.0 has no opaque types
                Kind::String | Kind::Opaque => (Type::String, readout.strings.push(reference)),
            };
            readout.places.push(place);
        }
        readout
    }

    /// Last values, in the order of the variables.
    pub fn values(&self) -> impl Iterator<Item = Datum> + '_ {
        self.places.iter().map(|&(kind, at)| match kind {
            Type::Real => Datum::Number(Value::Real(self.reals.values[at])),
            Type::Integer => Datum::Number(Value::Integer(self.integers.values[at])),
            Type::Boolean => Datum::Number(Value::Boolean(self.booleans.values[at] != 0)),
            Type::String => Datum::Text(self.strings.values[at].to_string_lossy().into_owned()),
        })
    }
}

impl Slave2 {
    pub(super) fn new(instance: InstanceCS) -> Self {
        Self { instance: Some(instance), stepping: false, failed: None, warnings: 0 }
    }

    /// Number of calls with `fmi2Warning` so far.
    pub fn warnings(&self) -> u64 {
        self.warnings
    }

    /// Sets the times and, if given, the tolerance of the experiment.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn set_up(&mut self, tolerance: Option<f64>, start_s: f64, stop_s: f64) -> Result<(), CallError> {
        let set_up = |instance: &mut InstanceCS| instance.setup_experiment(tolerance, start_s, Some(stop_s));
        self.call(|| "fmi2SetupExperiment".to_owned(), set_up)
    }

    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn enter_initialization(&mut self) -> Result<(), CallError> {
        self.call(|| "fmi2EnterInitializationMode".to_owned(), Common::enter_initialization_mode)
    }

    /// Leaves Initialization Mode; steps may follow.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        self.call(|| "fmi2ExitInitializationMode".to_owned(), Common::exit_initialization_mode)?;
        self.stepping = true;
        Ok(())
    }

    /// Sets a variable.
    ///
    /// # Errors
    /// The status of the FMU, with the variable's name and value.
    pub fn set(&mut self, variable: &Variable, value: &Datum) -> Result<(), CallError> {
        let reference = [variable.value_reference];
        let setting = |function: &'static str| move || format!("{function} of {} to {value}", variable.name);
        match value {
            Datum::Number(Value::Real(value)) => {
                self.call(setting("fmi2SetReal"), |instance| instance.set_real(&reference, &[*value]))
            }
            Datum::Number(Value::Integer(value)) => {
                self.call(setting("fmi2SetInteger"), |instance| instance.set_integer(&reference, &[*value]))
            }
            Datum::Number(Value::Boolean(value)) => {
                let value = [i32::from(*value)];
                self.call(setting("fmi2SetBoolean"), |instance| instance.set_boolean(&reference, &value))
            }
            // integers of more than 32 bits exist in FMI 3.0 only
            Datum::Text(_) | Datum::Whole(_) => {
                let text = [CString::new(value.to_string().replace('\0', " ")).unwrap_or_default()];
                let set = |instance: &mut InstanceCS| instance.set_string(&reference, &text).map(|()| Fmi2Res::OK);
                self.call(setting("fmi2SetString"), set)
            }
        }
    }

    /// Reads variables.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn read(&mut self, readout: &mut Readout2) -> Result<(), CallError> {
        let Readout2 { reals, integers, booleans, strings, .. } = readout;
        if !reals.values.is_empty() {
            self.call(|| "fmi2GetReal".to_owned(), |i| i.get_real(&reals.references, &mut reals.values))?;
        }
        if !integers.values.is_empty() {
            self.call(|| "fmi2GetInteger".to_owned(), |i| i.get_integer(&integers.references, &mut integers.values))?;
        }
        if !booleans.values.is_empty() {
            self.call(|| "fmi2GetBoolean".to_owned(), |i| i.get_boolean(&booleans.references, &mut booleans.values))?;
        }
        if !strings.values.is_empty() {
            let get = |instance: &mut InstanceCS| {
                instance.get_string(&strings.references, &mut strings.values).map(|()| Fmi2Res::OK)
            };
            self.call(|| "fmi2GetString".to_owned(), get)?;
        }
        Ok(())
    }

    /// Performs a step from a communication point.
    ///
    /// # Errors
    /// The status of the FMU. `fmi2Discard` is an error unless the FMU requests the end of the simulation.
    pub fn step(&mut self, time_s: f64, step_s: f64) -> Result<Step, CallError> {
        let step = |instance: &mut InstanceCS| instance.do_step(time_s, step_s, true);
        match self.call(|| format!("fmi2DoStep from {time_s} s"), step) {
            Err(error) if error.fault == Fault::Discard => self.ended().ok_or(error).map(Step::Ended),
            Err(error) => Err(error),
            Ok(()) => Ok(Step::Done),
        }
    }

    /// Time in s at which the FMU requested the end of the simulation, if it did.
    fn ended(&mut self) -> Option<f64> {
        let instance = self.instance.as_mut()?;
        let ended = catch_unwind(AssertUnwindSafe(|| instance.terminated().unwrap_or(false))).unwrap_or(false);
        let time_s = catch_unwind(AssertUnwindSafe(|| instance.last_successful_time().ok())).ok().flatten();
        if ended { time_s } else { None }
    }

    /// The only function that converts a status of the FMU to a `Result`. A status after which no call is allowed is
    /// stored.
    fn call(
        &mut self,
        name: impl FnOnce() -> String,
        body: impl FnOnce(&mut InstanceCS) -> Result<Fmi2Res, Fmi2Error>,
    ) -> Result<(), CallError> {
        let instance = self.instance.as_mut().expect("taken by drop only");
        // the crate panics on `fmi2Pending` and on a status that the standard does not define
        let answer = catch_unwind(AssertUnwindSafe(|| body(instance)));
        let fault = match answer {
            Ok(Ok(Fmi2Res::OK)) => return Ok(()),
            Ok(Ok(Fmi2Res::Warning)) => {
                self.warnings += 1;
                return Ok(());
            }
            Ok(Err(Fmi2Error::Discard)) => Fault::Discard,
            Ok(Err(Fmi2Error::Error | Fmi2Error::TypesPlatformMismatch(_))) => Fault::Error,
            Ok(Err(Fmi2Error::Fatal)) => Fault::Fatal,
            Ok(Ok(Fmi2Res::Pending)) | Err(_) => Fault::Other,
        };
        if fault != Fault::Discard {
            self.failed = Some(fault);
        }
        Err(CallError { call: name(), fault })
    }
}

impl Drop for Slave2 {
    fn drop(&mut self) {
        let Some(mut instance) = self.instance.take() else { return };
        match self.failed {
            None if self.stepping => {
                // the status no longer has any effect
                let _ = catch_unwind(AssertUnwindSafe(|| instance.terminate()));
            }
            None | Some(Fault::Discard | Fault::Error | Fault::Early) => {}
            // after fmi2Fatal, or while a step may still be running, not even fmi2FreeInstance may be called
            Some(Fault::Fatal | Fault::Other) => std::mem::forget(instance),
        }
    }
}
