//! Periodic motions of models with a shaft of given speed, and their Floquet modes, NOTATION eqs. (L32) to (L36).

mod floquet;
mod shooting;
mod steady;
mod turn;

pub use crate::solve::floquet::Harmonic;
pub use floquet::{Floquet, FloquetMode};
pub use shooting::{NearbyMotion, PeriodicMotion, Seen};
pub use steady::Settled;
pub use turn::{SAMPLES, Turn};
