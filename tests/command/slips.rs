//! Mistakes on the command line and in files, and outputs that used to omit information.

use std::path::Path;
use std::process::{Command, Output};

const WING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing.toml");

fn foldwing(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_foldwing")).args(arguments).current_dir(folder).output().expect("the command runs")
}

/// Runs the command as `foldwing` does, and also returns its processor time in s, which does not depend on the load of the computer; `None`
/// where no Unix shell can measure it.
fn timed(folder: &Path, arguments: &[&str]) -> (Output, Option<f64>) {
    if cfg!(not(unix)) {
        return (foldwing(folder, arguments), None);
    }
    let script = "\"$0\" \"$@\"; code=$?; times > processor_time; exit $code";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_foldwing")]).args(arguments);
    let output = shell.current_dir(folder).output().expect("the shell runs");
    let times = std::fs::read_to_string(folder.join("processor_time")).expect("written by the shell");
    // user and system time of the shell, then of its child: 0m1.250s
    let seconds = |time: &str| -> Option<f64> {
        let (minutes, seconds) = time.trim_end_matches('s').split_once('m')?;
        Some(60.0 * minutes.parse::<f64>().ok()? + seconds.parse::<f64>().ok()?)
    };
    let spent: Option<f64> = times.split_whitespace().skip(2).map(seconds).sum();
    assert!(spent.is_some(), "{times}");
    (output, spent)
}

#[track_caller]
fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[track_caller]
fn refuses(output: &Output, code: i32, message: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    assert!(stderr.contains(message), "`{message}` is not in\n{stderr}");
}

/// A linear model describes its operating point: in print, as JSON, for NumPy. The released wing's equilibrium is the latched one; the
/// start is not an equilibrium, because the motor starts to move the wing; a locked wing is at 170 degrees. "128 states at t = 0 s" used to
/// be the whole description.
#[test]
fn a_linear_model_says_at_which_state_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let point = |arguments: &[&str]| -> (String, serde_json::Value) {
        let file = folder.path().join("x.json");
        let chosen = ["linearize", WING, "--inputs", "fold.external_torque", "--outputs", "fold.angle", "-o", "x.json"];
        let text = succeeds(&foldwing(folder.path(), &[&chosen, arguments].concat()));
        (text, serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap())
    };
    let (text, json) = point(&[]);
    assert!(text.contains("about an equilibrium at t = 0 s; fold at -0.0095 deg, free, latch closed; with"), "{text}");
    assert!(text.contains("gravity.x = -9.8 m/s2"), "{text}");
    assert_eq!((&json["state"]["equilibrium"], &json["time_s"]), (&true.into(), &0.0.into()));
    let joint = &json["state"]["joints"][0];
    assert_eq!((&joint["name"], &joint["motion"], &joint["latch"]), (&"fold".into(), &"free".into(), &"closed".into()));
    assert!(joint["angle_rad"].as_f64().unwrap().abs() < 1e-3, "{joint}");
    let acting = json["state"]["acting"].as_array().unwrap();
    let value = |name: &str| acting.iter().find(|acting| acting["name"] == name).map(|acting| &acting["value"]);
    assert_eq!((value("fold.release"), value("gravity.x")), (Some(&true.into()), Some(&(-9.8).into())));
    assert_eq!(value("gravity.y"), None, "what is 0 does not act");

    let (text, json) = point(&["--state", "start"]);
    assert!(
        text.contains("about a state that is not an equilibrium at t = 0 s; fold at 170.0000 deg, free, latch open")
    );
    assert_eq!(json["state"]["equilibrium"], false);
    let (text, _) = point(&["--set", "fold.release=0", "--set", "load.outer[1].force.z=0.1"]);
    assert!(text.contains("fold at 170.0000 deg, held, latch open"), "{text}");
    assert!(text.contains("load.outer[1].force.z = 0.1 N") && text.contains("fold.release = false"), "{text}");

    let long = ["linearize", WING, "--state", "0.5", "--outputs", "fold.angle", "-o", "x.npz"];
    let output = foldwing(folder.path(), &long);
    succeeds(&output);
    let note = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(note.contains("--state 0.5 lies after the end of the simulation, 0.4 s"), "{note}");
    let mut archive = zip::ZipArchive::new(std::fs::File::open(folder.path().join("x.npz")).unwrap()).unwrap();
    for name in ["equilibrium", "joint_names", "joint_angles_rad", "joint_motions", "joint_latches"] {
        assert!(archive.by_name(&format!("{name}.npy")).is_ok(), "{name}");
    }
    assert!(archive.by_name("acting_values.npy").is_ok() && archive.by_name("acting_names.npy").is_ok());
}

