//! Long studies and their short representatives.

/// Returns whether studies run in full, as in `make validate`: `make test` has a short representative of each.
pub fn is_whole() -> bool {
    std::env::var_os("FOLDWING_WHOLE").is_some()
}
