//! Typical mistakes in model files and on the command line: each message marks the location with a caret and gives the remedy. Implausible
//! input gives a warning.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const WING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing.toml");

fn foldwing(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_foldwing"));
    command.args(arguments).current_dir(folder).output().expect("the command runs")
}

fn wing() -> String {
    std::fs::read_to_string(WING).unwrap()
}

/// Text at the first caret of a message, with the line number if there is one.
fn pointed_at(answer: &str) -> Option<(Option<usize>, String)> {
    let lines: Vec<&str> = answer.lines().collect();
    let at = lines.iter().position(|line| line.trim_start().starts_with('|') && line.contains('^'))?;
    let (source, carets): (Vec<char>, Vec<char>) = (lines[at - 1].chars().collect(), lines[at].chars().collect());
    let from = carets.iter().position(|letter| *letter == '^')?;
    let to = from + carets[from..].iter().take_while(|letter| **letter == '^').count();
    let number = lines[at - 1].split('|').next()?.trim().parse().ok();
    Some((number, source.get(from..to.min(source.len()))?.iter().collect()))
}

/// Text in the file, its replacement, the text at the caret, and parts of the remedy.
const IN_FILES: &[(&str, &str, &str, &str)] = &[
    ("length_m = 0.15", "lenght_m = 0.15", "lenght_m", "perhaps length_m is meant"),
    ("width_m = 0.05", "width_mm = 50", "width_mm", "write width_m (m)"),
    ("height_m = 0.002", "height_m = 0,002", "0,002", "a decimal comma? write 0.002"),
    ("height_m = 0.002", "height_m = -0.002", "-0.002", "allowed: a finite length > 0 m"),
    ("section = \"plate\"", "section = \"plat\"", "\"plat\"", "(did you mean \"plate\"?)"),
    ("elements = 4", "elements = 4.5", "4.5", "allowed: a whole number from 1 to 1000"),
    ("elements = 4", "elements = 0", "0", "allowed: a whole number from 1 to 1000"),
    ("axis = [0.0, 1.0, 0.0]", "axis = \"y\"", "\"y\"", "perhaps [0.0, 1.0, 0.0]"),
    ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 1.0]", "[0.0, 1.0]", "allowed: an array of 3 finite numbers"),
    ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "[0.0, 0.0, 0.0]", "not all 0"),
    ("axis = [0.0, 1.0, 0.0]", "", "fold", "add it: an array of 3 finite numbers"),
    ("type = \"revolute\"", "type = \"hinge\"", "\"hinge\"", "or \"revolute\""),
    ("parent = \"inner\"", "parent = \"iner\"", "\"iner\"", "(did you mean \"inner\"?)"),
    ("child = \"outer\"", "child = \"inner\"", "\"inner\"", "allowed: a body"),
    ("start_angle_deg = 170.0", "start_angle_rad = 2.967", "start_angle_rad", "write start_angle_deg (deg)"),
    ("start_angle_deg = 170.0", "start_angle_deg = 1700.0", "1700.0", "from -360 to 360 deg"),
    ("stiffness_N_m_rad = 0.026", "stiffness = 0.026", "stiffness", "write stiffness_N_m_rad (N·m/rad)"),
    ("[joint.fold.motor]", "[joint.fold.engine]", "engine", "allowed keys: type"),
    ("[joint.fold.motor]", "[joint.fold.drive]", "drive", "now called 'motor'"),
    ("youngs_modulus_Pa", "young_Pa", "young_Pa", "now called 'youngs_modulus_Pa'"),
    ("damping_N_m_s_rad = 0.0008", "damping_N_m_s_rad = -0.0008", "-0.0008", ">= 0"),
    ("stiffness_ratio = 1e4", "stiffnes_ratio = 1e4", "stiffnes_ratio", "perhaps stiffness_ratio is meant"),
    ("mass_kg = 0.0203", "mass_g = 20.3", "mass_g", "write mass_kg (kg)"),
    ("position_m = 0.15\n", "position_m = 0.16\n", "0.16", "from 0 to 0.15 m"),
    ("[gauge.root]", "[gauge.root]\n[gauge.root]", "root", "already on line"),
    ("name = \"FoldingWing\"", "name = \"Folding Wing\"", "\"Folding Wing\"", "perhaps \"Folding_Wing\""),
    ("name = \"FoldingWing\"", "name = FoldingWing", "FoldingWing", "text must be in quotes: write \"FoldingWing\""),
    ("gravity_m_s2 = [-9.8, 0.0, 0.0]", "gravity_m_s2 = -9.8", "-9.8", "allowed: an array of 3 finite accelerations"),
    ("stop_time_s = 0.4", "stop_time_s = -0.4", "-0.4", "allowed: a finite time > start_time_s"),
    ("step_s = 5e-4", "step_s = 0", "0", "allowed: a finite time > 0 s"),
    ("density_kg_m3 = 1425.0", "density_kg_m3 = \"1425\"", "\"1425\"", "allowed: a finite density > 0 kg/m³"),
    ("youngs_modulus_Pa = 2.83e9", "youngs_modulus_pa = 2.83e9", "youngs_modulus_pa", "write youngs_modulus_Pa (Pa)"),
    ("shape = \"rectangle\"", "shape = \"rect\"", "\"rect\"", "(did you mean \"rectangle\"?)"),
    (
        "[simulation]",
        "[simulation]\ngravity_m_s2 = [0.0, 0.0, -9.81]",
        "gravity_m_s2",
        "it belongs to the top of the file",
    ),
    ("body = \"inner\"\nposition_m = 0.02", "body = \"wing\"\nposition_m = 0.02", "\"wing\"", "\"inner\" or \"outer\""),
];

