//! Temporary files and folders that go with a command that is interrupted.

#[cfg(unix)]
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};

/// Paths that a signal removes. A signal is one for the whole process, so this list is, too.
static LEFTOVERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The process is the command: its signals are ours. In a program that calls us they are the program's.
static OWNS_SIGNALS: AtomicBool = AtomicBool::new(false);

/// Says that the process is the command.
pub fn own_signals() {
    OWNS_SIGNALS.store(true, Ordering::Relaxed);
}

/// A path that is removed if the process is interrupted while this is alive.
pub struct Leftover(PathBuf);

impl Leftover {
    /// Watches a file or folder.
    pub fn watch(path: &Path) -> Self {
        if OWNS_SIGNALS.load(Ordering::Relaxed) {
            watch_signals();
        }
        LEFTOVERS.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Leftover {
    fn drop(&mut self) {
        LEFTOVERS.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| *path != self.0);
    }
}

/// From now on SIGINT, SIGTERM and SIGHUP remove what is unfinished before they end the process, and a file that may not
/// grow any more is an error instead of an end. What the caller ignores stays ignored.
fn watch_signals() {
    static ONCE: Once = Once::new();
    ONCE.call_once(start);
}

#[cfg(unix)]
fn start() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;
    use std::sync::Arc;

    // where one of these fails, the command runs as it did without
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    let ignored = ignored();
    let wanted: Vec<i32> =
        [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored & (1 << (signal - 1)) == 0).collect();
    let Ok(mut signals) = Signals::new(wanted) else { return };
    let end = move || {
        for signal in signals.forever() {
            let list = LEFTOVERS.lock().unwrap_or_else(PoisonError::into_inner);
            for path in list.iter() {
                let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
            }
            // still locked: nothing new begins
            let _ = emulate_default_handler(signal);
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(end);
}

/// Signals that the caller of this process ignores, as `nohup` does, one bit each; none where the system does not say.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Elsewhere an interrupted command may leave its unfinished file; the old one is whole all the same.
#[cfg(not(unix))]
fn start() {}
