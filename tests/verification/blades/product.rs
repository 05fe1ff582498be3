//! B-20, B-21: the shipped curved blade through the model file and the plant.

use foldwing::config;
use foldwing::plant::Plant;
use nalgebra::Vector3;
use std::sync::Arc;

fn blade(change: impl Fn(&str) -> String) -> Plant {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/curved_blade.toml");
    let text = change(&std::fs::read_to_string(path).expect("the shipped model"));
    Plant::new(Arc::new(config::parse(&text, "curved_blade.toml").unwrap_or_else(|error| panic!("{error}"))))
}

/// B-20. Without loads the curved and twisted blade is in equilibrium in its natural shape: gauges read zero (they used to read the natural
/// curvature), nothing moves, and the tip is at its prescribed position: 4 m edgewise, 3 m flapwise to second order in the arc's angle,
/// rotated by the twist of 20°. Tolerance: 1e-3 of the length, for terms of fourth order in the arc's angle.
#[test]
fn b20_a_curved_blade_rests_in_its_natural_shape() {
    let mut plant = blade(|text| text.replacen("gravity_m_s2 = [0.0, 0.0, -9.81]", "", 1));
    plant.initialize(0.0).unwrap();
    plant.step(0.5).unwrap();
    let outputs = plant.outputs();
    assert!(outputs.gauges().iter().all(|strain| strain.abs() < 1e-15), "{:?}", outputs.gauges());
    let tip = &outputs.tips()[0];
    assert!(tip.velocity_m_s.norm() < 1e-12);
    let expected = Vector3::new(90.0 - 2.0 * 25.0 / (3.0 * 90.0), 4.0, 3.0);
    assert!((tip.position_m - expected).norm() < 0.09, "tip at {}", tip.position_m);
    // axes of the tip section: the chord is rotated by 20° towards z, minus the contribution of the arc's slope
    let chord = tip.rotation * Vector3::y();
    assert!((chord.z.atan2(chord.y).to_degrees() - 20.0).abs() < 0.5, "{chord}");
}

/// B-21. The strain report and the gauges agree: the gauge on the upper face at the root reads `γ + b k₂` of the report's measures, the
/// largest strain of the report is at least as large, and the two gauges at ±45° differ by the shear strain of torsion.
#[test]
fn b21_report_and_gauges_agree() {
    let mut plant = blade(|text| {
        text.to_owned() + "[gauge.mirror]\nbody = \"blade\"\nposition_m = 0.0\ndirection = [1.0, -1.0, 0.0]\n"
    });
    plant.initialize(0.0).unwrap();
    plant.step(1.0).unwrap();
    let gauges = &plant.outputs().gauges();
    let root = plant.section_strains()[0];
    let (a, b) = (0.5 * 4.45, 0.5 * 1.1125);
    let [stretch, twist, bend, _] = root.measures.into();
    assert!(stretch.abs() + twist.abs() > 0.0);
    assert!((gauges[0] - (stretch + b * bend)).abs() < 1e-15, "{} and {}", gauges[0], root.measures);
    assert!(root.largest.abs() >= gauges[0].abs() && root.largest.abs() > 1e-5);
    let shear = -2.0 * a * a * b / (a * a + b * b) * twist;
    assert!((gauges[2] - gauges[3] - shear).abs() < 1e-15, "{} and {shear}", gauges[2] - gauges[3]);
    assert_eq!(plant.section_strains().len(), 9, "ends of eight pairs");
}
