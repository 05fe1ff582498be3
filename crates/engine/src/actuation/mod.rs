//! Fold joints' machinery: drive, spring, latch, prescribed motion.

pub mod drive;
pub mod latch;
pub mod prescribed;
pub mod spring;
