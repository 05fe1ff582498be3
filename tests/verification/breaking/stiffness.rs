//! Load paths that keep a fraction of their stiffness: springs, closed loops, beams.

use crate::breaking::*;
use foldwing::config;
use foldwing::machine::builder::JointBuilder;
use foldwing::machine::{Failure, Spring};
use std::path::Path;

/// FL-25. A rotor on a spring that keeps a quarter of its stiffness oscillates at half its frequency from then on.
#[test]
fn fl25_a_spring_keeps_a_share() {
    let stiffness_n_m_rad = INERTIA_KG_M2 * FREQUENCY_RAD_S.powi(2);
    let joint = |joint: JointBuilder| {
        joint.spring(Spring { stiffness_n_m_rad, ..Spring::default() }).start_angle_rad(START_RAD)
    };
    let fails_s = 0.1;
    let mut plant = begun(joint, Failure::spring_break("spring", "hinge", 0.25).at_time_s(fails_s));
    assert!(drift_j(&mut plant, 1.0, 9) < 1e-8);
    let at = |f: fn(f64) -> f64, w: f64, t: f64| f(w * t);
    let (angle_rad, rate_rad_s) = (
        START_RAD * at(f64::cos, FREQUENCY_RAD_S, fails_s),
        -START_RAD * FREQUENCY_RAD_S * at(f64::sin, FREQUENCY_RAD_S, fails_s),
    );
    let half = 0.5 * FREQUENCY_RAD_S;
    let expected = angle_rad * at(f64::cos, half, 0.9) + rate_rad_s / half * at(f64::sin, half, 0.9);
    let found = plant.outputs().joints()[0].angle_rad;
    assert!((found - expected).abs() < 1e-7, "{found} rad for {expected} rad");
    let lost_j = 0.75 * 0.5 * stiffness_n_m_rad * angle_rad * angle_rad;
    assert!((plant.outputs().energy().dissipated - lost_j).abs() < 1e-8);
}

fn shipped(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/models/{name}.toml"));
    std::fs::read_to_string(path).expect("a shipped model")
}

/// FL-26. The ends of an opened loop separate; the energy balance closes, and the loop transmits no force any more. If one of two loops on
/// the same pin opens, the other still holds it.
#[test]
fn fl26_a_loop_opens() {
    let text = shipped("four_bar");
    let failing = |names: &[&str]| {
        let opens =
            |name| format!("\n[failure.{name}]\nkind = \"loop_break\"\nloop = \"{name}\"\nat_time_s = 0.0403\n");
        let failures: String = names.iter().map(opens).collect();
        start(config::parse(&(text.clone() + &failures), "four_bar").unwrap_or_else(|e| panic!("{e}")))
    };
    let mut held = failing(&["front"]);
    drift_j(&mut held, 0.2, 80);
    let [front, back] = [0, 1].map(|index| held.outputs().loops()[index]);
    assert!(front.force_n.norm() == 0.0 && back.force_n.norm() > 0.0 && front.gap_m.norm() < 1e-3);
    let mut plant = failing(&["front", "back"]);
    let scale_j = plant.outputs().energy().total.abs().max(1e-3);
    let before = drift_j(&mut plant, 0.04, 20);
    assert!(plant.outputs().loops()[0].gap_m.norm() < 1e-3);
    let after = drift_j(&mut plant, 0.2, 80);
    assert!(after < 20.0 * before.max(1e-7 * scale_j), "drift {after:e} J behind, {before:e} J before it opens");
    assert_eq!(failed_s(&plant, 0), Some(0.0403));
    let end = plant.outputs().loops()[0];
    assert!(end.gap_m.norm() > 1e-2, "gap {} m", end.gap_m.norm());
    assert_eq!(end.force_n.norm(), 0.0);
}

