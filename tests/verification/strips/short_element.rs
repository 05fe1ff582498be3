//! Short, stiff elements in wind: their accelerations are large, but their motion is small.

use foldwing::config;
use foldwing::plant::Plant;
use std::sync::Arc;

/// Latch times in s and the largest root strain of the tutorial's wing with the mass of the first hinge at a position of the inner body.
fn unfolded(place_m: f64) -> ([f64; 2], f64) {
    let text = std::fs::read_to_string("examples/tutorial/sketch.toml").expect("a model file");
    let here = "hinge1 = { body = \"inner\", position_m = 0.8,";
    assert!(text.contains(here));
    let text = text.replace(here, &format!("hinge1 = {{ body = \"inner\", position_m = {place_m},"));
    let mut plant = Plant::new(Arc::new(config::parse(&text, "sketch.toml").expect("a model")));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{place_m} m: {error}"));
    let mut peak = 0.0f64;
    for row in 1..=220 {
        plant.step(0.01 * f64::from(row)).unwrap_or_else(|error| panic!("{place_m} m: {error}"));
        peak = peak.max(plant.outputs().gauges()[0].abs());
    }
    ([0, 1].map(|fold| plant.outputs().latches()[fold].time_s), peak)
}

/// CR-64. A mass next to a fold creates a short element. A torque that starts there accelerates it by 1e8 1/s2, which used to be an error
/// ("the accelerations move the wing"). The motion changes as little as the position of the mass.
#[test]
fn a_mass_next_to_a_fold_moves_with_it() {
    let (at_fold, peak) = unfolded(0.8);
    for place_m in [0.799, 0.79, 0.76] {
        let (times, near) = unfolded(place_m);
        let away = (0.8 - place_m) / 0.8;
        for (time_s, expected_s) in times.iter().zip(at_fold) {
            // the mass is a twentieth of that beyond the first fold: its effect is less than its relative displacement
            assert!((time_s / expected_s - 1.0).abs() < away, "{place_m} m: {times:?} s for {at_fold:?} s");
        }
        assert!((near / peak - 1.0).abs() < 0.01 + away, "{place_m} m: {near} for {peak}");
    }
}
