//! One instance behind the functions of both interface types.

use crate::bindings::fmi::fmi3::callbacks::log_message;
use crate::bindings::fmi::fmi3::types::{DiscreteStatesInfo, Status};
use crate::model;
use foldwing_fmi::fmi3::Call;
use foldwing_fmi::instance::{self, CallError, Instance, InterfaceKind, Log, Manner, Request, Rule, Setup, Version};
use foldwing_fmi::interface::{Scalar, Whole};
use std::cell::RefCell;

/// An instance.
pub struct Held {
    instance: RefCell<Instance>,
}

/// The status of the component's interface.
pub fn status(of: instance::Status) -> Status {
    match of {
        instance::Status::Ok => Status::Ok,
        instance::Status::Warning => Status::Warning,
        instance::Status::Discard => Status::Discard,
        instance::Status::Error => Status::Error,
        instance::Status::Fatal => Status::Fatal,
    }
}

/// The status of a call without result.
pub fn outcome(of: Result<(), Status>) -> Status {
    of.err().unwrap_or(Status::Ok)
}

impl Held {
    /// A new instance, or none after a message with the cause.
    pub fn open(kind: InterfaceKind, name: String, token: &str, logging_on: bool, manner: Manner) -> Option<Self> {
        let fmu_type = match kind {
            InterfaceKind::ModelExchange => 0,
            InterfaceKind::CoSimulation => 1,
        };
        let request = Request {
            version: Version::Fmi3,
            name: Some(&name),
            fmu_type,
            guid: Some(token),
            resource_location: None,
            manner,
        };
        let made = model::text().and_then(|text| {
            let instance = Instance::of_text(&request, text, instance::MODEL_FILE).map_err(|error| error.to_string())?;
            // its outputs have the time that a step takes on the clock
            match foldwing_file::parse(text, instance::MODEL_FILE) {
                Ok(machine) if machine.solver.most_iterations.is_some() => Err("solver.mode = \"real_time\" needs a clock, \
                    which a WebAssembly component does not have: use the native FMU, or mode = \"accurate\""
                    .to_owned()),
                Ok(_) | Err(_) => Ok(instance),
            }
        });
        match made {
            Ok(mut instance) => {
                let sink = Box::new(move |of, category: instance::LogCategory, text: &str| {
                    log_message(&name, status(of), category.name(), text);
                });
                *instance.log_mut() = Log::new(Some(sink), logging_on);
                Some(Self { instance: RefCell::new(instance) })
            }
            Err(cause) => {
                log_message(&name, Status::Error, instance::LogCategory::Error.name(), &cause);
                None
            }
        }
    }

    /// The gate of every call: life cycle, message and status of an error.
    pub fn call<T>(&self, call: impl Into<Rule>, body: impl FnOnce(&mut Instance) -> Result<T, CallError>) -> Result<T, Status> {
        let call = call.into();
        let mut instance = self.instance.borrow_mut();
        match instance.permit(call).and_then(|()| body(&mut instance)) {
            Ok(value) => Ok(value),
            Err(error) => Err(status(instance.report(call, &error))),
        }
    }

    /// A call that is legal in no phase, since the FMU does not have its feature.
    pub fn refuse<T>(&self, call: Call) -> Result<T, Status> {
        // the life cycle refuses it before the body is executed
        match self.call(call, |_| Ok(())) {
            Ok(()) => Err(Status::Error),
            Err(status) => Err(status),
        }
    }

    /// A function of the component's interface that FMI 3.0 does not have; only that of co-simulation has one.
    #[cfg(feature = "co-simulation")]
    pub fn unknown(&self, function: &'static str) -> Status {
        let mut instance = self.instance.borrow_mut();
        let text = format!("{function}: not a function of FMI 3.0");
        instance.log_mut().refuse(instance::Status::Error, &text);
        Status::Error
    }

    pub fn get<T: Scalar + Default + Clone>(&self, call: Call, references: &[u32]) -> Result<Vec<T>, Status> {
        self.call(call, |instance| {
            let mut values = vec![T::default(); count(instance, references)];
            instance.get(Whole(references), &mut values)?;
            Ok(values)
        })
    }

    pub fn set<T: Scalar>(&self, call: Call, references: &[u32], values: &[T]) -> Status {
        outcome(self.call(call, |instance| instance.set(Whole(references), values)))
    }

    /// Values of a type without variables: none, for no reference.
    pub fn none<T>(&self, call: Call, references: &[u32], of: &'static str) -> Result<Vec<T>, Status> {
        self.call(call, |instance| instance.none_of_type(references, of).map(|()| Vec::new()))
    }

    pub fn set_logging(&self, on: bool, categories: &[String]) -> Status {
        outcome(self.call(Call::SetDebugLogging, |instance| {
            instance.log_mut().set_categories(on, categories.iter().map(String::as_str))
        }))
    }

