//! Long studies and their short versions.

/// Returns whether studies run in full, as in `make validate`; `make test` runs a short version of each.
pub fn is_whole() -> bool {
    std::env::var_os("FOLDWING_WHOLE").is_some()
}
