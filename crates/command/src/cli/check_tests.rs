//! Output of `check` for models with zero, one and several items in each list.

use super::*;
use foldwing_engine::machine::Gauge;

/// Models: one with a closed loop, and others with a latch and zero, one and several gauges.
fn machines() -> Vec<Machine> {
    let read = |name: &str| {
        let path = format!("{}/../../examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        foldwing_file::read(path).unwrap_or_else(|error| panic!("{error}")).0
    };
    let (mut four_bar, mut wing) = (read("models/four_bar"), read("models/folding_wing"));
    // the lists do not depend on the number of elements
    for body in four_bar.bodies.iter_mut().chain(&mut wing.bodies).filter(|body| body.is_beam()) {
        body.elements = 1;
    }
    let gauge = |n: usize| Gauge { name: format!("gauge{n}"), ..wing.gauges[0].clone() };
    let with = |count: usize| Machine { gauges: (0..count).map(gauge).collect(), ..wing.clone() };
    vec![with(1), with(0), with(2), four_bar, read("gear/castor")]
}

/// Lines of a section of the text.
fn section<'t>(text: &'t str, title: &str) -> Vec<&'t str> {
    let mut lines = text.lines().skip_while(|line| *line != title);
    if lines.next().is_none() {
        return Vec::new();
    }
    lines.take_while(|line| !line.is_empty()).collect()
}

/// Text and JSON list all bodies, joints, loops, gauges, notes and variables by name, in order, and no others, for any number of them.
#[test]
fn everything_is_listed_by_its_name() {
    for machine in machines() {
        let summary = Summary::new(&machine, "");
        let text = summary.text(true, false);
        let json: serde_json::Value = serde_json::from_str(&summary.json()).unwrap();
        let of_json = |key: &str| -> Vec<String> {
            let list = json[key].as_array().unwrap().iter();
            list.map(|own| own["name"].as_str().or(own.as_str()).unwrap().to_owned()).collect()
        };
        let bodies: Vec<&str> = machine.bodies.iter().map(|body| body.name.as_str()).collect();
        let joints: Vec<&str> = machine.bodies.iter().map(|body| body.joint.name.as_str()).collect();
        let loops: Vec<&str> = machine.closures.iter().map(|closure| closure.name.as_str()).collect();
        let runners: Vec<&str> = machine.no_slips.iter().map(|no_slip| no_slip.name.as_str()).collect();
        for (title, key, due) in [
            ("bodies", "bodies", bodies),
            ("joints", "joints", joints),
            ("closed loops", "loops", loops),
            ("skates and wheels", "skates_and_wheels", runners),
        ] {
            let listed: Vec<&str> =
                section(&text, title).iter().map(|line| line.trim_start().split(':').next().unwrap()).collect();
            assert_eq!(listed, due, "{title} of {}", machine.name);
            assert_eq!(of_json(key), due, "{key} of {}", machine.name);
        }
        let gauges: Vec<&str> = machine.gauges.iter().map(|gauge| gauge.name.as_str()).collect();
        let listed = text.lines().find_map(|line| line.strip_prefix("gauges: ")).unwrap();
        assert_eq!(listed, if gauges.is_empty() { "none".to_owned() } else { gauges.join(", ") });
        assert_eq!(of_json("gauges"), gauges);
        let noted: Vec<&str> = section(&text, "notes").iter().map(|line| line.trim_start()).collect();
        assert_eq!(noted, notes(&machine, machine.experiment.stop_time_s));
        assert_eq!(of_json("notes"), noted);
    }
}

