//! The motion of a rotor that repeats every revolution, its harmonics, and the modes about it.

mod find;
mod modes;
mod series;

pub use find::{MAXIMUM_HARMONICS, Options, Periodic, PeriodicError, find, find_watched};
pub use modes::{ModeTable, table_of_modes};
pub use series::{Series, Summary};
