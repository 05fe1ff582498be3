//! Packaging of a validated model as an FMU: model description, documentation page, icon, licences, reference results,
//! archive.

mod air_section;
pub mod archive;
pub mod contents;
pub mod cross_check;
pub mod description;
mod description3;
pub mod documentation;
pub mod drawing;
mod extras;
mod html;
pub mod icon;
mod kinds;
pub mod library;
pub mod licenses;
pub mod linear_model;
pub mod palette;
pub mod reference;
pub mod sketch;
pub mod ssp;
mod terminals;
mod use_section;
mod xml;

pub use archive::package;
pub use cross_check::CrossCheck;
pub use description::model_description;
pub use extras::Extras;
pub use kinds::Kinds;
pub use library::{Library, PackageError, Platform};
pub use reference::Reference;

/// Name of this program in `generationTool`.
pub const TOOL: &str = "foldwing";

/// Version of this package, written into the model description.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
