//! From a validated model to an FMU file: model description, documentation page, archive.

mod air_section;
pub mod archive;
pub mod description;
pub mod documentation;
pub mod drawing;
pub mod library;

pub use archive::{PackageError, package};
pub use description::model_description;
pub use library::{Library, Platform};

/// Name of the library inside every FMU, FMI 2.0 `modelIdentifier`.
pub const MODEL_IDENTIFIER: &str = "foldwing";

/// Version of this package, which the model description carries.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
