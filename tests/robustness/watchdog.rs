//! Ends the test, naming what was being done, where nothing has moved for too long: no call may hang. Long is processor time, so that
//! a busy machine does not end it; a call that waits and computes nothing is given twenty times as long on the clock.

#![allow(dead_code, reason = "each test uses a part of it")]

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// A time on the clock, and the processor time of this process in s where the system gives it.
#[derive(Clone, Copy)]
struct Moment(Instant, Option<f64>);

impl Moment {
    fn now() -> Self {
        Self(Instant::now(), processor_s())
    }

    /// Whether so many seconds have gone: of the processor, and all tests of the program together may have used them.
    fn is_past(self, limit_s: f64) -> bool {
        let tests = thread::available_parallelism().map_or(1.0, |count| count.get() as f64);
        let clock_s = self.0.elapsed().as_secs_f64();
        match (self.1, processor_s()) {
            (Some(then_s), Some(now_s)) => now_s - then_s > limit_s * tests || clock_s > 20.0 * limit_s,
            _ => clock_s > limit_s,
        }
    }
}

#[cfg(any(target_os = "linux", target_os = "macos"))]
fn processor_s() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn processor_s() -> Option<f64> {
    None
}

/// Tells the watchdog what is being done; the watch ends with it.
pub struct Guard {
    doing: Arc<Mutex<(Moment, String)>>,
    thread: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Guard {
    /// Something new begins.
    pub fn note(&self, doing: impl FnOnce() -> String) {
        *self.doing.lock().expect("not poisoned") = (Moment::now(), doing());
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

/// Watches that [`Guard::note`] is called at least every `limit_s` seconds of the processor.
pub fn watch(limit_s: u64) -> Guard {
    let doing = Arc::new(Mutex::new((Moment::now(), "nothing yet".to_owned())));
    let watched = Arc::clone(&doing);
    let (end, ended) = channel();
    let thread = thread::spawn(move || {
        while ended.recv_timeout(Duration::from_millis(200)) == Err(RecvTimeoutError::Timeout) {
            let (since, what) = watched.lock().expect("not poisoned").clone();
            if since.is_past(limit_s as f64) {
                eprintln!("hangs for more than {limit_s} s: {what}");
                std::process::abort();
            }
        }
    });
    Guard { doing, thread: Some((end, thread)) }
}
