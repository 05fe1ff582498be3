//! The command as used in scripts: exit codes, messages, files.

use crate::library;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn model() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/folding_wing.toml")
}

pub fn foldwing(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_foldwing")).args(arguments).output().expect("the command runs")
}

/// Runs the command on the shipped model: `command MODEL arguments…`.
fn on_model(command: &str, arguments: &[&str]) -> Output {
    let model = model();
    foldwing(&[&[command, model.to_str().unwrap()], arguments].concat())
}

#[track_caller]
fn refuses(output: &Output, code: i32, message: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    assert!(stderr.contains(message), "`{message}` is not in\n{stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

#[track_caller]
pub fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// Columns of a CSV by name.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let index = lines.next().unwrap().split(',').position(|header| header == name).expect(name);
    lines.map(|line| line.split(',').nth(index).unwrap().parse().unwrap()).collect()
}

/// The version includes the target, so that a bug report identifies the build.
#[test]
fn version_names_the_build() {
    let text = succeeds(&foldwing(&["--version"]));
    assert!(text.starts_with(concat!("foldwing ", env!("CARGO_PKG_VERSION"), " (")), "{text}");
    assert!(text.contains(std::env::consts::ARCH), "{text}");
}

/// `--profile` writes the counts of the summary, and consistent times; it does not change results.
#[test]
fn timing_says_what_a_run_costs() {
    let folder = scratch();
    let path = folder.path().join("timing.json");
    let run = ["--csv", "-", "--stop", "0.2"];
    let output = on_model("simulate", &[&run[..], &["--profile", path.to_str().unwrap()]].concat());
    assert_eq!(succeeds(&output), succeeds(&on_model("simulate", &run)), "the clocks must not change the result");

    let timing: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let number = |name: &str| timing[name].as_f64().unwrap_or_else(|| panic!("{name} is missing in {timing}"));
    let summary = String::from_utf8(output.stderr).unwrap();
    let counts = ["steps", "rejected", "failed", "iterations", "events"];
    let names = ["steps", "rejections", "failures", "iterations", "events"];
    for (count, name) in counts.into_iter().zip(names) {
        assert!(summary.contains(&format!(" {} {count}", number(name))), "{name} of {timing} is not in {summary}");
    }
    assert_eq!((number("simulated_s"), number("communication_steps")), (0.2, 400.0));
    assert!((number("step_us") * number("steps") * 1e-6 / number("steps_s") - 1.0).abs() < 1e-9, "{timing}");
    let wall_s = number("initialization_s") + number("steps_s") + number("rows_s");
    if cfg!(any(target_os = "linux", target_os = "macos")) {
        // one thread: no more than the wall-clock time, apart from the interval between the readings of the clocks
        assert!((1e-6..1.1 * wall_s + 1e-3).contains(&number("processor_s")), "{timing}");
    }
}

/// `--strains` writes one line per end of an element with the largest strain of the run, which is at least that of any gauge.
#[test]
fn strains_are_reported_per_section() {
    let folder = scratch();
    let strains = folder.path().join("strains.csv");
    let path = strains.to_str().unwrap();
    let csv = succeeds(&on_model("simulate", &["--csv", "-", "-q", "--stop", "0.2", "--strains", path]));
    let gauge = column(&csv, "gauge.root.strain").into_iter().fold(0.0f64, |peak, strain| peak.max(strain.abs()));
    let report = std::fs::read_to_string(strains).unwrap();
    assert_eq!(report.lines().next(), Some("body,position_m,largest_axial_strain,time_s,y_m,z_m"));
    assert_eq!(report.lines().count(), 1 + 2 * 5, "two bodies of four pairs\n{report}");
    let largest = column(&report, "largest_axial_strain").into_iter().fold(0.0f64, |peak, e| peak.max(e.abs()));
    assert!(largest >= gauge && largest < 2.0 * gauge, "{largest} and {gauge}\n{report}");
    let inside = folder.path().join("strains.csv/x.csv");
    let run = ["--csv", "-", "-q", "--stop", "0.001", "--strains", inside.to_str().unwrap()];
    refuses(&on_model("simulate", &run), 4, "strains.csv/x.csv: cannot be written");
}

/// `--lattice` writes the lattice and its wake at the requested times, and is an error for a model without one.
#[test]
fn the_lattice_is_written_at_chosen_times() {
    let folder = scratch();
    let file = folder.path().join("lattice.json");
    let path = file.to_str().unwrap();
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/folding_wing_in_tunnel.toml");
    let run = ["--csv", "-", "-q", "--stop", "0.01", "--lattice", path, "--lattice-at", "0.01", "--lattice-at", "0"];
    succeeds(&foldwing(&[&["simulate", model.to_str().unwrap()], &run[..]].concat()));
    let written: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    let times: Vec<f64> = written.as_array().unwrap().iter().map(|taken| taken["time_s"].as_f64().unwrap()).collect();
    assert_eq!(times.len(), 2);
    assert!(times[0] == 0.0 && (times[1] - 0.01).abs() < 1e-12, "{times:?}");
    for (surface, name) in written[1]["surfaces"].as_array().unwrap().iter().zip(["inner", "outer"]) {
        assert_eq!(surface["body"], name);
        let size = |key: &str| (surface[key].as_array().unwrap().len(), surface[key][0].as_array().unwrap().len());
        // eight steps of 1.25 ms have each shed a row, in front of those of the steady flow
        assert_eq!((size("corner_m"), size("wake_node_m")), ((6, 11), (10, 11)));
        assert_eq!(size("wake_circulation_m2_s"), (9, 10));
        assert_eq!(surface["corner_m"][5], surface["wake_node_m"][0], "the wake starts at the last corners");
        let shed = surface["wake_circulation_m2_s"][0][5].as_f64().unwrap();
        assert!(shed != 0.0, "the moving wing sheds");
    }
    refuses(&on_model("simulate", &run), 2, "has no vortex lattice");
    refuses(&on_model("simulate", &["--csv", "-", "--lattice", path]), 2, "--lattice-at");
}

/// Each exit code documented in `--help`, with a message that gives the cause.
#[test]
fn exit_codes_tell_causes_apart() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("broken.toml"), "name = \"X\"\nnonsense = 1\n").unwrap();
    std::fs::write(path("binary.toml"), b"name = \"\xff\"\n").unwrap();
    std::fs::write(path("library.so"), "not a library").unwrap();

    refuses(&foldwing(&["check", &path("broken.toml")]), 1, "broken.toml");
    refuses(&foldwing(&["check", &path("binary.toml")]), 1, "binary.toml:1: a model file is UTF-8 text");
    refuses(&on_model("package", &["-o", &path("x.fmu"), "--library", &path("library.so")]), 1, "shared library");
    refuses(&foldwing(&["fold"]), 2, "fold");
    refuses(&on_model("simulate", &["--csv", "-", "--variables", "fold.angel"]), 2, "did you mean `fold.angle`");
    refuses(&on_model("simulate", &["--csv", "-", "--step", "0"]), 2, "must be positive");
    refuses(&on_model("simulate", &["--csv", "-", "--step", "NaN"]), 2, "finite");
    refuses(&on_model("simulate", &["--csv", "-", "--stop", "-1"]), 2, "after the start time");
    refuses(&on_model("simulate", &["--csv", "-", "--step", "1e-12"]), 2, "rows");
    refuses(&on_model("simulate", &["--csv", "-", "--set", "fold.angle_command"]), 2, "NAME=VALUE");
    refuses(&on_model("simulate", &["--csv", "-", "--set", "fold.angle_command=x"]), 2, "`x` is not a number");
    refuses(&on_model("simulate", &["--csv", "-", "--set", "fold.angle=1"]), 2, "fold.angle");
    refuses(&on_model("simulate", &["--csv", "-", "--inputs", &path("no.csv")]), 4, "no.csv: cannot be read");
    refuses(&on_model("simulate", &["--csv", &path("broken.toml/out.csv")]), 4, "out.csv: cannot be written");
    refuses(&on_model("package", &["-o", &path("x.fmu"), "--library", &path("none.so")]), 4, "none.so");
    let library = ["-o", &path("x.fmu"), "--library", &path("library.so")];
    let with = |more: &[&str]| on_model("package", &[&library[..], more].concat());
    refuses(&with(&["--linear=never"]), 2, "--linear never: must be start, equilibrium or a time");
    refuses(&with(&["--no-reference", "--cross-check", &path("check")]), 2, "cannot be used with");
    refuses(&foldwing(&["check", &path("missing.toml")]), 4, "missing.toml: cannot be read");
    assert!(!Path::new(&path("x.fmu")).exists(), "a refused package leaves no file");
}

