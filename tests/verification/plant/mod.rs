//! The whole plant against references, identities and properties, without FMI.
//!
//! Cases are numbered P-xx. Machines are in `machines`, reference files in `tests/reference`.

mod allocation;
pub(crate) mod machines;

mod carried;
mod chains;
mod corners;
mod cylindrical;
mod dc_motor;
mod deployment;
mod double_pendulum;
mod energy;
mod failures;
mod flat_wheel;
mod hinges;
pub mod hybrid;
mod idle_loop;
mod internal_loads;
mod latch_impulse;
mod loops;
mod mode_damping;
mod moving_root;
mod no_slip;
mod no_slip_air;
mod reaction;
mod reading;
mod real_time;
pub(crate) mod rigid;
mod rigid_bodies;
mod rigid_latch;
mod rigid_loops;
mod rigid_loops_linear;
mod rod;
mod root_loops;
mod sleeves;
mod slides;
pub mod sliding;
mod sliding_air;
mod sliding_attitude;
mod sliding_ball;
mod sliding_linear;
mod snapshot;
mod statics;
mod steps;
mod stops;
mod two_body;
