//! Other people's FMUs: what their description says, and one instance driven through co-simulation of FMI 2.0 or 3.0.
//!
//! The crate `fmi` loads the library and calls its functions, behind bindings that bindgen makes from the official
//! headers. The description is read here: `docs/decisions/0005-foreign-fmus.md` says why.

mod description;
mod description3;
mod description_file;
mod error;
mod fmu;
mod image;
mod message;
mod slave;
mod slave2;
mod slave3;
mod unpack;

pub use description::{Datum, Description, DisplayUnit, Element, Experiment, Kind, NativeType, Unit, Variable};
pub use error::{CallError, Fault, ImportError};
pub use fmu::Fmu;
pub use message::{Message, Severity, listen};
pub use slave::{Readout, Slave, Step};
pub use slave2::{Readout2, Slave2};
pub use slave3::{Readout3, Slave3};
