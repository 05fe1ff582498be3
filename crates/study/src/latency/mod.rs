//! Latency of single communication steps, for hardware in the loop.

mod measure;
mod processor_time;

pub use measure::{Latency, LatencyError, Options, measure};
pub use processor_time::processor_time;
