//! FMI 3.0, co-simulation and Model Exchange: which of its functions is legal when. What they do is in
//! [`instance`](crate::instance).

mod life_cycle;

pub use life_cycle::{Call, FUNCTIONS};
