//! Common features of all commands: JSON, the list of written files, vectors by name; templates and examples.

use crate::command_line::{foldwing as run, succeeds};
use crate::library;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn example(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name).to_str().unwrap().to_owned()
}

fn wing() -> String {
    example("models/folding_wing.toml")
}

fn in_folder(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_foldwing")).current_dir(folder).args(arguments).output().expect("the command runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[track_caller]
fn json(output: &Output) -> Value {
    serde_json::from_str(&succeeds(output)).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

#[track_caller]
fn refused(output: &Output, code: i32) -> String {
    assert_eq!(output.status.code(), Some(code), "{}", stderr(output));
    stderr(output).lines().next().unwrap_or_default().to_owned()
}

/// Every command that writes files lists them on standard error; with `--quiet` standard error is empty.
#[test]
fn written_files_are_listed_unless_quiet() {
    let (wing, goland) = (wing(), example("models/goland_wing.toml"));
    let library = library().to_str().unwrap().to_owned();
    let held = ["--set", "fold.release=0"];
    let wind = ["--wind-m-s", "100:140:2", "--count", "2"];
    let commands: [(&[&str], &[&str]); 9] = [
        (&["check", &wing, "--draw", "wing.svg"], &["wing.svg"]),
        (&["simulate", &wing, "--stop", "0.01", "--csv", "run.csv"], &["run.csv"]),
        (&["sweep", &wing, "--vary", "fold.start_angle=1,2", "--stop", "0.01", "-o", "grid.csv"], &["grid.csv"]),
        (
            &[
                "modes",
                &wing,
                held[0],
                held[1],
                "--vary",
                "root.angular_velocity.z=0,1",
                "--count",
                "2",
                "--csv",
                "m.csv",
            ],
            &["m.csv"],
        ),
        (&["flutter", &goland, wind[0], wind[1], wind[2], wind[3], "--csv", "f.csv"], &["f.csv"]),
        (
            &["flutter", &goland, wind[0], wind[1], wind[2], wind[3], "--plot", "p", "--plot-format", "svg"],
            &["p/damping.svg", "p/frequency.svg", "p/root_locus.svg"],
        ),
        (&["linearize", &wing, held[0], held[1], "--outputs", "tip.", "-o", "wing.npz"], &["wing.npz"]),
        (&["package", &wing, "-o", "Wing.fmu", "--no-reference", "--library", &library], &["Wing.fmu"]),
        (
            &["examples", "models/roll_fold.toml", "-o", "."],
            &["./models/roll_fold.toml", "./models/foldwing.schema.json"],
        ),
    ];
    for (arguments, files) in commands {
        let folder = tempfile::tempdir().unwrap();
        let quiet = in_folder(folder.path(), &[arguments, &["-q"]].concat());
        succeeds(&quiet);
        assert_eq!(stderr(&quiet), "", "{arguments:?}");
        files.iter().for_each(|file| assert!(folder.path().join(file).is_file(), "{file}"));
        let folder = tempfile::tempdir().unwrap();
        let loud = in_folder(folder.path(), arguments);
        succeeds(&loud);
        for file in files {
            assert!(stderr(&loud).lines().any(|line| line == format!("wrote {file}")), "{file}: {}", stderr(&loud));
        }
        if arguments[0] != "linearize" {
            assert_eq!(quiet.stdout, loud.stdout, "the result is the same: {arguments:?}");
        }
    }
}

/// Commands without result files have the option, too: it suppresses warnings and notes.
#[test]
fn quiet_leaves_out_warnings() {
    let goland = example("models/goland_wing.toml");
    // wind from behind
    let behind = ["static", &goland, "--set", "wind.velocity.y=60"];
    let (loud, quiet) = (run(&behind), run(&[&behind[..], &["-q"]].concat()));
    assert_eq!(succeeds(&loud), succeeds(&quiet));
    assert!(stderr(&loud).starts_with("warning: the wind meets the surface of wing from behind"), "{}", stderr(&loud));
    assert_eq!(stderr(&quiet), "");
    let tip = example("models/flared_wing_tip.toml");
    let trim = run(&["trim", &tip, "--solve-for", "wind.velocity.z", "--target", "root.force.z=0", "--quiet"]);
    assert!(succeeds(&trim).contains("wind.velocity.z = ") && trim.stderr.is_empty());
}

/// `simulate --json` contains the joints and counts of its table and profile, and the files; messages for users go to standard error.
#[test]
fn the_summary_of_a_run_is_json() {
    let folder = tempfile::tempdir().unwrap();
    let wing = wing();
    let arguments = ["simulate", &wing, "--csv", "run.csv", "--profile", "cost.json", "--json"];
    let output = in_folder(folder.path(), &arguments);
    let value = json(&output);
    assert_eq!(stderr(&output), "wrote run.csv\nwrote cost.json\n");
    let table = fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let last = |name: &str| -> f64 {
        let place = table.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
        table.lines().last().unwrap().split(',').nth(place).unwrap().parse().unwrap()
    };
    let fold = &value["joints"][0];
    assert_eq!(fold["name"], "fold");
    assert_eq!(fold["angle_rad"].as_f64(), Some(last("fold.angle")));
    assert_eq!(fold["latch_time_s"].as_f64(), Some(last("fold.latch_time")));
    assert_eq!((&fold["latched"], &fold["latch_count"]), (&true.into(), &1.into()));
    assert_eq!(value["rows"].as_u64(), Some(table.lines().count() as u64 - 1));
    assert_eq!(value["files"], serde_json::json!(["run.csv", "cost.json"]));
    let cost: Value = serde_json::from_str(&fs::read_to_string(folder.path().join("cost.json")).unwrap()).unwrap();
    for count in ["steps", "rejections", "iterations", "factorizations"] {
        assert_eq!(value["solver"][count], cost[count], "{count}");
    }
    let open = json(&run(&["simulate", &wing, "--stop", "0.01", "--json", "-q"]));
    assert_eq!((&open["joints"][0]["latched"], &open["joints"][0]["latch_time_s"]), (&false.into(), &Value::Null));
    let message = refused(&run(&["simulate", &wing, "--json", "--csv", "-"]), 2);
    assert_eq!(message, "error: --csv -: --json writes to standard output too; name a file for the table");
}

/// JSON of sweeps, linear models, latency and modes as functions of a quantity: the numbers of their tables.
#[test]
fn other_results_are_json() {
    let folder = tempfile::tempdir().unwrap();
    let wing = wing();
    let held = ["--set", "fold.release=0"];
    let grid = ["sweep", &wing, "--vary", "fold.start_angle=1,2", "--stop", "0.01", "-o", "g.csv", "--json", "-q"];
    for resumed in [0, 2] {
        let sweep = json(&in_folder(folder.path(), &grid));
        assert_eq!((&sweep["variants"], &sweep["failed"], &sweep["resumed"]), (&2.into(), &0.into(), &resumed.into()));
        let header = fs::read_to_string(folder.path().join("g.csv")).unwrap();
        let columns: Vec<&str> = header.lines().next().unwrap().split(',').collect();
        assert_eq!(sweep["columns"], serde_json::json!(columns));
    }

    let linearize = [
        "linearize",
        &wing,
        held[0],
        held[1],
        "--inputs",
        "fold.external_torque",
        "--reduce",
        "4",
        "--outputs",
        "tip.",
    ];
    let described = json(&in_folder(folder.path(), &[&linearize[..], &["-o", "w.json", "--json", "-q"]].concat()));
    let file: Value = serde_json::from_str(&fs::read_to_string(folder.path().join("w.json")).unwrap()).unwrap();
    for key in ["states", "inputs", "outputs", "state", "reduction"] {
        assert_eq!(described[key], file[key], "{key}");
    }
    assert!(described.get("A").is_none() && described["files"] == serde_json::json!(["w.json"]));

    let latency = json(&run(&["latency", &wing, "--steps", "50", "--json"]));
    let steps: u64 = latency["wall_time"]["histogram"]
        .as_array()
        .unwrap()
        .iter()
        .map(|class| class["steps"].as_u64().unwrap())
        .sum();
    assert_eq!((steps, &latency["steps"]), (50, &50.into()));
    assert!(
        latency["wall_time"]["median_us"].as_f64().unwrap() <= latency["wall_time"]["slowest_us"].as_f64().unwrap()
    );

    let over = ["modes", &wing, held[0], held[1], "--count", "3", "--vary", "root.angular_velocity.z=0,10,20"];
    let modes = json(&in_folder(folder.path(), &[&over[..], &["--csv", "m.csv", "--json", "-q"]].concat()));
    let table = fs::read_to_string(folder.path().join("m.csv")).unwrap();
    let mut rows =
        table.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<_>>());
    for place in modes["modes"].as_array().unwrap() {
        for mode in 0..3 {
            let row = rows.next().unwrap();
            let values = [&place["value"], &place["frequency_Hz"][mode], &place["damping_ratio"][mode]];
            assert_eq!(values.map(|value| value.as_f64()), [0, 2, 3].map(|column| Some(row[column])));
            let pair = &place["eigenvalues_1_s"][mode];
            assert_eq!([pair[0].as_f64(), pair[1].as_f64()], [Some(row[4]), Some(row[5])]);
        }
    }
    assert!(rows.next().is_none() && modes["ended"].is_null() && modes["over"] == "root.angular_velocity.z");
}

/// The JSON of a Campbell diagram contains the names of the modes.
#[test]
fn a_campbell_diagram_is_json() {
    let turbine = example("turbine/nrel_5mw.toml");
    let diagram = json(&run(&[
        "modes",
        &turbine,
        "--state",
        "undeformed",
        "--vary",
        "rotor_speed_rpm=0,6,12",
        "--count",
        "2",
        "--json",
        "-q",
    ]));
    let last = &diagram["modes"][2];
    assert_eq!((&diagram["over"], last["value"].as_f64()), (&"rotor_speed_rpm".into(), Some(12.0)));
    // the free rotation of the shaft, then the tower
    assert_eq!((&last["motion"][0], &last["frequency_Hz"][0]), (&"shaft, free".into(), &0.0.into()));
    assert!(last["motion"][1].as_str().unwrap().starts_with("tower"), "{last}");
    assert!((last["frequency_Hz"][1].as_f64().unwrap() - 0.3266).abs() < 1e-3, "{last}");
}

/// A closed standard output is not an error, with JSON either.
#[test]
fn a_closed_pipe_ends_json_quietly() {
    let wing = wing();
    for arguments in
        [&["simulate", &wing, "--stop", "0.01", "--json"][..], &["examples", "--json"], &["modes", &wing, "--json"]]
    {
        let mut child = Command::new(env!("CARGO_BIN_EXE_foldwing"))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()), "{arguments:?}");
    }
}

