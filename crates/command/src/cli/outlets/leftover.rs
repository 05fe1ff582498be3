//! Temporary files and folders that are removed if a command is interrupted.

#[cfg(unix)]
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};

/// Paths that a signal handler removes. The list is global because signals concern the whole process.
static LEFTOVERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Whether the process is the command, which may handle its signals; in a library they are handled by the calling program.
static OWNS_SIGNALS: AtomicBool = AtomicBool::new(false);

/// Declares that the process is the command.
pub fn own_signals() {
    OWNS_SIGNALS.store(true, Ordering::Relaxed);
}

/// Path that is removed if the process is interrupted while this value exists.
pub struct Leftover(PathBuf);

impl Leftover {
    /// Registers a file or folder.
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

/// Installs handlers: SIGINT, SIGTERM and SIGHUP remove unfinished files before they end the process, and exceeding a file size limit
/// is an error instead of ending the process. Signals ignored by the caller stay ignored.
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

    // if one of these calls fails, the command runs without this handling
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
            // the list stays locked, so that no new file can be registered
            let _ = emulate_default_handler(signal);
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(end);
}

/// Signals that the caller of this process ignores, as with `nohup`, one bit each; 0 if the system does not provide them.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// On systems without these signals an interrupted command may leave its unfinished file; an existing file is never damaged.
#[cfg(not(unix))]
fn start() {}
