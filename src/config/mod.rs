//! The model file: TOML read into [`Machine`], every number checked, every error with its line.

pub mod machine;

pub use machine::Machine;
