//! Deployment in still air: Otsuka et al., Table 5, with k = 0.026 N·m/rad.

use crate::plant::machines::*;
use foldwing::machine::{ElementKind, Machine, Method};

/// Latch time in s, and peak of |root strain| and its time, at the output interval of the reference.
fn deploy(machine: Machine) -> (f64, f64, f64) {
    let mut plant = start(machine);
    let (mut peak, mut peak_s) = (0.0, 0.0);
    run(
        &mut plant,
        0.4,
        800,
        |_| {},
        |outputs| {
            if outputs.gauges()[0].abs() > peak {
                (peak, peak_s) = (outputs.gauges()[0].abs(), outputs.time_s);
            }
        },
    );
    (plant.outputs().latches()[0].time_s, peak, peak_s)
}

fn assert_relative(what: &str, unit: &str, value: f64, reference: f64, tolerance: f64) {
    let error = value / reference - 1.0;
    println!("{what}: {value:.6e} {unit}, {:.3} % from {reference:.5e}", 100.0 * error);
    assert!(error.abs() <= tolerance, "{what}: {value:.6e} {unit} is {:.3} % from {reference:e}", 100.0 * error);
}

/// P-01. Latch time and peak root strain, two pairs and 15 constant elements per body.
///
/// Source: `folding_wing_still_air.csv` (0.1222 s, 5.31e-3, both to 3e-4); the fully converged latch time is 0.12214 s. Tolerances 0.5 %
/// and 1 % are the targets; at the tolerance of 1e-5 the time integration takes a third of them.
#[test]
fn p01_wing_latches_in_still_air() {
    for (name, kind, count) in [("2 pairs", ElementKind::Linear, 2), ("15 constant", ElementKind::Constant, 15)] {
        let (latch_s, peak, peak_s) = deploy(wing(kind, count, Method::Esdirk4, 1e-5));
        assert_relative(&format!("{name}: latch time"), "s", latch_s, 0.1222, 5e-3);
        assert_relative(&format!("{name}: latch time, converged"), "s", latch_s, 0.12214, 1e-3);
        assert_relative(&format!("{name}: peak root strain at {peak_s:.4} s"), "", peak, 5.31e-3, 1e-2);
    }
}

/// P-02. With the stiffness as printed (0.26 N·m/rad) the wing latches at 0.0407 s: independent planar model.
#[test]
fn p02_wing_as_printed_latches_early() {
    let mut machine = default_wing(1e-5);
    *hinge_of(&mut machine, 1) = wing_hinge(0.26);
    let (latch_s, ..) = deploy(machine);
    assert_relative("latch time", "s", latch_s, 0.0407, 1e-2);
}

/// P-03. Time histories against `folding_wing_still_air.csv` at the file's own times, up to 0.3 s.
///
/// Fold angle within 0.5° before the latch, strain within 2 % of the peak. The vibration after latching needs no filter: it is equal in
/// both, and the differences stay below 1.4 % of the peak point by point from the latch to 0.3 s (0.4 % in a moving average over 6.5 ms).
/// Only the impulsive start is excluded from the 2 %: content above 1 kHz, which two pairs do not resolve, differs by 3.8 % at 1 ms, with
/// 15 constant elements by 1.7 %; a separate limit of 4 % applies up to 5 ms. With 6 pairs the fold angle differs by 0.05°, because the
/// time of the reference's 20 elements is 5e-4 too long.
#[test]
fn p03_histories_follow_the_reference() {
    let rows = reference_rows("folding_wing_still_air.csv");
    for (name, kind, count) in [("2 pairs", ElementKind::Linear, 2), ("15 constant", ElementKind::Constant, 15)] {
        let mut plant = start(wing(kind, count, Method::Esdirk4, 1e-5));
        let (mut fold_deg, mut early, mut strain, mut tip_m) = (0f64, 0f64, 0f64, 0f64);
        for row in rows.iter().skip(1).filter(|row| row[0] <= 0.3) {
            coast(&mut plant, row[0]);
            let outputs = plant.outputs();
            if row[0] < 0.122 {
                fold_deg = fold_deg.max((outputs.joints()[0].angle_rad.to_degrees() - row[1]).abs());
            }
            let difference = (outputs.gauges()[0] - row[2]).abs() / 5.31e-3;
            if row[0] < 5e-3 {
                early = early.max(difference)
            } else {
                strain = strain.max(difference)
            }
            let tip = outputs.tips()[0].position_m;
            tip_m = tip_m.max((tip.x - row[3]).abs()).max((-tip.z - row[4]).abs());
        }
        println!(
            "{name}: fold {fold_deg:.3}°, strain {:.2} % of the peak ({:.2} % before 5 ms), tip {tip_m:.1e} m",
            100.0 * strain,
            100.0 * early
        );
        assert!(fold_deg < 0.5, "{name}: fold angle differs by {fold_deg:.3}°");
        assert!(strain < 0.02, "{name}: strain differs by {:.2} % of the peak", 100.0 * strain);
        assert!(early < 0.04, "{name}: strain differs by {:.2} % of the peak before 5 ms", 100.0 * early);
        assert!(tip_m < 5e-4, "{name}: tip coordinates differ by {tip_m:.1e} m");
    }
}
