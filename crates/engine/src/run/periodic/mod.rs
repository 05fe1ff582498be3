//! Periodic motions of machines whose shaft turns at a given speed, and what happens beside them, NOTATION eqs. (L32) to (L36).

mod floquet;
mod shooting;
mod steady;
mod turn;

pub use crate::solve::floquet::Harmonic;
pub use floquet::{Floquet, FloquetMode};
pub use shooting::{NearbyMotion, PeriodicMotion, Seen};
pub use steady::Settled;
pub use turn::{SAMPLES, Turn};
