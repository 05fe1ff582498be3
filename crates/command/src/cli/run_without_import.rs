//! `foldwing run` in a build without the feature `import`: an error that names the build that has it.

use crate::cli::Failure;
pub use crate::cli::run_arguments::Arguments;

/// Returns the error.
pub fn run(_: &Arguments) -> Result<(), Failure> {
    Err(Failure::Usage(
        "run: this build cannot run FMUs; `make runner` (or `cargo build --release --features import`, with libclang) \
         makes one that can"
            .to_owned(),
    ))
}
