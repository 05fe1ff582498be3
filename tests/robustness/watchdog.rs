//! Ends the test with a message that names the current action if this takes too long: no call may hang. The limit is processor time, so
//! that a busy computer does not end the test; for a call that waits without computing, it is twenty times as long in wall-clock time.

#![allow(dead_code, reason = "each test uses a part of it")]

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// A wall-clock time, and the processor time of this process in s where the system provides it.
#[derive(Clone, Copy)]
struct Moment(Instant, Option<f64>);

impl Moment {
    fn now() -> Self {
        Self(Instant::now(), processor_s())
    }

    /// Returns whether this many seconds of processor time, used by all tests of the program together, have passed.
    fn is_past(self, limit_s: f64) -> bool {
        let tests = thread::available_parallelism().map_or(1.0, |count| count.get() as f64);
        let clock_s = self.0.elapsed().as_secs_f64();
        match (self.1, processor_s()) {
            (Some(then_s), Some(now_s)) => now_s - then_s > limit_s * tests || clock_s > 20.0 * limit_s,
            (None, _) | (_, None) => clock_s > limit_s,
        }
    }
}

/// From the Linux file of a process, in ticks of 10 ms: valgrind does not support the call with finer resolution.
fn processor_s() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/stat").ok()?;
    // the name of the program, in brackets, may contain any character
    let fields: Vec<&str> = status.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field)?.parse::<f64>().ok();
    Some(0.01 * (ticks(11)? + ticks(12)?))
}

/// Current action, and number of previous ones.
type Doing = Arc<Mutex<(u64, String)>>;

/// Reports the current action to the watchdog; the watch ends when it is dropped.
pub struct Guard {
    doing: Doing,
    thread: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Guard {
    /// Reports the start of a new action.
    pub fn note(&self, doing: impl FnOnce() -> String) {
        let mut now = self.doing.lock().expect("not poisoned");
        *now = (now.0 + 1, doing());
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        if let Some((end, thread)) = self.thread.take() {
            drop(end);
            let _ = thread.join();
        }
    }
}

/// Starts a watch that [`Guard::note`] is called at least every `limit_s` seconds of processor time.
pub fn watch(limit_s: u64) -> Guard {
    let doing: Doing = Arc::new(Mutex::new((0, "nothing yet".to_owned())));
    let watched = Arc::clone(&doing);
    let (end, ended) = channel();
    let thread = thread::spawn(move || {
        let (mut last, mut since) = (0, Moment::now());
        while ended.recv_timeout(Duration::from_millis(200)) == Err(RecvTimeoutError::Timeout) {
            let (count, what) = watched.lock().expect("not poisoned").clone();
            if count != last {
                (last, since) = (count, Moment::now());
            } else if since.is_past(limit_s as f64) {
                eprintln!("hangs for more than {limit_s} s: {what}");
                std::process::abort();
            }
        }
    });
    Guard { doing, thread: Some((end, thread)) }
}
