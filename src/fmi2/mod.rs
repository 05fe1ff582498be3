//! The FMI 2.0 co-simulation slave: C functions on top of [`crate::plant::Plant`] and the variable table.
//!
//! [`abi`] holds the only `unsafe` code: it turns C calls into calls of [`Instance`], behind one gate that checks
//! the handle and the life cycle and stops panics. Everything else is ordinary Rust and can be tested as such.

#[allow(unsafe_code, reason = "the C interface")]
pub mod abi;
mod error;
mod instance;
mod life_cycle;
mod log;
mod resource;
mod state;

pub use error::{CallError, InstantiationError, Status};
pub use instance::{Instance, Request, Setup};
pub use life_cycle::{Call, Phase};
pub use log::{LOG_CATEGORIES, Log, LogCategory, Sink};
pub use resource::{MODEL_FILE, ResourceError, resource_path};
pub use state::StateError;
