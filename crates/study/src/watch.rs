//! Progress of a study: the completed work, for a progress bar, and a means to stop the study.

use std::ops::ControlFlow;

/// Completed work of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// The current part of the study: the plural of its unit of work, such as `wind speeds`.
    pub part: &'static str,
    /// Number of units of this part that are done.
    pub done: usize,
    /// Number of all units of this part; `None` if it is not known in advance.
    pub total: Option<usize>,
}

/// Called at the start of a part and after every unit of work. [`ControlFlow::Break`] stops the study, which then fails with the variant
/// `Stopped` of its error.
pub type Watch<'w> = dyn FnMut(Progress) -> ControlFlow<()> + 'w;

/// The watch of a study without progress, which never stops it.
pub fn unwatched(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
