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

use std::ops::Range;

/// Numbers of the machines: the first `usual` ones, or those of `FOLDWING_MACHINES`, a number of machines or a range `FIRST..END`.
/// `make validate` draws more than `make test`.
fn numbers(usual: u64) -> Range<u64> {
    let Ok(text) = std::env::var("FOLDWING_MACHINES") else { return 0..usual };
    let (first, end) = text.split_once("..").unwrap_or(("0", &text));
    let number = |part: &str| part.parse().expect("FOLDWING_MACHINES is a number or FIRST..END");
    number(first)..number(end)
}

/// Seeds from `start` of machines of a special kind: a third as many as others.
fn third(start: u64, usual: u64) -> Vec<u64> {
    if std::env::var_os("FOLDWING_SEED").is_some() {
        return Vec::new();
    }
    let Range { start: first, end } = numbers(usual);
    (start + first.div_ceil(3)..start + end.div_ceil(3)).collect()
}

/// Seeds of machines with sliding joints: a third as many as others.
pub fn sliding_seeds(usual: u64) -> Vec<u64> {
    third(SLIDING, usual)
}

/// Seeds of machines with rigid loops: a third as many as others.
pub fn rigid_seeds(usual: u64) -> Vec<u64> {
    third(RIGID, usual)
}

/// Seeds: only `FOLDWING_SEED`, or the first `usual` ones.
pub fn seeds(usual: u64) -> Vec<u64> {
    match std::env::var("FOLDWING_SEED") {
        Ok(text) => vec![text.parse().expect("FOLDWING_SEED is a number")],
        Err(_) => numbers(usual).collect(),
    }
}
