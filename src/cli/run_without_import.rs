//! `foldwing run` of a build without the feature `import`: says how to get one that has it.

use crate::cli::Failure;
use std::ffi::OsString;

#[derive(clap::Args)]
pub struct Arguments {
    /// As in a build with the feature
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "X.fmu …")]
    _rest: Vec<OsString>,
}

/// Refuses.
pub fn run(_: &Arguments) -> Result<(), Failure> {
    Err(Failure::Usage(
        "run: this build cannot run FMUs; `make runner` (or `cargo build --release --features import`, with libclang) \
         makes one that can"
            .to_owned(),
    ))
}