/// Every mistake in a model file is shown: file, line, the words at the caret, the remedy; the exit code is 1.
#[test]
fn mistakes_in_files_are_shown_with_their_cure() {
    assert!(IN_FILES.len() >= 30);
    let folder = tempfile::tempdir().unwrap();
    for (from, to, token, cure) in IN_FILES {
        let text = wing();
        assert!(text.contains(from), "{from}");
        let broken = text.replacen(from, to, 1);
        std::fs::write(folder.path().join("wing.toml"), &broken).unwrap();
        let output = foldwing(folder.path(), &["check", "wing.toml"]);
        let answer = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{to}: {answer}");
        let (line, pointed) = pointed_at(&answer).unwrap_or_else(|| panic!("{to}: no caret in\n{answer}"));
        let line = line.unwrap_or_else(|| panic!("{to}: no number of a line in\n{answer}"));
        assert!(answer.starts_with(&format!("error: wing.toml:{line}: ")), "{to}:\n{answer}");
        assert_eq!(pointed, *token, "{to}:\n{answer}");
        assert!(broken.lines().nth(line - 1).unwrap().contains(token), "{to}: line {line}\n{answer}");
        assert!(answer.contains(cure), "{to}: `{cure}` is not in\n{answer}");
    }
}

/// Words of the command line, the text at the caret, words of the remedy, exit code.
const ON_THE_COMMAND_LINE: &[(&[&str], &str, &str, i32)] = &[
    (&["simulat", "wing.toml"], "simulat", "a similar subcommand exists: 'simulate'", 2),
    (&["simulate", "wing.toml", "--variable", "x"], "--variable", "a similar argument exists: '--variables'", 2),
    (&["simulate", "wing.toml", "--output", "x"], "--output", "--output has a new name: --variables NAME", 2),
    (&["simulate", "wing.toml", "--stop", "soon"], "soon", "invalid float literal", 2),
    (&["simulate", "wing.toml", "--variables", "fold.angel"], "fold.angel", "fold.angle", 2),
    (&["simulate", "wing.toml", "--variables", "fold.angular_velocity,fold.angel"], "fold.angel", "fold.angle", 2),
    (&["simulate", "wing.toml", "--variables", "fould.*"], "fould.*", "the names begin with", 2),
    (&["simulate", "wing.toml", "--set", "fold.start_angle"], "fold.start_angle", "must be NAME=VALUE", 2),
    (&["simulate", "wing.toml", "--set", "fold.start_angle=110"], "fold.start_angle=110", "write \"110 deg\"", 2),
    (
        &["simulate", "wing.toml", "--set", "fold.start_angle=90 kg"],
        "fold.start_angle=90 kg",
        "allowed: rad and deg",
        2,
    ),
    (&["simulate", "wing.toml", "--set", "fold.start_angle=x"], "fold.start_angle=x", "is not a number", 2),
    (
        &["simulate", "wing.toml", "--set", "fold.release=yes"],
        "fold.release=yes",
        "allowed are 0, 1, false and true",
        2,
    ),
    (&["simulate", "wing.toml", "--set", "fold.strat_angle=1"], "fold.strat_angle", "fold.start_angle", 2),
    (&["simulate", "wing.toml", "--set", "fold.angle=1"], "fold.angle=1", "only inputs and parameters can", 2),
    (
        &["simulate", "wing.toml", "--set", "file:solver.tolerance=1"],
        "file:solver.tolerance=1",
        "`foldwing sweep --vary`",
        2,
    ),
    (&["simulate", "wing.toml", "--csv", "wing.toml"], "wing.toml", "name another file", 2),
    (&["simulate", "wing.toml", "--csv", "x.csv", "--profile", "x.csv"], "x.csv", "name another file", 2),
    (&["simulate", "wing.toml", "--step", "0"], "--step", "the step must be positive", 2),
    (&["simulate", "wing.toml", "--stop", "-1"], "-1", "must be after the start time", 2),
    (&["simulate", "wing.toml", "--view", "x.html", "--compare", "x.dat"], "x.dat", "a table over time (.csv)", 2),
    (&["simulate", "-", "--inputs", "-"], "-", "standard input can be read only once", 2),
    (&["package", "wing.toml", "-o", "Wing"], "Wing", "write Wing.fmu", 2),
    (&["new", "wing"], "wing", "write wing.toml", 2),
    (&["linearize", "wing.toml", "-o", "x.csv"], "x.csv", "must end in .json, .npz or .mat", 2),
    (
        &["linearize", "wing.toml", "-o", "x.npz", "--state", "never"],
        "never",
        "must be start, equilibrium or a time",
        2,
    ),
    (&["linearize", "wing.toml", "-o", "x.npz", "--outputs", "fold.angel"], "fold.angel", "fold.angle", 2),
    (
        &["sweep", "wing.toml", "--vary", "fold.angle_command", "--output", "x.csv"],
        "fold.angle_command",
        "KEY=FROM:TO:COUNT",
        2,
    ),
    (&["sweep", "wing.toml", "--vary", "fold.comand=1,2", "--output", "x.csv"], "fold.comand", "fold.angle_command", 2),
    (&["sweep", "wing.toml", "--samples", "-", "--output", "x.csv"], "-", "name a file", 2),
    (&["modes", "wing.toml", "--state", "start"], "start", "possible values: undeformed, equilibrium", 2),
    (&["static", "wing.toml", "--path", "arc"], "arc", "arc-length", 2),
    (&["view", "table.csv"], "table.csv", "--compare table.csv", 2),
    (&["live", "wing.toml", "--speed", "0"], "0", "must be from 0.001 to 100", 2),
    (&["live", "wing.toml", "--set", "fold.angel=1"], "fold.angel", "did you mean", 2),
    (&["render", "wing.toml", "--video", "x.webm"], "x.webm", "videos are .mp4 (H.264), .gif, or .png", 2),
    (&["render", "wing.toml", "--video", "x.mov"], "x.mov", "ffmpeg converts them", 2),
    (&["render", "wing.toml", "--video", "film"], "film", "the name must end in the format", 2),
    (&["render", "wing.toml", "--video", "x.mp4", "--size", "641x360"], "641x360", "of an MP4 must be even", 2),
    (&["render", "wing.toml", "--video", "x.mp4", "--size", "1080p"], "1080p", "such as 1920x1080", 2),
    (&["render", "wing.toml", "--video", "x.gif", "--fps", "60"], "60", "at most 50 frames per second", 2),
    (&["render", "wing.toml", "--video", "x.mp4", "--camera", "side,top"], "side", "at most one of", 2),
    (&["render", "wing.toml", "--video", "x.mp4", "--from", "9"], "--from", "the run is from 0 to", 2),
    (&["render", "table.csv", "--video", "x.mp4"], "table.csv", "a page of `simulate --view`", 2),
    (&["compare", "table.csv", "table.csv", "--tolerance", "fold.angle"], "fold.angle", "must be NAME=X", 2),
    (&["compare", "table.csv", "table.csv", "--variables", "fold.angel"], "fold.angel", "fold.angle", 2),
    (&["completions", "bahs"], "bahs", "bash", 2),
    (&["latency", "wing.toml", "--steps", "0"], "0", "0 is not in 1..=100000000", 2),
];

