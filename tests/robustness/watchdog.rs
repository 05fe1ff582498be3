//! Ends the test, naming what was being done, where nothing has moved for too long: no call may hang.

#![allow(dead_code, reason = "each test uses a part of it")]

use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Tells the watchdog what is being done; the watch ends with the last one.
pub struct Guard {
    doing: Arc<Mutex<(Instant, String)>>,
}

impl Guard {
    /// Something new begins.
    pub fn note(&self, doing: impl FnOnce() -> String) {
        *self.doing.lock().expect("not poisoned") = (Instant::now(), doing());
    }
}

/// Watches that [`Guard::note`] is called at least every `limit_s` seconds.
pub fn watch(limit_s: u64) -> Guard {
    let doing = Arc::new(Mutex::new((Instant::now(), "nothing yet".to_owned())));
    let watched = Arc::downgrade(&doing);
    // not joined: it ends by itself, and a process that ends takes it along
    thread::spawn(move || {
        while let Some(doing) = watched.upgrade() {
            let (since, what) = doing.lock().expect("not poisoned").clone();
            if since.elapsed() > Duration::from_secs(limit_s) {
                eprintln!("hangs for more than {limit_s} s: {what}");
                std::process::abort();
            }
            drop(doing);
            thread::sleep(Duration::from_millis(200));
        }
    });
    Guard { doing }
}
