//! A long run seen from the interpreter: Ctrl-C, and how far it has come.

use pyo3::prelude::*;
use std::time::{Duration, Instant};

/// How often a run looks for Ctrl-C and tells of its progress.
const EVERY: Duration = Duration::from_millis(100);

/// Calls back into the interpreter at intervals, from a run that has released it.
pub struct Progress {
    callback: Option<Py<PyAny>>,
    last: Instant,
}

impl Progress {
    /// `callback` is called with the share that is done, from 0 to 1.
    pub fn new(callback: Option<Py<PyAny>>) -> Self {
        Self { callback, last: Instant::now() }
    }

    /// Lets the interpreter in if it is time.
    ///
    /// # Errors
    /// What a signal handler or the callback raises.
    pub fn at(&mut self, share: f64) -> PyResult<()> {
        if self.last.elapsed() < EVERY {
            return Ok(());
        }
        self.tell(share)
    }

    /// Lets the interpreter in now.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn tell(&mut self, share: f64) -> PyResult<()> {
        self.last = Instant::now();
        Python::attach(|py| {
            py.check_signals()?;
            self.callback.as_ref().map_or(Ok(()), |callback| callback.call1(py, (share,)).map(|_| ()))
        })
    }
}
