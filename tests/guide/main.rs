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

/// F-259. The example in Rust of the front page is the crate's first doc test, line for line but for its hidden end.
#[test]
fn f259_the_rust_example_of_the_front_page_is_the_doc_test() {
    let read = |path: &str| std::fs::read_to_string(in_package(path)).expect("a file of the repository");
    let library = read("src/lib.rs");
    let documented =
        library.lines().filter_map(|line| line.strip_prefix("//!").map(|text| text.trim_start_matches(' ')));
    let code: Vec<&str> = documented
        .skip_while(|line| *line != "```")
        .skip(1)
        .take_while(|line| *line != "```")
        .filter(|line| !line.starts_with("# "))
        .collect();
    let page = read("README.md");
    let shown: Vec<&str> =
        page.lines().skip_while(|line| *line != "```rust").skip(1).take_while(|line| *line != "```").collect();
    assert!(code.len() > 9, "{code:?}");
    assert_eq!(shown.iter().map(|line| line.trim()).collect::<Vec<_>>(), code);
}