/// Every mistake on the command line is shown with a caret and its remedy.
#[test]
fn mistakes_on_the_command_line_are_shown_with_their_cure() {
    assert!(ON_THE_COMMAND_LINE.len() >= 30);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("wing.toml"), wing()).unwrap();
    std::fs::write(folder.path().join("table.csv"), "time,fold.angle\n0,1\n1,2\n").unwrap();
    for (words, token, cure, code) in ON_THE_COMMAND_LINE {
        let output = foldwing(folder.path(), words);
        let answer = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{words:?}: {answer}");
        assert!(answer.starts_with("error: "), "{words:?}:\n{answer}");
        let (_, pointed) = pointed_at(&answer).unwrap_or_else(|| panic!("{words:?}: no caret in\n{answer}"));
        assert_eq!(pointed, *token, "{words:?}:\n{answer}");
        assert!(answer.contains(cure), "{words:?}: `{cure}` is not in\n{answer}");
    }
}

/// Lines of input tables are shown like lines of models.
#[test]
fn mistakes_in_tables_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    for (table, line, token, cure) in [
        ("time,fold.angle_command\n0,0\n1,one\n", 3, "one", "finite number"),
        ("time,fold.comand\n0,0\n", 1, "fold.comand", "fold.angle_command"),
        ("time,fold.angle_command\n0.1,0\n0,1\n", 3, "0", "ascend"),
        ("time,fold.angle_command\n0,0\n0,1\n0,2\n", 4, "0", "a jump has two"),
    ] {
        std::fs::write(folder.path().join("table.csv"), table).unwrap();
        let output = foldwing(folder.path(), &["simulate", WING, "--inputs", "table.csv"]);
        let answer = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{answer}");
        assert_eq!(pointed_at(&answer), Some((Some(line), token.to_owned())), "{answer}");
        assert!(answer.contains(cure), "{answer}");
    }
}

