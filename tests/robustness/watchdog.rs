//! Ends the test, naming what was being done, where nothing has moved for too long: no call may hang.

#![allow(dead_code, reason = "each test uses a part of it")]

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Tells the watchdog what is being done; the watch ends with it.
pub struct Guard {
    doing: Arc<Mutex<(Instant, String)>>,
    thread: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Guard {
    /// Something new begins.
    pub fn note(&self, doing: impl FnOnce() -> String) {
        *self.doing.lock().expect("not poisoned") = (Instant::now(), doing());
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

/// Watches that [`Guard::note`] is called at least every `limit_s` seconds.
pub fn watch(limit_s: u64) -> Guard {
    let doing = Arc::new(Mutex::new((Instant::now(), "nothing yet".to_owned())));
    let watched = Arc::clone(&doing);
    let (end, ended) = channel();
    let thread = thread::spawn(move || {
        while ended.recv_timeout(Duration::from_millis(200)) == Err(RecvTimeoutError::Timeout) {
            let (since, what) = watched.lock().expect("not poisoned").clone();
            if since.elapsed() > Duration::from_secs(limit_s) {
                eprintln!("hangs for more than {limit_s} s: {what}");
                std::process::abort();
            }
        }
    });
    Guard { doing, thread: Some((end, thread)) }
}
