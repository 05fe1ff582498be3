//! FMI 2.0, co-simulation and Model Exchange: a [`Plant`](foldwing_engine::plant::Plant) and the variable table behind a life
//! cycle.
//!
//! The crate `foldwing-fmu` turns C calls into calls of [`Instance`]; everything here is safe Rust and tested as such.

mod error;
mod exchange;
mod instance;
mod life_cycle;
mod log;
mod resource;
mod state;

pub use error::{CallError, InstantiationError, Status};
pub use exchange::EventInfo;
pub use instance::{Instance, Request, Setup};
pub use life_cycle::{Call, InterfaceKind, Phase};
pub use log::{LOG_CATEGORIES, Log, LogCategory, Sink};
pub use resource::{MODEL_FILE, ResourceError, resource_path};
pub use state::StateError;

/// Every function that the standard demands of an FMU for co-simulation and Model Exchange, by its exact name (FMI 2.0.4,
/// sections 2.1, 3.2 and 4.2).
pub const FUNCTIONS: &[&str] = &[
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2SetDebugLogging",
    "fmi2Instantiate",
    "fmi2FreeInstance",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2Terminate",
    "fmi2Reset",
    "fmi2GetReal",
    "fmi2GetInteger",
    "fmi2GetBoolean",
    "fmi2GetString",
    "fmi2SetReal",
    "fmi2SetInteger",
    "fmi2SetBoolean",
    "fmi2SetString",
    "fmi2GetFMUstate",
    "fmi2SetFMUstate",
    "fmi2FreeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SerializeFMUstate",
    "fmi2DeSerializeFMUstate",
    "fmi2GetDirectionalDerivative",
    "fmi2SetRealInputDerivatives",
    "fmi2GetRealOutputDerivatives",
    "fmi2DoStep",
    "fmi2CancelStep",
    "fmi2GetStatus",
    "fmi2GetRealStatus",
    "fmi2GetIntegerStatus",
    "fmi2GetBooleanStatus",
    "fmi2GetStringStatus",
    "fmi2EnterEventMode",
    "fmi2NewDiscreteStates",
    "fmi2EnterContinuousTimeMode",
    "fmi2CompletedIntegratorStep",
    "fmi2SetTime",
    "fmi2SetContinuousStates",
    "fmi2GetDerivatives",
    "fmi2GetEventIndicators",
    "fmi2GetContinuousStates",
    "fmi2GetNominalsOfContinuousStates",
];