/// Valid but implausible input: text in the file, its replacement, the text at the caret, the advice.
const IMPLAUSIBLE: &[(&str, &str, &str, &str)] = &[
    ("length_m = 0.15", "length_m = 150.0", "150.0", "millimetres? write 0.15"),
    ("youngs_modulus_Pa = 2.83e9", "youngs_modulus_Pa = 60", "60", "GPa? write 6e10"),
    ("youngs_modulus_Pa = 2.83e9", "youngs_modulus_Pa = 70000", "70000", "MPa? write 7e10"),
    ("youngs_modulus_Pa = 2.83e9", "youngs_modulus_Pa = 2.83e18", "2.83e18", "solids have"),
    ("density_kg_m3 = 1425.0", "density_kg_m3 = 1.425", "1.425", "g/cm3? write 1425"),
    ("height_m = 0.002", "height_m = 2.0", "2.0", "millimetres? write 0.002"),
    ("height_m = 0.002", "height_m = 0.04", "0.15", "shorter than ten times their thickness"),
    ("mass_kg = 0.0203", "mass_kg = 2030.0", "2030.0", "grams? write 2.03"),
    ("gravity_m_s2 = [-9.8, 0.0, 0.0]", "gravity_m_s2 = [-9806.0, 0.0, 0.0]", "[-9806.0, 0.0, 0.0]", "mm/s2?"),
    ("start_angle_deg = 170.0", "start_angle_deg = 2.9671", "2.9671", "rad? write 170"),
    ("step_s = 5e-4", "step_s = 0.2", "0.2", "milliseconds? write 0.0002"),
];

