//! The functions of FMI 3.0 as a component of WebAssembly, as the draft of the layered standard FMI-LS-WASM has them, over `foldwing-fmi`.
//!
//! The model file is in the component ([`model`]), so that it needs no access to the resources of the FMU. A panic ends the component's
//! instance: WebAssembly has no way to catch it.

#[cfg(all(feature = "co-simulation", feature = "model-exchange"))]
compile_error!("a component has one world: co-simulation or model-exchange");

#[cfg(feature = "co-simulation")]
mod bindings {
    wit_bindgen::generate!({ world: "co-simulation-fmu", path: "../wit" });
}
#[cfg(not(feature = "co-simulation"))]
mod bindings {
    wit_bindgen::generate!({ world: "model-exchange-fmu", path: "../wit" });
}

#[macro_use]
mod common;
#[cfg(feature = "co-simulation")]
mod co_simulation;
mod model;
#[cfg(not(feature = "co-simulation"))]
mod model_exchange;

/// The FMU.
struct Fmu;

impl bindings::exports::fmi::fmi3::common::Guest for Fmu {
    fn get_version() -> String {
        "3.0".to_owned()
    }
}

bindings::export!(Fmu with_types_in bindings);