/// Text and JSON list every variable with its causality, start value, unit and description, and the counts agree with the list.
#[test]
fn variables_are_those_of_the_interface() {
    for machine in machines() {
        let interface = Interface::new(&machine);
        let summary = Summary::new(&machine, "");
        let text = summary.text(true, false);
        let json: serde_json::Value = serde_json::from_str(&summary.json()).unwrap();
        let mut counts = [0; 3];
        let begin = text.lines().position(|line| line.ends_with(" parameters")).unwrap();
        let lines: Vec<&str> = text.lines().skip(begin).collect();
        let listed = json["variables"].as_array().unwrap();
        assert_eq!([listed.len(), lines.len() - 1], [interface.variables().len(); 2]);
        for ((row, line), own) in interface.variables().iter().zip(&lines[1..]).zip(listed) {
            let causality = match row.causality {
                Causality::Input => "input",
                Causality::Output => "output",
                Causality::Parameter => "parameter",
                Causality::Local => "local",
                Causality::Independent => "independent",
            };
            if let Some(kind) = ["input", "output", "parameter"].iter().position(|kind| *kind == causality) {
                counts[kind] += 1;
            }
            let start = match (row.value, causality) {
                (_, "output" | "local" | "independent") => None,
                (Value::Real(value), _) => Some(format!("{value:?}")),
                (Value::Integer(value), _) => Some(value.to_string()),
                (Value::Boolean(value), _) => Some(value.to_string()),
            };
            let unit = if row.unit().is_empty() { String::new() } else { format!(" [{}]", row.unit()) };
            let shown = start.as_ref().map(|start| format!(" = {start}")).unwrap_or_default();
            assert_eq!(*line, format!("  {causality} {}{shown}{unit}: {}", row.name, row.description));
            for (key, due) in [
                ("name", &*row.name),
                ("causality", causality),
                ("unit", row.unit()),
                ("description", &*row.description),
            ] {
                assert_eq!(own[key], due, "{own}");
            }
            let start = start.map_or(serde_json::Value::Null, |start| serde_json::from_str(&start).unwrap());
            assert_eq!(own["start"].as_f64(), start.as_f64(), "{own}");
            assert_eq!(own["start"].as_bool(), start.as_bool(), "{own}");
        }
        assert_eq!(lines[0], format!("{} inputs, {} outputs, {} parameters", counts[0], counts[1], counts[2]));
    }
}

/// In the text, joint parameters are followed by their unit; in the JSON, the unit is that of the key.
#[test]
fn numbers_of_joints_have_their_units() {
    let machine = machines().swap_remove(0);
    for travel in [Travel::Rotation, Travel::Translation] {
        let (turn, unit, torque, key) = match travel {
            Travel::Rotation => (180.0 / std::f64::consts::PI, "deg", "N.m", ["angle_deg", "n_m", "n_m_s", "torque"]),
            Travel::Translation => (1.0, "m", "N", ["position_m", "n", "n_s", "force"]),
        };
        let joint = machine.bodies.iter().find_map(|body| body.joint.kind.one_freedom()).expect("a fold").1.clone();
        let figures = Figures::of_one_freedom(travel, &joint);
        let json = serde_json::to_value(&figures).unwrap();
        let latch = joint.latch.as_ref().expect("a latch");
        let text = JointSummary { figures, ..JointSummary::new(&machine.bodies[1], &machine, (0, 0)) }.text();
        let per = |of: &str| format!("{of}/{}", if travel == Travel::Rotation { "rad" } else { "m" });
        let drive = &joint.motor;
        let [angle, n_m, n_m_s, torque_key] = key;
        let over = if travel == Travel::Rotation { "rad" } else { "m" };
        for (name, name_key, value, unit) in [
            ("start", format!("start_{angle}"), joint.start_angle_rad * turn, unit.to_owned()),
            ("k", format!("stiffness_{n_m}_{over}"), drive.stiffness_n_m_rad, per(torque)),
            ("c", format!("damping_{n_m_s}_{over}"), drive.damping_n_m_s_rad, per(&format!("{torque}.s"))),
            ("T", format!("constant_{torque_key}_{n_m}"), drive.constant_torque_n_m, torque.to_owned()),
            ("latch at", format!("latch_{angle}"), latch.angle_rad * turn, unit.to_owned()),
            ("latch stiffness", format!("latch_stiffness_{n_m}_{over}"), latch.stiffness_n_m_rad, per(torque)),
        ] {
            let shown = format!(", {name} {} {unit}", (value * 1e9).round() / 1e9);
            assert!(format!("{},", text.trim_end()).contains(&format!("{shown},")), "{shown} in {text}");
            let found = json[&name_key].as_f64().unwrap_or_else(|| panic!("{name_key} in {json}"));
            assert!((found - value).abs() <= 1e-12 * value.abs(), "{name_key} in {json}");
        }
    }
}