/// The default simulation latches; the CSV contains the outputs at the communication points.
#[test]
fn simulation_writes_the_deployment() {
    let csv = succeeds(&on_model("simulate", &["--csv", "-", "--step", "1e-3"]));
    assert_eq!(csv.lines().count(), 402);
    assert_eq!(column(&csv, "time").last(), Some(&0.4));
    let latch_s = *column(&csv, "fold.latch_time").last().unwrap();
    assert!((latch_s - 0.1222).abs() < 0.005 * 0.1222, "latch at {latch_s} s");
}

/// A latch that is closed at the start is not reported as "not latched", and a joint without a latch is not mentioned.
#[test]
fn summary_knows_what_a_latch_did() {
    let folder = scratch();
    let path = folder.path().join("wing.toml");
    let summary = |old: &str, new: &str, set: &[&str]| {
        let text = std::fs::read_to_string(model()).unwrap();
        assert!(text.contains(old), "{old}");
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let arguments = ["simulate", path.to_str().unwrap(), "--csv", "-", "--stop", "0.01"];
        let output = foldwing(&[&arguments, set].concat());
        succeeds(&output);
        String::from_utf8(output.stderr).unwrap()
    };
    let closed = ("[joint.fold.latch]\n", "[joint.fold.latch]\ninitially_closed = true\n");
    let text = summary(closed.0, closed.1, &[]);
    assert!(text.contains("fold: latched from the start, angle"), "{text}");
    let text = summary(closed.0, closed.1, &["--set", "fold.latch_enable=false"]);
    assert!(text.contains("fold: latch open at the end, angle"), "{text}");
    let text = summary("", "", &[]);
    assert!(text.contains("fold: did not latch, angle"), "{text}");
}

/// A run that fails reports time and cause, and keeps the rows written until then.
#[test]
fn failed_simulation_keeps_its_rows() {
    let settings = ["solver.min_step=0.01", "solver.max_step=0.02", "solver.tolerance=1e-9"];
    let sets: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let output = on_model("simulate", &[&["--csv", "-"], sets.as_slice()].concat());
    refuses(&output, 3, "no convergence at t = ");
    let csv = String::from_utf8(output.stdout).unwrap();
    assert!(column(&csv, "time").is_sorted_by(|a, b| a < b) && csv.lines().count() >= 2, "{csv}");
}

/// A last step that does not fit is shortened; a start time alone shifts the experiment.
#[test]
fn grid_ends_at_the_stop_time() {
    let csv = succeeds(&on_model(
        "simulate",
        &["--csv", "-", "--start", "1", "--stop", "1.01", "--step", "0.004", "--variables", "fold.angle"],
    ));
    assert_eq!(column(&csv, "time"), [1.0, 1.004, 1.008, 1.01]);
    let moved = succeeds(&on_model("simulate", &["--csv", "-", "--start", "1", "--step", "0.1"]));
    assert_eq!(column(&moved, "time").last(), Some(&1.4));
}

/// Inputs from a file are applied: a wing that is never released stays folded; errors give file, line and column.
#[test]
fn inputs_come_from_a_file() {
    let folder = scratch();
    let inputs = folder.path().join("in.csv");
    let run = |text: &str| {
        std::fs::write(&inputs, text).unwrap();
        on_model(
            "simulate",
            &[
                "--csv",
                "-",
                "--inputs",
                inputs.to_str().unwrap(),
                "--variables",
                "fold.angle",
                "--variables",
                "fold.angle_command",
            ],
        )
    };
    let held = succeeds(&run("time,fold.release,fold.angle_command\n0,0,0\n0.4,0,0.4\n"));
    let angle = column(&held, "fold.angle");
    assert!(angle.iter().all(|a| (a - angle[0]).abs() < 1e-9), "the stopper must hold the angle");
    assert!((column(&held, "fold.angle_command").last().unwrap() - 0.4).abs() < 1e-2);
    refuses(&run("time,fold.angle_command\n0,0\n0.1,x\n"), 1, "in.csv:3: column 2 (fold.angle_command): `x`");
    refuses(&run("time,fold.comand\n0,0\n"), 1, "did you mean `fold.angle_command`");
}

/// `check --json` is JSON with the data for scripts; the text contains the same.
#[test]
fn check_says_what_was_understood() {
    let json: serde_json::Value = serde_json::from_str(&succeeds(&on_model("check", &["--json"]))).unwrap();
    assert_eq!(json["bodies"].as_array().unwrap().len(), 2);
    assert!((json["mass_kg"].as_f64().unwrap() - 0.06305).abs() < 1e-9);
    let text = succeeds(&on_model("check", &["--list-variables"]));
    for expected in ["inner", "outer", "fold", "degrees of freedom", "input fold.angle_command", "gauge.root.strain"] {
        assert!(text.contains(expected), "{expected} is missing in\n{text}");
    }
}

/// Numbers of variables of every kind of joint in Foldwing and in the conventional method: Otsuka et al., Table 2, and eq. (13).
///
/// For the revolute joint the table prints 33 as the sum of 12 and 11, and therefore 97 % where eq. (13) gives 96 %. It has no clamped and
/// no free joint.
#[test]
fn check_counts_joint_variables_as_table_2() {
    let folder = scratch();
    let path = folder.path().join("joints.toml");
    let kinds = [
        ("clamped", ""),
        ("revolute", "axis = [0, 1, 0]"),
        ("universal", "axis = [0, 1, 0]\nbody_axis = [0, 0, 1]"),
        ("ball", ""),
        ("free", ""),
    ];
    let mut text = "name = \"Joints\"\n[section.bar]\nshape = \"ellipse\"\nwidth_m = 0.1\nheight_m = \
                    0.1\ndensity_kg_m3 = 1\nyoungs_modulus_Pa = 1e9\npoisson_ratio = 0.3\n"
        .to_owned();
    for (kind, keys) in kinds {
        text += &format!(
            "[body.{kind}]\nlength_m = 1\nsection = \"bar\"\nelements = 1\n[joint.{kind}_joint]\ntype = \
             \"{kind}\"\nparent = \"root\"\nchild = \"{kind}\"\n{keys}\n"
        );
    }
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    let json: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&["check", path, "--json"]))).unwrap();
    // here N_J, N_L; conventional N_J, N_L; printed reduction rate in per cent
    let expected = [
        ([0, 0, 12, 12], None),
        ([1, 0, 12, 11], Some(96.0)),
        ([9, 7, 12, 10], Some(27.0)),
        ([4, 1, 12, 9], Some(76.0)),
        ([7, 1, 12, 6], None),
    ];
    for ((kind, _), (joint, (counts, rate_percent))) in
        kinds.iter().zip(json["joints"].as_array().unwrap().iter().zip(expected))
    {
        assert_eq!(joint["kind"], *kind);
        let size = &joint["size"];
        let keys = ["variables", "multipliers", "conventional_variables", "conventional_multipliers"];
        assert_eq!(keys.map(|key| size[key].as_u64().unwrap()), counts, "{kind}");
        assert_eq!(size["in_table_2"], rate_percent.is_some(), "{kind}");
        let rate = size["reduction_rate"].as_f64().unwrap();
        let [a, b, c, d] = counts.map(|count| count as f64);
        assert!((rate - ((c + d) - (a + b)) / (c + d)).abs() < 1e-12, "{kind}: {rate}");
        assert!(rate_percent.is_none_or(|percent| (100.0 * rate).round() == percent), "{kind}: {rate}");
    }
    // eight strains per linear element, and 0 + 1 + 2 + 3 + 6 of the joints
    assert_eq!(json["degrees_of_freedom"], 5 * 8 + 12);
    let text = succeeds(&foldwing(&["check", path, "--unknowns"]));
    for line in [
        "  universal_joint: universal, 9 + 7 against 12 + 10, 27 % less\n",
        "  revolute_joint: revolute, 1 + 0 against 12 + 11, 96 % less (the table prints 33 for 12 + 11, and so 97 %)\n",
        "  free_joint: free, 7 + 1 against 12 + 6, 56 % less (not in the table: counted in the same way)\n",
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
    assert!(!text.contains("-0 ") && !text.contains("-0,") && !text.contains("-0.0000"), "no negative zeros: {text}");
}

