//! Gradients of a run: derivatives of outputs at given times, of largest values and means, of latch times and impulses with respect to numbers of the
//! model.
//!
//! The engine differentiates the discrete run along its steps ([`foldwing_engine::plant::Gradient`], NOTATION eqs. (X6)–(X11)); this
//! module adds names, instants of largest values, and the choice between forward and adjoint.

mod error;
mod extreme;
mod quantity;
mod solve;
#[cfg(test)]
mod tests;

pub use error::{GradientsError, QuantityError};
pub use quantity::{Average, Extreme, Quantity};
pub use solve::{By, Derivatives, Gradients, Mode, Numbers, Options, Recorded, Results, differentiate};
