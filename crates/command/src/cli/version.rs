//! Version of the command.

/// Build identification: version, commit if it was built from a repository, target.
pub(super) fn version() -> &'static str {
    if env!("FOLDWING_COMMIT").is_empty() {
        concat!(env!("CARGO_PKG_VERSION"), " (", env!("FOLDWING_TARGET"), ")")
    } else {
        concat!(env!("CARGO_PKG_VERSION"), " (", env!("FOLDWING_COMMIT"), ", ", env!("FOLDWING_TARGET"), ")")
    }
}