/// The schema is JSON, and a closed pipe is not an error.
#[test]
fn schema_is_json() {
    let schema: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&["schema"]))).unwrap();
    assert!(schema.is_object());
}

/// The description can be printed without running anything, and does not depend on the current folder.
#[test]
fn description_can_be_printed() {
    let text = succeeds(&on_model("package", &["--description-only"]));
    assert!(text.starts_with("<?xml") && text.contains("modelName=\"FoldingWing\""), "{text}");
}

/// `static` prints a shape for users and JSON for programs. The weight of the wing in equilibrium is that of `check`; a locked joint stays
/// at its angle; a released one rotates until its spring balances its motor, or its latch catches it.
#[test]
fn static_brings_the_wing_to_rest() {
    let json = |arguments: &[&str]| -> serde_json::Value {
        serde_json::from_str(&succeeds(&on_model("static", &[&["--json"], arguments].concat()))).unwrap()
    };
    let held = json(&["--set", "fold.release=0"]);
    assert_eq!(held["joints"][0]["angle_rad"].as_f64(), Some(170f64.to_radians()));
    let force = held["root"]["force_N"][0].as_f64().unwrap();
    assert!((force + 0.06305 * 9.8).abs() < 1e-9, "{force}");
    assert_eq!(held["bodies"][1]["sections"].as_array().unwrap().len(), 5, "the mesh boundaries of four pairs");
    // released, it unfolds until the latch closes: 1e4 k θ + T = moment of the weight, which is zero for a vertical wing
    let latched = json(&[]);
    assert_eq!(latched["joints"][0]["latched"], true);
    let angle = latched["joints"][0]["angle_rad"].as_f64().unwrap();
    assert!((angle + 0.043 / 260.0).abs() < 2e-5, "{angle}");
    let free = json(&["--set", "gravity.x=0", "--set", "fold.latch_enable=0"]);
    // k θ + T = 0
    let angle = free["joints"][0]["angle_rad"].as_f64().unwrap();
    assert!((angle + 0.043 / 0.026).abs() < 1e-9, "{angle}");
    let text = succeeds(&on_model("static", &["--set", "fold.release=0"]));
    for expected in ["kappa y 1/m", "fold: angle 170.000000 deg", "gauge root", "tip of outer", "reaction on root"] {
        assert!(text.contains(expected), "{expected} is missing in\n{text}");
    }
    let loose = on_model(
        "static",
        &["--set", "fold.motor_stiffness=0", "--set", "gravity.x=0", "--set", "fold.latch_enable=0"],
    );
    refuses(&loose, 3, "joint \"fold\"");
}

/// A linkage with its motor locked: `check` lists its loops, `static` finds the equilibrium in which they carry one half each of the weight
/// of rocker and coupler.
#[test]
fn closed_loops_are_shown() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/four_bar.toml");
    let path = path.to_str().unwrap();
    let text = succeeds(&foldwing(&["check", path]));
    assert!(text.contains("  front: coupler at 0.4 m to rocker at 0.3 m, k 500000 N/m"), "{text}");
    let json = succeeds(&foldwing(&["static", path, "--json", "--set", "motor.release=0"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let force_n = |i: usize, axis: usize| json["loops"][i]["force_N"][axis].as_f64().unwrap();
    assert_eq!((&json["loops"][0]["name"], &json["loops"][1]["name"]), (&"front".into(), &"back".into()));
    for axis in [0, 2] {
        let (front, back) = (force_n(0, axis), force_n(1, axis));
        assert!(front.abs() > 0.1 && (front - back).abs() < 1e-6 * front.abs(), "{front} N and {back} N");
        let gap_m = json["loops"][0]["gap_m"][axis].as_f64().unwrap();
        assert!((gap_m * 5e5 - front).abs() < 1e-9 * front.abs(), "{gap_m} m under {front} N");
    }
    let text = succeeds(&foldwing(&["static", path, "--set", "motor.release=0"]));
    assert!(text.contains("\nloop back: gap "), "{text}");
    // a free motor rotates the crank without end; the search then ends in a state with an open loop
    refuses(&foldwing(&["static", path]), 3, "is open by");
}

/// `modes` orders frequencies, with the exact first one of the straight cantilever if the wing is locked unfolded (without the joint's mass
/// the 0.3 m plate has 5.0589 Hz; with it less), and rejects unknown settings.
#[test]
fn modes_lists_frequencies() {
    let straight = ["--state", "undeformed", "--set", "fold.start_angle=0", "--set", "fold.release=0"];
    let json: serde_json::Value =
        serde_json::from_str(&succeeds(&on_model("modes", &[&["--json", "--count", "4"], &straight[..]].concat())))
            .unwrap();
    let list: Vec<f64> =
        json["modes"].as_array().unwrap().iter().map(|mode| mode["frequency_Hz"].as_f64().unwrap()).collect();
    assert!(list.len() == 4 && list.is_sorted(), "{list:?}");
    assert!(list[0] > 3.0 && list[0] < 5.0589, "{list:?}");
    let shape = &json["modes"][0]["shape"][1]["sections"][2];
    assert!(shape["displacement_m"][2].as_f64().unwrap().abs() > 0.1, "{shape}");
    let text = succeeds(&on_model("modes", &straight));
    assert!(text.contains("frequency Hz") && text.contains("flap"), "{text}");
    refuses(&on_model("modes", &["--set", "gravity.q=1"]), 2, "did you mean `gravity.");
}

/// `linearize` writes both kinds of file, at each kind of state; names select variables, and mistakes are reported.
#[test]
fn linearize_writes_json_and_npz() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let held = ["--set", "fold.release=0"];
    for at in ["start", "equilibrium", "0.01"] {
        let file = path("x.json");
        let arguments = [
            "--state",
            at,
            "--inputs",
            "fold.external_torque,load.inner[1].",
            "--outputs",
            "tip.position.,gauge.root.strain",
        ];
        let text = succeeds(&on_model("linearize", &[&arguments[..], &held[..], &["-o", &file]].concat()));
        assert!(text.contains("7 inputs, 4 outputs"), "{text}");
        let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        let rows = |key: &str| json[key].as_array().unwrap().len();
        // two bodies of four pairs with eight strains each, and their rates
        assert_eq!((rows("A"), rows("B"), rows("C"), rows("D"), rows("states")), (128, 128, 4, 4, 128));
        assert_eq!(json["inputs"][1]["name"], "load.inner[1].force.x");
        assert_eq!(
            (&json["outputs"][3]["name"], &json["outputs"][0]["unit"]),
            (&"gauge.root.strain".into(), &"m".into())
        );
    }
    let file = path("x.npz");
    succeeds(&on_model("linearize", &["--outputs", "tip.position.", "-o", &file, "--set", "fold.release=0"]));
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&file).unwrap()).unwrap();
    for name in
        ["A.npy", "B.npy", "C.npy", "D.npy", "x0.npy", "u0.npy", "y0.npy", "state_names.npy", "output_units.npy"]
    {
        assert!(archive.by_name(name).is_ok(), "{name} is missing");
    }
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut archive.by_name("C.npy").unwrap(), &mut bytes).unwrap();
    assert!(String::from_utf8_lossy(&bytes[..128]).contains("'shape': (3, 128)"));
    refuses(&on_model("linearize", &["-o", &path("x.csv")]), 2, "must end in .json, .npz or .mat");
    refuses(&on_model("linearize", &["--state", "never", "-o", &file]), 2, "start, equilibrium or a time");
    refuses(&on_model("linearize", &["--inputs", "fold.release", "-o", &file]), 2, "no real input is named");
}