/// FL-27. A beam that keeps a fraction of its stiffness bends like a beam of that stiffness; its modes from the start equal those with a
/// stiffness factor.
#[test]
fn fl27_a_beam_weakens() {
    let text = shipped("folding_wing");
    let failure = "\n[failure.crack]\nkind = \"stiffness_loss\"\nbody = \"inner\"\nremaining_fraction = 0.25\n";
    let machine = config::parse(&(text + failure), "wing").unwrap_or_else(|error| panic!("{error}"));
    let frequencies = |by_failure: bool| {
        let mut plant = Plant::new(std::sync::Arc::new(machine.clone()));
        if by_failure {
            trigger(&mut plant, 0);
        } else {
            plant.parameters_mut().bodies_mut()[0].stiffness_factor = 0.25;
        }
        plant.initialize(0.0).expect("starts");
        let modes = plant.study().modes(6).expect("has modes");
        modes.iter().map(|mode| mode.frequency_hz).collect::<Vec<f64>>()
    };
    let (weak, soft) = (frequencies(true), frequencies(false));
    for (weak, soft) in weak.iter().zip(&soft) {
        assert!((weak - soft).abs() <= 1e-9 * soft, "{weak} Hz, {soft} Hz");
    }
    let mut plant = start(machine);
    drift_j(&mut plant, 0.11, 11);
    trigger(&mut plant, 0);
    let drift = drift_j(&mut plant, 0.115, 5);
    assert!(failed_s(&plant, 0) == Some(0.11) && drift < 1e-4, "energy account drifts by {drift:e} J");
}

/// FL-28. Failures of one load path multiply, and a failure that has not occurred restores nothing: a loop opened by one failure stays open
/// while another is pending; two factors of one half give exactly one quarter.
#[test]
fn fl28_failures_of_one_load_path_multiply() {
    let text = shipped("four_bar");
    let failing = |failures: &[(&str, f64, f64)]| {
        let written = |&(name, at_s, remaining): &(&str, f64, f64)| {
            format!(
                "\n[failure.{name}]\nkind = \"loop_break\"\nloop = \"front\"\nat_time_s = {at_s:?}\nremaining_fraction = {remaining:?}\n"
            )
        };
        let failures: String = failures.iter().map(written).collect();
        let mut plant = start(config::parse(&(text.clone() + &failures), "four_bar").unwrap_or_else(|e| panic!("{e}")));
        drift_j(&mut plant, 0.1, 40);
        plant.outputs().loops()[0].force_n.norm()
    };
    for order in [[("a", 0.02, 0.0), ("b", 5.0, 0.0)], [("a", 5.0, 0.0), ("b", 0.02, 0.0)]] {
        assert_eq!(failing(&order), 0.0, "{order:?}");
    }
    let halves = failing(&[("a", 0.02, 0.5), ("b", 0.02, 0.5)]);
    let quarter = failing(&[("a", 0.02, 0.25)]);
    assert!(quarter > 0.0 && halves == quarter, "{halves} N, {quarter} N");
}

/// FL-29. A spring that breaks takes its damper with it: the rotor continues at its current rate.
#[test]
fn fl29_a_spring_breaks_with_its_damper() {
    let stiffness_n_m_rad = INERTIA_KG_M2 * FREQUENCY_RAD_S.powi(2);
    let joint = |joint: JointBuilder| {
        let spring = Spring { stiffness_n_m_rad, damping_n_m_s_rad: 0.1 * stiffness_n_m_rad, ..Spring::default() };
        joint.spring(spring).start_angle_rad(START_RAD)
    };
    let mut plant = begun(joint, Failure::spring_break("spring", "hinge", 0.0).at_time_s(0.1));
    drift_j(&mut plant, 0.2, 3);
    let rate_rad_s = plant.outputs().joints()[0].rate_rad_s;
    drift_j(&mut plant, 1.0, 5);
    let end_rad_s = plant.outputs().joints()[0].rate_rad_s;
    assert!(rate_rad_s < -0.1 && (end_rad_s - rate_rad_s).abs() < 1e-9, "{rate_rad_s} {end_rad_s} rad/s");
}
