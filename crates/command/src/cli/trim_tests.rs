//! Output of `trim`.

use super::*;
use crate::packaging::drawing::tests::two_body_machine;

/// Unknowns are reported under the given names with their units, also unknowns shared by several inputs, and targets under theirs; settings
/// are listed for each input with its sign. Text and JSON have the same numbers.
#[test]
fn results_have_the_names_and_units_that_were_given() {
    let mut machine = two_body_machine();
    machine.bodies.iter_mut().for_each(|body| body.elements = 1); // the names do not depend on the number of elements
    let interface = Interface::new(&machine);
    let unit = |name: &str| interface.find(name).expect("a variable").unit();
    for free in [
        vec!["gravity.x"],
        vec!["gravity.x,-gravity.z"],
        vec!["-gravity.z, gravity.x"],
        vec!["gravity.y", "-gravity.x,gravity.z"],
    ] {
        let free: Vec<String> = free.into_iter().map(str::to_owned).collect();
        let targets = [("root.force.x", 2.0), ("root.force.y", -1.0)];
        let targets = targets.map(|(output, value)| Target { output: output.to_owned(), value });
        let targets = targets[..free.len()].to_vec();
        let plant = plant_with(machine.clone(), &interface, &[]).unwrap();
        let options = Options { solve_for: free.clone(), targets, ..Options::default() };
        let found = foldwing_study::trim::solve(plant, &options).unwrap_or_else(|error| panic!("{error}"));
        let (text, json) = (text(&found), json!(found));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(json["free"].as_object().map(serde_json::Map::len), Some(free.len()), "{json}");
        for ((name, Solved { value, .. }), line) in free.iter().zip(&found.solved).zip(&lines[1..]) {
            let first = name.split(',').next().unwrap().trim_start_matches('-');
            assert_eq!(*line, format!("{name} = {} {}", six(*value), unit(first)));
            assert_eq!(json["free"][name], json!(value), "{json}");
            for part in name.split(',').map(str::trim) {
                let (sign, own) = part.strip_prefix('-').map_or((1.0, part), |own| (-1.0, own));
                assert_eq!(json["settings"][own], json!(sign * value), "{json}");
                let setting = format!("--set {own}={:?}", sign * value);
                assert!(lines[lines.len() - 1].split("  ").any(|line| line.contains(&setting)), "{text}");
            }
        }
        for (Target { output: name, value: target }, line) in options.targets.iter().zip(&lines[1 + free.len()..]) {
            let value = json["balances"][name].as_f64().expect("a number");
            assert!((value - target).abs() < 1e-8, "{json}");
            assert!(line.starts_with(&format!("{name}: {} {}, off by ", six(value), unit(name))), "{line}");
        }
    }
}
