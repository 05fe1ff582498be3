//! Observed and allowed differences. `make validate` lists both in `docs/tables/agreement.md`: a test close to its tolerance is fragile;
//! one whose tolerance is a hundred times the observed difference may miss the faults it is meant to find.

use std::io::Write;

/// Asserts that the observed difference is at most the allowed one. If `FOLDWING_AGREEMENT` names a file, also appends a row to that file.
#[track_caller]
pub fn agree(row: &str, observed: f64, allowed: f64) {
    if let Some(path) = std::env::var_os("FOLDWING_AGREEMENT") {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(&path);
        let written = file.and_then(|mut file| file.write_all(format!("{row},{observed:e},{allowed:e}\n").as_bytes()));
        written.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    assert!(observed <= allowed, "{row}: {observed:.2e}, allowed are {allowed:.0e}");
}
