//! `docs/guide/commands.md`: the help of the command, and whether the lines of the guide run.

use crate::guide::command_lines::{self, CommandLine};
use crate::guide::{assert_current, in_package};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const HEAD: &str = "\
# All commands and their options

This page shows what `foldwing --help` and `foldwing COMMAND --help` print; a test keeps it current. Formats of files and details of
the options: [COMMAND_LINE.md](../COMMAND_LINE.md).
";

/// Runs the command in a folder.
pub fn foldwing(folder: &std::path::Path, words: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_foldwing"));
    // without a terminal and without this variable, help is 100 characters wide
    command.args(words).current_dir(folder).env_remove("COLUMNS").output().expect("the command runs")
}

/// Help printed by the command, without trailing blanks.
fn help(words: &[&str]) -> String {
    let words: Vec<String> = words.iter().chain(&["--help"]).map(|word| (*word).to_owned()).collect();
    let output = foldwing(&in_package("."), &words);
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// The commands listed in the help.
fn commands(help: &str) -> Vec<String> {
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    list.filter(|line| !line.starts_with("    "))
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

/// F-244. The page of commands is current.
#[test]
fn f244_the_page_of_commands_is_current() {
    let top = help(&[]);
    let commands = commands(&top);
    assert!(commands.len() >= 10, "{commands:?}");
    let mut page = format!("{HEAD}\n```text\n{}\n```\n", top.trim_end());
    for command in commands.iter().filter(|command| *command != "help") {
        page += &format!("\n## `foldwing {command}`\n\n```text\n{}\n```\n", help(&[command]).trim_end());
    }
    assert_current("docs/guide/commands.md", &page);
}

/// The shared library that Cargo built next to this test.
pub fn library() -> PathBuf {
    let name = format!("{}foldwing_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    std::env::current_exe().unwrap().with_file_name(name)
}

/// Returns whether a call can run with only a model, its inputs and its samples.
fn can_run(call: &CommandLine) -> bool {
    let says = |text: &str| call.words.iter().any(|word| word.contains(text));
    let shown_only = says("<") || says("MODEL") || says("examples/") || says("win64=");
    // foreign FMUs need the feature `import`
    call.whole && !shown_only && call.words[0] != "run"
}

/// A small rotor on a stand, pitched by locked joints.
const ROTOR: &str = r#"
name = "Rotor"
gravity_m_s2 = [0.0, 0.0, 0.0]
[rigid_body.hub]
mass_kg = 10.0
inertia_kg_m2 = [1.0, 1.0, 1.0, 0, 0, 0]
[joint.shaft]
type = "revolute"
parent = "root"
child = "hub"
axis = [1, 0, 0]
start_rate_deg_s = 240.0
[modal_body.blade]
count = 3
length_m = 9.5
nodes = 8
stations = [0, 1]
mass_kg_m = [10, 5]
flap_stiffness_N_m2 = [1e6, 2e5]
edge_stiffness_N_m2 = [2e6, 4e5]
flap_shapes = [[1.0]]
edge_shapes = [[1.0]]
[joint.pitch]
type = "revolute"
parent = "hub"
child = "blade"
axis = [0.0, 0.0, -1.0]
motion = "locked"
parent_offset_m = [0.0, 0.0, 0.5]
mount_rotation_deg = [127.27922061357854, 0.0, 127.27922061357854]
[aerodynamics]
model = "bem"
hub = "hub"
hub_radius_m = 0.5
wind_m_s = [8.0, 0.0, 0.0]
step_s = 0.02
[surface.blade]
body = "blade"
elastic_axis_fraction = 0.25
stations_m = [0.0, 2.0, 4.0, 6.0, 8.0, 9.5]
polars = ["plate", "plate", "plate", "plate", "plate", "plate"]
chord_m = 0.5
incidence_deg = { table = [[0.0, -20.0], [2.0, -12.0], [5.0, -5.0], [9.5, -1.0]] }
[polar.plate]
rows = [[-180, 0, 0.5, 0], [-12, -1.1, 0.03, 0], [12, 1.1, 0.03, 0], [180, 0, 0.5, 0]]
[simulation]
stop_time_s = 1.0
step_s = 0.01
"#;

/// Output of a command that serves a page until Ctrl-C, which follows as soon as it has printed the address.
fn interrupted(folder: &Path, words: &[String]) -> Output {
    use std::io::{BufRead, BufReader};
    let mut command = Command::new(env!("CARGO_BIN_EXE_foldwing"));
    command.args(words).current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::piped());
    // do not open a browser on a computer with a display
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let mut child = command.spawn().unwrap();
    let mut address = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut address).unwrap();
    assert!(address.is_empty() || address.starts_with("http://127.0.0.1:"), "{address}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

/// F-246. Lines of the guide, of the front page and of the help that call the command run successfully as printed.
#[test]
fn f246_the_lines_of_the_guide_run() {
    let folder = tempfile::tempdir().unwrap();
    let model = std::fs::read_to_string(in_package("examples/models/folding_wing.toml")).unwrap();
    for name in ["wing.toml", "my_wing.toml", "mywing.toml", "stiffer.toml"] {
        std::fs::write(folder.path().join(name), &model).unwrap();
    }
    for name in ["goland_wing.toml", "flared_wing_tip.toml"] {
        std::fs::copy(in_package("examples/models").join(name), folder.path().join(name)).unwrap();
    }
    std::fs::copy(in_package("examples/tutorial/sketch.toml"), folder.path().join("sketch.toml")).unwrap();
    std::fs::copy(in_package("examples/turbine/nrel_5mw.toml"), folder.path().join("turbine.toml")).unwrap();
    std::fs::write(folder.path().join("rotor.toml"), ROTOR).unwrap();
    std::fs::write(folder.path().join("wt.toml"), ROTOR).unwrap();
    std::fs::write(folder.path().join("commands.csv"), "time, fold.angle_command\n0, 0\n0.1, 0.1\n").unwrap();
    std::fs::write(folder.path().join("measured.csv"), "time,fold.angle\n0,2.9\n0.1,0.8\n").unwrap();
    std::fs::write(folder.path().join("samples.csv"), "fold.start_angle\n1.0\n2.0\n").unwrap();
    let mut ran = BTreeSet::new();
    for call in command_lines::pages().iter().flat_map(|page| command_lines::of_page(page)) {
        let mut words = call.words.clone();
        if !can_run(&call) || !ran.insert(words.clone()) {
            continue;
        }
        // fewer steps than for a minute are sufficient to see that a line runs
        words.iter_mut().filter(|word| *word == "100000").for_each(|word| *word = "100".to_owned());
        // so are fewer speeds than those that bracket divergence, or over which a tip without springs is tracked, and fewer start angles
        words.iter_mut().filter(|word| *word == "10:40:4").for_each(|word| *word = "10:20:2".to_owned());
        words.iter_mut().filter(|word| *word == "10:40:10").for_each(|word| *word = "10:20:10".to_owned());
        words.iter_mut().filter(|word| *word == "10:80:8").for_each(|word| *word = "10:20:2".to_owned());
        words
            .iter_mut()
            .filter(|word| *word == "fold.start_angle=0:1.4:3")
            .for_each(|word| *word = "fold.start_angle=0:1.4:2".to_owned());
        // and fewer pixels
        words.iter_mut().filter(|word| *word == "1920x1080").for_each(|word| *word = "320x180".to_owned());
        // and fewer pictures of a film, in the sizes that the lines give or leave to the command
        if words.iter().any(|word| word == "--video") {
            match words.iter().position(|word| word == "--to") {
                Some(at) => words[at + 1] = "0.11".to_owned(),
                None => words.extend(["--from", "0.1", "--to", "0.11"].map(str::to_owned)),
            }
        }
        if words[0] == "new" {
            let _ = std::fs::remove_file(folder.path().join(&words[1])); // the command does not overwrite files
        }
        if words[0] == "view" {
            words.push("--no-open".to_owned()); // do not open a browser
        }
        if words[0] == "package" && !words.iter().any(|word| word == "--description-only" || word == "--library") {
            words.extend(["--library".to_owned(), library().to_str().unwrap().to_owned()]);
        }
        if words.iter().any(|word| word == "libfoldwing_fmu.so") {
            continue;
        }
        let clock = std::time::Instant::now();
        let output =
            if words[0] == "live" { interrupted(folder.path(), &words) } else { foldwing(folder.path(), &words) };
        if words[0] == "new" {
            std::fs::write(folder.path().join(&words[1]), &model).unwrap(); // the other lines use the wing of the pages
        }
        println!("{:6.2} s  foldwing {}", clock.elapsed().as_secs_f64(), words.join(" "));
        assert!(output.status.success(), "{}\n{}", call.place, String::from_utf8_lossy(&output.stderr));
    }
    assert!(ran.len() >= 30, "{} lines ran", ran.len());
}