/// The name of a vector selects and sets all its components, with a unit for all or in SI.
#[test]
fn vectors_are_set_and_chosen_by_name() {
    let wing = wing();
    let table = |settings: &[&str]| {
        let own = [
            "simulate",
            &wing,
            "--stop",
            "0.02",
            "-q",
            "--csv",
            "-",
            "--variables",
            "tip.position,gravity,root.angular_velocity",
        ];
        let set: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
        succeeds(&run(&[&own[..], &set].concat()))
    };
    let whole = table(&["gravity=0, 1,-1.62", "root.angular_velocity=45,0,90 deg/s"]);
    let header = "time,tip.position.x,tip.position.y,tip.position.z,gravity.x,gravity.y,gravity.z";
    assert!(whole.starts_with(header), "{whole}");
    let turn = ["root.angular_velocity.x=45 deg/s", "root.angular_velocity.z=90 deg/s"];
    let parts = ["gravity.x=0", "gravity.y=1", "gravity.z=-1.62", turn[0], turn[1]];
    assert_eq!(whole, table(&parts));
    assert_ne!(whole, table(&parts[..4]));
    let message = |setting: &str| refused(&run(&["static", &wing, "--set", setting]), 2);
    assert_eq!(message("gravity=0,-9.81"), "error: --set gravity=0,-9.81: 2 values for 3 components; write X,Y,Z");
    assert_eq!(message("gravity=0,0,down"), "error: --set gravity=0,0,down: gravity.z: `down` is not a number");
    assert!(message("tip.position=0,0,0").contains("tip.position.x: "), "an output cannot be set");
    assert!(message("gravity=0,0,inf").contains("must be finite"));
    // studies of rotating rotors and sweeps have different settings
    let turbine = example("turbine/nrel_5mw.toml");
    let turn = [
        "periodic",
        &turbine,
        "--speed-rpm",
        "12.1",
        "--count",
        "0",
        "--steps",
        "144",
        "--variables",
        "body.tower.deflection.z",
        "--json",
    ];
    let with = |settings: &[&str]| succeeds(&run(&[&turn[..], settings].concat()));
    assert_eq!(
        with(&["--set", "gravity=0,0,-1"]),
        with(&["--set", "gravity.x=0", "--set", "gravity.y=0", "--set", "gravity.z=-1"])
    );
}

