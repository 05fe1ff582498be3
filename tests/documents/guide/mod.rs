//! The guide in `docs/guide` and the program agree.

mod command_lines;
mod commands;
mod messages;
mod names;
mod rotor_slips;
mod variables;

#[allow(dead_code, reason = "`main` and what it prints")]
#[path = "../../../examples/package.rs"]
mod package;
#[allow(dead_code, reason = "`main` and what it prints")]
#[path = "../../../examples/wing.rs"]
mod wing;

use std::path::{Path, PathBuf};

fn in_package(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Asserts that a generated page is up to date. `make bless` writes it again.
fn assert_current(page: &str, text: &str) {
    if std::env::var_os("FOLDWING_BLESS").is_some() {
        std::fs::write(in_package(page), text).unwrap();
    }
    let found = std::fs::read_to_string(in_package(page)).unwrap_or_default().replace("\r\n", "\n");
    let difference = found.lines().zip(text.lines()).find(|(old, new)| old != new);
    assert!(found == text, "{page} is stale: `make bless` writes it anew; first {difference:?}");
}

/// F-259. The Rust example of the page of first scripts is the crate's first doc test, line for line except its hidden end.
#[test]
fn f259_the_rust_example_of_the_guide_is_the_doc_test() {
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
    let page = read("docs/guide/first_scripts.md");
    let shown: Vec<&str> =
        page.lines().skip_while(|line| *line != "```rust").skip(1).take_while(|line| *line != "```").collect();
    assert!(code.len() > 9, "{code:?}");
    assert_eq!(shown.iter().map(|line| line.trim()).collect::<Vec<_>>(), code);
}

/// F-260. The Rust examples: a wing built in code unfolds and has modes, a model file becomes an FMU.
#[test]
fn f260_the_rust_examples_do_what_they_say() {
    let latch_time_s = wing::unfold(wing::wing(0.15).unwrap()).unwrap();
    assert!((0.1..0.2).contains(&latch_time_s), "{latch_time_s} s");
    let modes = wing::latched_modes(wing::wing(0.15).unwrap()).unwrap();
    assert_eq!(modes.len(), 4);
    assert!(modes.iter().all(|(hz, ratio)| *hz > 0.1 && *ratio > 0.0), "a damped wing at rest: {modes:?}");
    // half the length with constant mass per length: bending is four times as fast
    let short = wing::latched_modes(wing::wing(0.075).unwrap()).unwrap();
    assert!((3.0..5.0).contains(&(short[0].0 / modes[0].0)), "{short:?} beside {modes:?}");

    let text = std::fs::read_to_string(in_package("examples/models/folding_wing.toml")).unwrap();
    let fmu = package::package(&text, &commands::library()).unwrap();
    assert_eq!(&fmu[..2], b"PK", "an archive");
    let refused = package::package(&text.replace("elements = 4", "elements = 0"), &commands::library()).unwrap_err();
    assert!(refused.to_string().contains("elements"), "{refused}");
}