/// Linear models of machines with a vortex lattice hold its loads constant: every output reports this, and wind, whose columns would be 0,
/// is not available as an input.
#[test]
fn linear_models_and_modes_of_a_lattice_are_without_air_and_say_so() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let tunnel = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing_in_tunnel.toml");
    let linearize = |file: &str, more: &[&str]| foldwing(&[&["linearize", tunnel, "-o", &path(file)], more].concat());
    assert!(succeeds(&linearize("x.json", &[])).contains("with constant aerodynamic loads"));
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path("x.json")).unwrap()).unwrap();
    assert_eq!(json["without_air"], true);
    let inputs = json["inputs"].as_array().unwrap();
    assert!(inputs.iter().all(|input| !input["name"].as_str().unwrap().starts_with("wind.")), "{inputs:?}");
    succeeds(&linearize("x.npz", &[]));
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path("x.npz")).unwrap()).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut archive.by_name("without_air.npy").unwrap(), &mut bytes).unwrap();
    assert!(bytes.ends_with(&1.0f64.to_le_bytes()));
    succeeds(&linearize("x.mat", &[]));
    assert!(String::from_utf8_lossy(&std::fs::read(path("x.mat")).unwrap()).contains("without_air"));
    refuses(&linearize("y.json", &["--inputs", "gust.z"]), 2, "have gusts as inputs");
    refuses(
        &linearize("y.json", &["--inputs", "wind.velocity.y"]),
        2,
        "the linear model of a vortex lattice holds the aerodynamic loads constant",
    );
    assert!(succeeds(&foldwing(&["modes", tunnel])).contains("with constant aerodynamic loads"));
    let file = path("vacuum.json");
    assert!(
        !succeeds(&on_model("linearize", &["--set", "fold.release=0", "-o", &file]))
            .contains("with constant aerodynamic loads")
    );
}

/// With `--lattice` linear models and modes include the vortex lattice, in discrete time: wind and a travelling gust are inputs, the file
/// contains the step, balanced truncation preserves the responses, and a model without a lattice is an error that names it.
#[test]
fn linear_models_modes_and_flutter_of_a_lattice_are_in_discrete_time() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let tunnel = include_str!("../../examples/models/folding_wing_in_tunnel.toml");
    let small = tunnel
        .replace("strips = 10", "strips = 3")
        .replace("chord_panels = 4", "chord_panels = 2")
        .replace("wake_rows = 30", "wake_rows = 10")
        .replace("step_s = 1.25e-3", "step_s = 2.5e-3")
        .replace("elements = 4", "elements = 2");
    std::fs::write(path("wing.toml"), &small).unwrap();
    let model = path("wing.toml");
    let inputs = ["--lattice", "--inputs", "gust.z,wind.velocity.z", "--outputs", "gauge.,tip.position.z"];
    let linearize = |file: &str, more: &[&str]| {
        foldwing(&[&["linearize", model.as_str(), "-o", &path(file)], &inputs[..], more].concat())
    };
    let said = succeeds(&linearize("x.json", &[]));
    assert!(said.contains("with the vortex lattice, in discrete time with steps of 0.0025 s"), "{said}");
    let read = |name: &str| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(path(name)).unwrap()).unwrap()
    };
    let whole = read("x.json");
    assert_eq!((&whole["without_air"], &whole["step_s"]), (&serde_json::json!(false), &serde_json::json!(0.0025)));
    let names: Vec<&str> =
        whole["states"].as_array().unwrap().iter().map(|state| state["name"].as_str().unwrap()).collect();
    assert!(
        names.contains(&"outer.strip[3].wake[10].circulation") && names.contains(&"inner.panel[2][1].circulation"),
        "{names:?}"
    );
    assert_eq!(names.len(), whole["A"].as_array().unwrap().len());
    succeeds(&linearize("x.npz", &["--reduce", "12"]));
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path("x.npz")).unwrap()).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut archive.by_name("step_s.npy").unwrap(), &mut bytes).unwrap();
    assert!(bytes.ends_with(&0.0025f64.to_le_bytes()));
    // for a frequency band: inside it the error is the reported one, also between the sampled frequencies
    succeeds(&linearize("band.json", &["--reduce", "6", "--max-frequency", "20"]));
    let band = read("band.json");
    let answers = [&whole, &band].map(|model| answers_to_20_hz(model, 0.0025));
    let mut off = 0.0_f64;
    for at in 0..answers[0][0].len() {
        let largest = answers[0].iter().map(|gains| gains[at].norm()).fold(0.0, f64::max);
        let left = answers[0].iter().zip(&answers[1]).map(|(gains, own)| (gains[at] - own[at]).norm());
        off = off.max(left.fold(0.0, f64::max) / largest);
    }
    let stated = band["reduction"]["error_in_band"].as_f64().unwrap();
    assert!(band["states"].as_array().unwrap().len() <= 6 && band["reduction"]["up_to_Hz"] == 20.0, "{band}");
    assert!(off > 1e-9 && (stated / off - 1.0).abs() < 0.05, "{stated:e} is stated, {off:e} found");
    refuses(&linearize("y.json", &["--modes", "4"]), 3, "reduced by balanced truncation");
    let free = small.replace("model = \"uvlm\"", "model = \"uvlm\"\nfree_wake = true");
    std::fs::write(path("free.toml"), free).unwrap();
    let refused = foldwing(&["linearize", &path("free.toml"), "--lattice", "-o", &path("z.json")]);
    refuses(&refused, 3, "a free wake has no steady shape; write free_wake = false");
    // one remedy, not the one for a flow without a solution
    assert!(!String::from_utf8_lossy(&refused.stderr).contains("aerodynamics.step_s"));
    refuses(&on_model("linearize", &["--lattice", "-o", &path("z.json")]), 3, "only a vortex lattice");
    let bare = succeeds(&foldwing(&["modes", &model, "--count", "2"]));
    let blown = succeeds(&foldwing(&["modes", &model, "--count", "2", "--lattice"]));
    assert!(bare.contains("constant aerodynamic loads") && blown.contains("with its vortex lattice"), "{bare}{blown}");
    let judged = "stability: stable (with the vortex lattice: from the slowest modes in discrete time)";
    assert!(blown.contains(judged) && !bare.contains("with the vortex lattice"), "{bare}{blown}");
    let json = succeeds(&foldwing(&["modes", &model, "--count", "2", "--lattice", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["stability"]["with_air_of_lattice"], true);
    refuses(&foldwing(&["modes", &model, "--lattice", "--state", "undeformed"]), 2, "use --state equilibrium");
    // more states than fit into memory
    let long = small.replace("wake_rows = 10", "wake_rows = 2000");
    std::fs::write(path("long.toml"), long).unwrap();
    let refused = foldwing(&["linearize", &path("long.toml"), "--lattice", "-o", &path("z.json")]);
    refuses(&refused, 3, "at most 8000 states are allowed: use fewer wake_rows");
    // a gust that already acts on the wing would be part of the steady flow
    let gust = "[gust.early]\nshape = \"sharp_edge\"\nvelocity_m_s = [0.0, 0.0, 0.1]\n";
    for (origin_m, is_refused) in [("[0.0, 0.0, 0.0]", true), ("[0.0, 1.0, 0.0]", false)] {
        std::fs::write(path("gust.toml"), format!("{small}\n{gust}origin_m = {origin_m}\n")).unwrap();
        let said = foldwing(&["modes", &path("gust.toml"), "--count", "2", "--lattice"]);
        if is_refused {
            refuses(&said, 3, "gust \"early\" acts on the surfaces at this time");
        } else {
            succeeds(&said);
        }
    }
    let flutter = succeeds(&foldwing(&["flutter", &model, "--wind-m-s", "10:20:3", "--count", "3"]));
    assert!(flutter.contains("neither flutter nor divergence up to 20 m/s"), "{flutter}");
}

/// `check` counts the shapes of modal bodies, not the cells of their sums: the turbine of the paper has 16 degrees of freedom, 13 of shapes
/// and three of joints.
#[test]
fn check_counts_the_shapes_of_modal_bodies() {
    let path = "examples/turbine/nrel_5mw.toml";
    let json: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&["check", path, "--json"]))).unwrap();
    assert_eq!(json["degrees_of_freedom"], 16);
    let modal = |body: &&serde_json::Value| body["element_kind"] == "modal";
    let bodies: Vec<_> = json["bodies"].as_array().unwrap().iter().filter(modal).collect();
    let shapes: Vec<_> = bodies.iter().map(|body| body["degrees_of_freedom"].as_u64().unwrap()).collect();
    assert_eq!(shapes, [4, 3, 3, 3]);
    assert!(bodies.iter().all(|body| body["elements"] == 0));
    let text = succeeds(&foldwing(&["check", path]));
    assert!(text.contains("16 degrees of freedom") && text.contains(", 4 shapes,"), "{text}");
}

