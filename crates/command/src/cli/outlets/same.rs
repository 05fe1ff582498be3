//! Comparison of paths: whether two lead to the same file, also through links, different case or `..`.

use std::path::Path;

/// Identity of a regular file.
#[derive(PartialEq)]
pub(super) struct Identity(Inner);

#[cfg(unix)]
type Inner = (u64, u64);
#[cfg(not(unix))]
type Inner = same_file::Handle;

impl Identity {
    /// Identity of an existing regular file; a pipe is not opened.
    pub fn of(path: &Path) -> Option<Self> {
        let found = std::fs::metadata(path).ok()?;
        if found.is_file() { inner(path, &found).map(Self) } else { None }
    }
}

#[cfg(unix)]
fn inner(_: &Path, found: &std::fs::Metadata) -> Option<Inner> {
    use std::os::unix::fs::MetadataExt;
    Some((found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn inner(path: &Path, _: &std::fs::Metadata) -> Option<Inner> {
    same_file::Handle::from_path(path).ok()
}
