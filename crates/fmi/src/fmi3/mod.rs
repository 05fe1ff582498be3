//! FMI 3.0, co-simulation and Model Exchange: phases in which its functions are legal. Their implementation is in
//! [`instance`](crate::instance).

mod life_cycle;

pub use life_cycle::{Call, FUNCTIONS};
