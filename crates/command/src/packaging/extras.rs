//! Optional contents of an archive.

use crate::packaging::{Kinds, Reference};
use foldwing_fmi::interface::LinearModel;

/// Optional contents of an archive.
#[derive(Debug, Clone, Default)]
pub struct Extras {
    /// Interface types of the FMU.
    pub kinds: Kinds,
    /// Reference results.
    pub reference: Option<Reference>,
    /// Linear model.
    pub linear: Option<LinearModel>,
}
