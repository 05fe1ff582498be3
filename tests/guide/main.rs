//! The guide in `docs/guide` and the program say the same.

mod command_lines;
mod commands;
mod messages;
mod names;
mod variables;

use std::path::{Path, PathBuf};

fn in_package(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A page that is written from the program is what the program gives. `make bless` writes it anew.
fn assert_current(page: &str, text: &str) {
    if std::env::var_os("FOLDWING_BLESS").is_some() {
        std::fs::write(in_package(page), text).unwrap();
    }
    let found = std::fs::read_to_string(in_package(page)).unwrap_or_default().replace("\r\n", "\n");
    let difference = found.lines().zip(text.lines()).find(|(old, new)| old != new);
    assert!(found == text, "{page} is stale: `make bless` writes it anew; first {difference:?}");
}