/// With strips, linear models and modes include aerodynamics: wind and a gust are inputs, lag states are states, flutter is found.
#[test]
fn linear_models_modes_and_flutter_are_in_the_air_of_strips() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let goland = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/goland_wing.toml");
    let inputs = ["--inputs", "wind.velocity.z,gust.z", "--outputs", "tip."];
    let said = succeeds(&foldwing(&[&["linearize", goland, "-o", &path("x.json")], &inputs[..]].concat()));
    assert!(said.contains("with aerodynamics") && !said.contains("constant"), "{said}");
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path("x.json")).unwrap()).unwrap();
    assert_eq!(json["without_air"], false);
    let names = |of: &str| -> Vec<String> {
        json[of].as_array().unwrap().iter().map(|signal| signal["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names("inputs"), ["wind.velocity.z", "gust.z"]);
    assert!(names("states").contains(&"wing.strip[12].gust_lag[3]".to_owned()), "{:?}", names("states"));
    let size = |of: &str| {
        json[of]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|row| row.as_array().unwrap())
            .map(|x| x.as_f64().unwrap().abs())
            .fold(0.0, f64::max)
    };
    assert!(size("B") > 0.0);
    assert!(succeeds(&foldwing(&["modes", goland])).contains("with aerodynamics"));
    let fluttering = foldwing(&["modes", goland, "--set", "wind.velocity.y=-145", "--count", "4"]);
    assert!(succeeds(&fluttering).contains("UNSTABLE"));
    let csv = path("modes.csv");
    let found = succeeds(&foldwing(&["flutter", goland, "--wind-m-s", "120:150:4", "--count", "3", "--csv", &csv]));
    assert!(found.contains("flutter at 137.4"), "{found}");
    let rows = std::fs::read_to_string(&csv).unwrap();
    assert!(rows.starts_with("speed_m_s,mode,frequency_Hz,damping_ratio,"), "{rows}");
    assert_eq!(rows.lines().count(), 1 + 4 * 3, "{rows}");
    let map =
        ["flutter", goland, "--wind-m-s", "120:160:3", "--count", "3", "--vary", "aero.density=1.0,1.225", "--json"];
    let map: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&map))).unwrap();
    let speed = |i: usize| map["results"][i]["flutter"][0]["speed_m_s"].as_f64().unwrap();
    assert!(speed(0) > 1.05 * speed(1), "thinner air, later flutter: {map}");
    for speeds in ["0:10:11", "-50:50:5"] {
        refuses(
            &foldwing(&["flutter", goland, "--wind-m-s", speeds]),
            2,
            "two or more positive speeds in ascending order",
        );
    }
    refuses(
        &foldwing(&["flutter", goland, "--speeds", "50:60:5"]),
        2,
        "--speeds has a new name: --wind-m-s FROM:TO:COUNT",
    );
    refuses(&foldwing(&["modes", goland, "--plot", &path("p")]), 2, "need --vary");
    let over = foldwing(&[
        "modes",
        goland,
        "--vary",
        "aero.density=0.1:1.3:4",
        "--count",
        "3",
        "--plot",
        &path("p"),
        "--plot-format",
        "svg",
    ]);
    assert!(succeeds(&over).contains("modes over aero.density"));
    assert!(folder.path().join("p/root_locus.svg").exists());
}

/// Mode shapes: a page and VTK files, for modes, flutter and a rotor; a model without modes to draw is rejected with the cause before
/// anything is written.
#[test]
fn mode_shapes_have_pages_and_vtk_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let shipped = |name: &str| format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let (goland, wing) = (shipped("models/goland_wing"), shipped("models/folding_wing"));
    let (page, vtk) = (path("modes.html"), path("vtk"));
    let said = succeeds(&foldwing(&["modes", &goland, "--count", "3", "--view", &page, "--vtk", &vtk]));
    assert_eq!(said, succeeds(&foldwing(&["modes", &goland, "--count", "3"])), "the same text as without pictures");
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("<script type=\"application/json\" class=\"modes\">") && text.contains("\"number\":3"));
    for number in 1..=3 {
        assert!(folder.path().join(format!("vtk/mode_{number}/run.pvd")).exists());
        assert!(folder.path().join(format!("vtk/mode_{number}/surfaces_0023.vtu")).exists());
    }
    assert!(!folder.path().join("vtk/mode_4").exists());
    let flutter = path("flutter.html");
    succeeds(&foldwing(&["flutter", &goland, "--wind-m-s", "120:150:4", "--count", "2", "--view", &flutter]));
    let text = std::fs::read_to_string(&flutter).unwrap();
    assert!(text.contains("flutter of mode 2") && text.contains("\"quantity\":[\"wind speed\",\"m/s\"]"));
    let none = path("none.html");
    for (arguments, code, message) in [
        (vec!["modes", &wing, "--count", "0", "--view", &none], 3, "no modes to draw"),
        (vec!["modes", &wing, "--vary", "gravity.z=-9:0:2", "--view", &none], 2, "cannot be used with"),
        (vec!["modes", &wing, "--vary", "gravity.z=-9:0:2", "--vtk", &vtk], 2, "cannot be used with"),
        (
            vec!["flutter", &goland, "--wind-m-s", "1,2", "--vary", "aero.density=1,2", "--view", &none],
            2,
            "cannot be used with",
        ),
        (vec!["periodic", &wing, "--count", "0", "--view", &none], 2, "which --count 0 omits"),
        (vec!["simulate", &wing, "--stop", "1e-3", "--view", &none, "--compare", &page], 1, "is a page of mode shapes"),
        (vec!["modes", &wing, "--view", &wing], 2, "refusing to overwrite"),
    ] {
        refuses(&foldwing(&arguments), code, message);
    }
    assert!(!folder.path().join("none.html").exists());
    std::fs::write(folder.path().join("vtk/mode_2/run.pvd"), "somebody's").unwrap();
    refuses(&foldwing(&["modes", &goland, "--count", "3", "--vtk", &vtk]), 4, "run.pvd");
}

