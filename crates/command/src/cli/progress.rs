//! Progress bar for long runs.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

/// Shorter runs show no progress bar.
const PROGRESS_AFTER: Duration = Duration::from_millis(500);

/// Progress bar on standard error for long runs, only on a terminal.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    steps: u64,
    what: &'static str,
    started: Instant,
}

impl Progress {
    /// Progress bar over `steps` steps; `what` follows the percentage.
    pub fn new(steps: u64, what: &'static str) -> Self {
        Self { bar: None, steps, what, started: Instant::now() }
    }

    /// Updates the bar after a step.
    pub fn at(&mut self, step: u64) {
        if self.bar.is_none() && self.started.elapsed() > PROGRESS_AFTER && io::stderr().is_terminal() {
            let style =
                ProgressStyle::with_template(&format!("{{wide_bar}} {{percent}} % {}, {{eta}} left", self.what))
                    .expect("the template is valid");
            let bar = ProgressBar::with_draw_target(Some(self.steps), ProgressDrawTarget::stderr());
            self.bar = Some(bar.with_style(style));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(step);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
