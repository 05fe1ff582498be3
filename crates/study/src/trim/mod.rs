//! Trim: values of inputs, parameters, attitude and turn for which outputs at equilibrium have their targets and free joints carry
//! no load.

mod attitude;
mod error;
mod found;
mod least_squares;
mod newton;
mod unknown;

pub use crate::values::Target;
pub use attitude::{Turn, TurnError};
pub use error::{Cause, Residual, TargetError, TrimError, UnknownError};
pub use found::{Balanced, Solved, Trim};
pub use newton::{Options, solve, solve_watched};
