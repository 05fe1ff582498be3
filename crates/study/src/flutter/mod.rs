//! Flutter and divergence: modes in air over the speed of the wind, and the speeds at which they start to grow.

mod found;
mod posture;
mod sweep;

pub use found::{Change, Ended, Event, Flutter, JointChange};
pub use sweep::{FlutterError, MAXIMUM_COUNT, MAXIMUM_SPEEDS, Options, sweep, sweep_watched, sweep_with};
