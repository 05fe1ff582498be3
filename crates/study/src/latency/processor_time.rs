//! Processor time of a thread; `benches/calls.rs` includes this file too.

use std::time::Duration;

/// Processor time of this thread, if the system provides it.
#[cfg(any(target_os = "linux", target_os = "macos"))]
pub fn processor_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
}

/// Processor time of this thread, if the system provides it.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
pub fn processor_time() -> Option<Duration> {
    None
}
