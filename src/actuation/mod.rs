//! Fold joints' machinery: drive, latch, prescribed motion.

pub mod drive;
pub mod latch;
pub mod prescribed;