/// A linear model about an unstable state reports this, in print and in every file: a rod of 0.3 m, upright on a free hinge, falls with
/// `√(3g/2L)` = 7.0036 1/s, for a thin rod in equilibrium; unstrained at the start it also starts to deform, which adds 2e-3 to that.
#[test]
fn a_linear_model_of_an_unstable_state_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let rod = |start_deg: f64| {
        format!(
            "name = \"Rod\"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[section.plate]\nshape = \"rectangle\"\nwidth_m = 0.05\n\
             height_m = 0.002\ndensity_kg_m3 = 1425.0\nyoungs_modulus_Pa = 2.83e9\ntorsional_rigidity_N_m2 = 0.18\n[body.rod]\n\
             length_m = 0.3\nsection = \"plate\"\nelements = 8\n[joint.h]\ntype = \"revolute\"\nparent = \"root\"\n\
             child = \"rod\"\naxis = [0.0, 1.0, 0.0]\nstart_angle_deg = {start_deg:?}\n"
        )
    };
    for (start_deg, unstable) in [(-90.0, true), (90.0, false)] {
        std::fs::write(folder.path().join("rod.toml"), rod(start_deg)).unwrap();
        let call = |file: &str| {
            succeeds(&foldwing(folder.path(), &["linearize", "rod.toml", "--state", "start", "-o", file, "--force"]))
        };
        let text = call("x.json");
        assert_eq!(text.contains("UNSTABLE: grows with 7.0"), unstable, "{text}");
        assert!(!text.contains("oscillating"), "{text}");
        let json: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(folder.path().join("x.json")).unwrap()).unwrap();
        let growing = json["state"]["growing_1_s"].as_array().unwrap();
        assert_eq!(growing.len(), usize::from(unstable), "{json}");
        for lambda in growing {
            let [re, im] = [0, 1].map(|part| lambda[part].as_f64().unwrap());
            assert!((re - 7.0036).abs() < 0.02 && im.abs() < 1e-6, "{lambda}");
        }
        call("x.npz");
        let mut archive = zip::ZipArchive::new(std::fs::File::open(folder.path().join("x.npz")).unwrap()).unwrap();
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut archive.by_name("growing_1_s.npy").unwrap(), &mut bytes).unwrap();
        let shape = format!("'shape': ({}, 2)", u8::from(unstable));
        assert!(String::from_utf8_lossy(&bytes[..128]).contains(&shape), "{shape}");
        call("x.mat");
        let bytes = std::fs::read(folder.path().join("x.mat")).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains("growing_1_s"));
    }
}

/// Control characters enter a model by escapes; importers cannot read a description that contains them. Line feeds and tabs are kept.
#[test]
fn descriptions_are_such_that_importers_can_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(WING).unwrap();
    let describe = |letters: &str| {
        let line = format!("description = \"{letters}\"\n");
        let rest: String =
            text.lines().filter(|line| !line.starts_with("description")).map(|line| format!("{line}\n")).collect();
        std::fs::write(folder.path().join("wing.toml"), line + &rest).unwrap();
        foldwing(folder.path(), &["package", "wing.toml", "--description-only"])
    };
    let refused = "wing.toml:1: key 'description': a text with the control character U+0001 is not allowed";
    refuses(&describe("a\\u0001b"), 1, refused);
    refuses(&describe("a\\u0001b"), 1, "^ allowed: text without control characters except line feeds and tabs");
    // a small random generator of the test: results depend on the letters, not on the order in which they are tried
    let mut state = 7_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as u32
    };
    for _ in 0..60 {
        let classes = [0x20, 0x80, 0x3000, 0xffff, 0x10_ffff];
        let letters = (0..12).map(|_| next() % classes[next() as usize % classes.len()]);
        let letters: Vec<char> = letters.filter_map(char::from_u32).collect();
        let escaped: String = letters.iter().map(|letter| format!("\\U{:08X}", u32::from(*letter))).collect();
        let output = describe(&escaped);
        let bad = |c: &char| c.is_control() && !matches!(c, '\n' | '\r' | '\t') || matches!(c, '\u{fffe}' | '\u{ffff}');
        assert_eq!(output.status.success(), !letters.iter().any(bad), "{escaped}");
        if output.status.success() {
            let xml = String::from_utf8(output.stdout).unwrap();
            let mut reader = quick_xml::Reader::from_str(&xml);
            let root = loop {
                match reader.read_event().unwrap() {
                    quick_xml::events::Event::Start(root) => break root.into_owned(),
                    quick_xml::events::Event::Eof => panic!("no element"),
                    _ => {}
                }
            };
            let found = root.attributes().flatten().find(|attribute| attribute.key.0 == "description").unwrap();
            let value = quick_xml::escape::unescape(&found.value).unwrap().into_owned();
            assert_eq!(value, letters.iter().collect::<String>(), "{escaped}");
        }
    }
}

