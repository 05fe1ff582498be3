//! Shares of tests over many similar cases.

/// `FOLDWING_SHARE`, or 1: tests over many machines, files or bytes take one case in this many. `make test` and `make assertions` set
/// 3, CI 2 for `make long`; `make long` otherwise, `make validate` and `cargo test` take all cases. `tools/run_rust_tests.py` lists these tests.
pub fn share() -> usize {
    match std::env::var("FOLDWING_SHARE") {
        Ok(text) => text.parse().ok().filter(|share| *share > 0).expect("FOLDWING_SHARE is a number from 1"),
        Err(_) => 1,
    }
}