    pub fn enter_initialization(&self, tolerance: Option<f64>, start_s: f64, stop_s: Option<f64>) -> Status {
        outcome(self.call(Call::EnterInitializationMode, |instance| {
            instance.setup_experiment(Setup { tolerance, start_s, stop_s })?;
            instance.enter_initialization();
            Ok(())
        }))
    }

    pub fn update_discrete_states(&self) -> Result<DiscreteStatesInfo, Status> {
        self.call(Call::UpdateDiscreteStates, |instance| {
            let event = instance.new_discrete_states()?;
            Ok(DiscreteStatesInfo {
                new_discrete_states_needed: false,
                terminate_simulation: false,
                nominals_of_continuous_states_changed: false,
                values_of_continuous_states_changed: event.states_changed,
                next_event_time_defined: event.next_event_s.is_some(),
                next_event_time: event.next_event_s.unwrap_or(0.0),
            })
        })
    }

    pub fn state(&self) -> Result<Vec<u8>, Status> {
        self.call(Call::GetFmuState, |instance| {
            let handle = instance.save_state(0)?;
            let bytes = instance.serialize_state(handle);
            instance.free_state(handle)?;
            bytes
        })
    }

    pub fn set_state(&self, bytes: &[u8]) -> Status {
        outcome(self.call(Call::SetFmuState, |instance| {
            let handle = instance.deserialize_state(bytes)?;
            let restored = instance.restore_state(handle);
            instance.free_state(handle)?;
            restored
        }))
    }

