//! The page receives the data that `foldwing simulate --view` writes.

use foldwing_command::cli::run_as;
use foldwing_command::report::viewer::{PackedRun, run_of_page};
use foldwing_web::{Session, State};
use std::path::Path;

/// Frames, signals and events of runs without aerodynamics, with strips and with a wake are equal
/// to the last bit.
#[test]
fn runs_are_those_of_the_viewer_page() {
    let folder = tempfile::tempdir().unwrap();
    for (model, frames) in [("folding_wing", 600), ("goland_wing", 150), ("folding_wing_in_tunnel", 20)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../examples/models/{model}.toml"));
        let page = folder.path().join(format!("{model}.html"));
        let words = ["foldwing", "simulate", "--quiet", "--csv", "-", "--frames"];
        let written = folder.path().join(format!("{model}.csv"));
        let words = words.map(|word| if word == "-" { written.as_os_str().into() } else { word.into() });
        let rest = [frames.to_string().into(), "--view".into(), page.clone().into(), path.clone().into()];
        assert_eq!(run_as(words.into_iter().chain(rest), None), 0, "{model}");
        let expected = run_of_page(&std::fs::read_to_string(&page).unwrap()).unwrap();
        let mut session = Session::begin(&std::fs::read_to_string(&path).unwrap(), frames).unwrap();
        assert_eq!(session.advance(u32::MAX), State::Finished);
        let found = PackedRun::from(session.packing());
        assert!(found.description == expected.description, "{model}: another description");
        assert!(found.numbers == expected.numbers, "{model}: other numbers");
    }
}

/// A run that fails reports the reason, and its recording ends at the failure.
#[test]
fn a_run_that_fails_keeps_its_picture() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/models/folding_wing.toml");
    let text = std::fs::read_to_string(path).unwrap();
    // a motor torque that no time step resolves
    let text = text.replacen("constant_torque_N_m = 0.043", "constant_torque_N_m = 1e9", 1);
    let mut session = Session::begin(&text, 600).unwrap();
    assert_eq!(session.advance(u32::MAX), State::Failed);
    let summary = session.summary();
    assert!(summary["failure"].as_str().unwrap().len() > 20, "{summary}");
    assert!(session.packing().numbers.len() > 100);
}