/// Mistakes whose messages used to be incomplete, or late.
#[test]
fn slips_are_answered_with_what_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(WING).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let run = |arguments: &[&str]| foldwing(folder.path(), &[&["simulate"], arguments].concat());
    let short = |more: &[&str]| run(&[&[WING, "--stop", "1e-3"], more].concat());
    // no output besides the summary
    assert!(succeeds(&short(&[])).is_empty());
    assert!(String::from_utf8_lossy(&short(&[]).stderr).contains("fold: did not latch"));
    // degrees if the unit is given
    let angle = |value: &str| {
        let set = format!("fold.start_angle={value}");
        succeeds(&short(&["--csv", "-", "--variables", "fold.angle", "--set", &set])).lines().nth(1).unwrap().to_owned()
    };
    assert_eq!(angle("90 deg"), angle(&format!("{:?}", 90f64.to_radians())));
    refuses(&short(&["--set", "fold.start_angle=90 kg"]), 2, "`kg` is not one of its units; allowed: rad and deg");
    refuses(&short(&["--set", "fold.start_angle=110"]), 2, "in degrees write \"110 deg\"");
    refuses(&short(&["--set", "file:solver.tolerance=1e-5"]), 2, "`foldwing sweep --vary`");
    // invalid inputs
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    refuses(&short(&["--inputs", "folder"]), 4, "folder: cannot be read");
    write("semicolon.csv", "time;fold.angle_command\n0;0\n");
    refuses(&short(&["--inputs", "semicolon.csv"]), 1, "columns are separated by `;`");
    write("long.csv", &format!("time,{}\n0,0\n", "x".repeat(5_000_000)));
    let (output, spent_s) = timed(folder.path(), &["simulate", WING, "--stop", "1e-3", "--inputs", "long.csv"]);
    refuses(&output, 1, "no input is named `xxx");
    assert!(output.stderr.len() < 500 && spent_s.is_none_or(|spent_s| spent_s < 10.0), "{spent_s:?} s, it took 18");
    write("cell.csv", &format!("time,fold.angle_command\n0,{}\n", "x".repeat(5_000_000)));
    assert!(short(&["--inputs", "cell.csv"]).stderr.len() < 500);
    refuses(
        &short(&["--csv", "-", "--set", "fold.angle_command=1e300"]),
        3,
        "the largest input is fold.angle_command = 1e300 rad",
    );
    // invalid model files
    write("x.fmu", "PK\u{3}\u{4} and so on");
    refuses(&run(&["x.fmu"]), 1, "`foldwing run` runs FMUs");
    write("comma.toml", "name = \"X\"\nheight_m = 0,004\n");
    refuses(&run(&["comma.toml"]), 1, "comma.toml:2: not valid TOML: ");
    refuses(&run(&["comma.toml"]), 1, "a decimal comma? write 0.004");
    write("twice.toml", "name = \"X\"\n[gauge.root] # first\nbody = \"a\"\n[gauge.root]\nbody = \"b\"\n");
    refuses(&run(&["twice.toml"]), 1, "twice.toml:4: not valid TOML: duplicate key: [gauge.root], already on line 2");
    write("key.toml", "name = \"X\"\n[gauge.root]\nbody = \"a\"\nbody = \"b\"\n");
    refuses(&run(&["key.toml"]), 1, "key.toml:4: not valid TOML: duplicate key: body, already on line 3");
    // the output for many errors is not many times as long
    let keys: String = (0..100_000).map(|i| format!("nonsense_{i} = 1\n")).collect();
    write("many.toml", &(keys + &text));
    let (output, spent_s) = timed(folder.path(), &["simulate", "many.toml"]);
    refuses(&output, 1, "and 99800 further problems after this line");
    assert!(spent_s.is_none_or(|spent_s| spent_s < 10.0), "{spent_s:?} s");
}