/// Implausible input gives a warning with its line, in `check` and `simulate`, without an error; the shipped wing gives none.
#[test]
fn the_implausible_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to, token, advice) in IMPLAUSIBLE {
        let text = wing();
        assert!(text.contains(from), "{from}");
        std::fs::write(folder.path().join("wing.toml"), text.replacen(from, to, 1)).unwrap();
        let output = foldwing(folder.path(), &["check", "wing.toml"]);
        let answer = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{to}: {answer}");
        assert!(answer.starts_with("warning: wing.toml:"), "{to}:\n{answer}");
        assert_eq!(pointed_at(&answer).map(|(_, pointed)| pointed).as_deref(), Some(*token), "{to}:\n{answer}");
        assert!(answer.contains(advice), "{to}: `{advice}` is not in\n{answer}");
    }
    let young = wing().replace("youngs_modulus_Pa = 2.83e9", "youngs_modulus_Pa = 60");
    std::fs::write(folder.path().join("wing.toml"), young).unwrap();
    let output = foldwing(folder.path(), &["simulate", "wing.toml", "--stop", "1e-4"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("GPa? write 6e10"));
    // a latch behind the start, relative to the direction in which the motor rotates the joint
    let latch = wing().replace("start_angle_deg = 170.0", "start_angle_deg = 110.0").replacen(
        "angle_deg = 0.0",
        "angle_deg = 130.0",
        1,
    );
    std::fs::write(folder.path().join("wing.toml"), &latch).unwrap();
    let answer = String::from_utf8_lossy(&foldwing(folder.path(), &["check", "wing.toml"]).stderr).into_owned();
    assert!(
        answer.contains("warning: joint fold: the latch at 130 deg is never reached without a command"),
        "{answer}"
    );
    // a run prints it, too, but not if inputs or settings drive the joint differently from the file, and not with --quiet
    let never = "warning: joint fold: the latch at 130 deg is never reached without a command";
    for (more, told) in [(&[][..], true), (&["--set", "fold.angle_command=140 deg"], false), (&["--quiet"], false)] {
        let arguments = [&["simulate", "wing.toml", "--stop", "0.05"], more].concat();
        let answer = String::from_utf8_lossy(&foldwing(folder.path(), &arguments).stderr).into_owned();
        assert_eq!(answer.contains(never), told, "{more:?}: {answer}");
    }
    // aerodynamic loads may drive the joint to its latch: without them neither command gives a verdict
    let air = "[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0.0, -5.0, 0.0]\nstep_s = 1e-3\n[surface.outer]\nbody = \"outer\"\nstrips = 2\n";
    std::fs::write(folder.path().join("wing.toml"), format!("{latch}\n{air}")).unwrap();
    for command in [&["check", "wing.toml"][..], &["simulate", "wing.toml", "--stop", "0.05"]] {
        let output = foldwing(folder.path(), command);
        let answer = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{command:?}: {answer}");
        assert!(!answer.contains("never reached without a command"), "{command:?}: {answer}");
    }
    // a step far from the time scale of the motion
    std::fs::write(
        folder.path().join("wing.toml"),
        wing().replace("stop_time_s = 0.4", "stop_time_s = 40.0").replace("step_s = 5e-4", "step_s = 1.0"),
    )
    .unwrap();
    let answer = String::from_utf8_lossy(&foldwing(folder.path(), &["check", "wing.toml"]).stderr).into_owned();
    assert!(answer.contains("step_s = 1 s is long for a wing that oscillates at"), "{answer}");
    let answer = |arguments: &[&str]| {
        String::from_utf8_lossy(&foldwing(folder.path(), &[&["simulate", "wing.toml"], arguments].concat()).stderr)
            .into_owned()
    };
    assert!(
        answer(&["--stop", "2"]).contains("warning: [simulation] step_s = 1 s is long for a wing that oscillates at")
    );
    assert!(
        answer(&["--stop", "2", "--step", "0.5"])
            .contains("warning: --step 0.5 s is long for a wing that oscillates at")
    );
    assert!(!answer(&["--stop", "2", "--step", "0.01"]).contains("is long for a wing"));
    assert!(
        answer(&["--stop", "1e-4", "--step", "1e-5"])
            .contains("warning: the run lasts 0.0001 s, a hundredth of the longest period")
    );
}

/// No shipped model is reported as implausible.
#[test]
fn shipped_models_are_plausible() {
    let models = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models");
    for entry in std::fs::read_dir(models).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let output = foldwing(Path::new(models), &["check", path.to_str().unwrap()]);
            let answer = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && !answer.contains("warning:"), "{}:\n{answer}", path.display());
        }
    }
}

/// `-` reads a model or a table from standard input, and errors mention this.
#[test]
fn standard_input_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let feed = |arguments: &[&str], text: &str| -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_foldwing"));
        command
            .args(arguments)
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    };
    let output = feed(&["simulate", "-", "--csv", "-", "--variables", "fold.angle", "--stop", "1e-3"], &wing());
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().next(), Some("time,fold.angle"));
    let output = feed(&["check", "-"], "name = 1\n");
    assert!(
        String::from_utf8_lossy(&output.stderr).contains("error: <standard input>:1: key 'name': 1 is not allowed")
    );
    let inputs =
        ["simulate", WING, "--inputs", "-", "--csv", "-", "--variables", "fold.angle_command", "--stop", "1e-3"];
    let output = feed(&inputs, "time,fold.angle_command\n0,0.25\n");
    assert!(
        String::from_utf8_lossy(&output.stdout).ends_with(",0.25\n"),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
}

