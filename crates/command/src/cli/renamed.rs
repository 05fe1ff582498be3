//! Options of version 0.1.0 that have been renamed.

/// Options of version 0.1.0 and their new names.
const OPTIONS: &[(&str, &str)] = &[
    ("--beside", "--compare FILE"),
    ("--timing", "--profile OUT.json"),
    ("--kinds", "--interface KINDS"),
    ("--out", "--output OUT.csv"),
    ("--output", "--variables NAME"),
    ("--about", "--state STATE"),
    ("--at", "--state STATE"),
    ("--over", "--vary KEY=VALUES"),
    ("--up-to", "--max-frequency HZ"),
    ("--find", "--solve-for KEY=FROM:TO"),
    ("--hold", "--target OUTPUT=VALUE"),
    ("--free", "--solve-for NAME"),
    ("--balance", "--target NAME=VALUE"),
    ("--accuracy", "--tolerance TOLERANCE"),
    ("--directions", "--perturbations N"),
    ("--speeds", "--wind-m-s FROM:TO:COUNT, with the number of speeds in place of their step"),
    ("--variables", "--list-variables"),
];

/// Returns the new name of a renamed option.
pub(super) fn option(unknown: &str) -> Option<&'static str> {
    OPTIONS.iter().find(|(old, _)| *old == unknown).map(|(_, new)| *new)
}
