//! Random machines as model files: every feature of the format, with ordinary dimensions, generated from a seed.
//!
//! A [`Model`] is a list of tables and a list of actions on the machine during a run. [`shrink`] removes entries of both one by one as long
//! as a failure persists. A [`View`] writes the same machine rotated as a whole, or its mirror image.

#![allow(dead_code, unused_imports, reason = "each test program uses a part of it")]

mod air;
mod airs;
mod course;
mod cylindrical;
mod dc_motor;
mod draw;
mod model;
mod no_slip;
mod rigid;
mod rotor;
mod shaped;
mod shrink;
mod sliding;
mod view;

pub use airs::AIRS;
pub use course::Doing;
pub use cylindrical::CYLINDRICAL;
pub use dc_motor::DC_MOTORS;
pub use draw::{STEPS, draw};
pub use model::{Model, Table, Value};
pub use no_slip::NO_SLIP;
pub use rigid::RIGID;
pub use shrink::shrink;
pub use sliding::SLIDING;
pub use view::{Frame, View};

/// Number of machines, from the environment; `make validate` uses more than `make test`.
pub fn count(usual: u64) -> u64 {
    std::env::var("FOLDWING_MACHINES").ok().map_or(usual, |text| text.parse().expect("FOLDWING_MACHINES is a number"))
}

/// Seeds of machines with sliding joints: a third as many as others.
pub fn sliding_seeds(usual: u64) -> Vec<u64> {
    match std::env::var_os("FOLDWING_SEED") {
        Some(_) => Vec::new(),
        None => (SLIDING..SLIDING + count(usual).div_ceil(3)).collect(),
    }
}

/// Seeds of machines with rigid loops: a third as many as others.
pub fn rigid_seeds(usual: u64) -> Vec<u64> {
    match std::env::var_os("FOLDWING_SEED") {
        Some(_) => Vec::new(),
        None => (RIGID..RIGID + count(usual).div_ceil(3)).collect(),
    }
}

/// Seeds: only `FOLDWING_SEED`, or the first `usual` ones.
pub fn seeds(usual: u64) -> Vec<u64> {
    match std::env::var("FOLDWING_SEED") {
        Ok(text) => vec![text.parse().expect("FOLDWING_SEED is a number")],
        Err(_) => (0..count(usual)).collect(),
    }
}