/// `--variables` accepts patterns and lists, and the column `time` is not repeated.
#[test]
fn outputs_are_chosen_by_patterns() {
    let folder = tempfile::tempdir().unwrap();
    let columns = |chosen: &[&str]| {
        let output = foldwing(folder.path(), &[&["simulate", WING, "--csv", "-", "--stop", "1e-3"], chosen].concat());
        String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or_default().to_owned()
    };
    assert_eq!(
        columns(&["--variables", "time,fold.angle,tip.position.?"]),
        "time,fold.angle,tip.position.x,tip.position.y,tip.position.z"
    );
    let all = columns(&["--variables", "fold.*"]);
    assert!(all.starts_with("time,fold.") && all.split(',').skip(1).all(|name| name.starts_with("fold.")), "{all}");
}

/// Colours are used only if forced; the written files are listed.
#[test]
fn colours_and_written_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_foldwing"));
    command.args(["simulate", "none.toml"]).current_dir(folder.path());
    let plain = command.output().unwrap();
    assert!(!plain.stderr.contains(&0x1b));
    let coloured = command.env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(coloured.stderr.starts_with(b"\x1b["), "{}", String::from_utf8_lossy(&coloured.stderr));
    let none = command.env("NO_COLOR", "1").env_remove("CLICOLOR_FORCE").output().unwrap();
    assert_eq!(none.stderr, plain.stderr);

    let output =
        foldwing(folder.path(), &["simulate", WING, "--csv", "new/x.csv", "--plot", "figures", "--stop", "0.01"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("\nwrote new/x.csv\n") && told.contains(" files in figures\n"), "{told}");
    let quiet = foldwing(folder.path(), &["simulate", WING, "--csv", "new/x.csv", "--stop", "0.01", "--quiet"]);
    assert!(quiet.stderr.is_empty(), "{}", String::from_utf8_lossy(&quiet.stderr));
}

/// `compare` distinguishes tables that agree from those that do not, with tolerances per column, and interpolates.
#[test]
fn tables_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("a.csv", "time,x,y,only\n0,0,1,1\n0.5,1,1,1\n1,2,1,1\n");
    write("b.csv", "time,y,x\n0,1,0\n1,1.001,2\n");
    write("later.csv", "time,x\n5,1\n6,1\n");
    let code = |arguments: &[&str]| foldwing(folder.path(), &[&["compare"], arguments].concat()).status.code();
    assert_eq!(code(&["a.csv", "a.csv"]), Some(0));
    assert_eq!(code(&["a.csv", "b.csv"]), Some(5), "y differs by 1e-3");
    assert_eq!(code(&["a.csv", "b.csv", "--variables", "x"]), Some(0), "x is straight between the rows of b");
    assert_eq!(code(&["a.csv", "b.csv", "--rtol", "0.0011"]), Some(0));
    assert_eq!(code(&["a.csv", "b.csv", "--rtol", "0.0009"]), Some(5));
    assert_eq!(code(&["a.csv", "b.csv", "--tolerance", "y=0.0011"]), Some(0));
    assert_eq!(code(&["a.csv", "b.csv", "--tolerance", "*=1", "--tolerance", "y=0.0009"]), Some(5));
    assert_eq!(code(&["a.csv", "later.csv"]), Some(1), "no time in common");
    assert_eq!(code(&["a.csv", "none.csv"]), Some(4));
    let output = foldwing(folder.path(), &["compare", "a.csv", "b.csv", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let y = json["columns"].as_array().unwrap().iter().find(|column| column["name"] == "y").unwrap();
    assert!((y["largest"].as_f64().unwrap() - 1e-3).abs() < 1e-15 && y["at_s"] == 1.0 && y["agrees"] == false, "{y}");
    assert_eq!((&json["agree"], &json["only_in_first"][0]), (&false.into(), &"only".into()));
}

/// `view` writes the page of a model and accepts pages; every shell has completions.
#[test]
fn view_and_completions() {
    let folder = tempfile::tempdir().unwrap();
    let output = foldwing(folder.path(), &["view", WING, "--stop", "0.01", "--no-open"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(std::fs::read_to_string(folder.path().join("folding_wing.html")).unwrap().starts_with("<!doctype html>"));
    assert!(foldwing(folder.path(), &["view", "folding_wing.html", "--no-open"]).status.success());
    std::fs::write(folder.path().join("other.html"), "<p>").unwrap();
    assert_eq!(foldwing(folder.path(), &["view", "other.html", "--no-open"]).status.code(), Some(1));
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = foldwing(folder.path(), &["completions", shell]).stdout;
        let script = String::from_utf8_lossy(&script);
        assert!(["simulate", "compare", "unknowns"].iter().all(|word| script.contains(word)), "{shell}");
    }
}
