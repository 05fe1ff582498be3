//! The folding wings of `examples/failures`.

use crate::breaking::*;
use foldwing::config;
use std::path::Path;

fn failing(name: &str) -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/failures/{name}.toml"));
    let text = std::fs::read_to_string(path).expect("a shipped model");
    config::parse(&text, name).unwrap_or_else(|error| panic!("{error}"))
}

/// A shipped machine with and without its failures.
fn both(name: &str) -> [Machine; 2] {
    let mut machine = failing(name);
    machine.solver.tolerance = 1e-6;
    let sound = Machine { failures: Vec::new(), ..machine.clone() };
    [machine, sound]
}

/// FL-30. Loss of the motor during unfolding: the wing, which latches with the motor, does not latch without it.
#[test]
fn fl30_the_motor_loss_on_the_way() {
    let [failing, sound] = both("motor_loss").map(|machine| {
        let mut plant = start(machine);
        let drift = drift_j(&mut plant, 0.6, 60);
        assert!(drift < 2e-4, "energy account drifts by {drift:e} J");
        plant
    });
    assert!(sound.outputs().latches()[0].closed.is_on());
    let at_s = failed_s(&failing, 0).expect("it fails");
    assert!((0.01..0.1).contains(&at_s), "fails at {at_s} s");
    assert_eq!(failing.outputs().latches()[0].count.get(), 0);
    assert_eq!(failing.outputs().joints()[0].motor_torque_n_m, 0.0);
}

/// FL-31. The latch does not catch: the wing swings through.
#[test]
fn fl31_the_latch_does_not_catch() {
    let [failing, sound] = both("latch_no_capture").map(|machine| {
        let mut plant = start(machine);
        let mut least_rad = f64::INFINITY;
        for i in 1..=80 {
            plant.step(5e-3 * f64::from(i)).expect("runs");
            least_rad = least_rad.min(plant.outputs().joints()[0].angle_rad);
        }
        (least_rad, plant)
    });
    assert_eq!(failed_s(&failing.1, 0), Some(0.05));
    assert!(sound.1.outputs().latches()[0].closed.is_on() && sound.0 > -0.1, "{} rad", sound.0);
    assert!(!failing.1.outputs().latches()[0].closed.is_on() && failing.0 < -0.5, "{} rad", failing.0);
}

/// FL-33. A latch that is already closed when its failure to catch occurs stays closed: only `latch_break` opens it.
#[test]
fn fl33_a_closed_latch_need_not_catch() {
    let [mut failing, _] = both("latch_no_capture");
    failing.failures[0].at_time_s = Some(0.14);
    let mut plant = start(failing);
    drift_j(&mut plant, 0.16, 20);
    assert_eq!(failed_s(&plant, 0), Some(0.14));
    let latch = plant.outputs().latches()[0];
    assert!(latch.closed.is_on() && latch.count.get() == 1 && latch.time_s < 0.14, "{latch:?}");
}

/// FL-32. Only one wing of an aircraft unfolds: unlike the intact aircraft, it rolls; momentum is conserved.
#[test]
fn fl32_one_side_unfolds() {
    let [failing, sound] = both("one_side_unfolds").map(|machine| {
        let mut plant = start(machine);
        let drift = drift_j(&mut plant, 0.3, 60);
        assert!(drift < 1e-4, "energy account drifts by {drift:e} J");
        plant
    });
    let roll = |plant: &Plant| plant.outputs().spatial()[0].rotation.euler_angles().1.to_degrees();
    let (rolled, straight) = (roll(&failing), roll(&sound));
    assert!(straight.abs() < 1e-6, "the sound one rolls by {straight} degrees");
    assert!(rolled.abs() > 5.0, "it rolls by {rolled} degrees");
    let held = failing.outputs().joints()[1];
    assert_eq!(held.rate_rad_s, 0.0);
    assert!(failing.outputs().latches()[0].closed.is_on() && !failing.outputs().latches()[1].closed.is_on());
}
