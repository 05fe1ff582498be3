//! Random calls on several instances of several models: legal and illegal, with valid and invalid arguments.
//!
//! `FOLDWING_CALLS` sets their number, `FOLDWING_SEED` runs the single sequence named by a failure.

use crate::random_faces::{self, Cast};
use crate::random_session::{Session, Tally};
use crate::share::share;
use std::process::Command;

/// Number of calls in a plain `cargo test`.
const SHARE: usize = 20_000;
/// Number of calls for each of the other interfaces, which share the code behind the calls.
const SHARE_OF_FACE: usize = 3_000;
/// Calls of one sequence, after which every instance is reset and compared with a new one.
const SEQUENCE: usize = 150;
/// Number of calls under valgrind, which is about forty times slower, and of models in its sessions. `make valgrind` uses all models and
/// more calls.
const SHARE_UNDER_VALGRIND: usize = 150;
const MODELS_UNDER_VALGRIND: usize = 6;

pub fn number(name: &str) -> Option<usize> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

/// RC-01. After each call: an allowed status; if it was rejected, one message and a bit-identical state; finite values after a step. After
/// each sequence, a reset instance is bit-identical to a new one.
#[test]
fn rc01_random_calls() {
    let calls = number("FOLDWING_CALLS").unwrap_or(SHARE.div_ceil(share()));
    let guard = crate::watchdog::watch(number("FOLDWING_WATCHDOG").unwrap_or(60) as u64);
    let mut session = Session::new();
    let mut tally = Tally::default();
    let seeds = match number("FOLDWING_SEED") {
        Some(seed) => seed as u64..seed as u64 + 1,
        None => 0..calls.div_ceil(SEQUENCE) as u64,
    };
    for seed in seeds {
        session.run(seed, SEQUENCE, &guard, &mut tally);
    }
    drop(session);
    println!("{tally}");
}

/// A session of one of the other three interfaces.
fn of_face(cast: Cast, share: usize) {
    let calls = number("FOLDWING_CALLS").unwrap_or(share);
    let guard = crate::watchdog::watch(number("FOLDWING_WATCHDOG").unwrap_or(60) as u64);
    let mut session = random_faces::Session::new(cast);
    let mut tally = random_faces::Tally::default();
    let seeds = match number("FOLDWING_SEED") {
        Some(seed) => seed as u64..seed as u64 + 1,
        None => 0..calls.div_ceil(SEQUENCE) as u64,
    };
    for seed in seeds {
        session.run(seed, SEQUENCE, &guard, &mut tally);
    }
    drop(session);
    println!("{cast:?}: {tally}");
}

/// RC-03. RC-01 for co-simulation of FMI 3.0: with and without Event Mode, with early returns and intermediate updates.
#[test]
fn rc03_random_calls_on_co_simulation_of_fmi3() {
    of_face(Cast::Steps3, SHARE_OF_FACE);
}

/// RC-04. RC-01 for Model Exchange of FMI 2.0, with invalid states and times.
#[test]
fn rc04_random_calls_on_model_exchange_of_fmi2() {
    of_face(Cast::Exchange2, SHARE_OF_FACE);
}

/// RC-05. RC-01 for Model Exchange of FMI 3.0.
#[test]
fn rc05_random_calls_on_model_exchange_of_fmi3() {
    of_face(Cast::Exchange3, SHARE_OF_FACE);
}

/// RC-02. All four under valgrind's memcheck: no access outside allocated memory, no use of uninitialised values, no leaks.
#[test]
#[ignore = "long; `make long` runs it"]
fn rc02_random_calls_under_valgrind() {
    let calls = number("FOLDWING_VALGRIND_CALLS").unwrap_or(SHARE_UNDER_VALGRIND);
    if !cfg!(target_os = "linux") || Command::new("valgrind").arg("--version").output().is_err() {
        // continuous integration and `make valgrind`, which sets the number of calls, are not satisfied by a skipped test
        let is_needed = std::env::var("CI").as_deref() == Ok("true") || number("FOLDWING_VALGRIND_CALLS").is_some();
        assert!(!is_needed, "valgrind is missing");
        println!("skipped: valgrind is not installed");
        return;
    }
    let mut command = Command::new("valgrind");
    command
        .args(["--tool=memcheck", "--leak-check=full", "--show-leak-kinds=definite,indirect,possible"])
        .args(["--errors-for-leak-kinds=definite,indirect,possible", "--error-exitcode=99", "--num-callers=40"])
        .arg(concat!("--suppressions=", env!("CARGO_MANIFEST_DIR"), "/tests/robustness/valgrind.supp"))
        .arg(std::env::current_exe().expect("a path"))
        .args(["random_calls::", "--skip", "valgrind", "--test-threads=1", "--nocapture"])
        .env("FOLDWING_CALLS", calls.to_string())
        .envs(number("FOLDWING_VALGRIND_CALLS").is_none().then(|| ("FOLDWING_FEW", MODELS_UNDER_VALGRIND.to_string())))
        .env("FOLDWING_WATCHDOG", "600")
        .env_remove("FOLDWING_SEED");
    let output = command.output().expect("valgrind starts");
    let (told, summary) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{}\n{told}\n{summary}", output.status);
    assert!(summary.contains("ERROR SUMMARY: 0 errors"), "{summary}");
    assert!(told.contains("4 passed"), "the test did not run: {told}");
    println!("valgrind, {calls} calls of each face:");
    for line in summary.lines().filter(|line| line.contains("lost:") || line.contains("SUMMARY")) {
        println!("  {line}");
    }
}
