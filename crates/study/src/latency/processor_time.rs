//! The clock of a thread; `benches/calls.rs` takes this file too.

use std::time::Duration;

/// Processor time of this thread, where the system tells it.
#[cfg(any(target_os = "linux", target_os = "macos"))]
pub fn processor_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
}

/// Processor time of this thread, where the system tells it.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
pub fn processor_time() -> Option<Duration> {
    None
}
