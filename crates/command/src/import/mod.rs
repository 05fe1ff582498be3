//! Other people's FMUs: what their description says, and one instance driven through FMI 2.0 co-simulation.
//!
//! The crate `fmi` loads the library and calls its functions, behind bindings that bindgen makes from the official
//! headers. The description is read here: `docs/decisions/0005-foreign-fmus.md` says why.

mod description;
mod description_file;
mod error;
mod fmu;
mod image;
mod message;
mod slave;
mod unpack;

pub use description::{Datum, Description, DisplayUnit, Experiment, Kind, Unit, Variable};
pub use error::{CallError, Fault, ImportError};
pub use fmu::Fmu;
pub use message::{Message, Severity, listen};
pub use slave::{Readout, Slave, Step};