/// Every template is a valid model named after the file, and the commands in it run as printed; nothing is overwritten, and identical files
/// are kept.
#[test]
fn templates_are_models_that_run() {
    for (template, files) in [("wing", 2), ("aircraft", 2), ("turbine", 10), ("tunnel", 2), ("aileron", 2)] {
        let folder = tempfile::tempdir().unwrap();
        let told = succeeds(&in_folder(folder.path(), &["new", "my-model.toml", "--template", template]));
        let text = fs::read_to_string(folder.path().join("my-model.toml")).unwrap();
        assert!(
            text.starts_with("#:schema ./foldwing.schema.json\n\n") && text.contains("\nname = \"my_model\""),
            "{text}"
        );
        assert_eq!(walk(folder.path()).len(), files, "{template}");
        let value = json(&in_folder(folder.path(), &["simulate", "my-model.toml", "--stop", "0.04", "--json", "-q"]));
        assert_eq!(value["name"], "my_model");
        let commands: Vec<&str> = told.lines().filter_map(|line| line.trim().strip_prefix("foldwing ")).collect();
        assert!(commands.len() >= 3 && commands[0].starts_with("check my-model.toml"), "{told}");
        for command in commands {
            assert!(text.contains(&format!("#   foldwing {command}")), "{command}");
            // runs and packages are tested above, and the long ones are shortened
            let words: Vec<&str> =
                command.split("  ").next().unwrap().split(' ').map(|word| word.trim_matches('\'')).collect();
            if ["check", "trim", "flutter"].contains(&words[0]) {
                succeeds(&in_folder(folder.path(), &words));
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let new = |arguments: &[&str]| in_folder(folder.path(), &[&["new"], arguments].concat());
    succeeds(&new(&["one.toml", "--template", "turbine"]));
    succeeds(&new(&["two.toml", "-t", "turbine", "-q"]));
    fs::write(folder.path().join("polars/du21_a17.csv"), "mine").unwrap();
    let message = refused(&new(&["three.toml", "-t", "turbine"]), 4);
    assert_eq!(message, "error: polars/du21_a17.csv: exists already; --force overwrites it");
    assert!(!folder.path().join("three.toml").exists(), "a refusal leaves nothing behind");
    assert!(refused(&new(&["three.toml", "-t", "plane"]), 2).contains("plane"));
}

fn walk(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] }).collect()
}

