//! Progress of a computation on a terminal: a line on standard error with an estimate of the remaining time.

use foldwing_study::watch;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Minimum duration of a computation that shows progress.
const PROGRESS_AFTER: Duration = Duration::from_millis(500);

/// Interval at which the line is redrawn.
const EVERY: Duration = Duration::from_millis(100);

/// Progress of a computation, displayed during the lifetime of this value if standard error is a terminal.
///
/// A separate thread draws it, so that it is also updated during a single unit of work.
pub struct Progress {
    shown: Option<Shown>,
}

struct Shown {
    work: Arc<Work>,
    /// Stops the thread when dropped.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Completed work, shared with the thread.
struct Work {
    part: Mutex<Part>,
    done: AtomicU64,
}

/// Part of a computation.
struct Part {
    /// Unit of work in the plural, or a phrase for work without units.
    what: &'static str,
    /// Number of units, if known.
    total: Option<u64>,
    began: Instant,
}

impl Progress {
    /// Shows progress over `total` units of work; `what` names the work, such as `time` or `variants`.
    pub fn of(what: &'static str, total: u64) -> Self {
        Self::new(what, Some(total))
    }

    /// Shows progress of work of unknown amount; `what` names it.
    pub fn phase(what: &'static str) -> Self {
        Self::new(what, None)
    }

    fn new(what: &'static str, total: Option<u64>) -> Self {
        if !io::stderr().is_terminal() {
            return Self { shown: None };
        }
        let part = Mutex::new(Part { what, total, began: Instant::now() });
        let work = Arc::new(Work { part, done: AtomicU64::new(0) });
        let (stop, stopped) = mpsc::channel();
        let thread = {
            let work = Arc::clone(&work);
            // without a thread only the progress line is missing
            thread::Builder::new().name("progress".to_owned()).spawn(move || draw(&work, &stopped)).ok()
        };
        Self { shown: Some(Shown { work, stop: Some(stop), thread }) }
    }

    /// Sets the number of completed units.
    pub fn at(&mut self, done: u64) {
        if let Some(shown) = &self.shown {
            shown.work.done.store(done, Ordering::Relaxed);
        }
    }

    /// Starts another part of the work.
    pub fn part(&mut self, what: &'static str, total: Option<u64>) {
        let Some(shown) = &self.shown else { return };
        let mut part = shown.work.part();
        if part.what != what || part.total != total {
            *part = Part { what, total, began: Instant::now() };
            shown.work.done.store(0, Ordering::Relaxed);
        }
    }

    /// Observer for the progress of a study; it never stops the study, since Ctrl-C ends the process.
    pub fn watch(&mut self) -> impl FnMut(watch::Progress) -> ControlFlow<()> {
        |watch::Progress { part, done, total }| {
            self.part(part, total.map(|total| total as u64));
            self.at(done as u64);
            ControlFlow::Continue(())
        }
    }
}

impl Work {
    fn part(&self) -> MutexGuard<'_, Part> {
        self.part.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // nothing depends on a panic of the thread
        }
    }
}

/// Draws the line until the sender of `stopped` is dropped, and then clears it.
fn draw(work: &Work, stopped: &Receiver<()>) {
    let mut bar: Option<(ProgressBar, bool)> = None;
    let mut wait = PROGRESS_AFTER;
    while let Err(RecvTimeoutError::Timeout) = stopped.recv_timeout(wait) {
        wait = EVERY;
        let (what, total, elapsed) = {
            let part = work.part();
            (part.what, part.total, part.began.elapsed())
        };
        let done = work.done.load(Ordering::Relaxed);
        let text = line(what, done, total, elapsed);
        let has_total = total.is_some();
        if let Some((old, _)) = bar.take_if(|(_, had_total)| *had_total != has_total) {
            old.finish_and_clear();
        }
        let (bar, _) = bar.get_or_insert_with(|| (new_bar(has_total).with_message(text.clone()), has_total));
        if let Some(total) = total {
            bar.set_length(total);
            bar.set_position(done);
        }
        bar.set_message(text);
        bar.tick();
    }
    if let Some((bar, _)) = bar {
        bar.finish_and_clear();
    }
}

/// A bar on standard error if the amount of work is known, otherwise a spinner.
fn new_bar(has_total: bool) -> ProgressBar {
    let template = if has_total { "{wide_bar} {msg}" } else { "{spinner} {msg}" };
    let style = ProgressStyle::with_template(template).expect("the template is valid");
    ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_style(style)
}

/// Text of the line: the completed fraction and the remaining time, extrapolated from the completed units, or the elapsed time
/// if the amount of work is unknown.
fn line(what: &str, done: u64, total: Option<u64>, elapsed: Duration) -> String {
    let so_far = time(elapsed);
    match total {
        Some(total) if (1..=total).contains(&done) => {
            let share = done as f64 / total as f64;
            let left = time(elapsed.mul_f64((1.0 - share) / share));
            format!("{:.0} % of the {what}, {left} left", (100.0 * share).floor())
        }
        Some(_) => format!("0 % of the {what}, {so_far} so far"),
        None if done > 0 => format!("{done} {what}, {so_far} so far"),
        None => format!("{what}, {so_far} so far"),
    }
}

/// Formats a duration with its two largest units.
fn time(duration: Duration) -> String {
    let s = duration.as_secs_f64().round() as u64;
    match (s / 3600, s / 60 % 60, s % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, min, s) => format!("{min} min {s:02} s"),
        (h, min, _) => format!("{h} h {min:02} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The estimate of the remaining time is the number of remaining units times the mean time of the completed ones.
    #[test]
    fn lines_estimate_the_time_left() {
        let at = |done, total, s| line("wind speeds", done, total, Duration::from_secs(s));
        assert_eq!(at(4, Some(16), 10), "25 % of the wind speeds, 30 s left");
        assert_eq!(at(16, Some(16), 10), "100 % of the wind speeds, 0 s left");
        assert_eq!(at(199, Some(200), 100), "99 % of the wind speeds, 1 s left");
        assert_eq!(at(1, Some(101), 1), "0 % of the wind speeds, 1 min 40 s left");
        assert_eq!(at(1, Some(7201), 1), "0 % of the wind speeds, 2 h 00 min left");
        assert_eq!(at(0, Some(16), 3), "0 % of the wind speeds, 3 s so far");
        assert_eq!(at(7, None, 3), "7 wind speeds, 3 s so far");
        assert_eq!(at(0, None, 3), "wind speeds, 3 s so far");
    }
}
