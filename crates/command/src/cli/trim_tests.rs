//! Output of `trim`.

use super::*;
use crate::packaging::drawing::tests::two_body_machine;

/// Unknowns are reported under the given names, also those with a common value, with their unit, and targets under theirs; the settings are
/// those of each input with its sign. JSON has the numbers of the text.
#[test]
fn results_have_the_names_and_units_that_were_given() {
    let mut machine = two_body_machine();
    machine.bodies.iter_mut().for_each(|body| body.elements = 1); // the names do not depend on them
    let interface = Interface::new(&machine);
    let unit = |name: &str| interface.find(name).expect("a variable").unit();
    for free in [
        vec!["gravity.x"],
        vec!["gravity.x,-gravity.z"],
        vec!["-gravity.z, gravity.x"],
        vec!["gravity.y", "-gravity.x,gravity.z"],
    ] {
        let free: Vec<String> = free.into_iter().map(str::to_owned).collect();
        let balances = [("root.force.x", 2.0), ("root.force.y", -1.0)].map(|(name, value)| (name.to_owned(), value));
        let balances = &balances[..free.len()];
        let plant = plant_with(machine.clone(), &interface, &[]).unwrap();
        let mut trim = Trim::new(&interface, plant, &free, balances, &[]).unwrap();
        let (values, left, steps) = trim.find().unwrap_or_else(|failure| panic!("{failure:?}"));
        let (text, json) = (trim.text(&values, &left, steps), trim.as_json(&values, steps));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(json["free"].as_object().map(serde_json::Map::len), Some(free.len()), "{json}");
        for ((name, value), line) in free.iter().zip(values.iter()).zip(&lines[1..]) {
            let first = name.split(',').next().unwrap().trim_start_matches('-');
            assert_eq!(*line, format!("{name} = {value:?} {}", unit(first)));
            assert_eq!(json["free"][name], json!(value), "{json}");
            for part in name.split(',').map(str::trim) {
                let (sign, own) = part.strip_prefix('-').map_or((1.0, part), |own| (-1.0, own));
                assert_eq!(json["settings"][own], json!(sign * value), "{json}");
                let setting = format!("--set {own}={:?}", sign * value);
                assert!(lines[lines.len() - 1].split("  ").any(|line| line.contains(&setting)), "{text}");
            }
        }
        for ((name, target), line) in balances.iter().zip(&lines[1 + free.len()..]) {
            let value = json["balances"][name].as_f64().expect("a number");
            assert!((value - target).abs() < 1e-8, "{json}");
            assert!(line.starts_with(&format!("{name}: {value:.9e} {}, off by ", unit(name))), "{line}");
        }
    }
}

/// A pendulum of 1 kg at 1 m rotates by the `arctan` of the ratio of two components of gravity, which flattens: from three times the other
/// one, the full Newton step towards a small angle leads to the other side and further away. Halved steps converge,
/// at `g_z = −g_x tan θ − kθ/(m l cos θ)`.
#[test]
fn steps_that_lead_away_are_halved() {
    use foldwing_engine::machine::{Body, Joint, Machine, Spring};
    const ANGLE_RAD: f64 = 0.2;
    let spring = Spring { stiffness_n_m_rad: 0.1, damping_n_m_s_rad: 0.0, rest_angle_rad: 0.0 };
    let machine = Machine::builder("Pendulum")
        .gravity_m_s2([10.0, 0.0, 30.0])
        .body(
            Body::rigid("arm").inertia(1.0, [1.0, 0.0, 0.0], nalgebra::Matrix3::identity()),
            Joint::revolute("hinge", [0.0, 1.0, 0.0]).spring(spring),
        )
        .build()
        .unwrap_or_else(|refused| panic!("{refused}"));
    let interface = Interface::new(&machine);
    let plant = plant_with(machine, &interface, &[]).unwrap();
    let (free, balances) = (["gravity.z".to_owned()], [("hinge.angle".to_owned(), ANGLE_RAD)]);
    let mut trim = Trim::new(&interface, plant, &free, &balances, &[]).unwrap();
    let (values, left, steps) = trim.find().unwrap_or_else(|failure| panic!("{failure:?}"));
    let expected_m_s2 = -10.0 * ANGLE_RAD.tan() - 0.1 * ANGLE_RAD / ANGLE_RAD.cos();
    // the tolerance of the residuals, 1e-9, over the slope of the angle
    assert!((values[0] - expected_m_s2).abs() < 1e-7, "{} for {expected_m_s2} after {steps} steps, {left}", values[0]);
}