/// The examples are those of the repository, byte for byte, with the files they need; files of the user are kept.
#[test]
fn examples_are_listed_and_copied() {
    let list = succeeds(&run(&["examples"]));
    for line in ["models/goland_wing.toml", "turbine/nrel_5mw_wind.toml", "python_ten_lines.py"] {
        assert!(
            list.lines().any(|listed| listed.starts_with(line) && listed.len() > line.len() + 10),
            "{line}: {list}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let copy = |arguments: &[&str]| in_folder(folder.path(), &[&["examples", "-o", "try"], arguments].concat());
    succeeds(&copy(&["turbine/nrel_5mw_wind.toml"]));
    assert_eq!(walk(folder.path()).len(), 10);
    succeeds(&in_folder(folder.path(), &["check", "try/turbine/nrel_5mw_wind.toml"]));
    succeeds(&copy(&[]));
    let copied = walk(folder.path());
    for path in &copied {
        let name = path.strip_prefix(folder.path().join("try")).unwrap();
        assert_eq!(fs::read(path).unwrap(), fs::read(example(name.to_str().unwrap())).unwrap(), "{}", name.display());
    }
    // all models and scripts of the repository, except notebooks
    let own = walk(Path::new(&example("")));
    let is_copied = |path: &&PathBuf| ["toml", "py"].contains(&path.extension().unwrap_or_default().to_str().unwrap());
    assert_eq!(copied.iter().filter(is_copied).count(), own.iter().filter(is_copied).count());

    let again = copy(&["models"]);
    assert!(stderr(&again).starts_with("note: ") && stderr(&again).contains(" are in try already"), "{again:?}");
    let mine = folder.path().join("try/models/goland_wing.toml");
    fs::write(&mine, "mine").unwrap();
    fs::remove_file(folder.path().join("try/models/branched.toml")).unwrap();
    let message = refused(&copy(&["models/*"]), 4);
    assert_eq!(message, "error: try/models/goland_wing.toml: exists already; --force overwrites it");
    assert!(!folder.path().join("try/models/branched.toml").exists(), "a refusal leaves nothing behind");
    succeeds(&copy(&["models/*", "--force"]));
    assert_ne!(fs::read_to_string(&mine).unwrap(), "mine");
    let message = refused(&run(&["examples", "golan_wing.toml"]), 2);
    assert_eq!(message, "error: no example is named `golan_wing.toml`; did you mean `goland_wing.toml`?");
}

/// Studies report their progress, and stop with a specific error when their watch requests it.
#[test]
fn studies_report_their_progress_and_stop() {
    use foldwing::plant::Plant;
    use foldwing::study::watch::Progress;
    use foldwing::study::{campbell, flutter, operating_points, periodic, trim};
    use std::ops::ControlFlow;
    use std::sync::Arc;

    type Call<'a> = &'a mut (dyn FnMut(Progress) -> ControlFlow<()> + 'a);

    /// Runs a study to its end, and again stopping at the call `stop`; returns its progress.
    #[track_caller]
    fn watched<E: std::fmt::Debug + PartialEq>(
        stop: usize,
        stopped: E,
        run: &dyn Fn(Call<'_>) -> Option<E>,
    ) -> Vec<(usize, Option<usize>)> {
        let mut seen = Vec::new();
        let whole = run(&mut |progress| {
            seen.push((progress.done, progress.total));
            ControlFlow::Continue(())
        });
        assert_eq!(whole, None);
        assert!(seen.len() > stop, "{seen:?}");
        let mut calls = 0;
        let ended = run(&mut |_| {
            calls += 1;
            if calls == stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!((ended, calls), (Some(stopped), stop));
        seen
    }

    let machine =
        |name: &str| Arc::new(foldwing::config::read(example(name)).unwrap_or_else(|error| panic!("{error}")).0);
    let goland = machine("models/goland_wing.toml");
    let options = flutter::Options { wind_m_s: vec![110.0, 120.0, 130.0, 140.0], count: 2 };
    let sweep = |watch: &mut dyn FnMut(Progress) -> ControlFlow<()>| {
        flutter::sweep_watched(Plant::new(goland.clone()), &options, watch).err()
    };
    // the last calls are from the refinement of the flutter speed
    for stop in [2, 6] {
        let seen = watched(stop, flutter::FlutterError::Stopped, &sweep);
        let speeds: Vec<_> = seen.iter().filter(|(_, total)| *total == Some(4)).map(|(done, _)| *done).collect();
        assert!(speeds.is_sorted() && speeds.first() == Some(&1) && speeds.last() == Some(&4), "{seen:?}");
        assert!(speeds.len() < seen.len() && seen[speeds.len()] == (1, None), "{seen:?}");
    }

    let turbine = machine("turbine/nrel_5mw.toml");
    for speed_rpm in [vec![0.0, 6.0, 12.0], vec![12.0, 6.0, 0.0]] {
        let options = campbell::Options { speed_rpm, undeformed: true, count: 2, ..campbell::Options::default() };
        let over = |watch: &mut dyn FnMut(Progress) -> ControlFlow<()>| {
            campbell::over_speed_watched(turbine.clone(), &options, watch).err()
        };
        let seen = watched(2, campbell::CampbellError::Stopped, &over);
        assert_eq!((seen[0], seen[seen.len() - 1]), ((1, Some(3)), (3, Some(3))), "{seen:?}");
    }

    let tip = machine("models/flared_wing_tip.toml");
    let options = trim::Options {
        solve_for: vec!["wind.velocity.z".to_owned()],
        targets: vec![trim::Target { output: "root.force.z".to_owned(), value: 5.0 }],
        ..trim::Options::default()
    };
    let solve = |watch: &mut dyn FnMut(Progress) -> ControlFlow<()>| {
        trim::solve_watched(Plant::new(tip.clone()), &options, watch).err()
    };
    // the first equilibrium, one of a difference, and one of a step
    for stop in [1, 3, 4] {
        let seen = watched(stop, trim::TrimError::Stopped, &solve);
        assert!(seen.iter().enumerate().all(|(call, progress)| *progress == (call, None)), "{seen:?}");
    }

    let windy = machine("turbine/nrel_5mw_wind.toml");
    let options = operating_points::Options {
        wind_m_s: vec![7.0, 8.0],
        speed_rpm: Some(vec![9.0]),
        settings: ["x", "y", "z"].map(|axis| operating_points::Setting::real(format!("gravity.{axis}"), 0.0)).to_vec(),
        steps: 144,
        tolerance: 1e-3,
        ..operating_points::Options::default()
    };
    let table = |watch: &mut dyn FnMut(Progress) -> ControlFlow<()>| {
        operating_points::tabulate_watched(windy.clone(), &options, watch).err()
    };
    let seen = watched(2, operating_points::PointsError::Stopped, &table);
    assert_eq!(seen, [(0, Some(2)), (1, Some(2)), (1, Some(2)), (2, Some(2))], "a state, a point");

    let options = periodic::Options { speed_rpm: Some(12.1), steps: 144, count: 0, ..periodic::Options::default() };
    let find =
        |watch: &mut dyn FnMut(Progress) -> ControlFlow<()>| periodic::find_watched(&turbine, &options, watch).err();
    assert_eq!(watched(1, periodic::PeriodicError::Stopped, &find).len(), 2);
}

/// `package`, `new` and `view` list the files they wrote as JSON, with no other output.
#[test]
fn commands_whose_results_are_files_print_json() {
    let folder = tempfile::tempdir().unwrap();
    let called = |arguments: &[&str]| json(&in_folder(folder.path(), arguments));
    let made = called(&["new", "wing.toml", "--json"]);
    assert_eq!(made["files"], serde_json::json!(["foldwing.schema.json", "wing.toml"]));
    let library = library().to_str().unwrap().to_owned();
    let fmu = called(&["package", "wing.toml", "-o", "w.fmu", "--fmi", "3", "--library", &library, "--json"]);
    assert_eq!((&fmu["fmi_version"], &fmu["co_simulation"]), (&Value::from("3.0"), &Value::from(true)));
    assert_eq!(fmu["files"], serde_json::json!(["w.fmu"]));
    assert_eq!(fmu["platforms"].as_array().map(Vec::len), Some(1));
    let page = called(&["view", "wing.toml", "--stop", "0.01", "--no-open", "--json"]);
    assert_eq!(page["files"], serde_json::json!(["wing.html"]));
    assert_eq!(called(&["view", "wing.html", "--no-open", "--json"])["page"], "wing.html");
}

/// Every connector of the system around an FMU is a variable of that FMU with the same causality, vectors as scalars in FMI 3.0; without
/// outputs of other types than Real, there are no connectors to them.
#[test]
fn systems_connect_the_variables_of_their_fmus() {
    let folder = tempfile::tempdir().unwrap();
    let (wing, library) = (wing(), library().to_str().unwrap().to_owned());
    for kind in [&["--fmi", "3", "--scalars"][..], &["--interface", "cs,me"], &["--real-outputs-only"]] {
        let named = ["package", &wing, "-o", "w.fmu", "--ssp", "w.ssp", "--no-reference", "--library", &library];
        succeeds(&in_folder(folder.path(), &[&named, kind].concat()));
        let text = |archive: &str, member: &str| {
            let mut archive = zip::ZipArchive::new(fs::File::open(folder.path().join(archive)).unwrap()).unwrap();
            std::io::read_to_string(archive.by_name(member).unwrap()).unwrap()
        };
        let (description, system) = (text("w.fmu", "modelDescription.xml"), text("w.ssp", "SystemStructure.ssd"));
        let connectors: Vec<(&str, &str)> = system
            .split("<ssd:Connector name=\"")
            .skip(1)
            .map(|rest| rest.split_once("\" kind=\"").expect("a kind"))
            .map(|(name, rest)| (name, rest.split('"').next().unwrap_or_default()))
            .collect();
        assert!(connectors.len() > 50, "{system}");
        for (name, causality) in connectors {
            let tag = description.split(&format!("name=\"{name}\"")).nth(1).and_then(|rest| rest.split('>').next());
            let tag = tag.unwrap_or_else(|| panic!("{kind:?}: no {name}"));
            assert!(tag.contains(&format!("causality=\"{causality}\"")), "{kind:?}: {name} {tag}");
        }
    }
}
