//! Progress of a long run in the interpreter: Ctrl-C and callback.

use pyo3::prelude::*;
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

    /// Calls the interpreter now.
    ///
    /// # Errors
    /// Those of [`Self::at`].
    pub fn tell(&mut self, share: f64) -> PyResult<()> {
        self.last = Instant::now();
        Python::attach(|py| {
            py.check_signals()?;
            self.callback.as_ref().map_or(Ok(()), |callback| callback.call1(py, (share,)).map(|_| ()))
        })
    }
}
