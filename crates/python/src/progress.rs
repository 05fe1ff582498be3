//! Progress of a long run in the interpreter: Ctrl-C and callback.

use foldwing_study::watch;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Interval at which a run checks for Ctrl-C and reports its progress.
const EVERY: Duration = Duration::from_millis(100);

/// Calls the interpreter at intervals, from a run that has released it.
pub struct Progress {
    callback: Option<Py<PyAny>>,
    last: Instant,
}

impl Progress {
    /// `callback` is called with the completed fraction, from 0 to 1.
    pub fn new(callback: Option<Py<PyAny>>) -> Self {
        Self { callback, last: Instant::now() }
    }

    /// Calls the interpreter if the interval has passed.
    ///
    /// # Errors
    /// Exceptions of a signal handler or the callback.
    pub fn at(&mut self, share: f64) -> PyResult<()> {
        if self.last.elapsed() < EVERY {
            return Ok(());
        }
        self.tell(share)
    }

    /// The watch of a study: shows the completed fraction of the current part, if its size is known, and stops the study with an
    /// exception of the interpreter, which it leaves in `raised`.
    pub fn watch<'w>(
        &'w mut self,
        raised: &'w mut Option<PyErr>,
    ) -> impl FnMut(watch::Progress) -> ControlFlow<()> + 'w {
        |watch::Progress { done, total, .. }| {
            let share = total.map(|total| done as f64 / total as f64);
            let due = self.last.elapsed() >= EVERY || share == Some(1.0);
            match if due { self.call(share) } else { Ok(()) } {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    *raised = Some(error);
                    ControlFlow::Break(())
                }
            }
        }
    }

    /// Calls the interpreter now.
    ///
    /// # Errors
    /// Those of [`Self::at`].
    pub fn tell(&mut self, share: f64) -> PyResult<()> {
        self.call(Some(share))
    }

    fn call(&mut self, share: Option<f64>) -> PyResult<()> {
        self.last = Instant::now();
        Python::attach(|py| {
            py.check_signals()?;
            match (&self.callback, share) {
                (Some(callback), Some(share)) => callback.call1(py, (share,)).map(|_| ()),
                _ => Ok(()),
            }
        })
    }
}
