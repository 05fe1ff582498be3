//! Flutter and divergence: aeroelastic modes versus wind speed, and the speeds at which they become unstable.

mod found;
mod posture;
mod sweep;

pub use found::{Change, Ended, Event, Flutter, JointChange};
pub use sweep::{FlutterError, MAXIMUM_COUNT, MAXIMUM_SPEEDS, Options, sweep, sweep_watched, sweep_with};