/// Each library is assigned to the platform in its header; a wrong name or kind, or a repetition, is rejected with its position.
#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn libraries_of_several_platforms_make_one_fmu() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let here = library().to_str().unwrap().to_owned();
    // The same library with a header for 64-bit ARM: `e_machine` is 183.
    let mut bytes = std::fs::read(&here).unwrap();
    bytes[18..20].copy_from_slice(&183_u16.to_le_bytes());
    std::fs::write(path("arm=64.so"), &bytes).unwrap();
    let package = |libraries: &[&str]| {
        let mut arguments = vec!["-o".to_owned(), path("x.fmu")];
        arguments.extend(libraries.iter().map(|library| format!("--library={library}")));
        on_model("package", &arguments.iter().map(String::as_str).collect::<Vec<_>>())
    };

    for arm in [path("arm=64.so"), format!("aarch64-linux={}", path("arm=64.so"))] {
        succeeds(&package(&[&here, &arm]));
        let archive = zip::ZipArchive::new(std::fs::File::open(path("x.fmu")).unwrap()).unwrap();
        let names = archive.file_names().map(|name| name.unwrap().into_owned());
        let binaries: Vec<String> = names.filter(|name| name.starts_with("binaries/")).collect();
        assert_eq!(binaries, ["binaries/aarch64-linux/FoldingWing.so", "binaries/linux64/FoldingWing.so"]);
    }
    std::fs::remove_file(path("x.fmu")).unwrap();

    refuses(&package(&[&format!("win64={here}")]), 1, "the library is for linux64, not for win64");
    refuses(&package(&[&format!("linux128={here}")]), 2, "platform 'linux128' is unknown; allowed: linux64, ");
    refuses(&package(&[&here, &here]), 2, "a second library for linux64; the first is ");
    refuses(&package(&[env!("CARGO_BIN_EXE_foldwing")]), 1, "not a Foldwing library: it does not export fmi2");
    refuses(&package(&["linux64=none.so"]), 4, "none.so: cannot read the library");
    assert!(!Path::new(&path("x.fmu")).exists(), "a refused package leaves no file");
}

/// `latency` steps a real-time model, prints wall-clock and processor time and counts; its turbulence is seeded, so its counts are
/// reproducible.
#[test]
fn latency_is_measured() {
    let folder = scratch();
    let path = folder.path().join("real_time.toml");
    let text = std::fs::read_to_string(model()).unwrap() + "\n[solver]\nmode = \"real_time\"\n";
    std::fs::write(&path, text).unwrap();
    let run = |more: &[&str]| foldwing(&[&["latency", path.to_str().unwrap(), "--steps", "300"], more].concat());
    let counts = |output: &Output| {
        let text = succeeds(output);
        let counts = text.split("; ").nth(1).unwrap().to_owned();
        assert!(text.contains("median") && text.contains("slowest") && text.contains("processor time"), "{text}");
        counts
    };
    let first = counts(&run(&[]));
    assert!(first.starts_with("301 internal steps, 0 repeated,"), "{first}"); // one more for the latch
    assert_eq!(first, counts(&run(&["--paced"])));
    assert_ne!(first, counts(&run(&["--seed", "2", "--turbulence", "0.5"])));
    refuses(&run(&["--step", "0"]), 2, "--step 0: must be a finite number and positive");
    refuses(&run(&["--turbulence=-1"]), 2, "--turbulence -1: must be a finite number and at least 0");
}

/// A rod on a free hinge, started upright: `static` finds the hanging state and reports this, `--branch path` keeps the upright state and
/// reports it as unstable; `modes` prints the real pole in 1/s, marked, without frequency and damping ratio (it used to print `damping
/// -1.000000` and a frequency).
#[test]
fn modes_prints_real_poles_and_static_the_stable_state() {
    let folder = scratch();
    let path = folder.path().join("rod.toml");
    let text = "name = \"Rod\"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[section.s]\nshape = \"rectangle\"\nwidth_m = 0.05\n\
        height_m = 0.002\ndensity_kg_m3 = 1425.0\nyoungs_modulus_Pa = 2.83e9\npoisson_ratio = 0.3\n[body.rod]\nlength_m = 0.3\n\
        section = \"s\"\nelements = 4\n[joint.h]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"rod\"\n\
        axis = [0.0, 1.0, 0.0]\nstart_angle_deg = -30.0\n[simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\n";
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    let hanging = succeeds(&foldwing(&["static", path]));
    assert!(hanging.contains("stability: stable") && hanging.contains("found by descent"), "{hanging}");
    let upright = succeeds(&foldwing(&["static", path, "--branch", "path"]));
    assert!(upright.contains("UNSTABLE in 1 direction") && upright.contains("grows with 7.00"), "{upright}");
    let json: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&["static", path, "--json"]))).unwrap();
    assert_eq!(json["stability"]["stable"], true);
    assert_eq!(json["stability"]["left_path"]["unstable_directions"], 1);
    let modes = succeeds(&foldwing(&["modes", path, "--count", "2"]));
    assert!(modes.contains("1/s, real UNSTABLE") && !modes.contains("-1.000000"), "{modes}");
    let json: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&["modes", path, "--json"]))).unwrap();
    let first = &json["modes"][0];
    assert!(first["frequency_Hz"].is_null() && first["damping_ratio"].is_null() && first["grows"] == true, "{first}");
    let table = succeeds(&on_model("static", &["--path", "arc-length", "--set", "fold.release=0"]));
    assert!(table.contains("Path of equilibria"), "{table}");
}

/// A bar on a ball joint of a loop, without gravity, has no unique equilibrium: the message gives the free motion and the joint.
#[test]
fn a_body_that_a_loop_leaves_a_motion_is_told() {
    let folder = scratch();
    let path = folder.path().join("hung.toml");
    let body =
        |name: &str| format!("[body.{name}]\nlength_m = 0.2\nsection = \"bar\"\nelements = 1\nload_stations = 0\n");
    let joint = |kind: &str, child: &str| {
        format!("[joint.{kind}]\ntype = \"{kind}\"\nparent = \"root\"\nchild = \"{child}\"\n")
    };
    let text = format!(
        "name = \"Hung\"\n[section.bar]\nshape = \"rectangle\"\nwidth_m = 0.02\nheight_m = 0.01\ndensity_kg_m3 = 2700.0\n\
         youngs_modulus_Pa = 70e9\npoisson_ratio = 0.33\n{}{}{}{}[loop.pin]\nbodies = [\"arm\", \"bar\"]\npositions_m = [0.0, 0.0]\n\
         stiffness_N_m = 1e5\n",
        body("arm"),
        body("bar"),
        joint("clamped", "arm"),
        joint("free", "bar"),
    );
    std::fs::write(&path, text).unwrap();
    let refused = foldwing(&["static", path.to_str().unwrap()]);
    refuses(
        &refused,
        3,
        "joint \"free\": its body is held by loops only, which leave a motion free; add a spring to a joint of the loops",
    );
}