    pub fn directional(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Status> {
        self.call(Call::GetDirectionalDerivative, |instance| {
            let mut found = vec![0.0; count(instance, unknowns)];
            instance.array_directional_derivative((unknowns, &mut found), (knowns, seed))?;
            Ok(found)
        })
    }

    pub fn adjoint(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Status> {
        self.call(Call::GetAdjointDerivative, |instance| {
            let mut found = vec![0.0; count(instance, knowns)];
            instance.array_adjoint_derivative((unknowns, seed), (knowns, &mut found))?;
            Ok(found)
        })
    }

    pub fn output_derivatives(&self, requests: &[(u32, u32)]) -> Result<Vec<f64>, Status> {
        self.call(Call::GetOutputDerivatives, |instance| {
            let references: Vec<u32> = requests.iter().map(|(reference, _)| *reference).collect();
            // an order that is too large is refused as the largest one is
            let orders: Vec<i32> = requests.iter().map(|&(_, order)| i32::try_from(order).unwrap_or(i32::MAX)).collect();
            let mut values = vec![0.0; count(instance, &references)];
            instance.array_output_derivatives(&references, &orders, &mut values)?;
            Ok(values)
        })
    }
}

/// Number of scalars in arrays; those that do not exist have none, and are refused by the call.
fn count(instance: &Instance, references: &[u32]) -> usize {
    let arrays = instance.interface().arrays();
    references.iter().filter_map(|&reference| arrays.get(reference as usize)).map(|array| array.rows.len()).sum()
}

/// The methods that instances of both interface types have.
macro_rules! methods {
    () => {
        fn set_debug_logging(&self, logging_on: bool, categories: Vec<String>) -> Status {
            self.set_logging(logging_on, &categories)
        }

        fn enter_initialization_mode(&self, tolerance: Option<f64>, start_time: f64, stop_time: Option<f64>) -> Status {
            self.enter_initialization(tolerance, start_time, stop_time)
        }

        fn exit_initialization_mode(&self) -> Status {
            outcome(self.call(Call::ExitInitializationMode, |instance| instance.exit_initialization()))
        }

        fn enter_event_mode(&self) -> Status {
            outcome(self.call(Call::EnterEventMode, |instance| instance.enter_event()))
        }

        fn update_discrete_states(&self) -> Result<DiscreteStatesInfo, Status> {
            Held::update_discrete_states(self)
        }

        fn terminate(&self) -> Status {
            outcome(self.call(Call::Terminate, |instance| {
                instance.terminate();
                Ok(())
            }))
        }

        fn reset(&self) -> Status {
            outcome(self.call(Call::Reset, |instance| {
                instance.reset();
                Ok(())
            }))
        }

        fn enter_configuration_mode(&self) -> Status {
            outcome(self.refuse(Call::EnterConfigurationMode))
        }

        fn exit_configuration_mode(&self) -> Status {
            outcome(self.refuse(Call::ExitConfigurationMode))
        }

        fn get_float64(&self, references: Vec<u32>) -> Result<Vec<f64>, Status> {
            self.get(Call::GetFloat64, &references)
        }

        fn set_float64(&self, references: Vec<u32>, values: Vec<f64>) -> Status {
            self.set(Call::SetFloat64, &references, &values)
        }

        fn get_int32(&self, references: Vec<u32>) -> Result<Vec<i32>, Status> {
            self.get(Call::GetInt32, &references)
        }

        fn set_int32(&self, references: Vec<u32>, values: Vec<i32>) -> Status {
            self.set(Call::SetInt32, &references, &values)
        }

        fn get_boolean(&self, references: Vec<u32>) -> Result<Vec<bool>, Status> {
            self.get(Call::GetBoolean, &references)
        }

        fn set_boolean(&self, references: Vec<u32>, values: Vec<bool>) -> Status {
            self.set(Call::SetBoolean, &references, &values)
        }

        without_variables! {
            get_float32 set_float32 f32, GetFloat32 SetFloat32 "Float32";
            get_int8 set_int8 i8, GetInt8 SetInt8 "Int8";
            get_int16 set_int16 i16, GetInt16 SetInt16 "Int16";
            get_int64 set_int64 i64, GetInt64 SetInt64 "Int64";
            get_uint8 set_uint8 u8, GetUInt8 SetUInt8 "UInt8";
            get_uint16 set_uint16 u16, GetUInt16 SetUInt16 "UInt16";
            get_uint32 set_uint32 u32, GetUInt32 SetUInt32 "UInt32";
            get_uint64 set_uint64 u64, GetUInt64 SetUInt64 "UInt64";
            get_string set_string String, GetString SetString "String";
            get_binary set_binary Vec<u8>, GetBinary SetBinary "Binary";
            get_clock set_clock bool, GetClock SetClock "Clock";
        }

        fn get_number_of_variable_dependencies(&self, _: u32) -> Result<u64, Status> {
            self.refuse(Call::GetNumberOfVariableDependencies)
        }

        fn get_variable_dependencies(&self, _: u32) -> Result<Vec<VariableDependency>, Status> {
            self.refuse(Call::GetVariableDependencies)
        }

        fn get_fmu_state(&self) -> Result<Vec<u8>, Status> {
            self.state()
        }

        fn set_fmu_state(&self, state: Vec<u8>) -> Status {
            self.set_state(&state)
        }

        fn get_directional_derivative(&self, unknowns: Vec<u32>, knowns: Vec<u32>, seed: Vec<f64>) -> Result<Vec<f64>, Status> {
            self.directional(&unknowns, &knowns, &seed)
        }

        fn get_adjoint_derivative(&self, unknowns: Vec<u32>, knowns: Vec<u32>, seed: Vec<f64>) -> Result<Vec<f64>, Status> {
            self.adjoint(&unknowns, &knowns, &seed)
        }

        fn get_output_derivatives(&self, requests: Vec<(u32, u32)>) -> Result<Vec<f64>, Status> {
            self.output_derivatives(&requests)
        }

        fn get_interval_decimal(&self, _: Vec<u32>) -> Result<Vec<(f64, IntervalQualifier)>, Status> {
            self.refuse(Call::GetIntervalDecimal)
        }

        fn get_interval_fraction(&self, _: Vec<u32>) -> Result<Vec<(IntervalFraction, IntervalQualifier)>, Status> {
            self.refuse(Call::GetIntervalFraction)
        }

        fn get_shift_decimal(&self, _: Vec<u32>) -> Result<Vec<f64>, Status> {
            self.refuse(Call::GetShiftDecimal)
        }

        fn get_shift_fraction(&self, _: Vec<u32>) -> Result<Vec<IntervalFraction>, Status> {
            self.refuse(Call::GetShiftFraction)
        }

        fn set_interval_decimal(&self, _: Vec<u32>, _: Vec<f64>) -> Status {
            outcome(self.refuse(Call::SetIntervalDecimal))
        }

        fn set_interval_fraction(&self, _: Vec<u32>, _: Vec<IntervalFraction>) -> Status {
            outcome(self.refuse(Call::SetIntervalFraction))
        }

        fn set_shift_decimal(&self, _: Vec<u32>, _: Vec<f64>) -> Status {
            outcome(self.refuse(Call::SetShiftDecimal))
        }

        fn set_shift_fraction(&self, _: Vec<u32>, _: Vec<IntervalFraction>) -> Status {
            outcome(self.refuse(Call::SetShiftFraction))
        }

        fn evaluate_discrete_states(&self) -> Status {
            outcome(self.refuse(Call::EvaluateDiscreteStates))
        }
    };
}

/// Getters and setters of types without variables.
macro_rules! without_variables {
    ($($get:ident $set:ident $type:ty, $get_call:ident $set_call:ident $of:literal;)*) => { $(
        fn $get(&self, references: Vec<u32>) -> Result<Vec<$type>, Status> {
            self.none(Call::$get_call, &references, $of)
        }

        fn $set(&self, references: Vec<u32>, _: Vec<$type>) -> Status {
            outcome(self.none::<$type>(Call::$set_call, &references, $of).map(|_| ()))
        }
    )* };
}