/// Trim: in the wind found, the lift of the wing balances its weight; other commands accept this wind.
#[test]
fn trim_finds_the_wind_that_carries_the_wing() {
    let flared = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/flared_wing_tip.toml");
    let call = ["trim", flared, "--solve-for", "wind.velocity.z", "--target", "root.force.z=0", "--json"];
    let found: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&call))).unwrap();
    // before, the load on the root is 17.6 N
    assert!(found["balances"]["root.force.z"].as_f64().unwrap().abs() <= 17.7e-9, "{found}");
    let wind_m_s = found["free"]["wind.velocity.z"].as_f64().unwrap();
    assert!(wind_m_s < -0.1, "the wing flies nose up: {found}");
    let setting = format!("wind.velocity.z={wind_m_s:?}");
    let rest = succeeds(&foldwing(&["static", flared, "--set", &setting, "--json"]));
    let rest: serde_json::Value = serde_json::from_str(&rest).unwrap();
    assert!(rest.is_object());
    refuses(
        &foldwing(&[
            "trim",
            flared,
            "--solve-for",
            "wind.velocity.z",
            "--target",
            "root.force.z=0",
            "--target",
            "root.force.y=0",
        ]),
        2,
        "1 unknowns for 2 targets",
    );
    refuses(
        &foldwing(&["trim", flared, "--solve-for", "fold.release", "--target", "root.force.z=0"]),
        2,
        "not a real input",
    );
    refuses(
        &foldwing(&["trim", flared, "--solve-for", "wind.velocity.z", "--target", "root.force.z"]),
        2,
        "must be NAME=VALUE",
    );
    for repeated in ["wind.velocity.z,-wind.velocity.z", "wind.velocity.z,wind.velocity.z"] {
        let call = foldwing(&["trim", flared, "--solve-for", repeated, "--target", "root.force.z=0"]);
        refuses(&call, 2, "--solve-for wind.velocity.z: is named twice");
    }
    let twice = ["--target", "root.force.z=0", "--target", "root.force.z=1"];
    let free = ["trim", flared, "--solve-for", "wind.velocity.z", "--solve-for", "wind.velocity.y"];
    refuses(&foldwing(&[&free[..], &twice[..]].concat()), 2, "--target root.force.z: is named twice");
    // the motor has no spring that a command could move
    let nothing = foldwing(&["trim", flared, "--solve-for", "fold.angle_command", "--target", "root.force.z=0"]);
    refuses(&nothing, 3, "the targets do not depend independently");
}

/// Trim of a free aircraft: three free values balance six loads, and every command accepts the resulting settings; modes have names.
/// Remaining loads are listed.
#[test]
fn trim_balances_a_free_aircraft() {
    let aircraft = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/flight/folding_aircraft.toml");
    let elevators =
        "aero.control_surface.elevator_left.angle_command,aero.control_surface.elevator_right.angle_command";
    let free = [
        "trim",
        aircraft,
        "--solve-for",
        "attitude.pitch",
        "--solve-for",
        elevators,
        "--solve-for",
        "load.fuselage[1].force.x",
    ];
    let found: serde_json::Value =
        serde_json::from_str(&succeeds(&foldwing(&[&free[..], &["--json"]].concat()))).unwrap();
    assert!((0.02..0.04).contains(&found["free"]["attitude.pitch"].as_f64().unwrap()), "{found}");
    let settings = found["settings"].as_object().unwrap();
    assert_eq!(
        settings["aero.control_surface.elevator_left.angle_command"],
        settings["aero.control_surface.elevator_right.angle_command"]
    );
    let settings: Vec<String> =
        settings.iter().flat_map(|(name, value)| ["--set".to_owned(), format!("{name}={value}")]).collect();
    let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
    let modes = succeeds(&foldwing(&[&["modes", aircraft, "--count", "12"][..], &settings].concat()));
    // the roll subsidence consists mostly of lag states, so it is excluded
    for name in ["spiral", "phugoid", "dutch roll", "short period"] {
        assert!(modes.contains(&format!("{name}: ")), "{modes}");
    }
    refuses(&foldwing(&["static", aircraft]), 3, "remain on the free joint \"flight\"; trim the model");
    // a single elevator rolls the aircraft
    let lame = [
        "trim",
        aircraft,
        "--solve-for",
        "attitude.pitch",
        "--solve-for",
        "aero.control_surface.elevator_left.angle_command",
    ];
    let lame = foldwing(&[&lame[..], &["--solve-for", "load.fuselage[1].force.x"]].concat());
    refuses(&lame, 3, "flight: moment x");
    // with one tip folded it flies banked, with six free values for six loads
    let folded = [
        "--set",
        "fold_left.start_angle=1.0472",
        "--solve-for",
        "attitude.roll",
        "--solve-for",
        "aero.control_surface.rudder.angle_command",
    ];
    let ailerons = [
        "--solve-for",
        "aero.control_surface.aileron_left.angle_command,-aero.control_surface.aileron_right.angle_command",
    ];
    let found = succeeds(&foldwing(&[&free[..], &folded, &ailerons, &["--json"]].concat()));
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    assert!((-0.2..-0.1).contains(&found["free"]["attitude.roll"].as_f64().unwrap()), "{found}");
    // elevators in opposite directions do not pitch the aircraft
    let twisted = foldwing(&[
        "trim",
        aircraft,
        "--solve-for",
        "aero.control_surface.elevator_left.angle_command,-aero.control_surface.elevator_right.angle_command",
    ]);
    refuses(&twisted, 3, "no trim: ");
    refuses(
        &foldwing(&["trim", aircraft, "--solve-for", "wind.velocity.x,gravity.x"]),
        2,
        "units cannot share a value",
    );
    let still = ["trim", aircraft, "--solve-for", "attitude.pitch", "--set", "wind.velocity.x=0"];
    refuses(&foldwing(&still), 2, "an attitude needs gravity and a wind that is not parallel to it");
    let eight = ["x", "y", "z"].map(|axis| format!("gravity.{axis}"));
    let eight = eight.iter().chain(&eight).chain(&eight).flat_map(|name| ["--solve-for", name.as_str()]);
    let eight: Vec<&str> = ["trim", aircraft].into_iter().chain(eight).collect();
    refuses(&foldwing(&eight), 2, "9 unknowns for 0 targets; 1 to 6 unknowns are needed");
}

/// Frequency response of a discrete-time model, as written by linearize, at 77 frequencies up to 20 Hz.
fn answers_to_20_hz(model: &serde_json::Value, step_s: f64) -> Vec<nalgebra::DMatrix<nalgebra::Complex<f64>>> {
    let matrix = |name: &str| {
        let rows: Vec<Vec<f64>> = serde_json::from_value(model[name].clone()).unwrap();
        nalgebra::DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| nalgebra::Complex::from(rows[i][j]))
    };
    let [a, b, c, d] = ["A", "B", "C", "D"].map(matrix);
    let answer = |i: usize| {
        let z = nalgebra::Complex::from_polar(1.0, std::f64::consts::TAU * 20.0 * i as f64 / 76.0 * step_s);
        let inside = nalgebra::DMatrix::from_diagonal_element(a.nrows(), a.nrows(), z) - &a;
        &c * inside.lu().solve(&b).unwrap() + &d
    };
    (0..77).map(answer).collect()
}

/// FD-06. A level turn banked by 0.5 rad: all loads on the free joint vanish, the turn rate follows from gravity and bank, the lift of the
/// wings corresponds to the load factor, and the released aircraft stays on its circle. Impossible turns are rejected with the cause.
#[test]
fn trim_flies_a_steady_turn() {
    let aircraft = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/flight/folding_aircraft.toml");
    let straight = [
        "trim",
        aircraft,
        "--solve-for",
        "attitude.pitch",
        "--solve-for",
        "load.fuselage[1].force.x",
        "--solve-for",
        "aero.control_surface.elevator_left.angle_command,aero.control_surface.elevator_right.angle_command",
    ];
    let lateral = [
        "--solve-for",
        "aero.control_surface.aileron_left.angle_command,-aero.control_surface.aileron_right.angle_command",
        "--solve-for",
        "aero.control_surface.rudder.angle_command",
    ];
    let turn = [&straight[..], &lateral, &["--solve-for", "turn.rate"]].concat();
    let trimmed = |arguments: &[&str]| -> (serde_json::Value, Vec<String>) {
        let found: serde_json::Value =
            serde_json::from_str(&succeeds(&foldwing(&[arguments, &["--json"]].concat()))).unwrap();
        let settings = found["settings"].as_object().unwrap();
        let settings =
            settings.iter().flat_map(|(name, value)| ["--set".to_owned(), format!("{name}={value}")]).collect();
        (found, settings)
    };
    let strain = |settings: &[String]| -> f64 {
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let rest = succeeds(&foldwing(&[&["static", aircraft, "--json"][..], &settings].concat()));
        let rest: serde_json::Value = serde_json::from_str(&rest).unwrap();
        rest["gauges"].as_array().unwrap().iter().map(|gauge| gauge["strain"].as_f64().unwrap()).sum()
    };
    let (bank_rad, speed_m_s) = (0.5f64, 18.0);
    let (found, settings) = trimmed(&[&turn[..], &["--set", "attitude.roll=0.5"]].concat());
    let rate_rad_s = found["free"]["turn.rate"].as_f64().unwrap();
    // fin and rudder carry a small part of the side force, and the nose is 0.04 rad up
    let level_rad_s = 9.81 * bank_rad.tan() / speed_m_s;
    assert!((rate_rad_s / level_rad_s - 1.0).abs() < 5e-3, "{rate_rad_s} {level_rad_s}");
    let share = strain(&settings) / strain(&trimmed(&straight).1);
    println!(
        "turn at {rate_rad_s} rad/s, {level_rad_s} by bank and gravity; strains {share} of those in straight flight"
    );
    // spar bending grows less than the load: on bent wings the lift moves inboard
    assert!((share * bank_rad.cos() - 1.0).abs() < 0.03, "{share}");
    // the same turn specified by its rate, to the left
    let mirrored = [&straight[..], &lateral, &["--solve-for", "attitude.roll", "--set"]].concat();
    let other = trimmed(&[&mirrored[..], &[&format!("turn.rate={}", -rate_rad_s)]].concat()).0;
    assert!((other["free"]["attitude.roll"].as_f64().unwrap() + bank_rad).abs() < 1e-6, "{other}");
    // released
    let mut run =
        vec!["simulate", aircraft, "--stop", "4", "--step", "4", "--csv", "-", "--variables", "flight.rotation.*"];
    run.extend(settings.iter().map(String::as_str));
    let rows = succeeds(&foldwing(&run));
    let last: Vec<f64> = rows.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    let turned_rad = 2.0 * last[2..5].iter().map(|part| part * part).sum::<f64>().sqrt();
    println!("attitude off by {turned_rad:.1e} rad after 4 s");
    // the tolerance of the coupling, 1e-6 of the loads, amplified by the phugoid
    assert!(turned_rad < 1e-4, "{rows}");
    // the root rotates about the direction of gravity and moves against the wind, eq. (Q11)
    let vector = |name: &str| {
        nalgebra::Vector3::from_fn(|i, _| found["settings"][format!("{name}.{}", ["x", "y", "z"][i])].as_f64().unwrap())
    };
    let spin = vector("gravity").normalize() * rate_rad_s;
    assert!((vector("root.angular_velocity") - spin).norm() < 1e-12, "{found}");
    assert!((vector("root.acceleration") + spin.cross(&vector("wind.velocity"))).norm() < 1e-12, "{found}");
    // the same turn about another centre: the aircraft moves once around it per revolution in the root frame, which is not a flight mode
    let mut modes = vec!["modes", aircraft, "--count", "6", "--json"];
    modes.extend(settings.iter().map(String::as_str));
    let modes: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&modes))).unwrap();
    let modes = modes["modes"].as_array().unwrap();
    let eigenvalue = |mode: &serde_json::Value| [0, 1].map(|part| mode["eigenvalue_1_s"][part].as_f64().unwrap());
    let around = modes.iter().find(|mode| (eigenvalue(mode)[1] - rate_rad_s).abs() < 1e-6).expect("a mode at the rate");
    assert!(eigenvalue(around)[0].abs() < 1e-6 && around["flight_mode"].is_null(), "{around}");
    let dutch_roll = modes.iter().find(|mode| mode["flight_mode"] == "dutch roll").expect("a dutch roll");
    assert!(eigenvalue(dutch_roll)[1] > 5.0, "{dutch_roll}");
    let refused = |text: &str, arguments: &[&str]| refuses(&foldwing(arguments), 2, text);
    let wing = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/flared_wing_tip.toml");
    let held = ["trim", wing, "--solve-for", "wind.velocity.z", "--target", "root.force.z=0", "--set", "turn.rate=0.1"];
    refused("only a model on a free joint can fly a steady turn", &held);
    refused("the value is not a finite number", &[&straight[..], &["--set", "turn.rate=nan"]].concat());
    let moved = [&turn[..], &["--set", "root.angular_velocity.z=0.1"]].concat();
    refused("a turn sets root.acceleration and root.angular_velocity", &moved);
    let lattice =
        std::fs::read_to_string(aircraft).unwrap().replace("model = \"strip\"", "model = \"uvlm\"\nfree_wake = true");
    let lattice = lattice.replace("drag_coefficient = 0.01\n", "chord_panels = 2\n").replace("= 0.75", "= 0.5");
    let lattice = lattice.replace("hinge_fraction = 0.7\n", "hinge_fraction = 0.5\n");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lattice.toml");
    std::fs::write(&path, lattice).unwrap();
    let path = path.to_str().unwrap();
    let in_lattice: Vec<&str> = turn.iter().map(|part| if *part == aircraft { path } else { part }).collect();
    refused("a free wake has no steady shape in a turn", &in_lattice);
}

/// Trim of a control surface: the angle at which the aileron floats, with strips and with the lattice; a balance not reached by any angle
/// within the limits is an error.
#[test]
fn trim_finds_the_angle_at_which_an_aileron_floats() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/aileron/folding_aileron.toml"));
    let text = text.unwrap();
    let folder = tempfile::tempdir().unwrap();
    let found = ["strip", "uvlm"].map(|model| {
        let path = folder.path().join(format!("{model}.toml"));
        let lattice = text.replace("model = \"strip\"", "model = \"uvlm\"").replace("indicial = \"fine\"\n", "");
        std::fs::write(&path, if model == "uvlm" { &lattice } else { &text }).unwrap();
        let path = path.to_str().unwrap();
        let free = ["trim", path, "--solve-for", "aero.control_surface.aileron.angle_command", "--target"];
        let call = [&free[..], &["aero.control_surface.aileron.hinge_moment=0", "--json"]].concat();
        let found: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&call))).unwrap();
        // the hinge moment at angle 0 is 1e-2 N·m
        assert!(
            found["balances"]["aero.control_surface.aileron.hinge_moment"].as_f64().unwrap().abs() <= 1e-9,
            "{found}"
        );
        let call = [&free[..], &["root.moment.y=-1000"]].concat();
        refuses(&foldwing(&call), 3, "no step reduces the residuals");
        found["free"]["aero.control_surface.aileron.angle_command"].as_f64().unwrap()
    });
    // it floats up in the wind that lifts the wing
    assert!(found.iter().all(|angle_rad| (-0.2..-0.005).contains(angle_rad)), "{found:?}");
}
